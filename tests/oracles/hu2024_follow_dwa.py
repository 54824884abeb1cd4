"""Decides the ticks of tests/data/follow_dwa_drives.jsonl anew, from the paper, and says where simrun decided otherwise.

    python3 tests/oracles/hu2024_follow_dwa.py              writes tests/data/follow_dwa_second.csv, prints the table of the README
    python3 tests/oracles/hu2024_follow_dwa.py --self-test  checks the states, the window and the terms against cases worked by hand
    python3 tests/oracles/hu2024_follow_dwa.py --changes    prints what the comparison would notice

The states are the program's own from the first tick of a drive to the last; what simrun decided serves the comparison alone. The standard
library is enough.
"""

import json
import math
import sys
from dataclasses import fields, replace

import decisions
import drives
import dynamic_window as core
import hu2024_paper as paper
from recovery import recovery

COLUMNS = ["drive", "tick", "state", "v", "omega", "cap_mps", "margin"]
WEIGHTS = ["heading_weight", "distance_weight", "movers_weight", "velocity_weight", "path_weight"]
RULES = [field.name for field in fields(paper.Rules)]


class Planner:
    """The planner of a drive."""

    def __init__(self, head):
        self.drive = drives.Drive(head, {"states": [True, False]}, [*WEIGHTS, "offset_scale_m", *RULES])
        self.path = paper.Path(head["path"])
        rules = paper.Rules(**{key: self.drive.params[key] for key in RULES})
        self.automaton = paper.Automaton(self.drive.robot, self.drive.tick_s, self.path, rules)

    def decide(self, tick, wanted):
        """The answer of a tick; without a command where none is wanted."""
        line, params = tick.line, self.drive.params
        state, cap_mps, slack = "track", None, None
        if params["states"]:
            state, cap_mps = self.automaton.step(now_of(line))
            slack = self.automaton.slack if self.automaton.slack < math.inf else None
        if not wanted:
            return drives.Answer(state, cap_mps=cap_mps)
        problem = paper.Problem(
            **self.drive.surroundings(tick),
            speed_cap_mps=math.inf if cap_mps is None else cap_mps,
            path=self.path,
            weights=tuple(params[key] for key in WEIGHTS),
            offset_scale_m=params["offset_scale_m"],
        )
        found = paper.scored(problem)
        if not found:
            return drives.Answer("recover", recovery(problem), cap_mps, admissible=0, slack=slack)
        best = core.choose(found)
        return drives.Answer(state, best.twist, cap_mps, core.margin(found, best), len(found), slack)


def now_of(line):
    """What the states ask of a tick."""
    movers = [paper.Mover(x, y, radius, vx, vy, number) for x, y, vx, vy, radius, number in line["movers"]]
    return paper.Now(line["tick"], tuple(line["pose"]), tuple(line["twist"]), line["progress_m"], movers)


Automaton, terms = paper.Automaton, paper.terms


def heavier(weight):
    """A weight 2 % higher."""

    def changed(problem):
        return scored(replace(problem, weights=tuple(1.02 * w if k == weight else w for k, w in enumerate(problem.weights))))

    return [(paper, "scored", changed)]


def method(name, function):
    """A change of the states."""
    return [(Automaton, name, function)]


def rules_with(**numbers):
    """The states with other numbers."""
    before = Automaton.__init__

    def changed(self, robot, tick_s, path, rules):
        before(self, robot, tick_s, path, replace(rules, **numbers))

    return method("__init__", changed)


def lead_of_follow(self, now, along, mover):
    """Follow with the lead of braking."""
    *rest, _ = reasons_to_follow(self, now, along, mover)
    yield from rest
    yield self.is_in_corridor(now, mover, self.rules.follow_distance_m, self.lead_ticks())


def given_up_not_followed(self, now, along, mover):
    """Follow only movers that are not given up."""
    yield mover.number != self.given_up, math.inf
    yield from reasons_to_follow(self, now, along, mover)


def angle_with_heading(self, now):
    return math.cos(now.pose[2]), math.sin(now.pose[2])


def from_45_on(self, angle_deg):
    low, high = self.rules.brake_angle_min_deg, self.rules.brake_angle_max_deg
    return low <= angle_deg <= high, 0.0


def below_135(self, angle_deg):
    low, high = self.rules.brake_angle_min_deg, self.rules.brake_angle_max_deg
    return low < angle_deg < high, 0.0


def gap_of_centres(self, now, mover):
    return math.dist((mover.x, mover.y), now.pose[:2])


def a_tick_longer(self, now):
    return (now.tick - 1 - self.brake.since) * self.tick_s >= self.rules.wait_max_s - 1e-9


def never_forget(self, now, along):
    return None


def first_of(self, now, movers):
    return next(iter(movers), None)


def ahead_of_heading(self, now, along, mover):
    return is_ahead(self, now, angle_with_heading(self, now), mover)


def all_movers_too(problem, candidate):
    """dist from movers as well."""
    return min(static_clearance_m(problem, candidate), mover_clearance_m(problem, candidate))


def without_lowest(problem):
    """The window of a capped tick, without the lowest speed within reach where that is above the cap."""
    return [twist for twist in twists(problem) if twist[0] <= problem.speed_cap_mps]


scored, reasons_to_follow, is_ahead, twists = paper.scored, Automaton.reasons_to_follow, Automaton.is_ahead, core.twists
static_clearance_m, mover_clearance_m, path_term = paper.static_clearance_m, paper.mover_clearance_m, paper.path_term

CHANGES = {
    "none": [],
    "R is d1 of now, not of when the state was entered": method("reach_of", lambda self, brake, now: self.brake_reach_m(now)),
    "brake from 45° on, not above": method("is_to_brake_for", from_45_on),
    "brake below 135°, not up to": method("is_to_brake_for", below_135),
    "brake above 50°": rules_with(brake_angle_min_deg=50.0),
    "follow below 20°": rules_with(follow_angle_max_deg=20.0),
    "the direction is the robot's heading": method("direction", angle_with_heading),
    "ahead of the heading, not of the path": method("is_ahead", ahead_of_heading),
    "the path's direction over 0.4 m": [(paper, "LOOK_M", 0.4)],
    "points of the corridor every 0.5 m": [(paper, "SPACING_M", 0.5)],
    "corridor without its margin": rules_with(corridor_margin_m=0.0),
    "gaps between centres": method("gap_m", gap_of_centres),
    "of several movers the first, not the nearest": method("nearest", first_of),
    "waits a tick longer": method("has_lasted", a_tick_longer),
    "a mover that was given up is never forgotten": method("forget", never_forget),
    "a mover that was given up is not followed": method("reasons_to_follow", given_up_not_followed),
    "braking without lead": method("lead_ticks", lambda self: 0),
    "follow with the lead of braking": method("reasons_to_follow", lead_of_follow),
    "above the cap nothing, though no lower speed is within reach": [(core, "twists", without_lowest)],
    "weight of `heading` 2 % higher": heavier(0),
    "weight of `dist` 2 % higher": heavier(1),
    "weight of `dist_m` 2 % higher": heavier(2),
    "weight of `vel` 2 % higher": heavier(3),
    "weight of `Path` 2 % higher": heavier(4),
    "L 2 % higher": [(paper, "path_term", lambda problem, each: path_term(replace(problem, offset_scale_m=1.02 * problem.offset_scale_m), each))],
    "`dist` also from movers": [(paper, "static_clearance_m", all_movers_too)],
    "`dist_m` from movers that stand": [
        (paper, "mover_clearance_m", lambda problem, each: mover_clearance_m(replace(problem, predict=False), each))
    ],
    "movers stand": [(core, "movers", lambda problem: [(x, y, radius, 0.0, 0.0) for x, y, radius, _, _ in problem.discs])],
}


def count(change, job):
    """See drives.changed."""
    return drives.changed(Planner, CHANGES[change], job)


# A path along x to 20, then along y; the robot on it at 3 m, with 2 m/s at most and 0.2 m/s².
ROBOT = core.Robot(0.15, 2.0, 0.35, 0.2, 0.2, 0.8)
CORNER = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)]


def near(found, expected):
    """Whether numbers or vectors are the same but for rounding."""
    if isinstance(expected, tuple):
        return len(found) == len(expected) and all(map(near, found, expected))
    return abs(found - expected) < 1e-12


def at(tick, *movers, s=3.0, v=0.0, pose=None):
    """What is known at a tick by a robot on the path along x."""
    return paper.Now(tick, pose or (s, 0.0, 0.0), (v, 0.0), s, list(movers))


def crossing(x=4.5, y=0.3, vx=0.0, vy=0.5, radius=0.3, number=1):
    """A mover, which crosses the path where nothing else is said."""
    return paper.Mover(x, y, radius, vx, vy, number)


def automaton_by_hand(**rules):
    """The states on the path with a corner."""
    return paper.Automaton(ROBOT, 0.1, paper.Path(CORNER), paper.Rules(**rules))


def self_test():
    """Fails where a part is not as worked by hand."""
    self_test_geometry()
    self_test_entering()
    self_test_holding()
    self_test_following()
    self_test_window()
    self_test_drive()
    print("the states, the window, the terms and the reading of drives are as worked by hand")


def self_test_geometry():
    automaton = automaton_by_hand()
    # Directions: along x; over the corner from 0.2 m before it to 0.3 m after it; at the end of the path from the robot to it; at the end itself the heading.
    assert near(automaton.direction(at(0)), (1.0, 0.0))
    assert near(automaton.direction(at(0, s=19.8)), (0.2 / math.sqrt(0.13), 0.3 / math.sqrt(0.13)))
    assert near(automaton.direction(at(0, s=40.0, pose=(23.0, 24.0, 0.0))), (-0.6, -0.8))
    assert near(automaton.direction(at(0, s=40.0, pose=(20.0, 20.0, math.pi / 6.0))), (math.sqrt(0.75), 0.5))
    # 0.4 m before the end both points are still 0.4 m apart.
    assert near(automaton.direction(at(0, s=39.6, pose=(0.0, 0.0, 0.0))), (0.0, 1.0))
    # d1: 2 m at least, 1²/0.4 + 1 = 3.5 m at 1 m/s either way, 11 m at 2 m/s.
    for v, expected in ((0.0, 2.0), (0.6, 2.0), (1.0, 3.5), (-1.0, 3.5), (2.0, 11.0)):
        assert near(automaton.brake_reach_m(at(0, v=v)), expected), v
    assert near(automaton.gap_m(at(0), crossing(x=6.0, y=4.0)), 5.0 - 0.15 - 0.3)
    # The corridor within 2 m: the last point is 5 m along; it is 0.15 + 0.3 + 0.2 = 0.65 m wide to either side, and beyond its end too.
    for x, y, inside in [
        (4.5, 0.649, True),
        (4.5, -0.651, False),
        (5.649, 0.0, True),
        (5.651, 0.0, False),
        (2.9, 0.6, True),
        (3.0 + 0.05, math.sqrt(0.65**2 - 0.05**2) + 1e-4, False),  # between two points 0.1 m apart it is a little narrower
        (3.0 + 0.05, math.sqrt(0.65**2 - 0.05**2) - 1e-4, True),
    ]:
        assert automaton.is_in_corridor(at(0), crossing(x=x, y=y), 2.0, 0)[0] is inside, (x, y)
    # With a lead of three ticks: 0.5 m/s brings it 0.15 m nearer.
    for y, inside in ((-0.79, True), (-0.81, False)):
        assert automaton.is_in_corridor(at(0), crossing(y=y), 2.0, 3)[0] is inside, y
    assert automaton_by_hand(brake_lead_s=0.3).lead_ticks() == 3
    # In front of the robot, by the direction of the path: with the robot before the corner it is the way over the corner.
    assert automaton.is_ahead(at(0), (1.0, 0.0), crossing(x=3.001))[0] and not automaton.is_ahead(at(0), (1.0, 0.0), crossing(x=3.0))[0]
    # The corridor goes round the corner, and ends with the path.
    late = at(0, s=19.5, pose=(19.5, 0.0, 0.0))
    assert automaton.is_in_corridor(late, crossing(x=20.6, y=1.4), 2.0, 0)[0]
    assert not automaton.is_in_corridor(late, crossing(x=21.0, y=0.0), 2.0, 0)[0]
    end = at(0, s=39.9, pose=(20.0, 19.9, 0.0))
    assert not automaton.is_in_corridor(end, crossing(x=20.0, y=20.66), 2.0, 0)[0]
    # Offsets: beside a leg, inside the corner at 1 m from one and 2 m from the other, beyond the end.
    for x, y, expected in ((5.0, -2.0, 2.0), (18.0, 1.0, 1.0), (20.0, 23.0, 3.0), (-3.0, 4.0, 5.0)):
        assert near(paper.offset_m(automaton.path, x, y), expected), (x, y)
    assert near(paper.offset_m(paper.Path([(1.0, 1.0)]), 4.0, 5.0), 5.0)


def self_test_entering():
    def state(*movers, v=0.0, **rules):
        return automaton_by_hand(**rules).step(at(0, *movers, v=v))

    def turned(degrees, speed=0.5):
        return crossing(vx=speed * math.cos(math.radians(degrees)), vy=speed * math.sin(math.radians(degrees)))

    assert state() == ("track", None)
    assert state(crossing()) == ("brake", 0.0)
    # Angles: 45 and less do not count, 135 does, more does not unless printed.
    for degrees, expected in ((44.0, "track"), (46.0, "brake"), (-46.0, "brake"), (134.9, "brake"), (-135.1, "track"), (180.0, "track")):
        assert state(turned(degrees))[0] == expected, degrees
    assert state(crossing(vx=0.5, vy=0.5))[0] == "track"  # 45° without rounding
    assert state(crossing(vx=-0.5, vy=0.0), brake_angle_max_deg=180.0)[0] == "brake"
    # Speed: more than 0.1 m/s.
    assert state(crossing(vy=0.1))[0] == "track" and state(crossing(vy=0.101))[0] == "brake"
    # Gap: less than d1, from edge to edge; a mover 2.44 m ahead is 1.99 m off, but beyond the corridor, which ends 2 m ahead, unless it is within 0.65 m.
    assert state(crossing(x=5.44, y=0.0))[0] == "brake"
    assert state(crossing(x=5.46, y=0.0))[0] == "track"
    assert state(crossing(x=5.44, y=0.6))[0] == "track"
    # At 1 m/s d1 is 3.5 m.
    assert state(crossing(x=5.46, y=0.0), v=1.0)[0] == "brake"
    # Behind the robot, though in the corridor.
    assert state(crossing(x=2.9, y=0.0))[0] == "track"
    # Of two, the one with the smaller gap; of equals the earlier one.
    automaton = automaton_by_hand()
    automaton.step(at(0, crossing(x=4.5, radius=0.2, number=4), crossing(x=4.6, radius=0.4, number=5)))
    assert automaton.brake.number == 5
    automaton = automaton_by_hand()
    automaton.step(at(0, crossing(y=0.3, number=8), crossing(y=-0.3, number=7)))
    assert automaton.brake.number == 8


def self_test_holding():
    # Entered at 1 m/s with a reach of 3.5 m, which stays: at rest d1 is 2 m, and the mover is 3 m ahead.
    automaton = automaton_by_hand()
    far = crossing(x=6.0, y=0.0)
    assert automaton.step(at(0, far, v=1.0)) == ("brake", 0.0) and near(automaton.brake.reach_m, 3.5)
    assert automaton.step(at(1, far)) == ("brake", 0.0)
    # Held whatever the mover's speed and angle; not with another number, not beyond the corridor, not where it is no longer sensed.
    assert automaton.step(at(2, crossing(x=6.0, y=0.0, vy=0.0)))[0] == "brake"
    assert automaton.step(at(3, far._replace(number=2)))[0] == "track"
    assert automaton.step(at(4, far))[0] == "track"
    automaton.step(at(5, far, v=1.0))
    assert automaton.step(at(6, far._replace(y=0.66)))[0] == "track"
    automaton.step(at(7, far, v=1.0))
    assert automaton.step(at(8))[0] == "track"
    assert automaton.given_up is None
    # What leaves one mover may at once wait for another, with its own reach and from 0 s on.
    automaton.step(at(9, far, v=1.0))
    assert automaton.step(at(10, crossing(number=2)))[0] == "brake"
    assert (automaton.brake.number, automaton.brake.reach_m, automaton.brake.since) == (2, 2.0, 10)
    # A mover that stays: ticks 0 to 99 are the first 10 s, at tick 100 the state has lasted 10 s.
    automaton = automaton_by_hand()
    stays, other = crossing(), crossing(x=4.0, number=2)
    assert [automaton.step(at(k, stays))[0] for k in range(101)] == ["brake"] * 100 + ["track"]
    assert automaton.given_up == 1 and automaton.brake is None
    # It is not waited for again while it is in the way; another one is.
    assert automaton.step(at(101, stays))[0] == "track"
    assert automaton.step(at(102, stays, other))[0] == "brake" and automaton.brake.number == 2
    assert automaton.step(at(103, stays))[0] == "track" and automaton.given_up == 1
    # Once it has left the corridor within d1 it counts again: at that tick already, had it come back.
    assert automaton.step(at(104, stays._replace(y=0.7)))[0] == "track" and automaton.given_up is None
    assert automaton.step(at(105, stays))[0] == "brake"
    # The same where it is not sensed for a tick.
    automaton.brake, automaton.given_up = None, 1
    automaton.step(at(106))
    assert automaton.given_up is None
    # Forgetting looks as far as d1 of now: 2.6 m ahead is in the way at 1 m/s, and not at rest.
    automaton.given_up = 1
    assert automaton.step(at(107, crossing(x=5.7, y=0.0), v=1.0))[0] == "track" and automaton.given_up == 1
    assert automaton.step(at(108, crossing(x=5.7, y=0.0)))[0] == "track" and automaton.given_up is None
    # Another that is given up takes the place of the first.
    automaton = automaton_by_hand(wait_max_s=0.2)
    assert [automaton.step(at(k, stays))[0] for k in range(3)] == ["brake", "brake", "track"]
    assert [automaton.step(at(k, stays, other))[0] for k in range(3, 6)] == ["brake"] * 3
    assert (automaton.given_up, automaton.brake.number) == (2, 1)
    # With lead it is in the way before it is there, and out of the way behind it.
    automaton = automaton_by_hand(brake_lead_s=1.0)
    assert automaton.step(at(0, crossing(y=-1.1)))[0] == "brake"
    assert automaton.step(at(1, crossing(y=0.64)))[0] == "brake"
    assert automaton.step(at(2, crossing(y=0.66)))[0] == "track"


def self_test_following():
    ahead = crossing(x=5.0, y=0.1, vx=1.5, vy=0.0)
    automaton = automaton_by_hand()
    assert automaton.step(at(0, ahead)) == ("follow", 1.5)
    # More than 2/3 of 2 m/s.
    assert automaton.step(at(1, ahead._replace(vx=1.33)))[0] == "track"
    assert automaton.step(at(2, ahead._replace(vx=1.34))) == ("follow", 1.34)
    # Below 25°; the cap is the whole speed.
    for degrees, expected in ((24.9, "follow"), (-24.9, "follow"), (25.1, "track")):
        mover = ahead._replace(vx=1.5 * math.cos(math.radians(degrees)), vy=1.5 * math.sin(math.radians(degrees)))
        state, cap = automaton.step(at(3, mover))
        assert state == expected and (cap is None or near(cap, 1.5)), degrees
    # Less than 4 m off, edge to edge, and near the path of the next 4 m.
    assert automaton.step(at(4, ahead._replace(x=7.44, y=0.0)))[0] == "follow"
    assert automaton.step(at(5, ahead._replace(x=7.46, y=0.0)))[0] == "track"
    assert automaton.step(at(6, ahead._replace(x=6.0, y=0.66)))[0] == "track"
    # Of two the nearest; faster than the robot may drive; without lead.
    assert automaton.step(at(7, ahead, ahead._replace(x=4.5, vx=1.8, number=2))) == ("follow", 1.8)
    assert automaton.step(at(8, ahead._replace(vx=3.0))) == ("follow", 3.0)
    side = ahead._replace(y=-0.8, vx=1.5, vy=0.5)
    assert automaton_by_hand(brake_lead_s=1.0).step(at(9, side))[0] == "track"
    # Braking comes first, and a mover that was given up may be followed.
    assert automaton.step(at(10, ahead, crossing(number=2))) == ("brake", 0.0)
    automaton = automaton_by_hand()
    automaton.given_up = 1
    assert automaton.step(at(11, ahead)) == ("follow", 1.5) and automaton.given_up == 1


def self_test_window():
    def problem(v, cap_mps, **given):
        sampling = core.Sampling(0.02, 0.02, 0.1, 30, 2.0, "arc")
        given = {"pose": (20.0, 20.0, 0.0), "target": (35.0, 20.0), "path": paper.Path([(10.0, 20.0), (35.0, 20.0)]), **given}
        return paper.Problem(robot=ROBOT, sampling=sampling, predict=True, twist=(v, 0.0), size=(40.0, 40.0), speed_cap_mps=cap_mps, **given)

    def speeds(v, cap_mps):
        return sorted({twist[0] for twist in core.twists(problem(v, cap_mps))})

    # A tick changes the speed by 0.02 m/s. Without a cap; with one above, within and below the window; braking from 1 m/s and to rest.
    for v, cap_mps, expected in [
        (1.0, math.inf, (0.98, 1.0, 1.02)),
        (1.0, 1.5, (0.98, 1.0, 1.02)),
        (1.0, 1.01, (0.98, 1.0, 1.01)),
        (1.0, 0.99, (0.98, 0.99)),
        (1.0, 0.5, (0.98,)),
        (1.0, 0.0, (0.98,)),
        (0.015, 0.0, (0.0,)),
        (0.0, 0.0, (0.0,)),
        (2.0, 3.0, (1.98, 2.0)),
    ]:
        assert near(tuple(speeds(v, cap_mps)), expected), (v, cap_mps, speeds(v, cap_mps))
    # Straight on from (20, 20) at 1 m/s, in the open: 3 m on. A mover 3.5 m ahead that comes at 0.5 m/s: after t it is 3.5 - 1.5 t away, less 0.15 and 0.2 m.
    still = problem(1.0, math.inf)
    (each,) = [c for c in core.candidates(still) if near(c.twist, (1.0, 0.0))]
    assert near(each.end, (23.0, 20.0, 0.0))
    assert near(paper.terms(still, each), (math.pi, 2.0, 2.0, 1.0, 1.0))
    away = problem(1.0, math.inf, discs=[(21.5, 20.0, 0.2, 1.2, 0.0), (20.0, 21.0, 0.2, 0.0, 0.0)])
    # The first goes on before it: 1.5 m + 0.2 m/s t, nearest after the first tick: 1.52 - 0.35 = 1.17 m. The second: sqrt(1 + 0.01) - 0.35.
    (each,) = [c for c in core.candidates(away) if near(c.twist, (1.0, 0.0))]
    assert near(paper.mover_clearance_m(away, each), math.sqrt(1.01) - 0.35)
    assert near(paper.mover_clearance_m(replace(away, discs=away.discs[:1]), each), 1.17)
    assert near(paper.static_clearance_m(away, each), 2.0)
    # V_a asks for the nearer of both: from 0.655 m a robot stops that drives at 0.51 m/s.
    assert not core.candidates(replace(away, sampling=replace(away.sampling, va_distance="clearance")))
    # A box beside the way, 0.75 m from the edge: it counts for dist alone. The path 3 m beside: 1/(1 + 3), and with L = 2 m 1/(1 + 3/2).
    walled = replace(away, boxes=[(21.0, 20.9, 22.0, 22.0)], path=paper.Path([(10.0, 23.0), (35.0, 23.0)]))
    assert near(paper.terms(walled, each), (math.pi, 0.75, math.sqrt(1.01) - 0.35, 1.0, 0.25))
    assert near(paper.path_term(replace(walled, offset_scale_m=2.0), each), 0.4)
    # With one term alone: Path turns to the left, to where the path is; dist_m away from the one that stands there.
    left = replace(still, path=walled.path, weights=(0.0, 0.0, 0.0, 0.0, 1.0))
    assert core.choose(paper.scored(left)).twist[1] > 0.0
    assert core.choose(paper.scored(replace(away, weights=(0.0, 0.0, 1.0, 0.0, 0.0)))).twist[1] < 0.0
    # The shares of each term add up to 1.
    assert near(sum(c.score for c in paper.scored(walled)), 0.65)


def self_test_drive():
    params = {
        **{key: allowed[0] for key, allowed in drives.WORDS.items()},
        **dict(zip(WEIGHTS, (0.05, 0.2, 0.2, 0.1, 0.1))),
        **vars(paper.Rules()),
        "va_distance": "arc",
        "states": True,
        "offset_scale_m": 1.0,
        "speed_step_mps": 0.02,
        "yaw_rate_step_radps": 0.02,
        "horizon_s": 3.0,
        "d_cap_m": 2.0,
        "predict_dynamic": True,
    }
    limits = {"radius_m": 0.15, "speed_max_mps": 2.0, "reverse_speed_max_mps": 0.0, "acceleration_max_mps2": 0.2}
    limits |= {"deceleration_max_mps2": 0.2, "yaw_rate_max_radps": 0.35, "yaw_acceleration_max_radps2": 0.8}
    head = {"planner": "follow_dwa", "cols": 40, "rows": 40, "resolution_m": 1.0, "known": [], "dt_s": 0.1, "params": params}
    head |= {"robot": limits, "path": [[10, 20], [35, 20]], "key_nodes_m": [0, 25], "goal": [35, 20]}

    def line(tick, mover, state, cap_mps, v, **more):
        movers = [] if mover is None else [[*mover, 0.3, 9]]
        common = {"pose": [20.0, 20.0, 0.0], "twist": [1.0, 0.0], "progress_m": 10.0, "sub_goal": [35.0, 20.0]}
        return {"tick": tick, "movers": movers, "state": state, "notes": [cap_mps], "command": [v, 0.0], **common, **more}

    lines = [
        line(0, None, "track", 2.0, 1.02),
        line(1, (22.5, 20.0, 0.0, 0.5), "brake", 0.0, 0.98),
        line(2, (23.0, 20.0, 1.5, 0.0), "brake", 0.0, 0.98),
        line(3, (24.3, 20.0, 1.5, 0.0), "follow", 1.5, 1.02),
        line(5, None, "recover", 2.0, 0.98, added=[[col, row] for col in (18, 19, 20, 21) for row in (18, 19, 20, 21)]),
    ]
    # At tick 2 the mover has turned away and is still in the way within 3.5 m, so the robot waits; at tick 3 it is beyond, 3.85 m off. At tick 5 the
    # robot touches cells wherever it goes.
    text = [json.dumps(each) for each in ({"drive": head}, *lines)]
    _, unread, found = drives.replay(Planner, drives.always, (0, text))
    assert not unread
    for _, recorded, answer in found:
        mine = (answer.state, 2.0 if answer.cap_mps is None else answer.cap_mps, answer.command[0])
        assert mine[0] == recorded["state"] and near(mine[1:], (recorded["notes"][0], recorded["command"][0])), (recorded, answer)
        assert not [key for key in drives.differences(head, recorded, answer) if key != "command"]
    # Without its states it tracks; what is recorded otherwise is found.
    head["params"]["states"] = False
    _, _, found = drives.replay(Planner, drives.always, (0, [json.dumps({"drive": head}), *text[1:]]))
    assert [answer.state for _, _, answer in found] == ["track"] * 4 + ["recover"]
    assert [drives.differences(head, recorded, answer)[:2] for _, recorded, answer in found][1:4] == [["state", "cap"]] * 3


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        self_test()
    elif sys.argv[1:] == ["--changes"]:
        drives.show_changes("follow_dwa", count, CHANGES)
    else:
        drives.compare("follow_dwa", Planner, COLUMNS)
