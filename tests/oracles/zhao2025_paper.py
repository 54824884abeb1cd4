"""Local planner of zhao2025, a dynamic window with a term for the velocity of a moving obstacle, written from the paper.

Zhao, Xie, Xu, Zhu, Xu, 2025, sections 2.5 and 2.6 (eq. 8 to 17). The paper has no formula for `barr`; its resolution, tick by tick, is that of
docs/book/src/papers/systems.md, section 5 (the ids Z-A..). It shares no code with simrun. The standard library is enough.
"""

import math
from dataclasses import dataclass

import dynamic_window as core

STANDS_MPS = 0.01  # below this speed a mover stands
ACUTE_RAD = math.pi / 2.0


@dataclass(frozen=True)
class Problem(core.Problem):
    """What the planner knows at one tick; the parameters of `barr`."""

    weights: tuple = (0.07, 0.2, 0.3, 0.4)  # of heading, dist, velocity and barr, table 4
    barr: str = "sum"  # or relative, target (Z-A8, Z-A9)
    barr_when: str = "acute"  # or always (Z-A17)
    barr_mode: str = "additive"  # or multiplicative (Z-A7)


def plus(a, b):
    """The sum of two vectors."""
    return a[0] + b[0], a[1] + b[1]


def minus(a, b):
    """The difference of two vectors."""
    return a[0] - b[0], a[1] - b[1]


def along(v, theta):
    """The velocity of a robot with this speed and heading."""
    return v * math.cos(theta), v * math.sin(theta)


def nearest_mover(problem):
    """The mover whose edge is nearest to the robot's centre, the earlier one of equals; None where there is none."""
    x, y, _ = problem.pose
    return min(problem.discs, key=lambda disc: math.hypot(disc[0] - x, disc[1] - y) - disc[2], default=None)


def robot_velocity(problem):
    """v_c."""
    return along(problem.twist[0], problem.pose[2])


def candidate_velocity(problem, twist):
    """v_c(i): how fast and where to a candidate drives at the end of the horizon."""
    horizon_s = problem.sampling.steps * problem.sampling.tick_s
    return along(twist[0], problem.pose[2] + twist[1] * horizon_s)


def resultant(v_c, v_b):
    """v_h1."""
    return plus(v_c, v_b)


def turned(v_h1, v_b):
    """v_h2: v_h1 turned by +90°, or by -90° where that would have a part along v_b."""
    left = (-v_h1[1], v_h1[0])
    if left[0] * v_b[0] + left[1] * v_b[1] <= 0.0:
        return left
    return -left[0], -left[1]


def adjusted(v_c, v_b):
    """v_c2, by the convention of the sum (Z-A9)."""
    return minus(turned(resultant(v_c, v_b), v_b), v_b)


def mover_velocity(problem):
    """v_b, or None where no mover has a say in this tick."""
    mover = nearest_mover(problem)
    if mover is None or math.hypot(*mover[3:5]) < STANDS_MPS:
        return None
    v_b = mover[3:5]
    if problem.barr_when == "acute" and not core.angle(resultant(robot_velocity(problem), v_b), v_b) < ACUTE_RAD:
        return None
    return v_b


def barr(problem, v_b, twist):
    """barr of a candidate, where a mover has a say."""
    v_ci = candidate_velocity(problem, twist)
    if problem.barr == "sum":
        return core.angle(resultant(v_ci, v_b), v_b)
    if problem.barr == "relative":
        return core.angle(minus(v_ci, v_b), v_b)
    return 1.0 + math.cos(core.angle(v_ci, adjusted(robot_velocity(problem), v_b)))


def score(problem, head, dist, velocity, barr_share):
    """Eq. 16, with shares of terms: eq. 13 to 15 and 17."""
    heading_weight, distance_weight, velocity_weight, barr_weight = problem.weights
    plain = heading_weight * head + distance_weight * dist + velocity_weight * velocity
    return barr_share * plain if problem.barr_mode == "multiplicative" else plain + barr_weight * barr_share


def scored(problem):
    """The admissible candidates with their scores."""
    found = core.candidates(problem)
    v_b = mover_velocity(problem)
    rows = []
    for each in found:
        term = 1.0 if v_b is None else barr(problem, v_b, each.twist)
        rows.append((core.heading(problem, each), core.distance(problem, each), each.twist[0], term))
    for candidate, row in zip(found, core.shares(rows)):
        candidate.score = score(problem, *row)
    return found
