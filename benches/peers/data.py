"""Makes the data set that every peer reads: simulated recordings of a rotating arm, seeded.

A folder holds samples.f64 (angle, rate, horizontal, vertical, distance: five rows of doubles, SI),
sigma.f64, truth.f64 and start.f64 for the peers, and campaign.toml with one CSV a run for homepoint.
Both hold the same doubles.
"""

from pathlib import Path

import numpy as np

import common

RATES = np.radians([5, -5, 50, -50, 190, -190])
SIGMA = np.array([6e-6, 6e-6, 8e-6])
ROTATION = np.array([0.3, -0.2, 0.5])
# The arm stands where the horizontal angle passes 180 deg, so residuals must be wrapped.
TRUTH = np.concatenate([
    [1.15], common.turn(ROTATION), [-2.0, 0.3, 0.5], [2.0e-3, 2.3e-3, 1.1e-3], [2e-5, -3e-5, 4e-5]
])
OFFSET = np.array([5e-3, 0.01, -0.008, 0.006, 0.01, -0.01, 0.008] + 6 * [0.0])
START = common.moved(np.concatenate([TRUTH[:8], np.zeros(6)]), OFFSET)


def vector(v):
    """The rotation vector of a unit quaternion."""
    return 2 * np.arctan2(np.linalg.norm(v[1:]), v[0]) * v[1:] / np.linalg.norm(v[1:])


def quantities(values, unit):
    """A list of quantities as TOML."""
    return "[" + ", ".join(f'"{value:.17g} {unit}"' for value in values) + "]"


CAMPAIGN = f"""\
# Simulated recordings of a rotating arm, six rates, for comparison with other solvers.
title   = "Rotating arm, one setup, six runs"
model   = "polar_one_rotation"
effects = ["line_of_sight", "vertical_index", "distance_offset"]

[parameters]
radius      = {{ start = "{START[0]:.17g} m" }}
orientation = {{ start = {quantities(vector(START[1:5]), "rad")} }}
position    = {{ start = {quantities(START[5:8], "m")} }}

[measurands]
horizontal = {{ sigma = "6 urad" }}
vertical   = {{ sigma = "6 urad" }}
distance   = {{ sigma = "8 um" }}
"""

# The library's collimation, but with the zenith angle before the index, as the peers have it.
LINE_OF_SIGHT = """\
name  = "line_of_sight"
title = "Line of sight not square to the trunnion axis"
acts  = "instrument"

[parameters]
offset = { unit = "rad", typical = "4 arcsec", scope = "instrument" }

[patch]
horizontal = 'horizontal + offset / sin(atan2(hypot(point.x, point.y), point.z))'
"""


def make(folder, count):
    """Makes a folder with `count` samples, unless it is there."""
    folder = Path(folder)
    samples = folder / "samples.f64"
    if samples.exists() and samples.stat().st_size == count * 5 * 8:
        return
    (folder / "effects").mkdir(parents=True, exist_ok=True)
    (folder / "effects" / "line_of_sight.toml").write_text(LINE_OF_SIGHT)
    random = np.random.default_rng(2009)
    campaign = CAMPAIGN
    columns = []
    for number, (rate, share) in enumerate(zip(RATES, np.array_split(np.arange(count), 6))):
        duration = 3 * 2 * np.pi / abs(rate)
        times = np.arange(len(share)) * (duration / len(share))
        angle = 0.7 * number + rate * times
        rates = np.full(len(share), rate)
        exact = common.predict(TRUTH + 0j, angle, rates).real
        readings = exact + SIGMA[:, None] * random.standard_normal(exact.shape)
        readings[0] = common.wrapped(readings[0])
        columns.append(np.vstack([angle, rates, readings]))
        table = np.vstack([times + 1000.0 * number, columns[-1]]).T
        header = "time [s],arm_angle [rad],arm_angle_rate [rad/s]," \
                 "horizontal [rad],vertical [rad],distance [m]"
        np.savetxt(folder / f"run{number}.csv", table, "%.17g", ",", header=header, comments="")
        campaign += f'\n[[runs]]\nname = "run{number}"\ndata = "run{number}.csv"\n'
    SIGMA.tofile(folder / "sigma.f64")
    TRUTH.tofile(folder / "truth.f64")
    START.tofile(folder / "start.f64")
    (folder / "campaign.toml").write_text(campaign)
    np.hstack(columns).tofile(samples)
