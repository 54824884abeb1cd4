#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["matplotlib>=3.8"]
# ///
"""Plots how simrun's cost grows, from the tables that the benches and scripts/time_threads.py write.

    cargo run --release -p simrun-benches -- --csv docs/book/src/performance/benches.csv
    scripts/time_threads.py --csv docs/book/src/performance/threads.csv
    uv run scripts/plot_growth.py docs/book/src/performance -o docs/book/src/performance/growth.svg
"""

import argparse
import csv
import pathlib
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="folder with benches.csv and threads.csv")
    parser.add_argument("-o", "--output", default="growth.svg", help="picture to write: .png, .svg or .pdf")
    args = parser.parse_args()
    with open(args.folder / "benches.csv", newline="") as file:
        benches = list(csv.DictReader(file))
    with open(args.folder / "threads.csv", newline="") as file:
        threads = list(csv.DictReader(file))

    matplotlib.rcParams["svg.hashsalt"] = "simrun"
    figure, axes = plt.subplots(2, 3, figsize=(11, 6.2), constrained_layout=True)
    (samples, obstacles, movers), (search, field, cores) = axes
    for axis, row, label in [
        (samples, "growth/samples", "candidates of a decision"),
        (obstacles, "growth/obstacles", "static discs"),
        (movers, "growth/movers", "movers"),
    ]:
        lines = [line for line in benches if line["row"] == row]
        spread(axis, [float(line["input"]) for line in lines], lines)
        axis.set(xlabel=label, ylabel="µs a tick")
    for axis, row, label in [(search, "grid_growth", "ns an expansion of a_star"), (field, "distance_field", "ns a cell of the field")]:
        lines = [line for line in benches if line["row"] == row]
        sides = [float(line["input"].split()[0]) for line in lines]
        # The time of all queries, or of one field, over the expansions, or the cells.
        units = [float(re.match(r"\d+", line["counts"])[0]) if row == "grid_growth" else side * side
                 for line, side in zip(lines, sides)]
        for line, unit in zip(lines, units):
            for key in ("ours_us", "ours_min_us", "ours_max_us"):
                line[key] = 1e3 * float(line[key]) / unit
        spread(axis, sides, lines)
        axis.set(xlabel="cells along a side of the map", ylabel=label)
        axis.set_xscale("log", base=2)
    numbers = [int(line["threads"]) for line in threads]
    rates = [float(line["times_one_thread"]) for line in threads]
    below = [rate - float(line["least"]) for rate, line in zip(rates, threads)]
    above = [float(line["most"]) - rate for rate, line in zip(rates, threads)]
    cores.errorbar(numbers, rates, yerr=[below, above], marker="o", capsize=3, color="C0")
    cores.plot(numbers, numbers, linestyle=":", color="grey", label="as many times as threads")
    cores.set(xlabel="threads", ylabel="episodes per second over one thread", xticks=numbers)
    cores.legend(frameon=False)
    for axis in axes.flat:
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
    figure.savefig(args.output, metadata={"Date": None} if args.output.endswith(".svg") else None)
    print(args.output)


def spread(axis, xs, lines):
    """Medians with bars from the least to the most."""
    middle, least, most = ([float(line[key]) for line in lines] for key in ("ours_us", "ours_min_us", "ours_max_us"))
    below = [m - l for m, l in zip(middle, least)]
    above = [h - m for m, h in zip(middle, most)]
    axis.errorbar(xs, middle, yerr=[below, above], marker="o", capsize=3, color="C0")


if __name__ == "__main__":
    main()
