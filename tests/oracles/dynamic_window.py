"""The dynamic window approach as the five papers share it: window, rollouts, clearances, admissibility, normalised terms, the choice.

Written from the papers and docs/book/src/papers/systems.md §1.4; the papers' own planners build upon it. It shares no code with simrun. The standard
library is enough.
"""

import math
from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Robot:
    """A disc with two driven wheels."""

    radius_m: float
    speed_max_mps: float
    yaw_rate_max_radps: float
    acceleration_mps2: float
    deceleration_mps2: float
    yaw_acceleration_radps2: float  # and deceleration
    speed_min_mps: float = 0.0


@dataclass(frozen=True)
class Sampling:
    """How the planner samples, predicts and judges."""

    speed_step_mps: float
    yaw_rate_step_radps: float
    tick_s: float
    steps: int  # of the horizon
    cap_m: float  # clip of the clearance that is scored
    va_distance: str  # arc | clearance


@dataclass(frozen=True)
class Problem:
    """What the planner knows at one tick: metres, radians, seconds."""

    robot: Robot
    sampling: Sampling
    predict: bool  # whether movers move on, else they are taken to stand
    pose: tuple  # x, y, theta
    twist: tuple  # v, omega
    target: tuple  # x, y
    size: tuple  # width and height of the map; its border is a wall
    boxes: list = field(default_factory=list)  # x_min, y_min, x_max, y_max of blocked cells
    discs: list = field(default_factory=list)  # x, y, radius, vx, vy of movers
    speed_cap_mps: float = math.inf  # limit of this tick, below that of the robot


@dataclass
class Candidate:
    """An admissible twist, and what became of it over the horizon."""

    twist: tuple
    end: tuple  # x, y, theta
    clearance_m: float  # least over the predicted poses
    score: float = 0.0
    poses: list = field(default_factory=list, repr=False)  # from the robot's own on


def window(centre, fall, rise, low, high, step, extra):
    """Samples of one axis of V_s ∩ V_d: from the low end by `step`, both ends, the present value, and `extra` if inside.

    Where nothing of V_s is within reach, what is nearest to it: a robot that still rolls backwards brakes.
    """
    low, high = (min(max(end, centre - fall), centre + rise) for end in (low, high))
    values = [low + i * step for i in range(int((high - low) / step + 1e-9) + 1)]
    values += [x for x in (high, centre, *extra) if low <= x <= high]
    values.sort()
    distinct = values[:1]
    for value in values[1:]:
        if value - distinct[-1] > 1e-9:
            distinct.append(value)
    return distinct


def yaw_rates(problem, extra):
    """Samples of the yaw rate."""
    robot, sampling = problem.robot, problem.sampling
    change, most = robot.yaw_acceleration_radps2 * sampling.tick_s, robot.yaw_rate_max_radps
    return window(problem.twist[1], change, change, -most, most, sampling.yaw_rate_step_radps, extra)


def twists(problem):
    """The sampled twists, speeds outside, yaw rates inside."""
    robot, sampling = problem.robot, problem.sampling
    fall, rise = robot.deceleration_mps2 * sampling.tick_s, robot.acceleration_mps2 * sampling.tick_s
    fastest = min(robot.speed_max_mps, problem.speed_cap_mps)
    speeds = window(problem.twist[0], fall, rise, robot.speed_min_mps, fastest, sampling.speed_step_mps, ())
    rates = yaw_rates(problem, (0.0,))
    return [(v, omega) for v in speeds for omega in rates]


def rollout(pose, speeds, omega, tick_s):
    """Poses now and after each step, in Euler's form; a speed for each step."""
    x, y, theta = pose
    poses = [pose]
    for v in speeds:
        x, y, theta = x + v * tick_s * math.cos(theta), y + v * tick_s * math.sin(theta), theta + omega * tick_s
        poses.append((x, y, theta))
    return poses


def point_to_box_m(px, py, box):
    """Distance of a point to a full box."""
    dx = max(box[0] - px, 0.0, px - box[2])
    dy = max(box[1] - py, 0.0, py - box[3])
    return math.hypot(dx, dy)


def border_m(px, py, size):
    """Distance of a point inside the map to its border."""
    return min(px, py, size[0] - px, size[1] - py)


def movers(problem):
    """The movers as the planner takes them."""
    if problem.predict:
        return problem.discs
    return [(x, y, radius, 0.0, 0.0) for x, y, radius, _, _ in problem.discs]


def clearances_m(problem, poses, reach):
    """Distance of the robot's edge to anything at each predicted pose, at most `reach`; 0 or less where it touches.

    The pose that the robot is at is not predicted, and what lies between two poses does not count.
    """
    radius_m, tick_s = problem.robot.radius_m, problem.sampling.tick_s
    moving = movers(problem)
    found = []
    for k, (px, py, _) in enumerate(poses[1:], start=1):
        best = min(reach + radius_m, border_m(px, py, problem.size))
        for x_min, y_min, x_max, y_max in problem.boxes:
            # point_to_box_m, written out and only where it can be less: this is where the time goes.
            dx = x_min - px if px < x_min else px - x_max if px > x_max else 0.0
            if dx < best:
                dy = y_min - py if py < y_min else py - y_max if py > y_max else 0.0
                if dy < best:
                    best = min(best, math.hypot(dx, dy))
        for x, y, radius, vx, vy in moving:
            best = min(best, math.hypot(x + vx * k * tick_s - px, y + vy * k * tick_s - py) - radius)
        found.append(best - radius_m)
    return found


def wrap(angle):
    """The angle in (−π, π]."""
    angle = math.fmod(angle, 2.0 * math.pi)
    if angle > math.pi:
        angle -= 2.0 * math.pi
    elif angle <= -math.pi:
        angle += 2.0 * math.pi
    return angle


def angle(a, b):
    """Angle between two vectors, 0 to π; π/2 where either is shorter than 1e-9."""
    if math.hypot(*a) < 1e-9 or math.hypot(*b) < 1e-9:
        return math.pi / 2.0
    return math.atan2(abs(a[0] * b[1] - a[1] * b[0]), a[0] * b[0] + a[1] * b[1])


def admissible(problem, twist, clearance):
    """No contact over the horizon, and V_a with the modulus of ω."""
    if clearance <= 0.0:
        return False
    v, omega = twist
    robot, sampling = problem.robot, problem.sampling
    if sampling.va_distance == "arc":
        # No contact is known: all of the arc that was looked at, v T, is free. No yaw rate is bounded.
        return abs(v) <= 2.0 * robot.deceleration_mps2 * sampling.steps * sampling.tick_s
    return v * v <= 2.0 * clearance * robot.deceleration_mps2 and omega * omega <= 2.0 * clearance * robot.yaw_acceleration_radps2


def reach_m(problem):
    """Clearance beyond which nothing changes.

    The clip is for scoring only; V_a looks as far as the fastest robot needs to stop.
    """
    robot, cap_m = problem.robot, problem.sampling.cap_m
    if problem.sampling.va_distance == "arc":
        return cap_m
    fastest = robot.speed_max_mps**2 / (2.0 * robot.deceleration_mps2)
    return max(cap_m, fastest, robot.yaw_rate_max_radps**2 / (2.0 * robot.yaw_acceleration_radps2))


def nearby(problem):
    """The problem without the boxes that no rollout can come near."""
    robot, sampling = problem.robot, problem.sampling
    x, y, _ = problem.pose
    far = reach_m(problem) + robot.radius_m + max(robot.speed_max_mps, abs(problem.twist[0])) * sampling.steps * sampling.tick_s
    return replace(problem, boxes=[box for box in problem.boxes if point_to_box_m(x, y, box) <= far])


def candidates(problem):
    """Every sampled twist that is admissible."""
    sampling = problem.sampling
    reach, problem = reach_m(problem), nearby(problem)
    found = []
    for twist in twists(problem):
        poses = rollout(problem.pose, [twist[0]] * sampling.steps, twist[1], sampling.tick_s)
        clearance = min(clearances_m(problem, poses, reach))
        if admissible(problem, twist, clearance):
            found.append(Candidate(twist, poses[-1], clearance, poses=poses))
    return found


def bearing_from(pose, target):
    """Angle from the heading to the target, in (−π, π]."""
    x, y, theta = pose
    return wrap(math.atan2(target[1] - y, target[0] - x) - theta)


def heading(problem, candidate):
    """π less the angle between the last heading and the target."""
    return math.pi - abs(bearing_from(candidate.end, problem.target))


def distance(problem, candidate):
    """The clearance as it is scored."""
    return min(candidate.clearance_m, problem.sampling.cap_m)


def shares(rows):
    """Each term of each candidate over the sum of that term over all candidates; 0 where the sum is 0."""
    sums = [sum(column) for column in zip(*rows)]
    return [[term / total if total > 0.0 else 0.0 for term, total in zip(row, sums)] for row in rows]


def choose(found):
    """The largest score; among equals the larger v, then the smaller |ω|, then the earlier."""
    return max(found, key=lambda c: (c.score, c.twist[0], -abs(c.twist[1])))


def margin(found, best):
    """How much less than the best the second best scores, over the best; None where there is no second."""
    second = max((candidate.score for candidate in found if candidate is not best), default=None)
    return None if second is None else 1.0 - second / best.score if best.score > 0.0 else 0.0
