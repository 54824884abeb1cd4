"""Decides the problems of tests/data/decisions.csv anew, from the paper, and says where simrun decides otherwise.

    python3 tests/oracles/gao2025_dwa.py

Writes tests/data/decisions_second.csv and prints the tables of tests/oracles/README.md. Takes about a minute; the standard library is enough.
"""

import csv
from collections import defaultdict
from multiprocessing import Pool
from pathlib import Path

import gao2025_paper as paper
from gao2025_recovery import recovery

DATA = Path(__file__).resolve().parent.parent / "data"
COLUMNS = ["v", "omega", "recovers", "margin"]


def problem_of(row):
    """The problem of a row."""

    def numbers(*keys):
        return tuple(float(row[key]) for key in keys)

    cells = [[int(number) for number in cell.split(":")] for cell in row["cells"].split()]
    return paper.Problem(
        planner=row["planner"],
        va_distance=row["va_distance"],
        pose=numbers("x", "y", "theta"),
        twist=numbers("v", "omega"),
        target=numbers("target_x", "target_y"),
        previous=numbers("previous_x", "previous_y"),
        size=numbers("cols", "rows"),
        boxes=[(col, line, col + 1, line + 1) for col, line in cells],
        discs=[tuple(float(number) for number in mover.split(":")) for mover in row["movers"].split()],
    )


def decide(row):
    """The line of decisions_second.csv for a row: the command, whether nothing is admissible, and how much less than the best the
    second best scores, over the best."""
    problem = problem_of(row)
    found = paper.scored(problem)
    if not found:
        return dict(zip(COLUMNS, (*recovery(problem), "true", None)))
    best = paper.choose(found)
    second = max((candidate.score for candidate in found if candidate is not best), default=None)
    return dict(zip(COLUMNS, (*best.twist, "false", None if second is None else 1.0 - second / best.score)))


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


def show(rows, lines):
    """Prints the table of the README and every decision that differs."""
    groups = defaultdict(list)
    for row, line in zip(rows, lines):
        groups[row["va_distance"], row["planner"]].append((row, line))
    print("| planner | `va_distance` | decisions | with movers | nothing admissible | same |")
    print("|---|---|---|---|---|---|")
    for (va_distance, planner), mine in sorted(groups.items()):
        movers = sum(row["movers"] != "" for row, _ in mine)
        empty = sum(line["recovers"] == "true" for _, line in mine)
        equal = sum(is_same(row, line) for row, line in mine)
        print(f"| `{planner}` | `{va_distance}` | {len(mine)} | {movers} | {empty} | {equal} |")
    margins = sorted(line["margin"] for line in lines if line["margin"] is not None)
    print("smallest margins:", *(f"{margin:.2g}" for margin in margins[:8]), f"median: {margins[len(margins) // 2]:.2g}")
    for row, line in zip(rows, lines):
        if not is_same(row, line):
            print(row, line)


def main():
    content = (DATA / "decisions.csv").read_bytes()
    rows = list(csv.DictReader(content.decode().splitlines()))
    with Pool() as pool:
        lines = pool.map(decide, rows, chunksize=20)
    with open(DATA / "decisions_second.csv", "w", newline="") as file:
        file.write(f"# of decisions.csv with the FNV-1a digest {digest(content)}\n")
        out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        out.writeheader()
        for line in lines:
            out.writerow({key: f"{value:.10g}" if isinstance(value, float) else value for key, value in line.items()})
    show(rows, lines)


if __name__ == "__main__":
    main()
