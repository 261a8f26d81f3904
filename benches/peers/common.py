"""What the Python peers share: the data, the reference model, timing and the way results are told.

State (14 numbers): radius, quaternion w x y z, position x y z, delays of horizontal, vertical and
distance, collimation, index, offset. Tangent (13): the quaternion has three, the rotation vector of
a turn from the right, q exp(delta).
"""

import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np

# Below this change of the sum of squares a batch estimate has converged, for every peer.
TOLERANCE = 1e-10
# Newton steps of one reading.
NEWTON_STEPS = 8


class Data:
    """The samples of a folder: angle, rate and the readings, one row each."""

    def __init__(self, folder):
        folder = Path(folder)
        columns = np.fromfile(folder / "samples.f64").reshape(5, -1)
        self.angle, self.rate = columns[0], columns[1]
        self.readings = columns[2:]
        self.sigma = np.fromfile(folder / "sigma.f64")
        self.truth = np.fromfile(folder / "truth.f64")
        self.start = np.fromfile(folder / "start.f64")
        self.count = len(self.angle)


def rotation(q):
    """The matrix of a unit quaternion w x y z."""
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def turn(v):
    """The unit quaternion of a rotation vector."""
    half = np.linalg.norm(v) / 2
    return np.concatenate([[np.cos(half)], np.sinc(half / np.pi) / 2 * np.asarray(v)])


def product(a, b):
    """The product of two quaternions."""
    return np.concatenate([
        [a[0] * b[0] - a[1:] @ b[1:]],
        a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]),
    ])


def moved(state, step):
    """The state moved by a step in the tangent space."""
    q = product(state[1:5], turn(step[1:4]))
    return np.concatenate([
        [state[0] + step[0]], q / np.linalg.norm(q), state[5:] + step[4:]
    ])


def wrapped(angle):
    """An angle brought into [-pi, pi] by whole turns."""
    return angle - 2 * np.pi * np.round(angle / (2 * np.pi))


def atan2(y, x):
    """atan2 that carries a complex step: turned by its real angle first."""
    a = np.arctan2(y.real, x.real)
    c, s = np.cos(a), np.sin(a)
    return a + np.arctan((y * c - x * s) / (x * c + y * s))


def predict(state, angle, rate):
    """Horizontal, vertical and distance at each sample, real or complex."""
    turned = rotation(state[1:5])

    def point(delay):
        a = angle + rate * delay
        target = state[0] * np.array([np.cos(a), np.sin(a), 0 * a])
        return turned @ target + state[5:8, None]

    x, y, z = point(state[8])
    zenith = atan2(np.sqrt(x * x + y * y), z)
    horizontal = atan2(y, x) + state[11] / np.sin(zenith)
    x, y, z = point(state[9])
    vertical = atan2(np.sqrt(x * x + y * y), z) + state[12]
    x, y, z = point(state[10])
    distance = np.sqrt(x * x + y * y + z * z) + state[13]
    return np.array([horizontal, vertical, distance])


def reference(data, state):
    """Residuals (3, n) and their Jacobian (3, n, 13) by complex step: the common reference."""
    residual = data.readings - predict(state + 0j, data.angle, data.rate).real
    residual[0] = wrapped(residual[0])
    jacobian = np.empty((3, data.count, 13))
    h = 1e-30
    for k in range(13):
        step = state + 0j
        if 1 <= k < 4:
            axis = np.zeros(4)
            axis[k] = 0.5
            step[1:5] += 1j * h * product(state[1:5], axis)
        else:
            step[k if k < 1 else k + 1] += 1j * h
        jacobian[:, :, k] = -predict(step, data.angle, data.rate).imag / h
    return residual / data.sigma[:, None], jacobian / data.sigma[:, None, None]


def timed(work, least=0.5, count=5):
    """Median seconds of repeated calls, after one that is not counted."""
    work()
    times = []
    while len(times) < count or sum(times) < least:
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def gauss_newton(normal, state):
    """Batch estimate from normal equations; returns the state and the number of iterations.

    `normal(state)` gives J^T J, J^T r and r^T r. Undamped: the start is near.
    """
    last = np.inf
    for iteration in range(1, 51):
        hessian, gradient, cost = normal(state)
        if abs(last - cost) <= TOLERANCE * cost:
            break
        last = cost
        scale = 1 / np.sqrt(np.diag(hessian))
        scaled = hessian * scale * scale[:, None]
        state = moved(state, -scale * np.linalg.solve(scaled, scale * gradient))
    return state, iteration


def tell(job, **result):
    """Prints one result as a JSON line."""
    plain = {key: value.tolist() if hasattr(value, "tolist") else value for key, value in result.items()}
    print(json.dumps({"job": job, **plain}))


def tell_check(residual, jacobian):
    """Prints residuals (3, n) and Jacobian (3, n, 13) for comparison, sample by sample."""
    tell("check", residual=np.asarray(residual).T.ravel(),
         jacobian=np.asarray(jacobian).transpose(1, 0, 2).ravel())


def tell_batch(seconds, iterations, state):
    """Prints how a batch estimate ended."""
    tell("batch", seconds=seconds, iterations=int(iterations), state=np.asarray(state))


def main(jobs):
    """Runs `PEER JOB FOLDER`: `jobs` maps names to functions of the data."""
    jobs[sys.argv[1]](Data(sys.argv[2]))
