"""Local planner PDWA of qin2026, a dynamic window that regions along the path trigger, written from the paper.

Qin, Gao, Lu, Computers, Materials & Continua 87(1), 86, 2026, sections 4.3, 4.4 and 4.6 (eq. 10 to 23). The paper's algorithm 2 is an image; its
resolution, tick by tick, is that of docs/book/src/papers/systems.md, section 3 (the ids Q-A..). It shares no code with simrun. The standard
library is enough.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass

import dynamic_window as core

# Every number that the paper leaves open, by the name under which a drive may give another.
DEFAULTS = {
    "split": "length",  # length | turning_points
    "trigger": "conflict",  # conflict | always
    "region_length_max_m": 8.0,
    "region_length_min_m": 2.0,
    "region_half_width_m": 1.5,
    "region_extension_m": 0.5,
    "conflict_window_s": 3.0,
    "conflict_margin_m": 0.3,
    "clear_s": 1.0,
    "retreat_s": 1.0,
    "wait_s": 10.0,
    "attempts_max": 5,
    "reached_m": 0.05,
    "retreat_speed_mps": 0.2,
    "retreat_lookahead_m": 0.8,
    "retreat_bearing_max_rad": math.pi / 4.0,
    "retreat_check_s": 1.0,
    "retreat_room_m": 0.05,
}

# Rounding below which two shapes touch, and below which a distance does not shrink.
ROUNDING_M = 1e-9

TRACKED = "tracked"  # the command is the path tracker's


def whole(number):
    """The nearest whole number."""
    return math.floor(number + 0.5)


class Path:
    """A line through points, by arc length."""

    def __init__(self, points):
        self.points = [tuple(point) for point in points]
        self.at_m = [0.0]
        for a, b in zip(self.points, self.points[1:]):
            self.at_m.append(self.at_m[-1] + math.dist(a, b))

    def point(self, s):
        """The point at an arc length, or the nearer end."""
        if s <= 0.0 or len(self.points) == 1:
            return self.points[0]
        if s >= self.at_m[-1]:
            return self.points[-1]
        k = bisect_right(self.at_m, s)
        share = (s - self.at_m[k - 1]) / (self.at_m[k] - self.at_m[k - 1])
        return tuple(a + (b - a) * share for a, b in zip(self.points[k - 1], self.points[k]))


def split_by_length(ends, longest, shortest):
    """Regions (a, b) no longer than `longest` where they are cut, then joined where they are shorter than `shortest`.

    What has been joined is looked at again, and is not cut again.
    """
    regions = []
    for a, b in ends:
        count = math.ceil((b - a) / longest) if b - a > longest else 1
        cuts = [a + (b - a) * k / count for k in range(count)] + [b]
        regions += zip(cuts, cuts[1:])
    k = 0
    while k < len(regions) and len(regions) > 1:
        a, b = regions[k]
        if b - a >= shortest:
            k += 1
        elif k + 1 < len(regions):
            regions[k : k + 2] = [(a, regions[k + 1][1])]
        else:
            regions[k - 1 :] = [(regions[k - 1][0], b)]
    return regions


class Rectangle:
    """The rectangle about an axis, longer at both ends and with a half width."""

    def __init__(self, start, end, half_width, extension):
        length = math.dist(start, end)
        self.along = tuple((b - a) / length for a, b in zip(start, end)) if length > 0.0 else (1.0, 0.0)
        self.centre = tuple((a + b) / 2.0 for a, b in zip(start, end))
        self.half = (length / 2.0 + extension, half_width)

    def local(self, x, y):
        """A point in the axes of the rectangle."""
        dx, dy = x - self.centre[0], y - self.centre[1]
        return dx * self.along[0] + dy * self.along[1], dy * self.along[0] - dx * self.along[1]

    def gap_to_point_m(self, x, y):
        """Distance of a point."""
        return math.hypot(*(max(0.0, abs(place) - half) for place, half in zip(self.local(x, y), self.half)))

    def gap_to_box_m(self, box):
        """Widest gap to a box along an axis of either; 0 or less where they touch."""
        centre = ((box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0)
        sides = ((box[2] - box[0]) / 2.0, (box[3] - box[1]) / 2.0)
        cos, sin = abs(self.along[0]), abs(self.along[1])
        mine = [
            abs(place) - half - reach
            for place, half, reach in zip(
                self.local(*centre), self.half, (sides[0] * cos + sides[1] * sin, sides[0] * sin + sides[1] * cos)
            )
        ]
        reaches = (self.half[0] * cos + self.half[1] * sin, self.half[0] * sin + self.half[1] * cos)
        its = [abs(c - own) - side - reach for c, own, side, reach in zip(centre, self.centre, sides, reaches)]
        return max(mine + its)


@dataclass
class Now:
    """What is known at a tick: metres, radians, seconds."""

    pose: tuple  # x, y, theta
    twist: tuple  # v, omega
    progress_m: float
    movers: list  # x, y, radius, vx, vy
    believed: list  # boxes of all blocked cells
    unexpected: list  # boxes of those that the known map lacks


@dataclass
class Margins:
    """How near the decisions of a tick were to others."""

    conflict_m: float = math.inf  # gap by which no obstacle is in conflict; below 0 where one is
    score: float = None  # see dynamic_window.margin
    admissible: int = None  # twists of the dynamic window; None where it was not asked


class Automaton:
    """The planner's own state."""

    def __init__(self, robot, reverse_speed_max_mps, sampling, predict, weights, size, params):
        self.robot, self.reverse_speed_max_mps, self.sampling = robot, reverse_speed_max_mps, sampling
        self.predict, self.weights, self.size = predict, weights, size
        self.params = {**DEFAULTS, **params}
        unknown = set(params) - set(DEFAULTS)
        if unknown:
            raise ValueError(f"unknown parameters {sorted(unknown)}, expected some of {sorted(DEFAULTS)}")
        self.margins = Margins()

    def take_path(self, points, key_nodes_m):
        """Starts afresh on a path."""
        params = self.params
        self.path = Path(points)
        self.length_m = key_nodes_m[-1]
        if abs(self.length_m - self.path.at_m[-1]) > 1e-6:
            raise ValueError(f"the last key node is at {self.length_m} m, the path ends at {self.path.at_m[-1]} m")
        self.regions = list(zip(key_nodes_m, key_nodes_m[1:]))
        if params["split"] == "length":
            self.regions = split_by_length(self.regions, params["region_length_max_m"], params["region_length_min_m"])
        self.rectangles = [
            Rectangle(self.path.point(a), self.path.point(b), params["region_half_width_m"], params["region_extension_m"])
            for a, b in self.regions
        ]
        self.state, self.ticks, self.clear = "follow", 0, 0
        self.failures, self.failed_in = 0, 0

    def ticks_of(self, name):
        """A duration in ticks."""
        return whole(self.params[name] / self.sampling.tick_s)

    def decide(self, now):
        """The command of a tick, or TRACKED; the state, the region, the conflict and the failures are left behind."""
        self.margins = Margins()
        entered_m = now.progress_m + self.params["region_extension_m"]
        self.region = min(sum(b <= entered_m for _, b in self.regions), len(self.regions) - 1)
        if self.region > self.failed_in:
            self.failures = 0
        self.conflict = self.params["trigger"] == "always" or self.in_conflict(now)
        command = None
        while command is None:
            command = getattr(self, self.state)(now)
        self.ticks += 1
        return command

    def enter(self, state):
        """Goes to a state, whose rules hold at once."""
        self.state, self.ticks = state, 0

    # Conflict

    def watched(self):
        """The rectangles that are watched."""
        last = self.region
        if self.state in ("retreat", "withdraw", "wait"):
            last = max(last, self.failed_in)
        return self.rectangles[self.region : last + 1]

    def nominal(self, now):
        """The points of the path that the robot would be at after each tick, were it free."""
        v, s = max(now.twist[0], 0.0), now.progress_m
        points = []
        for _ in range(self.ticks_of("conflict_window_s")):
            v = min(v + self.robot.acceleration_mps2 * self.sampling.tick_s, self.robot.speed_max_mps)
            s = min(s + v * self.sampling.tick_s, self.length_m)
            points.append(self.path.point(s))
        return points

    def in_conflict(self, now):
        """Whether an obstacle touches a watched rectangle and comes too near to the nominal motion."""
        watched, points, tick_s = self.watched(), self.nominal(now), self.sampling.tick_s
        back = self.path.point(now.progress_m + self.params["retreat_lookahead_m"])
        found = False
        for x, y, radius, vx, vy in now.movers:
            touching = min(rectangle.gap_to_point_m(x, y) for rectangle in watched) - radius
            gaps = (math.dist(q, (x + vx * j * tick_s, y + vy * j * tick_s)) for j, q in enumerate(points, start=1))
            found |= self.is_near(touching, min(gaps) - self.robot.radius_m - radius)
        for box in now.unexpected:
            touching = min(rectangle.gap_to_box_m(box) for rectangle in watched)
            found |= self.is_near(touching, min(core.point_to_box_m(*q, box) for q in points) - self.robot.radius_m)
            found |= self.is_near(0.0, segment_to_box_m(now.pose[:2], back, box) - self.robot.radius_m)
        return found

    def is_near(self, touching, gap):
        """Whether both are small enough for a conflict."""
        lacking = gap - self.params["conflict_margin_m"]
        self.margins.conflict_m = min(self.margins.conflict_m, max(touching, lacking))
        return touching <= ROUNDING_M and lacking < 0.0

    # States: each gives the command, TRACKED, or None where another state's rules hold at once.

    def follow(self, now):
        if not self.conflict:
            return TRACKED
        self.clear = 0
        return self.enter("avoid")

    def avoid(self, now):
        self.clear = 0 if self.conflict else self.clear + 1
        if self.clear >= self.ticks_of("clear_s"):
            return self.enter("follow")
        command = self.dynamic_window(now)
        if command is None:
            self.failures += 1
            self.failed_in = self.region
            self.enter("retreat" if self.failures <= self.params["attempts_max"] else "withdraw")
        return command

    def retreat(self, now):
        if self.ticks >= self.ticks_of("retreat_s"):
            if not self.conflict:
                return self.enter("follow")
            command = self.dynamic_window(now)
            if command is not None:
                self.clear = 0
                self.enter("avoid")
                return command
        return self.withdraw(now)

    def withdraw(self, now):
        if self.behind_m(now) <= 0.0 or self.reverse_speed_max_mps <= 0.0:
            self.clear = 0
            return self.enter("wait")
        return self.back_up(now)

    def wait(self, now):
        self.clear = 0 if self.conflict else self.clear + 1
        if self.clear >= self.ticks_of("clear_s"):
            self.failures = 0
            return self.enter("follow")
        if self.ticks >= self.ticks_of("wait_s"):
            self.failures = self.clear = 0
            return self.enter("avoid")
        return 0.0, 0.0

    def behind_m(self, now):
        """How far the robot may still back up."""
        return now.progress_m - (self.regions[max(self.failed_in - 1, 0)][0] + self.params["reached_m"])

    # Commands

    def dynamic_window(self, now):
        """The best twist towards the end of the region, eq. 10 to 17, or None."""
        problem = core.Problem(
            robot=self.robot,
            sampling=self.sampling,
            predict=self.predict,
            pose=now.pose,
            twist=now.twist,
            target=self.path.point(self.regions[self.region][1]),
            size=self.size,
            boxes=now.believed,
            discs=now.movers,
        )
        found = core.candidates(problem)
        self.margins.admissible = len(found)
        if not found:
            return None
        rows = [(core.heading(problem, each), core.distance(problem, each), each.twist[0]) for each in found]
        for candidate, row in zip(found, core.shares(rows)):
            candidate.score = sum(weight * term for weight, term in zip(self.weights, row))
        best = core.choose(found)
        self.margins.score = core.margin(found, best)
        return best.twist

    def back_up(self, now):
        """Backwards along the path, or a turn on the spot until the tail looks along it; a turn is not checked for room."""
        params, robot = self.params, self.robot
        x, y, theta = now.pose
        goal = self.path.point(max(now.progress_m - params["retreat_lookahead_m"], 0.0))
        dx, dy = goal[0] - x, goal[1] - y
        gx, gy = dx * math.cos(theta) + dy * math.sin(theta), dy * math.cos(theta) - dx * math.sin(theta)
        tail = core.wrap(math.atan2(gy, gx) - math.pi)
        if abs(tail) > params["retreat_bearing_max_rad"]:
            stoppable = math.sqrt(2.0 * robot.yaw_acceleration_radps2 * abs(tail))
            return 0.0, math.copysign(min(robot.yaw_rate_max_radps, stoppable, abs(tail) / self.sampling.tick_s), tail)
        v = -min(params["retreat_speed_mps"], self.reverse_speed_max_mps)
        omega = v * 2.0 * gy / (gx * gx + gy * gy)
        omega = min(robot.yaw_rate_max_radps, max(-robot.yaw_rate_max_radps, omega))
        return (v, omega) if self.has_room(now, v, omega) else (0.0, 0.0)

    def has_room(self, now, v, omega):
        """Whether nothing is near on the way back: the nearest static and each mover, unless it is no nearer than if the robot stood."""
        tick_s, radius_m = self.sampling.tick_s, self.robot.radius_m
        ticks = self.ticks_of("retreat_check_s")
        x, y, theta = now.pose
        least = radius_m + self.params["retreat_room_m"]
        reach = least + abs(v) * ticks * tick_s
        near = [box for box in now.believed if core.point_to_box_m(x, y, box) <= reach]

        def distances(pose, t):
            px, py, _ = pose
            return [
                min([core.border_m(px, py, self.size), *(core.point_to_box_m(px, py, box) for box in near)]),
                *(math.dist((px, py), (cx + vx * t, cy + vy * t)) - radius for cx, cy, radius, vx, vy in now.movers),
            ]

        for t in (j * tick_s for j in range(1, ticks + 1)):
            stood, then = distances(now.pose, t), distances(arc((x, y, theta), v, omega, t), t)
            if any(b < least and b < a - ROUNDING_M for a, b in zip(stood, then)):
                return False
        return True


def segment_to_box_m(a, b, box):
    """Distance of a segment to a box, 0 where they touch."""

    def to_segment_m(x, y):
        dx, dy = b[0] - a[0], b[1] - a[1]
        length_squared = dx * dx + dy * dy
        share = ((x - a[0]) * dx + (y - a[1]) * dy) / length_squared if length_squared > 0.0 else 0.0
        share = min(1.0, max(0.0, share))
        return math.hypot(x - a[0] - share * dx, y - a[1] - share * dy)

    # The parts of the segment between the sides, in x and in y, in shares of its length: it passes through the box where they overlap.
    enters, leaves = 0.0, 1.0
    for k in (0, 1):
        step = b[k] - a[k]
        if step == 0.0:
            if not box[k] <= a[k] <= box[k + 2]:
                enters = math.inf
            continue
        first, last = sorted(((box[k] - a[k]) / step, (box[k + 2] - a[k]) / step))
        enters, leaves = max(enters, first), min(leaves, last)
    if enters <= leaves:
        return 0.0
    corners = [to_segment_m(x, y) for x in (box[0], box[2]) for y in (box[1], box[3])]
    return min(corners + [core.point_to_box_m(*a, box), core.point_to_box_m(*b, box)])


def arc(pose, v, omega, t):
    """The pose after a time at a constant twist."""
    x, y, theta = pose
    turned = omega * t
    if abs(turned) < 1e-12:
        return x + v * t * math.cos(theta), y + v * t * math.sin(theta), theta
    # The chord, which loses no digits where the turn is small.
    chord, along = v * t * math.sin(turned / 2.0) / (turned / 2.0), theta + turned / 2.0
    return x + chord * math.cos(along), y + chord * math.sin(along), theta + turned
