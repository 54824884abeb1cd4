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
    """A twist, and what became of it over the horizon."""

    twist: tuple
    end: tuple  # x, y, theta
    clearance_m: float  # least over the trajectory, unclipped as far as `reach_m` was asked for
    admissible: bool
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


def point_to_segment_m(px, py, ax, ay, bx, by):
    """Distance of a point to the segment from a to b."""
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    t = 0.0 if length2 == 0.0 else min(1.0, max(0.0, ((px - ax) * dx + (py - ay) * dy) / length2))
    return math.hypot(px - ax - t * dx, py - ay - t * dy)


def point_to_box_m(px, py, box):
    """Distance of a point to a full box."""
    dx = max(box[0] - px, 0.0, px - box[2])
    dy = max(box[1] - py, 0.0, py - box[3])
    return math.hypot(dx, dy)


def crosses(ax, ay, bx, by, box):
    """Whether the segment meets the full box (its parameters inside both slabs overlap)."""
    enter, leave = 0.0, 1.0
    for a, b, low, high in ((ax, bx, box[0], box[2]), (ay, by, box[1], box[3])):
        d = b - a
        if d == 0.0:
            if a < low or a > high:
                return False
            continue
        t, u = (low - a) / d, (high - a) / d
        enter, leave = max(enter, min(t, u)), min(leave, max(t, u))
    return enter <= leave


def segment_to_box_m(ax, ay, bx, by, box):
    """Distance of a segment to a full box: 0 where they meet, else attained at an end or at a corner."""
    if crosses(ax, ay, bx, by, box):
        return 0.0
    best = min(point_to_box_m(ax, ay, box), point_to_box_m(bx, by, box))
    for cx in (box[0], box[2]):
        for cy in (box[1], box[3]):
            best = min(best, point_to_segment_m(cx, cy, ax, ay, bx, by))
    return best


def movers(problem):
    """The movers as the planner takes them: `dwa` takes them to stand (G-A12)."""
    still = problem.planner == "dwa"
    return [(x, y, radius, 0.0, 0.0) if still else (x, y, radius, vx, vy) for x, y, radius, vx, vy in problem.discs]


def clearance_m(problem, poses, reach):
    """Least distance of the robot's edge to anything over the predicted poses, at most `reach`, and whether it touches.

    The pose that the robot is at is not predicted.
    """
    best = reach + ROBOT_RADIUS_M
    width, height = problem.size
    for k, (px, py, _) in enumerate(poses[1:], start=1):
        best = min(best, px, py, width - px, height - py)
        for box in problem.boxes:
            best = min(best, point_to_box_m(px, py, box))
        for x, y, radius, vx, vy in movers(problem):
            best = min(best, math.hypot(x + vx * k * TICK_S - px, y + vy * k * TICK_S - py) - radius)
    return best - ROBOT_RADIUS_M, best <= ROBOT_RADIUS_M


def line_clearance_m(problem, poses, reach):
    """The same over the whole line through the poses, from the robot's own on: the other reading of "trajectory".

    Exact: the steps of eq. 19 are straight, and in the frame of a mover of constant velocity they still are.
    """
    best = reach + ROBOT_RADIUS_M
    width, height = problem.size
    for x, y, _ in poses:
        best = min(best, x, y, width - x, height - y)
    longest = max(math.dist(a[:2], b[:2]) for a, b in zip(poses, poses[1:])) + 1e-12
    for box in problem.boxes:
        k = 0
        while k + 1 < len(poses):
            # Steps from here that cannot come as near as the nearest so far.
            far = int((point_to_box_m(poses[k][0], poses[k][1], box) - best) / longest)
            if far < 1:
                best = min(best, segment_to_box_m(*poses[k][:2], *poses[k + 1][:2], box))
            k += max(far, 1)
    for x, y, radius, vx, vy in movers(problem):
        for k, (a, b) in enumerate(zip(poses, poses[1:])):
            t, u = k * TICK_S, (k + 1) * TICK_S
            gap = point_to_segment_m(x, y, a[0] - vx * t, a[1] - vy * t, b[0] - vx * u, b[1] - vy * u) - radius
            best = min(best, gap)
    return best - ROBOT_RADIUS_M, best <= ROBOT_RADIUS_M


def wrap(angle):
    """The angle in (−π, π]."""
    angle = math.fmod(angle, 2.0 * math.pi)
    if angle > math.pi:
        angle -= 2.0 * math.pi
    elif angle <= -math.pi:
        angle += 2.0 * math.pi
    return angle


def admissible(problem, twist, clearance, touches):
    """No contact over the horizon, and eq. 22 with the modulus of ω."""
    if touches:
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


def candidates(problem, clearance=clearance_m):
    """Every sampled twist with its clearance and whether it is admissible."""
    reach = reach_m(problem)
    found = []
    for twist in twists(problem):
        poses = rollout(problem.pose, [twist[0]] * STEPS, twist[1])
        distance, touches = clearance(problem, poses, reach)
        found.append(Candidate(twist, poses[-1], distance, admissible(problem, twist, distance, touches)))
    return found


def terms(problem, candidate):
    """head, dist, vel and dist_g of a candidate, eq. 24 to 27."""
    x, y, theta = candidate.end
    tx, ty = problem.target
    head = math.pi - abs(wrap(math.atan2(ty - y, tx - x) - theta))
    dist = min(candidate.clearance_m, CAP_M)
    goal = 1.0 / max(math.hypot(tx - x, ty - y), GOAL_DISTANCE_MIN_M)
    return head, dist, candidate.twist[0], goal


def score(problem, found):
    """Eq. 24 or 26 over the admissible candidates; σ divides each term by its sum (G-A16)."""
    rows = [(candidate, terms(problem, candidate)) for candidate in found if candidate.admissible]
    sums = [sum(row[1][k] for row in rows) for k in range(4)]
    d2 = max(math.dist(problem.previous, problem.target), SEGMENT_MIN_M)
    for candidate, row in rows:
        head, dist, vel, goal = (k / total if total > 0.0 else 0.0 for k, total in zip(row, sums))
        candidate.score = HEADING_WEIGHT * head + DISTANCE_WEIGHT * dist
        if problem.planner == "dwa":
            candidate.score += VELOCITY_WEIGHT * vel
        else:
            candidate.score += VELOCITY_WEIGHT * math.log(math.e + row[1] / d2) * vel + GOAL_WEIGHT * goal
    return [candidate for candidate, _ in rows]


def choose(scored):
    """The largest score; among equals the larger v, then the smaller |ω|, then the earlier."""
    return max(scored, key=lambda c: (c.score, c.twist[0], -abs(c.twist[1])))


def recovery(problem):
    """Nothing is admissible: brake, and turn on the spot towards the target (systems.md, section 1.4)."""
    x, y, theta = problem.pose
    v, omega = problem.twist
    off = wrap(math.atan2(problem.target[1] - y, problem.target[0] - x) - theta)
    wanted = math.copysign(YAW_RATE_MAX_RADPS, off) if off != 0.0 else 0.0
    change = YAW_ACCELERATION_RADPS2 * TICK_S
    return max(0.0, v - ACCELERATION_MPS2 * TICK_S), min(omega + change, max(omega - change, wanted))


def decide(problem, clearance=clearance_m):
    """The command, every candidate, and the scored ones (none where the command is the recovery)."""
    found = candidates(problem, clearance)
    scored = score(problem, found)
    return (choose(scored).twist if scored else recovery(problem)), found, scored
