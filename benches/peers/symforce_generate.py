"""SymForce: writes C++ functions of one sample into a folder: `symforce_generate.py FOLDER`.

Residual (linearisation with Jacobian) and normal equations, each as one function with its common
subexpressions taken out. Tangents of the quaternion are SymForce's own (a turn from the right).
"""

import sys
import time
from pathlib import Path

import symforce

# The target is never on the instrument's vertical axis, so no epsilon is needed.
symforce.set_epsilon_to_number(1e-300)

import symforce.symbolic as sf  # noqa: E402
from symforce.codegen import Codegen, CppConfig  # noqa: E402
from symforce.values import Values  # noqa: E402


def symbols(name, count):
    return sf.Matrix([sf.Symbol(f"{name}{i}") for i in range(count)])


def generate(folder):
    state = symbols("state", 14)
    readings, weight = symbols("reading", 3), symbols("weight", 3)
    angle, rate = sf.Symbol("angle"), sf.Symbol("rate")
    orientation = sf.Rot3(sf.Quaternion(xyz=sf.V3(*state[2:5]), w=state[1]))
    position = sf.V3(*state[5:8])

    def point(delay):
        moment = angle + rate * delay
        target = state[0] * sf.V3(sf.cos(moment), sf.sin(moment), 0)
        return orientation * target + position

    x, y, z = point(state[8])
    sine = sf.sqrt(x**2 + y**2) / sf.sqrt(x**2 + y**2 + z**2)
    horizontal = sf.atan2(y, x, epsilon=0) + state[11] / sine
    x, y, z = point(state[9])
    vertical = sf.atan2(sf.sqrt(x**2 + y**2), z, epsilon=0) + state[12]
    x, y, z = point(state[10])
    distance = sf.sqrt(x**2 + y**2 + z**2) + state[13]

    difference = readings - sf.V3(horizontal, vertical, distance)
    turns = 2 * sf.pi
    difference[0] -= turns * sf.floor(difference[0] / turns + sf.S(1) / 2)
    residual = sf.V3(*[d * w for d, w in zip(difference, weight)])
    # The whole turns have no derivative.
    smooth = sf.V3(*[-p * w for p, w in zip((horizontal, vertical, distance), weight)])
    blocks = [smooth.jacobian(sf.V1(state[0])), smooth.jacobian(orientation)]
    blocks += [smooth.jacobian(sf.V1(one)) for one in state[5:14]]
    jacobian = sf.Matrix([[value for block in blocks for value in block[row, :]] for row in range(3)])

    inputs = Values(state=state, angle=angle, rate=rate, reading=readings, weight=weight)
    for name, outputs in {
        "residual_jacobian": Values(res=residual, jacobian=jacobian),
        "normal_equations": Values(
            hessian=(jacobian.T * jacobian).lower_triangle(), rhs=jacobian.T * residual
        ),
    }.items():
        code = Codegen(inputs=inputs, outputs=outputs, config=CppConfig(), name=name)
        code.generate_function(output_dir=folder, skip_directory_nesting=True)


if __name__ == "__main__":
    begin = time.perf_counter()
    generate(Path(sys.argv[1]))
    print(time.perf_counter() - begin)
