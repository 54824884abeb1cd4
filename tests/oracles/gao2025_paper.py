"""Local planners DWA and ImpDWA of gao2025, written from the paper.

Gao, Zhang, Liu, Ou, Cheng, Zhu, AIMS Press, 2025, section 2.3 (eq. 19 to 27). Where the paper leaves something open, this
program follows docs/papers/systems.md (the ids G-A..). It shares no code with simrun. The standard library is enough.
"""

import math
from dataclasses import dataclass, field

# Printed in section 2.1 of the paper.
ROBOT_RADIUS_M = 0.15
SPEED_MAX_MPS = 1.0
YAW_RATE_MAX_RADPS = 0.6
ACCELERATION_MPS2 = 0.2  # a_i = a_d, G-A17
YAW_ACCELERATION_RADPS2 = 0.3  # a_m = a_n, G-A17
TICK_S = 0.1

# Not in the paper: systems.md, G-A18 and section 10; the clip is the one of scenarios/papers/gao2025_*.yaml.
SPEED_MIN_MPS = 0.0
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


@dataclass
class Problem:
    """What the planner knows at one tick: metres, radians, seconds."""

    planner: str  # dwa | imp_dwa
    va_distance: str  # arc | clearance
    pose: tuple  # x, y, theta
    twist: tuple  # v, omega
    target: tuple  # x, y
    previous: tuple  # x, y of the key node before the target
    size: tuple  # width and height of the map; its border is a wall
    boxes: list = field(default_factory=list)  # x_min, y_min, x_max, y_max of blocked cells
    discs: list = field(default_factory=list)  # x, y, radius, vx, vy of movers


@dataclass
class Candidate:
    """An admissible twist, and what became of it over the horizon."""

    twist: tuple
    end: tuple  # x, y, theta
    clearance_m: float  # least over the predicted poses
    score: float = 0.0


def window(centre, change, low, high, step, extra):
    """Samples of one axis of V_s ∩ V_d: from the low end by `step`, both ends, the present value, and `extra` if inside."""
    low = max(low, centre - change)
    high = min(high, centre + change)
    values = [low + i * step for i in range(int((high - low) / step + 1e-9) + 1)]
    values += [x for x in (high, centre, *extra) if low <= x <= high]
    values.sort()
    distinct = values[:1]
    for value in values[1:]:
        if value - distinct[-1] > 1e-9:
            distinct.append(value)
    return distinct


def twists(problem):
    """The sampled twists, speeds outside, yaw rates inside."""
    v, omega = problem.twist
    speeds = window(v, ACCELERATION_MPS2 * TICK_S, SPEED_MIN_MPS, SPEED_MAX_MPS, SPEED_STEP_MPS, ())
    rates = window(
        omega, YAW_ACCELERATION_RADPS2 * TICK_S, -YAW_RATE_MAX_RADPS, YAW_RATE_MAX_RADPS, YAW_RATE_STEP_RADPS, (0.0,)
    )
    return [(v, omega) for v in speeds for omega in rates]


def rollout(pose, speeds, omega):
    """Poses now and after each step, eq. 19; a speed for each step."""
    x, y, theta = pose
    poses = [pose]
    for v in speeds:
        x, y, theta = x + v * TICK_S * math.cos(theta), y + v * TICK_S * math.sin(theta), theta + omega * TICK_S
        poses.append((x, y, theta))
    return poses


def point_to_box_m(px, py, box):
    """Distance of a point to a full box."""
    dx = max(box[0] - px, 0.0, px - box[2])
    dy = max(box[1] - py, 0.0, py - box[3])
    return math.hypot(dx, dy)


def movers(problem):
    """The movers as the planner takes them: `dwa` takes them to stand (G-A12)."""
    still = problem.planner == "dwa"
    return [(x, y, radius, 0.0, 0.0) if still else (x, y, radius, vx, vy) for x, y, radius, vx, vy in problem.discs]


def clearances_m(problem, poses, reach):
    """Distance of the robot's edge to anything at each predicted pose, at most `reach`; 0 or less where it touches.

    The pose that the robot is at is not predicted, and what lies between two poses does not count.
    """
    width, height = problem.size
    found = []
    for k, (px, py, _) in enumerate(poses[1:], start=1):
        best = min(reach + ROBOT_RADIUS_M, px, py, width - px, height - py)
        for box in problem.boxes:
            best = min(best, point_to_box_m(px, py, box))
        for x, y, radius, vx, vy in movers(problem):
            best = min(best, math.hypot(x + vx * k * TICK_S - px, y + vy * k * TICK_S - py) - radius)
        found.append(best - ROBOT_RADIUS_M)
    return found


def wrap(angle):
    """The angle in (−π, π]."""
    angle = math.fmod(angle, 2.0 * math.pi)
    if angle > math.pi:
        angle -= 2.0 * math.pi
    elif angle <= -math.pi:
        angle += 2.0 * math.pi
    return angle


def admissible(problem, twist, clearance):
    """No contact over the horizon, and eq. 22 with the modulus of ω."""
    if clearance <= 0.0:
        return False
    if problem.va_distance == "arc":
        # Arc length to the first contact: there is none.
        return True
    v, omega = twist
    return v * v <= 2.0 * clearance * ACCELERATION_MPS2 and omega * omega <= 2.0 * clearance * YAW_ACCELERATION_RADPS2


def reach_m(problem):
    """Clearance beyond which nothing changes.

    The clip is for scoring only; eq. 22 as printed looks as far as the fastest robot needs to stop.
    """
    return CAP_M if problem.va_distance == "arc" else SPEED_MAX_MPS**2 / (2.0 * ACCELERATION_MPS2)


def candidates(problem):
    """Every sampled twist that is admissible."""
    reach = reach_m(problem)
    found = []
    for twist in twists(problem):
        poses = rollout(problem.pose, [twist[0]] * STEPS, twist[1])
        clearance = min(clearances_m(problem, poses, reach))
        if admissible(problem, twist, clearance):
            found.append(Candidate(twist, poses[-1], clearance))
    return found


def terms(problem, candidate):
    """head, dist, vel and dist_g of a candidate, eq. 24 to 27."""
    x, y, theta = candidate.end
    tx, ty = problem.target
    head = math.pi - abs(wrap(math.atan2(ty - y, tx - x) - theta))
    dist = min(candidate.clearance_m, CAP_M)
    goal = 1.0 / max(math.hypot(tx - x, ty - y), GOAL_DISTANCE_MIN_M)
    return head, dist, candidate.twist[0], goal


def scored(problem):
    """The admissible candidates with their scores, eq. 24 or 26; σ divides each term by its sum (G-A16)."""
    found = candidates(problem)
    rows = [terms(problem, candidate) for candidate in found]
    sums = [sum(row[k] for row in rows) for k in range(4)]
    d2 = max(math.dist(problem.previous, problem.target), SEGMENT_MIN_M)
    for candidate, row in zip(found, rows):
        head, dist, vel, goal = (k / total if total > 0.0 else 0.0 for k, total in zip(row, sums))
        candidate.score = HEADING_WEIGHT * head + DISTANCE_WEIGHT * dist
        if problem.planner == "dwa":
            candidate.score += VELOCITY_WEIGHT * vel
        else:
            candidate.score += VELOCITY_WEIGHT * math.log(math.e + row[1] / d2) * vel + GOAL_WEIGHT * goal
    return found


def choose(found):
    """The largest score; among equals the larger v, then the smaller |ω|, then the earlier."""
    return max(found, key=lambda c: (c.score, c.twist[0], -abs(c.twist[1])))
