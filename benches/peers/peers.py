"""The peers: how each is built and called, and under which name it appears.

A peer is called as `COMMAND JOB FOLDER` and prints one JSON line. `jobs` maps the common jobs (check, J,
J+NE, batch, newton, load) to the peer's own names. Building raises an error where a peer is not to
be had; the measurement then goes on without it.
"""

import json
import subprocess
import sys
import time
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).parent
BUILD = Path("target/peers/build")


@dataclass
class Peer:
    """One way to do the work."""

    name: str
    command: list
    jobs: dict
    # Seconds from the model's text to a ready function, where that is not a job of its own.
    load: float | None = None
    notes: list = field(default_factory=list)


def same(*jobs):
    return {job: job for job in jobs}


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def homepoint():
    lines = output("cargo", "bench", "--bench", "peers", "--no-run", "--message-format=json")
    built = [json.loads(line) for line in lines.splitlines()]
    (program,) = [one["executable"] for one in built
                  if one.get("executable") and one["target"]["name"] == "peers"]
    yield Peer("homepoint", [program], same("check", "J", "J+NE", "batch", "newton", "load"))


def python_peer(name, package, jobs):
    metadata.version(package)
    return Peer(name, [sys.executable, str(HERE / f"{package}_peer.py")], jobs)


def compile_cpp(source, program, *options):
    """Compiles one C++ file; returns the seconds it took."""
    start = time.perf_counter()
    output("g++", "-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-I/usr/include/eigen3",
           f"-I{HERE}", f"-I{BUILD}", str(HERE / source), "-o", str(BUILD / program), *options)
    return time.perf_counter() - start


def ceres():
    seconds = compile_cpp("ceres.cpp", "ceres", "-lceres", "-lglog")
    command = [str(BUILD / "ceres")]
    yield Peer("Ceres, AutoDiffCostFunction", command, same("check", "J", "J+NE"), seconds)
    yield Peer("Ceres, loop over Jets", command,
               {job: f"{job}-jets" for job in ("check", "J", "J+NE", "newton")})
    yield Peer("Ceres, DENSE_NORMAL_CHOLESKY", command, same("check", "batch"))
    yield Peer("Ceres, DENSE_QR", command, {"check": "check", "batch": "batch-qr"})


def symforce():
    metadata.version("symforce")
    generated = float(output(sys.executable, str(HERE / "symforce_generate.py"), str(BUILD)))
    for name, program, options in (
        ("SymForce, -O3 -march=native", "symforce", []),
        ("SymForce, -ffast-math too", "symforce_fast", ["-ffast-math"]),
    ):
        seconds = compile_cpp("symforce.cpp", program, *options)
        yield Peer(name, [str(BUILD / program)], same("check", "J", "J+NE"), generated + seconds)


def jax():
    yield python_peer("JAX", "jax", same("check", "J", "J+NE", "load"))
    yield python_peer("JAX, own Gauss-Newton", "jax", same("check", "batch"))


def scipy():
    yield python_peer("SciPy, newton", "scipy", same("check", "newton"))
    for method in ("trf", "lm"):
        jobs = {"check": "check", "batch": f"batch-{method}"}
        yield python_peer(f"SciPy, least_squares {method}", "scipy", jobs)


def numpy():
    yield python_peer("NumPy by hand", "numpy", same("check", "J", "J+NE"))
    yield python_peer("NumPy by hand, own Gauss-Newton", "numpy", same("check", "batch"))


def tiny_solver():
    # A copy, so that its lock file and its build stay out of the sources.
    folder = BUILD / "tiny_solver"
    (folder / "src").mkdir(parents=True, exist_ok=True)
    for name in ("Cargo.toml", "src/main.rs"):
        (folder / name).write_bytes((HERE / "tiny_solver" / name).read_bytes())
    output("cargo", "build", "--release", "--manifest-path", str(folder / "Cargo.toml"),
           "--target-dir", str(BUILD / "tiny_solver_target"))
    program = BUILD / "tiny_solver_target/release/tiny-solver-peer"
    yield Peer("tiny-solver", [str(program)], same("check", "J", "J+NE", "batch"))


def all_peers():
    """Every peer that can be built, homepoint first; and what was left out, with the reason."""
    BUILD.mkdir(parents=True, exist_ok=True)
    found, missing = list(homepoint()), []
    for family in (symforce, ceres, jax, scipy, numpy, tiny_solver):
        try:
            found += family()
        except (OSError, subprocess.CalledProcessError, metadata.PackageNotFoundError) as error:
            told = getattr(error, "stderr", None) or str(error)
            reason = told.strip().splitlines()[-1] if told.strip() else "no reason told"
            missing.append(f"{family.__name__} is skipped: {reason}")
    return found, missing


def versions():
    """What was compared, with versions."""
    told = [output("rustc", "--version").split(" (")[0], output("g++", "--version").splitlines()[0]]
    for package in ("symforce", "jax", "scipy", "numpy"):
        try:
            told.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:
            pass
    for package in ("libceres-dev", "libeigen3-dev"):
        asked = ("dpkg-query", "-W", "-f", "${Version}", package)
        found = subprocess.run(asked, capture_output=True, text=True).stdout
        if found:
            told.append(f"{package} {found}")
    cargo = (HERE / "tiny_solver/Cargo.toml").read_text()
    told.append("tiny-solver " + cargo.split('tiny-solver = "=')[1].split('"')[0])
    revision = subprocess.run(("git", "rev-parse", "--short", "HEAD"), capture_output=True, text=True)
    return [f"homepoint {revision.stdout.strip()}", *told]
