"""NumPy, differentiated by hand and vectorised over samples: an orientation, no solver."""

import time

import numpy as np

import common


def gradients(data, state, measurand):
    """What the three measurands start from: point, its lengths and R^T g -> a row of the Jacobian."""
    turned = common.rotation(state[1:5])
    a = data.angle + data.rate * state[8 + measurand]
    c, s = np.cos(a), np.sin(a)
    target = state[0] * np.array([c, s, np.zeros_like(c)])
    x, y, z = turned @ target + state[5:8, None]
    flat = x * x + y * y
    rho, length = np.sqrt(flat), np.sqrt(flat + z * z)

    def row(into, gradient):
        """Fills a row: radius, turn (target x R^T g), position, delay."""
        u = turned.T @ gradient
        into[0] = c * u[0] + s * u[1]
        into[1] = target[1] * u[2]
        into[2] = -target[0] * u[2]
        into[3] = target[0] * u[1] - target[1] * u[0]
        into[4:7] = gradient
        into[7 + measurand] = data.rate * into[3]

    return x, y, z, rho, length, row


def jacobian(data, state):
    """Residuals (3, n) and their Jacobian (3, 13, n)."""
    residual = np.empty((3, data.count))
    rows = np.zeros((3, 13, data.count))
    x, y, z, rho, length, row = gradients(data, state, 0)
    residual[0] = np.arctan2(y, x) + state[11] * length / rho
    bend = state[11] / (rho * length)
    share = bend * (1 - (length / rho) ** 2)
    row(rows[0], np.array([-y / rho**2 + share * x, x / rho**2 + share * y, bend * z]))
    rows[0, 10] = length / rho
    x, y, z, rho, length, row = gradients(data, state, 1)
    residual[1] = np.arctan2(rho, z) + state[12]
    along = z / (rho * length**2)
    row(rows[1], np.array([along * x, along * y, -rho / length**2]))
    rows[1, 11] = 1
    x, y, z, rho, length, row = gradients(data, state, 2)
    residual[2] = length + state[13]
    row(rows[2], np.array([x, y, z]) / length)
    rows[2, 12] = 1
    residual = data.readings - residual
    residual[0] = common.wrapped(residual[0])
    residual /= data.sigma[:, None]
    rows *= -1 / data.sigma[:, None, None]
    return residual, rows


def normal(data, state):
    """J^T J, J^T r and r^T r."""
    residual, rows = jacobian(data, state)
    hessian = sum(row @ row.T for row in rows)
    gradient = sum(row @ one for row, one in zip(rows, residual))
    return hessian, gradient, np.vdot(residual, residual)


def check(data):
    residual, rows = jacobian(data, data.truth)
    common.tell_check(residual, rows.transpose(0, 2, 1))


def time_of(work):
    def job(data):
        seconds = common.timed(lambda: work(data, data.truth))
        common.tell("time", ns_per_sample=seconds / data.count * 1e9)
    return job


def batch(data):
    start = time.perf_counter()
    state, iterations = common.gauss_newton(lambda state: normal(data, state), data.start)
    common.tell_batch(time.perf_counter() - start, iterations, state)


if __name__ == "__main__":
    common.main({"check": check, "J": time_of(jacobian), "J+NE": time_of(normal), "batch": batch})
