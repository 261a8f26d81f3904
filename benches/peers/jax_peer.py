"""JAX on the CPU, one thread, doubles: the model of one sample, vmap, jit.

Jacobians alone are faster in reverse mode (three outputs), normal equations in forward mode (they
fuse); each job has its faster one.
"""

import os
import time
from functools import partial

os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402

import common  # noqa: E402

jax.config.update("jax_enable_x64", True)


def residual(step, state, angle, rate, reading, sigma):
    """Residuals of one sample at the state moved by a small step.

    Written in scalars: crosses, matrix products and updates of arrays are several times slower.
    """
    w, i, j, k = state[1:5]
    a, b, c = step[1:4] / 2
    # q (1, step/2): the first order of a turn, enough at step zero.
    w, i, j, k = (w - i * a - j * b - k * c, i + w * a + j * c - k * b,
                  j + w * b + k * a - i * c, k + w * c + i * b - j * a)
    columns = ((1 - 2 * (j * j + k * k), 2 * (i * j - w * k)),
               (2 * (i * j + w * k), 1 - 2 * (i * i + k * k)),
               (2 * (i * k - w * j), 2 * (j * k + w * i)))
    radius, rest = state[0] + step[0], state[5:] + step[4:]

    def point(delay):
        moment = angle + rate * delay
        x, y = radius * jnp.cos(moment), radius * jnp.sin(moment)
        return [p * x + q * y + rest[row] for row, (p, q) in enumerate(columns)]

    x, y, z = point(rest[3])
    horizontal = jnp.arctan2(y, x) + rest[6] * jnp.sqrt(1 + z * z / (x * x + y * y))
    x, y, z = point(rest[4])
    vertical = jnp.arctan2(jnp.sqrt(x * x + y * y), z) + rest[7]
    x, y, z = point(rest[5])
    distance = jnp.sqrt(x * x + y * y + z * z) + rest[8]
    difference = reading[0] - horizontal
    difference = difference - 2 * jnp.pi * jnp.round(difference / (2 * jnp.pi))
    rest = [difference, reading[1] - vertical, reading[2] - distance]
    return jnp.stack(rest) / sigma


def of_one(mode, state, angle, rate, reading, sigma):
    """Residual and Jacobian of one sample; values come along."""
    def both(step):
        value = residual(step, state, angle, rate, reading, sigma)
        return value, value
    jacobian, value = mode(both, has_aux=True)(jnp.zeros(13))
    return value, jacobian


def linearise(state, angle, rate, readings, sigma, mode=jax.jacrev):
    """Residuals (n, 3) and Jacobians (n, 3, 13)."""
    one = jax.vmap(partial(of_one, mode), in_axes=(None, 0, 0, 1, None))
    return one(state, angle, rate, readings, sigma)


def normal(state, angle, rate, readings, sigma):
    """J^T J, J^T r and r^T r."""
    value, jacobian = linearise(state, angle, rate, readings, sigma, jax.jacfwd)
    value, rows = value.reshape(-1), jacobian.reshape(-1, 13)
    return rows.T @ rows, rows.T @ value, value @ value


def compiled(function, data, state):
    """The function for these samples, its arguments, and the seconds that compiling took."""
    arguments = [jnp.asarray(one) for one in (state, data.angle, data.rate, data.readings, data.sigma)]
    start = time.perf_counter()
    ready = jax.jit(function).lower(*arguments).compile()
    return ready, arguments, time.perf_counter() - start


def check(data):
    value, jacobian = jax.jit(linearise)(data.truth, data.angle, data.rate, data.readings, data.sigma)
    common.tell_check(value.T, jacobian.transpose(1, 0, 2))


def time_of(function):
    def job(data):
        ready, arguments, _ = compiled(function, data, data.truth)
        seconds = common.timed(lambda: jax.block_until_ready(ready(*arguments)))
        common.tell("time", ns_per_sample=seconds / data.count * 1e9)
    return job


def load(data):
    common.tell("load", seconds=compiled(linearise, data, data.truth)[2])


def batch(data):
    ready, arguments, _ = compiled(normal, data, data.start)
    start = time.perf_counter()
    state, iterations = common.gauss_newton(
        lambda state: [np.asarray(one) for one in ready(jnp.asarray(state), *arguments[1:])],
        data.start,
    )
    common.tell_batch(time.perf_counter() - start, iterations, state)


if __name__ == "__main__":
    jobs = {"J": time_of(linearise), "J+NE": time_of(normal)}
    common.main({"check": check, "load": load, "batch": batch, **jobs})
