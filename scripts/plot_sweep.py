#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["matplotlib>=3.8"]
# ///
"""Plots success and length against a swept key, from summary.csv alone.

    uv run scripts/plot_sweep.py results/dwa_horizon_weight/summary.csv -o sweep.png
    python3 scripts/plot_sweep.py results/dwa_horizon_weight/summary.csv --x stacks.local.dwa.horizon_s

One line for each stack and each value of the other swept keys. Bars are the Wilson 95 % intervals of the success rate
and, below, one standard error of the mean length of the successful drives.
"""

import argparse
import csv
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("summary", help="summary.csv of a sweep")
    parser.add_argument("--x", help="swept key along the horizontal axis; the first one by default")
    parser.add_argument("-o", "--output", default="sweep.png", help="picture to write: .png, .svg or .pdf")
    args = parser.parse_args()

    with open(args.summary, newline="") as file:
        reader = csv.DictReader(file)
        rows, columns = list(reader), reader.fieldnames or []
    # Swept keys are the columns whose name is a path.
    keys = [name for name in columns if "." in name]
    if not keys:
        sys.exit(f"{args.summary}: no key was swept")
    x = args.x or keys[0]
    if x not in keys:
        sys.exit(f"{x} was not swept; swept were {', '.join(keys)}")

    places = {row[x]: None for row in rows if row[x]}
    # A key that does not touch a stack is empty in its rows: they hold at every value.
    rows = [{**row, x: value} for row in rows for value in ([row[x]] if row[x] else places)]
    lines = {}
    for row in rows:
        others = [f"{key.rsplit('.', 1)[-1]} {row[key]}" for key in keys if key != x and row[key]]
        lines.setdefault((row["stack"], *others), []).append(row)

    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8, 7), sharex=True, constrained_layout=True)
    numeric = all(is_number(value) for value in places)
    at = {value: float(value) if numeric else index for index, value in enumerate(places)}
    shown = 0.01 * (max(at.values()) - min(at.values()) or 1.0)
    for number, (name, points) in enumerate(lines.items()):
        shift = shown * (number - (len(lines) - 1) / 2)
        stacks = {row["stack"] for row in rows}
        label = ", ".join(name if len(stacks) > 1 else name[1:] or name)
        rate = [p for p in points if p["success_rate"]]
        xs = [at[p[x]] + shift for p in rate]
        ys = [100 * float(p["success_rate"]) for p in rate]
        low = [y - 100 * float(p["success_low"]) for y, p in zip(ys, rate)]
        high = [100 * float(p["success_high"]) - y for y, p in zip(ys, rate)]
        top.errorbar(xs, ys, yerr=[[max(v, 0) for v in low], [max(v, 0) for v in high]], marker="o", capsize=3, label=label)
        driven = [p for p in points if p["mean_length_m"]]
        errors = [float(p["sd_length_m"] or 0) / math.sqrt(max(successes(p), 1)) for p in driven]
        bottom.errorbar(
            [at[p[x]] + shift for p in driven], [float(p["mean_length_m"]) for p in driven], yerr=errors, marker="o", capsize=3
        )
    top.set_ylabel("success, %")
    top.set_ylim(0, 103)
    bottom.set_ylabel("mean length of successful drives, m")
    bottom.set_xlabel(x)
    if not numeric:
        bottom.set_xticks(list(at.values()), list(at))
    for axes in (top, bottom):
        axes.grid(alpha=0.3)
    if len(lines) > 1:
        top.legend(fontsize=8)
    top.set_title(rows[0]["scenario"])
    figure.savefig(args.output, dpi=110)
    print(args.output)


def successes(row):
    return int(row["success"])


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


if __name__ == "__main__":
    main()
