"""Decides the problems of tests/data/decisions_gao2025.csv anew, from the paper, and says where simrun decides otherwise.

    python3 tests/oracles/gao2025_dwa.py

Writes tests/data/decisions_gao2025_second.csv and prints the tables of tests/oracles/README.md. Takes about a minute; the standard library is enough.
"""

import decisions
import gao2025_paper as paper


def decide(row):
    """The line of decisions_gao2025_second.csv for a row."""
    problem = paper.Problem(
        robot=paper.ROBOT,
        sampling=paper.sampling(row["va_distance"]),
        predict=row["planner"] == "imp_dwa",
        planner=row["planner"],
        previous=decisions.numbers(row, "previous_x", "previous_y"),
        **decisions.surroundings(row, 1.0),
    )
    return decisions.answer(problem, paper.scored(problem))


if __name__ == "__main__":
    decisions.compare("decisions_gao2025", decide, ["va_distance", "planner"])
