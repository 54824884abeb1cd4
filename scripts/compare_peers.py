#!/usr/bin/env python3
"""Times simrun beside peers that are written for Python, on the same scenes and the same core.

    scripts/compare_peers.py                         table on the screen
    scripts/compare_peers.py --csv peers.csv --pairs 9

The peers are installed by name, each at the version stated below, into an environment that is thrown away afterwards
(--environment FOLDER keeps it). The two sides run in turn, A B A B; each pair gives a ratio, and what counts is the
median of the ratios. The peers that are written in Rust are in the benches: cargo run --release -p simrun-benches.

Needs Python 3.11 or newer with venv, Linux, and the network for the peers.
"""

import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

from release import ROOT, build

SCENES = ROOT / "benches" / "scenes"
PEERS = ROOT / "scripts" / "peers"
PACKAGES = [
    "navground==0.7.0", "ir-sim==2.12.0", "tcod==21.2.2", "pathfinding==1.0.23", "python-motion-planning==2.1",
    "numpy==2.4.6", "scipy==1.17.1", "shapely==2.2.0", "numba==0.68.1", "gymnasium==1.4.0", "PyYAML==6.0.3",
]


def simulator(tool):
    return [PEERS / "simulators.py", tool, SCENES / "world30.world"], []


def planner(tool, scene, queries):
    return [PEERS / "planners.py", tool, SCENES / f"{scene}.map", SCENES / f"{scene}.scen"], [queries]


# What is done; row and input of simrun's benches; the peer and how it is called; how many times as fast simrun is to be.
COMPARISONS = [
    ("tick, 35 rollouts", "tick/world30/35", "5 x 7 samples", "navground 0.7.0 HL", simulator("navground"), 1.5),
    ("tick, 35 rollouts", "tick/world30/35", "5 x 7 samples", "ir-sim 2.12.0 dash", simulator("irsim"), 200),
    ("tick, 400 rollouts", "tick/world30/400", "20 x 20 samples", "ir-sim 2.12.0 dash", simulator("irsim"), 60),
    ("a_star, 100 x 100", "a_star", "random100-20", "tcod 21.2.2", planner("tcod", "random100-20", 50), None),
    ("a_star, 512 x 512", "a_star", "random512-20", "tcod 21.2.2", planner("tcod", "random512-20", 20), None),
    ("a_star, 100 x 100", "a_star", "random100-20", "pathfinding 1.0.23", planner("pathfinding", "random100-20", 50), None),
    ("a_star, 100 x 100", "a_star", "random100-20", "python-motion-planning 2.1",
     planner("python_motion_planning", "random100-20", 50), None),
]
COLUMNS = ["job", "simrun_us", "peer", "peer_us", "times_as_fast", "least", "most", "pairs", "target", "verdict"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=5, help="pairs of measurements (default 5)")
    parser.add_argument("--core", type=int, default=0, help="the core that both sides run on (default 0)")
    parser.add_argument("--csv", help="file to write the table to as well")
    parser.add_argument("--environment", help="folder of the peers' environment: made if it is not there, and kept")
    parser.add_argument("--only", default="", help="only comparisons whose job or peer contains this")
    args = parser.parse_args()
    wanted = [c for c in COMPARISONS if args.only in c[0] or args.only in c[3]]
    if not wanted:
        sys.exit(f"no comparison contains {args.only!r}")

    benches = build("simrun-benches")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        python = environment(pathlib.Path(args.environment) if args.environment else folder / "environment")
        rows = []
        for comparison in wanted:
            rows.append(compare(comparison, benches, python, folder, args))
            print("  ".join(f"{str(value):<{width}}" for value, width in zip(rows[-1], WIDTHS)), flush=True)
    if args.csv:
        with open(args.csv, "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])


WIDTHS = [18, 9, 26, 9, 8, 8, 8, 2, 6, 6]


def environment(folder):
    """The Python that the peers are installed for."""
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES], check=True)
    return python


def compare(comparison, benches, python, folder, args):
    job, row, scene, peer, (call, last), target = comparison
    pairs = []
    for _ in range(args.pairs):
        pairs.append((ours(benches, row, scene, folder, args.core), theirs(python, [*call, args.core, *last])))
    ratios = [theirs / ours for ours, theirs in pairs]
    median = statistics.median
    verdict = "" if target is None else "met" if median(ratios) >= target else "MISSED"
    figures = [round(median(ratios), 2), round(min(ratios), 2), round(max(ratios), 2)]
    ours_us, theirs_us = (round(median(side), 2) for side in zip(*pairs))
    return [job, ours_us, peer, theirs_us, *figures, args.pairs, target or "", verdict]


def ours(benches, row, scene, folder, core):
    """Microseconds of simrun, by its bench."""
    table = folder / "ours.csv"
    bench = [benches, "--pairs", 3, "--core", core, "--csv", table, row]
    output([str(word) for word in bench])
    with open(table, newline="") as file:
        return next(float(line["ours_us"]) for line in csv.DictReader(file) if (line["row"], line["input"]) == (row, scene))


def theirs(python, call):
    """Microseconds of the peer, from the last line that its script prints."""
    return json.loads(output([str(word) for word in [python, *call]]).splitlines()[-1])["us"]


def output(call):
    done = subprocess.run(call, capture_output=True, text=True, cwd=ROOT)
    if done.returncode != 0:
        sys.exit(f"{' '.join(call)}\n{done.stdout}{done.stderr}")
    return done.stdout


if __name__ == "__main__":
    main()
