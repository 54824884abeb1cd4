"""Counts how many decisions change where the second implementation is changed in one place: what the comparison would notice.

    python3 tests/oracles/gao2025_changes.py

Takes every fifth problem of tests/data/decisions_gao2025.csv, and all with nothing admissible; prints a table of tests/oracles/README.md.
"""

import csv
import math
from multiprocessing import Pool

import decisions
import dynamic_window as core
import gao2025_paper as paper
from gao2025_dwa import decide

clearances_m, window = core.clearances_m, core.window


def changed_clearances(change):
    """The clearances with `change` made to them."""
    return lambda problem, poses, reach: [change(gap) for gap in clearances_m(problem, poses, reach)]


def line_clearances_m(problem, poses, reach):
    """Also at nine places on each step from the robot's own pose on, with movers where they are at its end."""
    found = clearances_m(problem, poses, reach)
    for share in (k / 10 for k in range(1, 10)):
        moved = [tuple(a + (b - a) * share for a, b in zip(p, q)) for p, q in zip(poses, poses[1:])]
        found += clearances_m(problem, [poses[0], *moved], reach)
    return found


def without_angular_half(problem, twist, clearance):
    arc = problem.sampling.va_distance == "arc"
    return clearance > 0.0 and (arc or twist[0] ** 2 <= 2.0 * clearance * problem.robot.deceleration_mps2)


CHANGES = {
    "none": {},
    "weight of `head` 2 % higher": {"HEADING_WEIGHT": 1.02 * paper.HEADING_WEIGHT},
    "weight of `dist` 2 % higher": {"DISTANCE_WEIGHT": 1.02 * paper.DISTANCE_WEIGHT},
    "weight of `vel` 2 % higher": {"VELOCITY_WEIGHT": 1.02 * paper.VELOCITY_WEIGHT},
    "weight of `dist_g` 2 % higher": {"GOAL_WEIGHT": 1.02 * paper.GOAL_WEIGHT},
    "clip of the clearance 2 % higher": {"CAP_M": 1.02 * paper.CAP_M},
    "`d2` at least 41 m": {"SEGMENT_MIN_M": 41.0},
    "horizon 2.9 s": {"STEPS": 29},
    "ω = 0 not sampled": {"window": lambda *axis: window(*axis[:-1], [x for x in axis[-1] if x != 0.0])},
    "movers stand": {"movers": lambda problem: [(x, y, radius, 0.0, 0.0) for x, y, radius, _, _ in problem.discs]},
    "movers move for `dwa` too": {"movers": lambda problem: problem.discs},
    "eq. 22 without its angular half": {"admissible": without_angular_half},
    "no eq. 22": {"admissible": lambda problem, twist, clearance: clearance > 0.0},
    "clearances between the poses count": {"clearances_m": line_clearances_m},
    "clearances 1 mm less": {"clearances_m": changed_clearances(lambda gap: gap - 1e-3)},
    "clearances rounded down to 0.1 mm": {"clearances_m": changed_clearances(lambda gap: math.floor(gap * 1e4) / 1e4)},
    "clearances rounded down to 1 mm": {"clearances_m": changed_clearances(lambda gap: math.floor(gap * 1e3) / 1e3)},
    "clearances rounded down to 1 cm": {"clearances_m": changed_clearances(lambda gap: math.floor(gap * 1e2) / 1e2)},
}


def differs(job):
    """Whether the second implementation with a change decides otherwise than simrun."""
    name, row = job
    changes = [(core if hasattr(core, key) else paper, key, value) for key, value in CHANGES[name].items()]
    unchanged = [(module, key, getattr(module, key)) for module, key, _ in changes]
    for change in changes:
        setattr(*change)
    try:
        return not decisions.is_same(row, decide(row))
    finally:
        for change in unchanged:
            setattr(*change)


def main():
    with open(decisions.DATA / "decisions.csv") as file:
        rows = [row for k, row in enumerate(csv.DictReader(file)) if k % 5 == 0 or row["recovers"] == "true"]
    groups = sorted({(row["va_distance"], row["planner"]) for row in rows})
    print("| change |", " | ".join(f"`{planner}`, `{va_distance}`" for va_distance, planner in groups), "|")
    print("|---" * (1 + len(groups)) + "|")
    with Pool() as pool:
        for name in CHANGES:
            cells = []
            for group in groups:
                mine = [row for row in rows if (row["va_distance"], row["planner"]) == group]
                cells.append(f"{sum(pool.map(differs, [(name, row) for row in mine], chunksize=5))} of {len(mine)}")
            print(f"| {name} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
