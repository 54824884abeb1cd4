"""A table of decisions of simrun, and the table of a second implementation's answers to it."""

import csv
from collections import defaultdict
from multiprocessing import Pool
from pathlib import Path

import dynamic_window as core
from recovery import recovery

DATA = Path(__file__).resolve().parent.parent / "data"
COLUMNS = ["v", "omega", "recovers", "margin"]


def numbers(row, *keys):
    """The numbers in these columns."""
    return tuple(float(row[key]) for key in keys)


def surroundings(row, resolution_m):
    """The target, the map and the movers of a row, as the fields of a problem."""
    cells = [[int(number) for number in cell.split(":")] for cell in row["cells"].split()]
    return {
        "pose": numbers(row, "x", "y", "theta"),
        "twist": numbers(row, "v", "omega"),
        "target": numbers(row, "target_x", "target_y"),
        "size": tuple(side * resolution_m for side in numbers(row, "cols", "rows")),
        "boxes": [tuple(side * resolution_m for side in (col, line, col + 1, line + 1)) for col, line in cells],
        "discs": [tuple(float(number) for number in mover.split(":")) for mover in row["movers"].split()],
    }


def answer(problem, found):
    """The line for a problem whose admissible candidates these are: the command, whether there are none, and the margin."""
    if not found:
        return dict(zip(COLUMNS, (*recovery(problem), "true", None)))
    best = core.choose(found)
    return dict(zip(COLUMNS, (*best.twist, "false", core.margin(found, best))))


def is_same(row, line):
    """Whether simrun decided the same; the ends of the window carry the rounding of their sums."""
    near = [abs(float(row[theirs]) - line[ours]) <= 1e-9 for theirs, ours in (("command_v", "v"), ("command_omega", "omega"))]
    return all(near) and row["recovers"] == line["recovers"]


def digest(content):
    """FNV-1a, 64 bits."""
    value = 0xCBF29CE484222325
    for byte in content:
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}"


def write(path, source, content, columns, lines):
    """Writes lines of answers to `source`, of which this is the content."""
    with open(path, "w", newline="") as file:
        file.write(f"# of {source} with the FNV-1a digest {digest(content)}\n")
        out = csv.DictWriter(file, columns, lineterminator="\n")
        out.writeheader()
        for line in lines:
            out.writerow({key: f"{value:.10g}" if isinstance(value, float) else value for key, value in line.items()})


def show(rows, lines, keys):
    """Prints a table of how many are the same for each value of these columns, and every decision that differs."""
    groups = defaultdict(list)
    for row, line in zip(rows, lines):
        groups[tuple(row[key] for key in keys)].append((row, line))
    print("|", " | ".join(f"`{key}`" for key in keys), "| decisions | with movers | nothing admissible | same |")
    print("|---" * (len(keys) + 4) + "|")
    for values, mine in sorted(groups.items()):
        movers = sum(row["movers"] != "" for row, _ in mine)
        empty = sum(line["recovers"] == "true" for _, line in mine)
        equal = sum(is_same(row, line) for row, line in mine)
        print("|", " | ".join(f"`{value}`" for value in values), f"| {len(mine)} | {movers} | {empty} | {equal} |")
    margins = sorted(line["margin"] for line in lines if line["margin"] is not None)
    if margins:
        print("smallest margins:", *(f"{margin:.2g}" for margin in margins[:8]), f"median: {margins[len(margins) // 2]:.2g}")
    for row, line in zip(rows, lines):
        if not is_same(row, line):
            print({key: value for key, value in row.items() if key != "cells"}, line)


def compare(name, decide, keys):
    """Answers every row of `name`.csv, writes `name`_second.csv, and prints where they agree."""
    content = (DATA / f"{name}.csv").read_bytes()
    rows = list(csv.DictReader(content.decode().splitlines()))
    with Pool() as pool:
        lines = pool.map(decide, rows, chunksize=20)
    write(DATA / f"{name}_second.csv", f"{name}.csv", content, COLUMNS, lines)
    show(rows, lines, keys)
