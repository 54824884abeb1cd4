#!/usr/bin/env python3
"""Times a run of simrun with 1, 2, ... threads in turn, and checks that the results are the same bytes.

    scripts/time_threads.py                          episodes per second on the screen
    scripts/time_threads.py --csv threads.csv --rounds 7

Builds simrun in release mode first.
"""

import argparse
import csv
import filecmp
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

from release import ROOT, build


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="scenarios/warehouse.yaml", help="default: %(default)s")
    parser.add_argument("--episodes", type=int, default=60, help="episodes of each stack (default %(default)s)")
    parser.add_argument("--rounds", type=int, default=5, help="times that each number of threads runs (default %(default)s)")
    parser.add_argument("--most", type=int, default=len(os.sched_getaffinity(0)), help="most threads; default: all cores")
    parser.add_argument("--csv", help="file to write the table to as well")
    args = parser.parse_args()

    simrun = build("simrun")
    numbers = range(1, args.most + 1)
    rates = {threads: [] for threads in numbers}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(args.rounds):
            for threads in numbers:
                out = pathlib.Path(folder) / str(threads)
                call = [simrun, args.scenario, "--episodes", str(args.episodes),
                        "--threads", str(threads), "--quiet", "--force", "--out", out]
                begin = time.perf_counter()
                subprocess.run(call, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
                time_s = time.perf_counter() - begin
                with open(out / "episodes.csv", newline="") as file:
                    rates[threads].append(sum(1 for _ in csv.DictReader(file)) / time_s)
                for name in ("episodes.csv", "summary.csv"):
                    assert filecmp.cmp(out / name, pathlib.Path(folder) / "1" / name, shallow=False), f"{name} differs"

    header = ["threads", "episodes_per_s", "times_one_thread", "least", "most"]
    rows = []
    for threads in numbers:
        ratios = [rate / one for rate, one in zip(rates[threads], rates[1])]
        figures = [statistics.median(rates[threads]), statistics.median(ratios), min(ratios), max(ratios)]
        rows.append([threads, *(round(figure, 2) for figure in figures)])
    for row in [header, *rows]:
        print("  ".join(f"{value!s:<16}" for value in row))
    if args.csv:
        with open(args.csv, "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([header, *rows])


if __name__ == "__main__":
    main()
