"""SciPy: least_squares with the analytic Jacobian of numpy_peer, and newton on whole arrays."""

import time

import numpy as np
from scipy.optimize import least_squares, newton

import common
import numpy_peer


def right_jacobian(v):
    """How exp(v) turns from the right as the rotation vector v changes."""
    angle = np.linalg.norm(v)
    cross = np.cross(np.eye(3), -v)
    if angle < 1e-4:
        return np.eye(3) - cross / 2 + cross @ cross / 6
    return (np.eye(3) - (1 - np.cos(angle)) / angle**2 * cross
            + (angle - np.sin(angle)) / angle**3 * cross @ cross)


class Problem:
    """Residuals and Jacobian over a step from the start, as least_squares wants them."""

    def __init__(self, data):
        self.data = data

    def residual(self, step):
        state = common.moved(self.data.start, step)
        return numpy_peer.jacobian(self.data, state)[0].ravel()

    def jacobian(self, step):
        state = common.moved(self.data.start, step)
        rows = numpy_peer.jacobian(self.data, state)[1]
        rows[:, 1:4] = np.einsum("ki,mkn->min", right_jacobian(step[1:4]), rows[:, 1:4])
        return rows.transpose(0, 2, 1).reshape(-1, 13)


def batch(method):
    def job(data):
        problem = Problem(data)
        start = time.perf_counter()
        found = least_squares(
            problem.residual, np.zeros(13), problem.jacobian, method=method, x_scale="jac",
            ftol=common.TOLERANCE, xtol=None if method == "trf" else 1e-15,
            gtol=None if method == "trf" else 1e-15,
        )
        seconds = time.perf_counter() - start
        common.tell_batch(seconds, found.njev or found.nfev, common.moved(data.start, found.x))
    return job


def delays(data):
    """The delay of each reading by Newton's method, all readings of a measurand at once."""
    state = data.truth
    turned = common.rotation(state[1:5])
    c, s = np.cos(data.angle), np.sin(data.angle)

    def point(delay):
        """The target and its velocity."""
        turn = data.rate * delay
        a, b = np.cos(turn), np.sin(turn)
        x, y = state[0] * (c * a - s * b), state[0] * (s * a + c * b)
        p = turned[:, :1] * x + turned[:, 1:2] * y + state[5:8, None]
        return p, (turned[:, 1:2] * x - turned[:, :1] * y) * data.rate

    def horizontal(delay):
        (x, y, z), _ = point(delay)
        value = np.arctan2(y, x) + state[11] * np.sqrt(1 + z * z / (x * x + y * y))
        return common.wrapped(value - data.readings[0])

    def horizontal_slope(delay):
        (x, y, z), (u, v, w) = point(delay)
        flat = x * x + y * y
        along = (x * u + y * v) / flat
        return (x * v - y * u) / flat + state[11] * (z * w - z * z * along) / (
            flat * np.sqrt(1 + z * z / flat))

    def vertical(delay):
        (x, y, z), _ = point(delay)
        return np.arctan2(np.sqrt(x * x + y * y), z) + state[12] - data.readings[1]

    def vertical_slope(delay):
        (x, y, z), (u, v, w) = point(delay)
        rho = np.sqrt(x * x + y * y)
        return ((x * u + y * v) / rho * z - rho * w) / (rho * rho + z * z)

    def distance(delay):
        (x, y, z), _ = point(delay)
        return np.sqrt(x * x + y * y + z * z) + state[13] - data.readings[2]

    def distance_slope(delay):
        p, velocity = point(delay)
        return (p * velocity).sum(0) / np.sqrt((p * p).sum(0))

    pairs = [(horizontal, horizontal_slope), (vertical, vertical_slope), (distance, distance_slope)]
    # Readings near a turning point of their measurand never converge; they do not hold up the rest.
    with np.errstate(all="ignore"):
        return [newton(f, np.zeros(data.count), slope, tol=1e-12, maxiter=common.NEWTON_STEPS,
                       full_output=True, disp=False)[0] for f, slope in pairs]


def newton_job(data):
    import warnings
    warnings.simplefilter("ignore")
    seconds = common.timed(lambda: delays(data))
    common.tell("newton", ns_per_sample=seconds / data.count * 1e9,
                delays=[float(np.nanmedian(one)) for one in delays(data)])


def check(data):
    """At a step of zero from the truth, where this Jacobian is the tangent's."""
    data.start = data.truth
    problem = Problem(data)
    common.tell_check(problem.residual(np.zeros(13)).reshape(3, -1),
                      problem.jacobian(np.zeros(13)).reshape(3, -1, 13))


if __name__ == "__main__":
    jobs = {"batch-trf": batch("trf"), "batch-lm": batch("lm")}
    common.main({"check": check, "newton": newton_job, **jobs})
