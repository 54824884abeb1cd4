"""Local planner of zhu2025, a dynamic window with a fuzzy controller for its weights, written from the paper.

Zhu, Tu, Shen, Yin, Zhang, Zhao, Chen, 2025, eq. 11 to 17 and table 1. Where the paper leaves something open, this program follows
docs/book/src/papers/systems.md (the ids U-A..). It shares no code with simrun. The standard library is enough.
"""

import math
from dataclasses import dataclass

import dynamic_window as core

GOAL_DISTANCE_MIN_M = 0.1  # U-A9

# U-A10: where the inputs are saturated; the sets are triangles with peaks at 0, 1/3, 2/3 and 1 of that, and of 1 for the outputs.
OBSTACLE_UNIVERSE_M = 3.0
GOAL_UNIVERSE_M = 10.0

# Table 1: sets of D_obs and D_goal, then of alpha, beta, gamma and lambda; beta of rule 7 is U-A12, rule 16 is U-A13.
RULES = [
    (1, 1, 1, 2, 3, 2),
    (1, 2, 1, 3, 3, 2),
    (1, 4, 1, 4, 4, 2),
    (1, 3, 1, 4, 3, 2),
    (2, 1, 3, 1, 3, 3),
    (2, 2, 3, 2, 3, 3),
    (2, 3, 2, 3, 3, 3),
    (2, 4, 2, 4, 4, 3),
    (3, 1, 3, 1, 3, 1),
    (3, 2, 3, 1, 3, 2),
    (3, 3, 3, 1, 3, 3),
    (3, 4, 3, 1, 4, 4),
    (4, 1, 4, 1, 2, 1),
    (4, 2, 4, 1, 2, 1),
    (4, 3, 4, 1, 3, 2),
    (4, 4, 4, 1, 4, 3),
]


@dataclass(frozen=True)
class Problem(core.Problem):
    """What the planner knows at one tick."""

    far_target: tuple = ()  # x, y of what Dgoal and D_goal are measured to
    fixed_weights: tuple = ()  # alpha, beta, gamma, lambda; empty where the fuzzy controller gives them


def degrees(value, universe):
    """Degree of an input in each of the sets N1 to N4."""
    place = 3.0 * min(max(value, 0.0), universe) / universe
    return [max(0.0, 1.0 - abs(place - peak)) for peak in range(4)]


def centroid(heights):
    """Centre of the union of the sets M1 to M4, each cut at its height.

    Over one third only two sets are above 0; x runs from 0 to 1 over it. The union is linear between the places where a set is cut or
    where two cut sets can meet, and the integrals over such a piece are exact.
    """
    area = moment = 0.0
    for third in range(3):
        falling, rising = heights[third], heights[third + 1]
        places = sorted({0.0, 0.5, 1.0, falling, 1.0 - falling, rising, 1.0 - rising})
        points = [((third + x) / 3.0, max(min(falling, 1.0 - x), min(rising, x))) for x in places]
        for (x0, y0), (x1, y1) in zip(points, points[1:]):
            area += (x1 - x0) * (y0 + y1) / 2.0
            moment += (x1 - x0) * (y0 * (2.0 * x0 + x1) + y1 * (x0 + 2.0 * x1)) / 6.0
    return moment / area


def fuzzy_weights(obstacle_m, goal_m):
    """alpha, beta, gamma and lambda: Mamdani's inference with minimum and maximum, and the centroid."""
    near, close = degrees(obstacle_m, OBSTACLE_UNIVERSE_M), degrees(goal_m, GOAL_UNIVERSE_M)
    heights = [[0.0] * 4 for _ in range(4)]
    for n_obstacle, n_goal, *outputs in RULES:
        strength = min(near[n_obstacle - 1], close[n_goal - 1])
        for output, m in zip(heights, outputs):
            output[m - 1] = max(output[m - 1], strength)
    return tuple(centroid(output) for output in heights)


def obstacle_distance_m(problem):
    """D_obs: distance of the robot's edge, where it is now, to the nearest obstacle, not below 0."""
    x, y, _ = problem.pose
    gaps = [core.border_m(x, y, problem.size)]
    gaps += [core.point_to_box_m(x, y, box) for box in problem.boxes]
    gaps += [math.hypot(cx - x, cy - y) - radius for cx, cy, radius, _, _ in problem.discs]
    return max(0.0, min(gaps) - problem.robot.radius_m)


def weights(problem):
    """alpha, beta, gamma and lambda of this tick."""
    if problem.fixed_weights:
        return problem.fixed_weights
    return fuzzy_weights(obstacle_distance_m(problem), math.dist(problem.pose[:2], problem.far_target))


def terms(problem, candidate):
    """Head, Dist, Vel and Dgoal of a candidate, eq. 16 and 17 (U-A9)."""
    goal = 1.0 / max(math.dist(problem.far_target, candidate.end[:2]), GOAL_DISTANCE_MIN_M)
    return core.heading(problem, candidate), core.distance(problem, candidate), candidate.twist[0], goal


def scored(problem):
    """The admissible candidates with their scores, eq. 17, each term over its sum."""
    found = core.candidates(problem)
    now = weights(problem)
    for candidate, row in zip(found, core.shares([terms(problem, candidate) for candidate in found])):
        candidate.score = sum(weight * term for weight, term in zip(now, row))
    return found
