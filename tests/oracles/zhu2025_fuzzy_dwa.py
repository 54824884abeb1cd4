"""Decides the problems of tests/data/decisions_zhu2025.csv anew, from the paper, and says where simrun decides otherwise.

    python3 tests/oracles/zhu2025_fuzzy_dwa.py              writes tests/data/decisions_zhu2025_second.csv, prints the table of the README
    python3 tests/oracles/zhu2025_fuzzy_dwa.py --self-test  checks the fuzzy controller against cases worked by hand

The standard library is enough.
"""

import math
import sys

import decisions
import dynamic_window as core
import zhu2025_paper as paper

# The paper prints no limits: systems.md, U-A16 and section 10. A column of one of these names holds instead, where the table has it.
LIMITS = {
    "radius_m": 0.15,
    "speed_max_mps": 1.0,
    "yaw_rate_max_radps": math.radians(20.0),
    "acceleration_mps2": 0.2,
    "deceleration_mps2": 0.2,
    "yaw_acceleration_radps2": math.radians(50.0),
}
SAMPLING = {
    "speed_step_mps": 0.01,
    "yaw_rate_step_radps": math.radians(1.0),
    "tick_s": 0.1,
    "horizon_s": 3.0,
    "cap_m": 2.0,
}


def given(row, defaults):
    """These numbers, from the row where it has them."""
    return {key: float(row.get(key, value)) for key, value in defaults.items()}


def one_of(row, key, words):
    """The word in this column."""
    if row[key] not in words:
        raise ValueError(f"{key} is {row[key]!r}, expected one of {', '.join(words)}")
    return row[key]


def problem_of(row):
    """The problem of a row."""
    one_of(row, "planner", ["fuzzy_dwa"])
    sampling = given(row, SAMPLING)
    steps = math.floor(sampling.pop("horizon_s") / sampling["tick_s"] + 0.5)
    fixed = one_of(row, "weights", ["fuzzy", "fixed"]) == "fixed"
    far = ("target_x", "target_y") if one_of(row, "d_goal_of", ["sub_goal", "goal"]) == "sub_goal" else ("goal_x", "goal_y")
    return paper.Problem(
        robot=core.Robot(**given(row, LIMITS)),
        sampling=core.Sampling(steps=steps, va_distance=one_of(row, "va_distance", ["arc", "clearance"]), **sampling),
        predict=one_of(row, "predict", ["true", "false"]) == "true",
        far_target=decisions.numbers(row, *far),
        fixed_weights=decisions.numbers(row, "w_head", "w_dist", "w_vel", "w_goal") if fixed else (),
        **decisions.surroundings(row, float(row["resolution_m"])),
    )


def decide(row):
    """The line of decisions_zhu2025_second.csv for a row."""
    problem = problem_of(row)
    return decisions.answer(problem, paper.scored(problem))


# D_obs, D_goal, and alpha, beta, gamma, lambda as worked by hand. One rule alone gives the centres of whole sets: the half triangles M1 and M4
# have theirs at a third of 1/3 from their peak, 1/9 and 8/9; M2 and M3 at their peaks, 1/3 and 2/3. Cut at 1/2, M1 has the area 1/8 and the
# moment 7/432, M3 1/4 and 1/6; M1 with M2, which overlap, 7/24 and 37/432; M4, and M3 with M4, are those mirrored.
BY_HAND = [
    (0.0, 0.0, 1 / 9, 1 / 3, 2 / 3, 1 / 3),  # rule 1
    (0.0, 10.0, 1 / 9, 8 / 9, 8 / 9, 1 / 3),  # rule 3
    (0.0, 20 / 3, 1 / 9, 8 / 9, 2 / 3, 1 / 3),  # rule 4
    (1.0, 20 / 3, 1 / 3, 2 / 3, 2 / 3, 2 / 3),  # rule 7
    (2.0, 0.0, 2 / 3, 1 / 9, 2 / 3, 1 / 9),  # rule 9
    (3.0, 10.0, 8 / 9, 1 / 9, 8 / 9, 2 / 3),  # rule 16
    (50.0, 41.0, 8 / 9, 1 / 9, 8 / 9, 2 / 3),  # rule 16, saturated
    (0.5, 0.0, 79 / 162, 37 / 126, 2 / 3, 1 / 2),  # rules 1 and 5 at 1/2: M1 M3, M1 M2, M3, M2 M3
    (2.5, 10.0, 89 / 126, 7 / 54, 47 / 54, 89 / 126),  # rules 12 and 16 at 1/2: M3 M4, M1, M4, M3 M4
]


def self_test():
    """Fails where the fuzzy controller is not as worked by hand."""
    for obstacle_m, goal_m, *expected in BY_HAND:
        found = paper.fuzzy_weights(obstacle_m, goal_m)
        assert all(math.isclose(a, b, rel_tol=1e-14) for a, b in zip(found, expected)), (obstacle_m, goal_m, found, expected)
    # Against sums over 100,000 points, where all sets are cut at different heights.
    for heights in ((0.3, 0.9, 0.2, 0.6), (0.0, 0.4, 0.7, 0.0), (0.55, 0.0, 0.0, 0.1), (1.0, 1.0, 1.0, 1.0)):
        places = [(k + 0.5) / 100000 for k in range(100000)]
        union = [max(min(h, max(0.0, 1.0 - abs(3.0 * x - peak))) for peak, h in enumerate(heights)) for x in places]
        summed = sum(x * y for x, y in zip(places, union)) / sum(union)
        assert abs(summed - paper.centroid(heights)) < 1e-9, (heights, summed, paper.centroid(heights))
    print("the fuzzy controller is as worked by hand")


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        self_test()
    else:
        decisions.compare("decisions_zhu2025", decide, ["weights", "d_goal_of", "va_distance"])
