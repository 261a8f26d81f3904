"""Makes the tables of tests/lane_math.rs with mpmath at 60 digits.

usage: python3 generate.py FOLDER [SCALE]   (SCALE times as many random points; default 1)

A row holds, as bits in hexadecimal, the arguments and the correctly rounded value, and what the true
value lies above the rounded one in thousandths of its last place.
"""

import math
import random
import struct
import sys

from mpmath import acos, asin, atan, atan2, cos, exp, factorial, floor, isinf, log, mp, mpf
from mpmath import nint, pi, power, sin, sqrt, tan, tanh

mp.dps = 60
folder = sys.argv[1]
many = 60 * (int(sys.argv[2]) if len(sys.argv) > 2 else 1)
random.seed(20240607)


def bits(x):
    return struct.unpack("<Q", struct.pack("<d", x))[0]


def from_bits(b):
    return struct.unpack("<d", struct.pack("<Q", b))[0]


def rounded(value):
    """The nearest double, subnormals included, and the rest in thousandths of its last place."""
    if value == 0 or isinf(value):
        return float(value), 0
    exponent = int(floor(log(abs(value), 2)))
    exponent += (abs(value) >= mpf(2) ** (exponent + 1)) - (abs(value) < mpf(2) ** exponent)
    place = mpf(2) ** (max(exponent, -1022) - 52)
    whole = int(nint(value / place))
    try:
        return math.ldexp(whole, max(exponent, -1022) - 52), int(nint(1000 * (value / place - whole)))
    except OverflowError:
        return math.copysign(math.inf, value), 0


def sign():
    return random.choice([-1, 1])


def uniform(low, high, count):
    return [random.uniform(low, high) for _ in range(count)]


def any_size(low=-1074, high=1023):
    exponent = int(random.uniform(low, high))
    if exponent < -1022:
        return sign() * from_bits(random.getrandbits(52) >> random.randrange(52))
    return sign() * math.ldexp(1 + random.random(), exponent)


def any_sizes(count, low=-1074, high=1023):
    return [any_size(low, high) for _ in range(count)]


def around(x, count=6):
    return [s * from_bits(bits(x) + k) for s in (1, -1) for k in range(-count, count + 1)]


def near_multiples(period, count, exponent):
    return [sign() * float(period * int(2 ** random.uniform(0, exponent))) for _ in range(count)]


def nearest_to_multiples(count):
    """Doubles below 2^21 that come nearest to a multiple of π/2, by continued fractions."""
    found = set()
    for e in range(21):
        x = mpf(2) ** (e - 52) * 2 / pi
        q, previous = 1, 0
        while q < 2**53:
            factor = -(-(2**52) // q)
            if q * factor < 2**53:
                found.add(math.ldexp(q * factor, e - 52))
            x = 1 / (x - floor(x))
            q, previous = int(floor(x)) * q + previous, q
    off = lambda v: abs(mpf(v) * 2 / pi - nint(mpf(v) * 2 / pi))
    return sorted(found, key=off)[:count]


TINY = [5e-324, -5e-324, 1e-310, -(2.0**-1022), 2.0**-1022, 1e-300, 1e-160, 1e-20, 1e-10, 2.0**-27]
LARGEST = from_bits(0x7FEFFFFFFFFFFFFF)


def stumpff(k):
    def value(x):
        root = sqrt(abs(x))
        if 0 < x and k <= 3 and x >= 4 * (k + 1) * (k + 2):
            first = cos(root) if k % 2 == 0 else sin(root) / root
            return first if k < 2 else (1 - first) / x
        mp.dps = 100 + int(root)
        total, term, i = mpf(0), 1 / factorial(k), 0
        while i <= root or abs(term) > mpf(10) ** -mp.dps:
            total, i = total + term, i + 1
            term *= -x / ((k + 2 * i) * (k + 2 * i - 1))
        mp.dps = 60
        return +total

    return value


def unary():
    angles = uniform(-1.6, 1.6, many) + uniform(-100, 100, many) + any_sizes(many, -20, 20)
    angles += any_sizes(many) + TINY + [1e22, 2.0**1000, LARGEST, 6.1898001973e25]
    # The double nearest of all to a multiple of π/2, and another one.
    angles += [6381956970095103 * 2.0**797, 5.319372648326541e255]
    angles += near_multiples(pi / 2, many, 19) + near_multiples(pi / 2, many // 4, 200)
    angles += near_multiples(pi / 4, many // 4, 19) + nearest_to_multiples(many // 3)
    for x in (pi / 4, pi / 2, pi, mpf(2) ** 20):
        angles += around(float(x))
    yield "sin", sin, angles
    yield "cos", cos, angles
    yield "tan", tan, angles

    slopes = uniform(-1, 1, many) + uniform(-5, 5, many) + any_sizes(many, -30, 60)
    slopes += any_sizes(many) + TINY + around(0.5) + around(1.0) + around(2.0) + [1e300]
    yield "atan", atan, slopes

    ratios = uniform(-1, 1, 2 * many) + any_sizes(many, -60, -1) + TINY + around(0.5)
    ratios += [sign() * (1 - 2 ** random.uniform(-53, -1)) for _ in range(many)]
    ratios += [x for x in around(1.0) if abs(x) <= 1] + around(math.sqrt(0.5))
    yield "asin", asin, ratios
    yield "acos", acos, ratios

    powers = uniform(-1, 1, many) + uniform(-708, 709, many) + uniform(-745, -707, many // 2)
    powers += any_sizes(many, -60, 9) + TINY + [float(log(2) * (n + 0.5)) for n in range(-20, 20)]
    for x in (708.0, float(log(2) / 2), float(log(2)), 709.782712893384, 745.1332191019411):
        powers += around(x)
    yield "exp", exp, powers

    sizes = [abs(x) for x in any_sizes(2 * many) + TINY] + uniform(0.3, 3, 2 * many)
    sizes += [1 + sign() * 2 ** random.uniform(-52, -3) for _ in range(many)] + [LARGEST]
    for x in (1.0, math.sqrt(0.5), math.sqrt(2)):
        sizes += [x for x in around(x) if x > 0]
    yield "ln", log, sizes

    rapidities = uniform(-1, 1, 2 * many) + uniform(-22, 22, many) + any_sizes(many, -60, 9)
    rapidities += uniform(0.5, 1.2, many) + around(0.55) + around(20.0, 2) + TINY
    yield "tanh", tanh, rapidities

    for k in (0, 1, 2, 3, 4, 5, 8):
        near, far = float(max(1, k * (k - 1))), float((k + 1) * (k + 2))
        x = uniform(-far, far, many) + uniform(0, near, many) + uniform(near, 4 * far, many)
        x += uniform(0, 2000, many // 2) + any_sizes(many // 4, -60, 3) + around(near, 3)
        x += around(far, 3)
        if k < 4:
            x += [2.0 ** random.uniform(7, 39) for _ in range(many // 2)]
            x += [float((pi / 2 * n) ** 2) for n in range(1, many)]
        yield f"stumpff{k}", stumpff(k), x


def binary():
    points = [(random.uniform(-1, 1), random.uniform(-1, 1)) for _ in range(3 * many)]
    points += [(any_size(-30, 30), any_size(-30, 30)) for _ in range(many)]
    points += [(any_size(), any_size()) for _ in range(many)]
    points += [(any_size(-1074, -1010), any_size(-1074, -1010)) for _ in range(many // 3)]
    for _ in range(many):
        x, off = random.uniform(-2, 2), 1 + sign() * 2 ** random.uniform(-53, -4)
        points.append((x * random.choice([0.5, 1.0, 2.0]) * off, x))
    edges = [LARGEST, 1e308, 1e300, 1.0, 4e-308, 2.3e-308, 1e-310, 5e-324]
    points += [(s * y, t * x) for y in edges for x in edges for s in (1, -1) for t in (1, -1)]

    def length(y, x):
        return sqrt(y * y + x * x)

    def angle(y, x):
        # 0 where the length, rounded, is below the smallest normal number.
        return mpf(0) if rounded(length(y, x))[0] < 2.0**-1022 else atan2(y, x)

    yield "hypot", length, points
    yield "atan2", angle, points

    pairs = [(random.uniform(0.01, 10), random.uniform(-20, 20)) for _ in range(2 * many)]
    bases = [abs(x) for x in any_sizes(3 * many)]
    bases += [1 + sign() * 2 ** random.uniform(-52, -2) for _ in range(2 * many)]
    for x in bases:
        if x not in (0, 1):
            pairs.append((x, float(random.uniform(-744, 709.7) / log(mpf(x)))))
    exponents = [0.5, -0.5, 1 / 3, 2.0, 3.0, -1.0, 1.0, 0.0, 1e-10, 1e-300, 1.5, 2.5]
    for _ in range(many):
        x = math.ldexp(random.uniform(0.5, 2), random.randrange(-10, 10))
        pairs.append((x, random.choice(exponents)))
    yield "pow", power, pairs


for name, function, arguments in [*unary(), *binary()]:
    with open(f"{folder}/{name}.txt", "w") as file:
        for row in dict.fromkeys(arguments):
            row = row if isinstance(row, tuple) else (row,)
            value, rest = rounded(function(*map(mpf, row)))
            file.write(" ".join(f"{bits(x):016x}" for x in (*row, value)) + f" {rest}\n")
