"""Decides the problems of tests/data/decisions.csv anew, from the paper, and says where and why simrun decides otherwise.

    python3 tests/oracles/gao2025_dwa.py

Writes tests/data/decisions_second.csv and prints the tables of tests/oracles/README.md. Takes some minutes; the standard library is enough.
"""

import csv
import math
from collections import Counter
from multiprocessing import Pool
from pathlib import Path

import gao2025_bound as simrun
import gao2025_paper as paper

DATA = Path(__file__).resolve().parent.parent / "data"
COLUMNS = ["v", "omega", "score_best", "score_simrun", "score_mean", "bound_v", "bound_omega", "reason"]


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


def same(a, b):
    """Whether two twists are one; the ends of the window carry the rounding of their sums."""
    return abs(a[0] - b[0]) <= 1e-9 and abs(a[1] - b[1]) <= 1e-9


def compare(row):
    """The line of decisions_second.csv for a row, and what the tables need besides."""
    problem = problem_of(row)
    theirs = float(row["command_v"]), float(row["command_omega"])
    recovers = row["recovers"] == "true"
    ours, found, scored = paper.decide(problem)
    line, _, line_scored = paper.decide(problem, paper.line_clearance_m)

    bound = simrun.Bound(problem, paper.reach_m(problem))
    bounded, bound_found, bound_scored = paper.decide(problem, bound)
    if not bound_scored:
        bounded = simrun.recovery(problem, bound)

    best = max((c.score for c in scored), default=None)
    worst = min((c.score for c in scored), default=None)
    mean = sum(c.score for c in scored) / len(scored) if scored else None
    theirs_scored = next((c.score for c in scored if same(c.twist, theirs)), None)

    def agrees(command, scored):
        return same(command, theirs) and recovers != bool(scored)

    if agrees(ours, scored):
        reason = "same"
    elif agrees(bounded, bound_scored):
        reason = "bound" if scored else "recovery"
    else:
        reason = "unexplained"

    both = [(a, b) for a, b in zip(found, bound_found) if b.admissible]
    return dict(zip(COLUMNS, (*ours, best, theirs_scored, mean, *bounded, reason))), {
        "group": (row["planner"], row["va_distance"]),
        "movers": bool(problem.discs),
        "line_equal": agrees(line, line_scored),
        "bound_equal": agrees(bounded, bound_scored),
        "empty": (not scored, not bound_scored),
        "gap": None if theirs_scored is None or recovers else (best - theirs_scored) / mean,
        "rank": None if theirs_scored is None or recovers else sum(c.score > theirs_scored for c in scored),
        "candidates": len(scored),
        "spread": (best - worst) / mean if scored else None,
        "step": (abs(ours[0] - theirs[0]), abs(ours[1] - theirs[1])),
        "slack": [a.clearance_m - b.clearance_m for a, b in both],
        "in_contact": bound.in_contact,
    }


def digest(content):
    """FNV-1a, 64 bits."""
    value = 0xCBF29CE484222325
    for byte in content:
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}"


def quantile(values, q):
    """The value at the share q of the sorted list."""
    values = sorted(values)
    return values[round(q * (len(values) - 1))] if values else math.nan


def show(results):
    """Prints the tables of the README."""
    groups = sorted({more["group"] for _, more in results}, key=lambda group: (group[1], group[0]))
    print("| planner | `va_distance` | decisions | with movers | same | bound | recovery | unexplained |")
    print("|---|---|---|---|---|---|---|---|")
    for group in groups:
        mine = [(line, more) for line, more in results if more["group"] == group]
        count = Counter(line["reason"] for line, _ in mine)
        shares = [f"{count[reason]} ({100 * count[reason] / len(mine):.1f} %)" for reason in ("same", "bound")]
        rest = [str(count[reason]) for reason in ("recovery", "unexplained")]
        movers = sum(more["movers"] for _, more in mine)
        print("|", " | ".join([f"`{group[0]}`", f"`{group[1]}`", str(len(mine)), str(movers), *shares, *rest]), "|")
    print()
    print("| planner | `va_distance` | same by the line | same with the bound | gap, median | gap, 99 % | spread, median | rank, median (of) | not admissible | \\|Δv\\| ≤ 0.01 | \\|Δω\\| ≤ 0.01 |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for group in groups:
        mine = [more for _, more in results if more["group"] == group]
        apart = [more for line, more in results if more["group"] == group and line["reason"] == "bound"]
        gaps = [more["gap"] for more in apart if more["gap"] is not None]
        steps = [more["step"] for more in apart]
        cells = [
            f"`{group[0]}`",
            f"`{group[1]}`",
            f"{sum(more['line_equal'] for more in mine)}",
            f"{sum(more['bound_equal'] for more in mine)} of {len(mine)}",
            f"{100 * quantile(gaps, 0.5):.2f} %",
            f"{100 * quantile(gaps, 0.99):.1f} %",
            f"{100 * quantile([more['spread'] for more in apart], 0.5):.0f} %",
            f"{1 + quantile([more['rank'] for more in apart if more['rank'] is not None], 0.5)}"
            f" ({quantile([more['candidates'] for more in apart], 0.5)})",
            f"{sum(more['gap'] is None for more in apart)}",
            f"{100 * sum(v <= 0.0101 for v, _ in steps) / len(steps):.0f} %",
            f"{100 * sum(omega <= 0.0101 for _, omega in steps) / len(steps):.0f} %",
        ]
        print("|", " | ".join(cells), "|")
    slack = [value for _, more in results for value in more["slack"]]
    print()
    print(f"clearance bound below the exact one, {len(slack)} rollouts: least {1000 * min(slack):.4f} mm, mean {1000 * sum(slack) / len(slack):.2f} mm,")
    print(f"90 % {1000 * quantile(slack, 0.9):.2f} mm, most {1000 * max(slack):.1f} mm")
    print(f"nothing admissible, exact and bound: {Counter(more['empty'] for _, more in results)}")
    print(f"believed in contact: {sum(more['in_contact'] for _, more in results)}")


def main():
    content = (DATA / "decisions.csv").read_bytes()
    rows = list(csv.DictReader(content.decode().splitlines()))
    with Pool() as pool:
        results = pool.map(compare, rows, chunksize=20)
    with open(DATA / "decisions_second.csv", "w", newline="") as file:
        file.write(f"# of decisions.csv with the FNV-1a digest {digest(content)}\n")
        out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        out.writeheader()
        for line, _ in results:
            out.writerow({key: f"{value:.10g}" if isinstance(value, float) else value for key, value in line.items()})
    show(results)
    for row, (line, _) in zip(rows, results):
        if line["reason"] == "unexplained":
            print(row, line)


if __name__ == "__main__":
    main()
