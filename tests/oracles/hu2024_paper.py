"""Local planner of hu2024, a dynamic window that waits for movers or follows them and keeps to the path, written from the paper.

Hu, Wang, Zhang, Engineering Letters 32(3), 2024, section III (eq. 14 to 18). Where the paper leaves something open, this program follows
docs/book/src/papers/systems.md, section 6 (the ids H-A..), whose order of things within a tick it keeps. It shares no code with simrun. The
standard library is enough.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import dynamic_window as core
from qin2026_paper import Path, whole

LOOK_M = 0.5  # over which the direction of the path is taken
SPACING_M = 0.1  # of the points of the corridor
SAME_PLACE_M = 1e-6


class Mover(NamedTuple):
    """A mover as it is sensed."""

    x: float
    y: float
    radius_m: float
    vx: float
    vy: float
    number: int

    def speed_mps(self):
        """Its speed."""
        return math.hypot(self.vx, self.vy)


@dataclass
class Now:
    """What is known at a tick: metres, radians, seconds."""

    tick: int
    pose: tuple  # x, y, theta
    twist: tuple  # v, omega
    progress_m: float
    movers: list


@dataclass
class Rules:
    """When to brake and when to follow: metres, m/s, degrees, seconds."""

    brake_distance_m: float = 2.0
    brake_speed_mps: float = 0.1
    brake_angle_min_deg: float = 45.0
    brake_angle_max_deg: float = 135.0
    brake_lead_s: float = 0.0
    wait_max_s: float = 10.0
    follow_distance_m: float = 4.0
    follow_speed_ratio: float = 2.0 / 3.0
    follow_angle_max_deg: float = 25.0
    corridor_margin_m: float = 0.2


@dataclass
class Brake:
    """What is kept while the robot waits."""

    number: int  # of the mover
    reach_m: float
    since: int  # tick


class Automaton:
    """The states, and what is kept from one tick to the next."""

    def __init__(self, robot, tick_s, path, rules):
        self.robot, self.tick_s, self.path, self.rules = robot, tick_s, path, rules
        self.brake, self.given_up = None, None
        self.slack = math.inf

    def step(self, now):
        """The state of a tick and its cap, None where there is none. Leaves behind how near a rule was to going the other way."""
        self.slack = math.inf
        along = self.direction(now)
        self.forget(now, along)
        self.hold(now, along)
        if self.brake is None:
            self.enter(now, along)
        if self.brake is not None:
            return "brake", 0.0
        followed = self.followed(now, along)
        return ("track", None) if followed is None else ("follow", followed.speed_mps())

    # Geometry

    def direction(self, now):
        """d, the direction of the planned trajectory (H-A16)."""
        ahead = self.path.point(now.progress_m), self.path.point(now.progress_m + LOOK_M)
        for a, b in (ahead, (now.pose[:2], self.path.points[-1])):
            apart = math.dist(a, b)
            if apart >= SAME_PLACE_M:
                return (b[0] - a[0]) / apart, (b[1] - a[1]) / apart
        return math.cos(now.pose[2]), math.sin(now.pose[2])

    def gap_m(self, now, mover):
        """From the robot's edge to the mover's."""
        return math.dist((mover.x, mover.y), now.pose[:2]) - self.robot.radius_m - mover.radius_m

    def brake_reach_m(self, now):
        """d1 (H-A14)."""
        v = abs(now.twist[0])
        return max(self.rules.brake_distance_m, v * v / (2.0 * self.robot.deceleration_mps2) + 1.0)

    def reach_of(self, brake, now):
        """R of the state brake: that of the tick at which it was entered."""
        return brake.reach_m

    def lead_ticks(self):
        """J where braking is at stake."""
        return whole(self.rules.brake_lead_s / self.tick_s)

    def is_ahead(self, now, along, mover):
        """Whether the mover is in front of the robot, and by how much."""
        before = (mover.x - now.pose[0]) * along[0] + (mover.y - now.pose[1]) * along[1]
        return before > 0.0, before

    def is_in_corridor(self, now, mover, reach_m, lead_ticks):
        """Whether the mover is, or will be, near the path ahead, and by how much."""
        points = [self.path.point(now.progress_m + SPACING_M * k) for k in range(whole(reach_m / SPACING_M) + 1)]
        places = [(mover.x + mover.vx * j * self.tick_s, mover.y + mover.vy * j * self.tick_s) for j in range(lead_ticks + 1)]
        limit = self.robot.radius_m + mover.radius_m + self.rules.corridor_margin_m
        apart = min(math.dist(place, point) for place in places for point in points)
        return apart <= limit, limit - apart

    def in_the_way(self, now, along, mover, reach_m, lead_ticks):
        """The two conditions of being in the way, the second only where the first holds."""
        yield self.is_ahead(now, along, mover)
        yield self.is_in_corridor(now, mover, reach_m, lead_ticks)

    def all_hold(self, conditions):
        """Whether all hold; conditions give themselves and by how much, in metres, m/s or radians. What follows one that does not is not looked at."""
        least = math.inf
        for holds, slack in conditions:
            least = min(least, abs(slack)) if holds else abs(slack)
            if not holds:
                break
        else:
            holds = True
        self.slack = min(self.slack, least)
        return holds

    def sensed(self, now, number):
        """The mover with a number, or None."""
        return next((mover for mover in now.movers if mover.number == number), None)

    def is_still_in_the_way(self, now, along, number, reach_m):
        """Whether a mover is sensed and in the way."""
        mover = self.sensed(now, number)
        return mover is not None and self.all_hold(self.in_the_way(now, along, mover, reach_m, self.lead_ticks()))

    def nearest(self, now, movers):
        """The mover with the smallest gap, the earlier one of equals; None of none."""
        return min(movers, key=lambda mover: self.gap_m(now, mover), default=None)

    # The steps of a tick

    def forget(self, now, along):
        """Step 1: a mover that was given up counts again once it is out of the way."""
        if self.given_up is not None and not self.is_still_in_the_way(now, along, self.given_up, self.brake_reach_m(now)):
            self.given_up = None

    def has_lasted(self, now):
        """Whether the state brake has been held for as long as it may; it lasts 0 s at the tick at which it is entered."""
        return (now.tick - self.brake.since) * self.tick_s >= self.rules.wait_max_s - 1e-9

    def hold(self, now, along):
        """Step 2: whether the robot goes on waiting."""
        if self.brake is None:
            return
        if self.is_still_in_the_way(now, along, self.brake.number, self.reach_of(self.brake, now)):
            if not self.has_lasted(now):
                return
            self.given_up = self.brake.number
        self.brake = None

    def is_to_brake_for(self, angle_deg):
        """The angles for which the robot waits, and by how much (H-A13)."""
        low, high = self.rules.brake_angle_min_deg, self.rules.brake_angle_max_deg
        return low < angle_deg <= high, math.radians(min(angle_deg - low, high - angle_deg))

    def reasons_to_brake(self, now, along, mover, reach_m):
        """The conditions of entering the state brake."""
        yield mover.number != self.given_up, math.inf
        yield mover.speed_mps() > self.rules.brake_speed_mps, mover.speed_mps() - self.rules.brake_speed_mps
        gap_m = self.gap_m(now, mover)
        yield gap_m < reach_m, reach_m - gap_m
        yield self.is_to_brake_for(math.degrees(core.angle((mover.vx, mover.vy), along)))
        yield from self.in_the_way(now, along, mover, reach_m, self.lead_ticks())

    def enter(self, now, along):
        """Step 3: whether the robot begins to wait."""
        reach_m = self.brake_reach_m(now)
        cause = self.nearest(now, [m for m in now.movers if self.all_hold(self.reasons_to_brake(now, along, m, reach_m))])
        if cause is not None:
            self.brake = Brake(cause.number, reach_m, now.tick)

    def reasons_to_follow(self, now, along, mover):
        """The conditions of the state follow."""
        least_mps = self.rules.follow_speed_ratio * self.robot.speed_max_mps
        yield mover.speed_mps() > least_mps, mover.speed_mps() - least_mps
        gap_m, reach_m = self.gap_m(now, mover), self.rules.follow_distance_m
        yield gap_m < reach_m, reach_m - gap_m
        angle_deg = math.degrees(core.angle((mover.vx, mover.vy), along))
        yield angle_deg < self.rules.follow_angle_max_deg, math.radians(self.rules.follow_angle_max_deg - angle_deg)
        yield from self.in_the_way(now, along, mover, reach_m, 0)

    def followed(self, now, along):
        """Step 4: the mover that the robot follows, or None."""
        return self.nearest(now, [m for m in now.movers if self.all_hold(self.reasons_to_follow(now, along, m))])


@dataclass(frozen=True)
class Problem(core.Problem):
    """What the dynamic window knows at one tick."""

    path: Path = None
    weights: tuple = (0.05, 0.2, 0.2, 0.1, 0.1)  # of heading, dist, dist_m, vel and Path (H-A12)
    offset_scale_m: float = 1.0  # L


def static_clearance_m(problem, candidate):
    """dist: from what stands, cut; `problem` without what is too far to matter."""
    cap_m = problem.sampling.cap_m
    return min(core.clearances_m(replace(problem, discs=[]), candidate.poses, cap_m))


def mover_clearance_m(problem, candidate):
    """dist_m: from movers where they will be, cut; the cut where there is none."""
    tick_s, least = problem.sampling.tick_s, problem.sampling.cap_m
    for x, y, radius, vx, vy in core.movers(problem):
        for k, (px, py, _) in enumerate(candidate.poses[1:], start=1):
            apart = math.hypot(x + vx * k * tick_s - px, y + vy * k * tick_s - py)
            least = min(least, apart - radius - problem.robot.radius_m)
    return least


def offset_m(path, x, y):
    """Distance of a point from the path, all of it."""
    least = math.dist((x, y), path.points[0])
    for a, b in zip(path.points, path.points[1:]):
        dx, dy = b[0] - a[0], b[1] - a[1]
        length_squared = dx * dx + dy * dy
        share = ((x - a[0]) * dx + (y - a[1]) * dy) / length_squared if length_squared > 0.0 else 0.0
        share = min(1.0, max(0.0, share))
        least = min(least, math.hypot(x - a[0] - share * dx, y - a[1] - share * dy))
    return least


def path_term(problem, candidate):
    """Path (H-A11)."""
    return 1.0 / (1.0 + offset_m(problem.path, *candidate.end[:2]) / problem.offset_scale_m)


def terms(problem, candidate):
    """heading, dist, dist_m, vel and Path of a candidate."""
    return (
        core.heading(problem, candidate),
        static_clearance_m(problem, candidate),
        mover_clearance_m(problem, candidate),
        candidate.twist[0],
        path_term(problem, candidate),
    )


def scored(problem):
    """The admissible candidates with their scores, eq. 18, each term over its sum."""
    found, problem = core.candidates(problem), core.nearby(problem)
    for candidate, row in zip(found, core.shares([terms(problem, candidate) for candidate in found])):
        candidate.score = sum(weight * term for weight, term in zip(problem.weights, row))
    return found
