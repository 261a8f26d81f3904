"""Checks every peer against the common reference, times all in turn, writes the table.

Repetitions go round: every peer's job once, then all again, so that a slow spell of the machine meets
all alike. Each process runs on one CPU with one thread; a figure is the median of the rounds.
"""

import argparse
import datetime
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np

import common
import data
import numpy_peer
import peers

FOLDER = Path("target/peers")
# Agreement of residuals (in units of their sigma) and of Jacobians (of each column's largest).
AGREEMENT = 1e-9
# Batch estimates agree within this part of every parameter's standard uncertainty.
BATCH_AGREEMENT = 0.01
# Median delays of the readings agree within this (s): the few readings without a solution differ.
DELAY_AGREEMENT = 2e-8
# A batch is not repeated once its peer has used this time (s).
BATCH_TIME = 60
ONE_THREAD = {name: "1" for name in (
    "RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


def say(text):
    print(f"peers: {text}", file=sys.stderr)


def call(peer, job, folder, cpu):
    """Runs one job; its JSON line with the peak memory (bytes), or None."""
    process = subprocess.Popen(
        [*peer.command, peer.jobs[job], str(FOLDER / folder)], stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True, env=os.environ | ONE_THREAD,
        preexec_fn=lambda: os.sched_setaffinity(0, {cpu}),
    )
    told = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0 or not told.strip():
        say(f"{peer.name}: job {job} failed")
        return None
    return json.loads(told.splitlines()[-1]) | {"memory": usage.ru_maxrss * 1024}


def agrees(peer, cpu):
    """Whether a peer's residuals and Jacobian are those of the common reference."""
    samples = common.Data(FOLDER / "tiny")
    residual, jacobian = common.reference(samples, samples.truth)
    residual, jacobian = residual.T, jacobian.transpose(1, 0, 2)
    told = call(peer, "check", "tiny", cpu)
    if told is None:
        return False
    off = abs(np.reshape(told["residual"], residual.shape) - residual).max()
    columns = abs(np.reshape(told["jacobian"], jacobian.shape) - jacobian).max((0, 1))
    off = max(off, (columns / abs(jacobian).max((0, 1))).max())
    if not off <= AGREEMENT:
        say(f"{peer.name} differs from the reference by {off:.1e}: left out")
    return off <= AGREEMENT


def tangent(state, origin):
    """The step from one state to another."""
    inverse = origin[1:5] * [1, -1, -1, -1]
    turn = 2 * common.product(inverse, state[1:5])
    return np.concatenate([[state[0] - origin[0]], turn[1:] * np.sign(turn[0]), state[5:] - origin[5:]])


def measured(all_peers, jobs, arguments):
    """The results of every (job, peer) in all rounds."""
    results = {}
    for number in range(arguments.repeats):
        for job, folder in jobs.items():
            for peer in all_peers:
                if job not in peer.jobs:
                    continue
                known = results.setdefault((job, peer.name), [])
                spent = sum(one["seconds"] for one in known) if job == "batch" else 0
                if spent > BATCH_TIME or None in known:
                    continue
                say(f"round {number + 1}: {job}, {peer.name}")
                known.append(call(peer, job, folder, arguments.cpu))
    return {key: found for key, found in results.items() if found and None not in found}


def median(results, job, name, key):
    return statistics.median(one[key] for one in results[job, name])


def figure(value):
    """Three significant digits, no exponent above one."""
    if value >= 100:
        return f"{float(f'{value:.3g}'):.0f}"
    return f"{value:.3g}"


def times_table(results, names, columns):
    """Peers by jobs, each with its ratio to homepoint: `columns` are (job, key, heading)."""
    rows = ["| | " + " | ratio | ".join(heading for _, _, heading in columns) + " | ratio |",
            "|---|" + "--:|--:|" * len(columns)]
    for name in names:
        cells = []
        for job, key, _ in columns:
            if (job, name) in results:
                value = median(results, job, name, key)
                cells += [figure(value), figure(value / median(results, job, "homepoint", key))]
            else:
                cells += ["", ""]
        if any(cells):
            rows.append(f"| {name} | " + " | ".join(cells) + " |")
    return rows


def batch_table(results, names):
    """How the batch estimates went, and how far they are from homepoint's."""
    large = common.Data(FOLDER / "large")
    own = np.array(results["batch", "homepoint"][0]["state"])
    hessian, _, _ = numpy_peer.normal(large, own)
    uncertainty = np.sqrt(np.diag(np.linalg.inv(hessian)))
    seconds = median(results, "batch", "homepoint", "seconds")
    rows = ["| | s | iterations | s / iteration | peak memory, MB | farthest parameter, u | ratio |",
            "|---|--:|--:|--:|--:|--:|--:|"]
    for name in names:
        if ("batch", name) not in results:
            continue
        told = results["batch", name][0]
        value = median(results, "batch", name, "seconds")
        memory = median(results, "batch", name, "memory") / 1e6
        far = (abs(tangent(np.array(told["state"]), own)) / uncertainty).max()
        if not far <= BATCH_AGREEMENT:
            say(f"{name}: its estimate is {far:.2g} standard uncertainties from homepoint's")
        count = told.get("iterations")
        each = f"{count} | {figure(value / count)}" if count else "not told |"
        rows.append(f"| {name} | {figure(value)} | {each} | {memory:.0f} | {far:.1g} | "
                    f"{figure(value / seconds)} |")
    return rows


def warn_of_delays(results, names):
    own = np.array(results["newton", "homepoint"][0]["delays"])
    for name in names:
        if ("newton", name) in results:
            off = abs(np.array(results["newton", name][0]["delays"]) - own).max()
            if not off <= DELAY_AGREEMENT:
                say(f"{name}: its median delays differ by {off:.1e} s")


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return "unknown"


def vector_instructions():
    flags = Path("/proc/cpuinfo").read_text().split("flags", 1)[-1].split("\n")[0].split()
    return ", ".join(flag for flag in ("avx", "avx2", "fma", "avx512f") if flag in flags)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--batch-samples", type=int, default=1_000_000)
    parser.add_argument("--cpu", type=int, default=max(os.sched_getaffinity(0)))
    arguments = parser.parse_args()
    for folder, count in (("tiny", 60), ("small", arguments.samples), ("large", arguments.batch_samples)):
        data.make(FOLDER / folder, count)
    load = os.getloadavg()[0]
    found, missing = peers.all_peers()
    for one in missing:
        say(one)
    found = [peer for peer in found if agrees(peer, arguments.cpu)]
    names = [peer.name for peer in found]
    if "homepoint" not in names:
        sys.exit("peers: homepoint itself differs from the reference; nothing is timed")
    jobs = {"J": "small", "J+NE": "small", "newton": "small", "load": "tiny", "batch": "large"}
    results = measured(found, jobs, arguments)
    for peer in found:
        if peer.load is not None:
            results["load", peer.name] = [{"seconds": peer.load}]
    warn_of_delays(results, names)
    lines = [
        f"{datetime.date.today()}; {processor()} ({vector_instructions()}), {os.cpu_count()} CPUs, "
        f"load {load:.1f} before; one thread; {arguments.samples} samples of 3 readings, batch "
        f"{arguments.batch_samples}; median of rounds: {arguments.repeats}.",
        "Versions: " + ", ".join(peers.versions()) + ".", "",
        "Nanoseconds a sample (three readings); the ratio is to homepoint, above 1 is slower.", "",
        *times_table(results, names, [(job, "ns_per_sample", job) for job in ("J", "J+NE", "newton")]), "",
        "The batch estimate, seconds in all.", "",
        *batch_table(results, names), "",
        "From the model's text to a ready function, seconds.", "",
        *times_table(results, names, [("load", "seconds", "load")]), "",
        *missing,
    ]
    text = "\n".join(lines).rstrip() + "\n"
    (FOLDER / "table.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
