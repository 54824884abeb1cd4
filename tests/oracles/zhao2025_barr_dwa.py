"""Decides the ticks of tests/data/barr_dwa_drives.jsonl anew, from the paper, and says where simrun decided otherwise.

    python3 tests/oracles/zhao2025_barr_dwa.py              writes tests/data/barr_dwa_second.csv, prints the table of the README
    python3 tests/oracles/zhao2025_barr_dwa.py --self-test  checks barr and the score against cases worked by hand
    python3 tests/oracles/zhao2025_barr_dwa.py --changes    prints what the comparison would notice

The standard library is enough.
"""

import json
import math
import sys
from dataclasses import replace

import decisions
import drives
import dynamic_window as core
import zhao2025_paper as paper
from recovery import recovery

COLUMNS = ["drive", "tick", "state", "v", "omega", "margin"]
WORDS = {
    "barr": ["sum", "relative", "target"],
    "barr_when": ["acute", "always"],
    "barr_mode": ["additive", "multiplicative"],
}
WEIGHTS = ["heading_weight", "distance_weight", "velocity_weight", "barr_weight"]


class Planner:
    """The planner of a drive. It keeps nothing from one tick to the next."""

    def __init__(self, head):
        self.drive = drives.Drive(head, WORDS, WEIGHTS)

    def decide(self, tick, wanted):
        """The answer of a tick; without a command where none is wanted."""
        if not wanted:
            return drives.Answer("track")
        params = self.drive.params
        problem = paper.Problem(
            **self.drive.surroundings(tick),
            weights=tuple(params[key] for key in WEIGHTS),
            **{key: params[key] for key in WORDS},
        )
        flags = {"barr acts": paper.mover_velocity(problem) is not None}
        found = paper.scored(problem)
        if not found:
            return drives.Answer("recover", recovery(problem), admissible=0, flags=flags)
        best = core.choose(found)
        return drives.Answer("track", best.twist, margin=core.margin(found, best), admissible=len(found), flags=flags)


def nearest_centre(problem):
    """By the distance of centres."""
    x, y, _ = problem.pose
    return min(problem.discs, key=lambda disc: math.hypot(disc[0] - x, disc[1] - y), default=None)


def robot_alone(problem, v_b, twist):
    """The angle against v_c(i) itself where the sum is asked for."""
    if problem.barr == "sum":
        return core.angle(paper.candidate_velocity(problem, twist), v_b)
    return barr(problem, v_b, twist)


def turned_the_other_way(v_h1, v_b):
    """v_h2 with a part along v_b."""
    return tuple(-side for side in turned(v_h1, v_b))


def heavier(weight):
    """The score with a weight 2 % higher."""

    def changed(problem, *shares):
        weights = [1.02 * number if k == weight else number for k, number in enumerate(problem.weights)]
        return score(replace(problem, weights=tuple(weights)), *shares)

    return changed


def obtuse_too(problem):
    """Where also obtuse angles count."""
    return mover_velocity(replace(problem, barr_when="always"))


barr, turned, score, mover_velocity = paper.barr, paper.turned, paper.score, paper.mover_velocity

CHANGES = {
    "none": [],
    "no mover has a say": [(paper, "mover_velocity", lambda problem: None)],
    "`sum`: the angle of v_c(i) in place of v_c(i) + v_b": [(paper, "barr", robot_alone)],
    "v_c(i) looks where the robot looks now": [(paper, "candidate_velocity", lambda p, twist: paper.along(twist[0], p.pose[2]))],
    "also where the angle is not acute": [(paper, "mover_velocity", obtuse_too)],
    "acute below 85°": [(paper, "ACUTE_RAD", math.radians(85.0))],
    "the mover whose centre is nearest": [(paper, "nearest_mover", nearest_centre)],
    "the first mover": [(paper, "nearest_mover", lambda problem: next(iter(problem.discs), None))],
    "a mover stands below 0.5 m/s": [(paper, "STANDS_MPS", 0.5)],
    "`target`: v_h2 turned the other way": [(paper, "turned", turned_the_other_way)],
    "`target`: v_c2 = v_h2 + v_b": [(paper, "adjusted", lambda v_c, v_b: paper.plus(paper.turned(paper.plus(v_c, v_b), v_b), v_b))],
    "weight of `heading` 2 % higher": [(paper, "score", heavier(0))],
    "weight of `dist` 2 % higher": [(paper, "score", heavier(1))],
    "weight of `velocity` 2 % higher": [(paper, "score", heavier(2))],
    "weight of `barr` 2 % higher": [(paper, "score", heavier(3))],
    "movers are predicted to move on": [(core, "movers", lambda problem: problem.discs)],
}


def count(change, job):
    """See drives.changed."""
    return drives.changed(Planner, CHANGES[change], job)


def problem_by_hand(**given):
    """A robot that drives along x at 1 m/s in the open."""
    robot = core.Robot(0.15, 2.0, math.radians(20.0), 1.0, 1.0, math.radians(50.0))
    sampling = core.Sampling(0.02, math.radians(1.0), 0.1, 30, 1.0, "clearance")
    common = {"robot": robot, "sampling": sampling, "predict": False, "size": (40.0, 40.0)}
    return paper.Problem(**{**common, "pose": (10.0, 10.0, 0.0), "twist": (1.0, 0.0), "target": (30.0, 10.0), **given})


def near(found, expected):
    """Whether numbers or vectors are the same but for rounding."""
    if isinstance(expected, tuple):
        return len(found) == len(expected) and all(map(near, found, expected))
    return abs(found - expected) < 1e-12


def self_test():
    """Fails where a part is not as worked by hand."""
    quarter = math.pi / 2.0
    # Angles: a right one, one of 45°, none, half a turn, and with a vector that is too short.
    for a, b, expected in [
        ((2.0, 0.0), (0.0, 3.0), quarter),
        ((1.0, 1.0), (0.0, 3.0), quarter / 2.0),
        ((1.0, 1.0), (2.0, 2.0), 0.0),
        ((1.0, 0.0), (-2.0, 0.0), math.pi),
        ((9e-10, 0.0), (1.0, 0.0), quarter),
        ((1.0, 0.0), (0.0, 9e-10), quarter),
    ]:
        assert near(core.angle(a, b), expected) and near(core.angle(b, a), expected), (a, b)
    # The mover: 3 m off with a radius of 0.2 is farther than 3.5 m off with 1 m; of equals the earlier one.
    small, large = (13.0, 10.0, 0.2, 0.0, 1.0), (10.0, 13.5, 1.0, 0.0, -1.0)
    assert paper.nearest_mover(problem_by_hand(discs=[small, large])) == large
    assert paper.nearest_mover(problem_by_hand(discs=[])) is None
    twins = [(13.0, 10.0, 0.2, 0.0, 1.0), (7.0, 10.0, 0.2, 0.0, 2.0)]
    assert paper.nearest_mover(problem_by_hand(discs=twins)) == twins[0]
    # The robot at 1 m/s along x. A mover that crosses at 1 m/s: 45°, acute. One that comes at 2 m/s: v_c + v_b looks along v_b, 0°. One that comes
    # at 0.5 m/s: v_c + v_b looks the other way, 180°. One that comes at 1 m/s: no resultant, 90°, which is not acute. One at (-0.5, 0.5): the
    # resultant (0.5, 0.5) is at 90°.
    for v_b, is_acute in [
        ((0.0, 1.0), True),
        ((-2.0, 0.0), True),
        ((-0.5, 0.0), False),
        ((-1.0, 0.0), False),
        ((-0.5, 0.5), False),
        ((-0.5, 0.51), True),
        ((0.0099, 0.0), None),
        ((0.0, 0.01), True),
    ]:
        problem = problem_by_hand(discs=[(14.0, 10.0, 0.3, *v_b)])
        assert paper.mover_velocity(problem) == (v_b if is_acute else None), v_b
        always = problem_by_hand(discs=problem.discs, barr_when="always")
        assert paper.mover_velocity(always) == (v_b if is_acute is not None else None), v_b
    # A robot that stands: v_c + v_b is v_b, an angle of 0.
    assert paper.mover_velocity(problem_by_hand(twist=(0.0, 0.0), discs=[(14.0, 10.0, 0.3, -1.0, 0.0)])) == (-1.0, 0.0)
    # Only the nearest has a say: it stands, and the other that moves does not count.
    assert paper.mover_velocity(problem_by_hand(discs=[(14.0, 10.0, 0.3, 0.0, 0.0), (16.0, 10.0, 0.3, 0.0, 1.0)])) is None

    # A mover that crosses from right to left at 1 m/s. After 3 s at omega the robot looks at 3 omega.
    v_b, turn = (0.0, 1.0), quarter / 3.0
    expected = {
        # v_c(i): along x, along y, along -y, at rest; the angle of v_c(i) + v_b with y.
        "sum": [((1.0, 0.0), quarter / 2.0), ((1.0, turn), 0.0), ((2.0, -turn), math.pi), ((0.0, turn), 0.0), ((1.0, -turn), quarter)],
        # The angle of v_c(i) - v_b with y.
        "relative": [((1.0, 0.0), 1.5 * quarter), ((2.0, turn), 0.0), ((1.0, turn), quarter), ((1.0, -turn), math.pi), ((0.0, 0.1), math.pi)],
        # v_h1 = (1, 1); turned left it is (-1, 1), along v_b, so right: v_h2 = (1, -1), v_c2 = (1, -2), 63.43° to the right of x.
        "target": [
            ((1.0, 0.0), 1.0 + 1.0 / math.sqrt(5.0)),
            ((1.0, -turn), 1.0 + 2.0 / math.sqrt(5.0)),
            ((1.0, turn), 1.0 - 2.0 / math.sqrt(5.0)),
            ((0.5, -math.atan(2.0) / 3.0), 2.0),
            ((0.0, 0.1), 1.0),
        ],
    }
    assert near(paper.adjusted((1.0, 0.0), v_b), (1.0, -2.0))
    # From left to right it is the mirror image; with v_h1 along v_b a turn to the left has no part along it.
    assert near(paper.adjusted((1.0, 0.0), (0.0, -1.0)), (1.0, 2.0))
    assert near(paper.turned((3.0, 0.0), (2.0, 0.0)), (0.0, 3.0))
    # Zhao's own signs: v_c2 - v_b = v_h2 gives back v_c of a symmetric crossing, which is why the sum is taken (Z-A8).
    assert near(paper.plus(paper.turned((1.0, 1.0), v_b), v_b), (1.0, 0.0))
    for kind, rows in expected.items():
        problem = problem_by_hand(barr=kind, discs=[(14.0, 8.0, 0.3, *v_b)])
        for twist, value in rows:
            assert near(paper.barr(problem, v_b, twist), value), (kind, twist, paper.barr(problem, v_b, twist))
    # The score of shares 0.1, 0.2, 0.3 and 0.5: 0.007 + 0.04 + 0.09 = 0.137, and 0.2.
    assert near(paper.score(problem_by_hand(), 0.1, 0.2, 0.3, 0.5), 0.337)
    assert near(paper.score(problem_by_hand(barr_mode="multiplicative"), 0.1, 0.2, 0.3, 0.5), 0.0685)
    # A mover without a say gives every candidate the same share, which changes no choice.
    still = [(14.0, 8.0, 0.3, 0.0, 0.0)]
    for mode in ("additive", "multiplicative"):
        with_it, without = (paper.scored(problem_by_hand(barr_mode=mode, discs=still, weights=(0.07, 0.2, 0.3, w))) for w in (0.4, 0.0))
        assert len(with_it) == len(without) > 100
        assert core.choose(with_it).twist == core.choose(without).twist
        assert near(sum(each.score for each in with_it), 0.97 if mode == "additive" else 0.57 / len(with_it))
    # Far from everything the term alone decides: `sum` is largest for the fastest candidate that ends looking away from the mover's way; omega changes
    # by 5°/s in a tick, 15° in 3 s.
    alone = problem_by_hand(discs=[(14.0, 3.0, 0.3, *v_b)], weights=(0.0, 0.0, 0.0, 1.0))
    v, omega = core.choose(paper.scored(alone)).twist
    assert near(v, 1.1) and near(omega, -math.radians(5.0))
    self_test_drive()
    print("barr, the score and the reading of drives are as worked by hand")


def self_test_drive():
    """A drive of two ticks in the open, as it is read."""
    params = {
        **dict(zip(WEIGHTS, (0.07, 0.2, 0.3, 0.4))),
        **{key: allowed[0] for key, allowed in {**drives.WORDS, **WORDS}.items()},
        "va_distance": "clearance",
        "speed_step_mps": 0.02,
        "yaw_rate_step_radps": math.radians(1.0),
        "horizon_s": 3.0,
        "d_cap_m": 1.0,
        "predict_dynamic": False,
    }
    limits = {"radius_m": 0.15, "speed_max_mps": 2.0, "reverse_speed_max_mps": 0.0, "acceleration_max_mps2": 1.0}
    limits |= {"deceleration_max_mps2": 1.0, "yaw_rate_max_radps": math.radians(20.0), "yaw_acceleration_max_radps2": math.radians(50.0)}
    head = {"planner": "barr_dwa", "cols": 40, "rows": 40, "resolution_m": 0.5, "known": [[0, 0]], "dt_s": 0.1}
    head |= {"params": params, "robot": limits, "path": [[1, 10], [19, 10]], "key_nodes_m": [0, 18], "goal": [19, 10]}
    common = {"pose": [10.0, 10.0, 0.0], "progress_m": 9.0, "sub_goal": [19.0, 10.0], "notes": []}
    # First in the open; then within the robot, which touches a cell wherever it goes, and cannot stop within a tick.
    first = {"tick": 0, "twist": [1.0, 0.0], "movers": [[14.0, 8.0, 0.0, 1.0, 0.3, 7]], "state": "track", "command": [1.1, 0.0], **common}
    second = {"tick": 1, "twist": [1.0, 0.0], "movers": [], "added": [[20, 20], [21, 20]], "state": "recover", "command": [0.9, 0.0], **common}
    lines = [json.dumps(line) for line in ({"drive": head}, first, second)]
    _, unread, found = drives.replay(Planner, drives.always, (0, lines))
    (_, _, one), (_, _, two) = found
    assert not unread and one.state == "track" and one.flags == {"barr acts": True} and near(one.command[0], 1.1)
    assert two.state == "recover" and two.admissible == 0 and near(two.command, (0.9, 0.0)) and not two.flags["barr acts"]
    planner = Planner(head)
    ticks = list(planner.drive.ticks(lines[1:]))
    assert ticks[0].boxes == [(0.0, 0.0, 0.5, 0.5)] and ticks[1].boxes[1] == (10.0, 10.0, 10.5, 10.5)
    assert planner.drive.surroundings(ticks[0])["discs"] == [(14.0, 8.0, 0.3, 0.0, 1.0)]
    assert planner.drive.size == (20.0, 20.0) and planner.drive.sampling.steps == 30


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        self_test()
    elif sys.argv[1:] == ["--changes"]:
        drives.show_changes("barr_dwa", count, CHANGES)
    else:
        drives.compare("barr_dwa", Planner, COLUMNS)
