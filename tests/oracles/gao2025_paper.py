"""Local planners DWA and ImpDWA of gao2025, written from the paper.

Gao, Zhang, Liu, Ou, Cheng, Zhu, AIMS Press, 2025, section 2.3 (eq. 19 to 27). Where the paper leaves something open, this
program follows docs/book/src/papers/systems.md (the ids G-A..). It shares no code with simrun. The standard library is enough.
"""

import math
from dataclasses import dataclass

import dynamic_window as core

# Printed in section 2.1 of the paper; deceleration as acceleration, G-A17.
ROBOT = core.Robot(
    radius_m=0.15,
    speed_max_mps=1.0,
    yaw_rate_max_radps=0.6,
    acceleration_mps2=0.2,
    deceleration_mps2=0.2,
    yaw_acceleration_radps2=0.3,
)
TICK_S = 0.1

# Not in the paper: systems.md, G-A18 and section 10; the clip is the one of scenarios/papers/gao2025_*.yaml.
SPEED_STEP_MPS = 0.01
YAW_RATE_STEP_RADPS = 0.01
STEPS = 30  # horizon of 3 s
CAP_M = 0.5

# Section 4, by name: G-A11.
HEADING_WEIGHT = 0.05
DISTANCE_WEIGHT = 0.2
VELOCITY_WEIGHT = 0.1
GOAL_WEIGHT = 0.2

GOAL_DISTANCE_MIN_M = 0.1  # G-A15
SEGMENT_MIN_M = 1.0  # G-A13


@dataclass(frozen=True)
class Problem(core.Problem):
    """What the planner knows at one tick."""

    planner: str = "imp_dwa"  # or dwa, which takes movers to stand (G-A12)
    previous: tuple = ()  # x, y of the key node before the target


def sampling(va_distance):
    """How the planners sample."""
    return core.Sampling(SPEED_STEP_MPS, YAW_RATE_STEP_RADPS, TICK_S, STEPS, CAP_M, va_distance)


def terms(problem, candidate):
    """head, dist, vel and dist_g of a candidate, eq. 24 to 27."""
    goal = 1.0 / max(math.dist(problem.target, candidate.end[:2]), GOAL_DISTANCE_MIN_M)
    return core.heading(problem, candidate), core.distance(problem, candidate), candidate.twist[0], goal


def scored(problem):
    """The admissible candidates with their scores, eq. 24 or 26; σ divides each term by its sum (G-A16)."""
    found = core.candidates(problem)
    rows = [terms(problem, candidate) for candidate in found]
    d2 = max(math.dist(problem.previous, problem.target), SEGMENT_MIN_M)
    for candidate, row, (head, dist, vel, goal) in zip(found, rows, core.shares(rows)):
        candidate.score = HEADING_WEIGHT * head + DISTANCE_WEIGHT * dist
        if problem.planner == "dwa":
            candidate.score += VELOCITY_WEIGHT * vel
        else:
            candidate.score += VELOCITY_WEIGHT * math.log(math.e + row[1] / d2) * vel + GOAL_WEIGHT * goal
    return found
