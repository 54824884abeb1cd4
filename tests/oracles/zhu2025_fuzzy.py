"""Writes tests/data/fuzzy.csv: the weights that scikit-fuzzy gives for Table 1 of zhu2025.

    python3 tests/oracles/zhu2025_fuzzy.py > tests/data/fuzzy.csv

Needs scikit-fuzzy and what it asks for: pip install scikit-fuzzy numpy scipy networkx packaging. src/plan/local/fuzzy_dwa/controller.rs
reads the table in a test. Triangles, minimum for "and" and for the implication, maximum for the aggregation, centroid over 20,001 points.
The inputs are not rounded: memberships are interpolated between the points of their universes, and the corners of
the triangles are points of them.
"""

import sys

import numpy as np
from skfuzzy import control

# D_obs, D_goal, alpha, beta, gamma, lambda, in the order of the table; rule 7 beta and rule 16 as systems.md completes them.
TABLE = """
1 1 1 2 3 2
1 2 1 3 3 2
1 4 1 4 4 2
1 3 1 4 3 2
2 1 3 1 3 3
2 2 3 2 3 3
2 3 2 3 3 3
2 4 2 4 4 3
3 1 3 1 3 1
3 2 3 1 3 2
3 3 3 1 3 3
3 4 3 1 4 4
4 1 4 1 2 1
4 2 4 1 2 1
4 3 4 1 3 2
4 4 4 1 4 3
"""
RULES = [[int(number) for number in line.split()] for line in TABLE.split("\n") if line]
OBSTACLE_RANGE_M, GOAL_RANGE_M = 3.0, 10.0
WEIGHTS = ["alpha", "beta", "gamma", "lambda"]


def with_triangles(variable, top):
    """Gives a variable the four triangles with peaks at 0, 1/3, 2/3 and 1 of its universe."""
    peaks = [0.0, top / 3.0, 2.0 * top / 3.0, top]
    for number, peak in enumerate(peaks, start=1):
        low, high = peak - top / 3.0, peak + top / 3.0
        variable[str(number)] = np.clip(np.minimum((variable.universe - low) / (peak - low), (high - variable.universe) / (high - peak)), 0.0, 1.0)
    return variable


def controller():
    """The control system of the table."""
    # 3,001 points: a third of the range is one of them.
    obstacle = with_triangles(control.Antecedent(np.linspace(0.0, OBSTACLE_RANGE_M, 3001), "obstacle"), OBSTACLE_RANGE_M)
    goal = with_triangles(control.Antecedent(np.linspace(0.0, GOAL_RANGE_M, 3001), "goal"), GOAL_RANGE_M)
    outputs = [with_triangles(control.Consequent(np.linspace(0.0, 1.0, 20001), name, defuzzify_method="centroid"), 1.0) for name in WEIGHTS]
    rules = [
        control.Rule(obstacle[str(row[0])] & goal[str(row[1])], [output[str(number)] for output, number in zip(outputs, row[2:])])
        for row in RULES
    ]
    return control.ControlSystemSimulation(control.ControlSystem(rules), clip_to_bounds=True)


def main():
    simulation = controller()
    print("obstacle_m,goal_m," + ",".join(WEIGHTS))
    # A lattice that meets peaks, middles and places between, and one pair beyond both ranges.
    points = [(round(0.15 * i, 3), round(0.5 * k, 3)) for i in range(21) for k in range(21)] + [(7.0, 25.0)]
    for obstacle_m, goal_m in points:
        simulation.input["obstacle"], simulation.input["goal"] = obstacle_m, goal_m
        simulation.compute()
        print(f"{obstacle_m},{goal_m}," + ",".join(f"{simulation.output[name]:.9f}" for name in WEIGHTS))
        sys.stdout.flush()


main()
