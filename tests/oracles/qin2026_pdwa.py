"""Drives PDWA's automaton through the ticks of tests/data/pdwa_drives.jsonl anew, from the paper, and says where simrun decided otherwise.

    python3 tests/oracles/qin2026_pdwa.py              writes tests/data/pdwa_second.csv, prints the tables of the README
    python3 tests/oracles/qin2026_pdwa.py --self-test  checks regions, rectangles and backing up against cases worked by hand

The state is the program's own from the first tick of a drive to the last; what simrun decided serves the comparison alone. The standard
library is enough.
"""

import json
import math
import sys
from collections import Counter
from multiprocessing import Pool

import decisions
import dynamic_window as core
import qin2026_paper as paper

COLUMNS = ["drive", "tick", "state", "region", "conflict", "failures", "v", "omega"]
FIRST_DIFFERENCES = 20  # printed


def automaton_of(drive):
    """The planner of a drive, and its map as a set of blocked cells."""
    limits, window, tick_s = drive["robot"], drive["params"]["avoid"], drive["dt_s"]
    for key, words in (("prediction", ["euler"]), ("va_distance", ["arc", "clearance"])):
        if window[key] not in words:
            raise ValueError(f"{key} is {window[key]!r}, expected {' or '.join(words)}")
    automaton = paper.Automaton(
        robot=core.Robot(
            radius_m=limits["radius_m"],
            speed_max_mps=limits["speed_max_mps"],
            yaw_rate_max_radps=limits["yaw_rate_max_radps"],
            acceleration_mps2=limits["acceleration_max_mps2"],
            deceleration_mps2=limits["deceleration_max_mps2"],
            yaw_acceleration_radps2=limits["yaw_acceleration_max_radps2"],
        ),
        reverse_speed_max_mps=limits["reverse_speed_max_mps"],
        sampling=core.Sampling(
            speed_step_mps=window["speed_step_mps"],
            yaw_rate_step_radps=window["yaw_rate_step_radps"],
            tick_s=tick_s,
            steps=paper.whole(window["horizon_s"] / tick_s),
            cap_m=window["d_cap_m"],
            va_distance=window["va_distance"],
        ),
        predict=window["predict_dynamic"],
        weights=(window["heading_weight"], window["distance_weight"], window["velocity_weight"]),
        size=(drive["cols"] * drive["resolution_m"], drive["rows"] * drive["resolution_m"]),
        params={key: drive["params"][key] for key in ("split", "trigger")},
    )
    automaton.take_path(drive["path"], drive["key_nodes_m"])
    return automaton, {tuple(cell) for cell in drive["known"]}


def boxes(cells, resolution_m):
    """The squares of cells."""
    return [tuple(side * resolution_m for side in (col, row, col + 1, row + 1)) for col, row in sorted(cells)]


def replay(job):
    """What a drive's header says, and for each tick what simrun recorded, what the automaton decides, and how near that was to something else."""
    number, lines = job
    drive = json.loads(lines[0])["drive"]
    automaton, known = automaton_of(drive)
    resolution_m = drive["resolution_m"]
    believed, unexpected = boxes(known, resolution_m), []
    ticks = []
    for line in map(json.loads, lines[1:]):
        if "path" in line:
            automaton.take_path(line["path"], line["key_nodes_m"])
            continue
        if "added" in line:
            added = {tuple(cell) for cell in line["added"]} - known
            believed, unexpected = boxes(known | added, resolution_m), boxes(added, resolution_m)
        now = paper.Now(
            pose=tuple(line["pose"]),
            twist=tuple(line["twist"]),
            progress_m=line["progress_m"],
            movers=[(x, y, radius, vx, vy) for x, y, vx, vy, radius, _ in line["movers"]],
            believed=believed,
            unexpected=unexpected,
        )
        command = automaton.decide(now)
        tracked = command is paper.TRACKED
        mine = {
            "drive": number,
            "tick": line["tick"],
            "state": automaton.state,
            "region": automaton.region,
            "conflict": "true" if automaton.conflict else "false",
            "failures": automaton.failures,
            "v": None if tracked else float(command[0]),
            "omega": None if tracked else float(command[1]),
        }
        region, conflict, failures = line["notes"]
        theirs = {"state": line["state"], "region": region, "conflict": conflict == 1.0, "failures": failures, "command": line["command"]}
        ticks.append((theirs, mine, (automaton.margins, automaton.behind_m(now))))
    name = ", ".join(f"{key} {drive[key]}" for key in ("scenario", "stack", "episode"))
    return name, ticks


def differences(theirs, mine):
    """What is not the same: state, region, conflict, failures, command. The path tracker's command is not compared."""
    found = [key for key in ("state", "region", "failures") if theirs[key] != mine[key]]
    if theirs["conflict"] != (mine["conflict"] == "true"):
        found.append("conflict")
    if theirs["state"] != "follow":
        numbers = mine["v"], mine["omega"]
        if None in numbers or any(abs(a - b) > 1e-9 for a, b in zip(theirs["command"], numbers)):
            found.append("command")
    return found


def show(drives):
    """Prints the tables of the README, the transitions, and the first difference of each drive."""
    counts, transitions, first, same_drives, scores = Counter(), Counter(), [], 0, []
    for name, ticks in drives:
        before, differs = "follow", False
        for theirs, mine, (margins, behind_m) in ticks:
            state = theirs["state"]
            found = differences(theirs, mine)
            counts[state, "ticks"] += 1
            counts.update((state, key) for key in found)
            transitions[before, mine["state"]] += before != mine["state"]
            before = mine["state"]
            if margins.score is not None:
                scores.append(margins.score)
            if found and not differs:
                differs = True
                first.append((name, found, theirs, mine, margins, behind_m))
        same_drives += not differs
    keys = ("state", "region", "conflict", "failures", "command")
    print("| simrun's state | ticks |", " | ".join(f"same {key}" for key in keys), "|")
    print("|---" * (len(keys) + 2) + "|")
    for state in sorted({state for state, _ in counts}):
        total = counts[state, "ticks"]
        cells = ["" if (state, key) == ("follow", "command") else total - counts[state, key] for key in keys]
        print(f"| `{state}` | {total} |", " | ".join(map(str, cells)), "|")
    print(f"\n{same_drives} of {len(drives)} drives are the same at every tick")
    print("transitions:", ", ".join(f"{a} to {b} {count}" for (a, b), count in sorted(transitions.items()) if count))
    if scores:
        scores.sort()
        print("smallest margins of the score:", *(f"{score:.2g}" for score in scores[:8]), f"median: {scores[len(scores) // 2]:.2g}")
    for name, found, theirs, mine, margins, behind_m in first[:FIRST_DIFFERENCES]:
        print(f"\n{name}, tick {mine['tick']}: {', '.join(found)}\n  simrun  {theirs}\n  second  {mine}")
        print(f"  no conflict by {margins.conflict_m:.3g} m, may back up {behind_m:.3g} m, admissible {margins.admissible}, margin {margins.score}")


def self_test():
    """Fails where a part is not as worked by hand."""
    # 17 m are cut into three; 1 m at the end is joined with what is before; 1 m and 1.5 m with what is after.
    assert paper.split_by_length([(0.0, 17.0), (17.0, 18.0)], 8.0, 2.0) == [(0.0, 17 / 3), (17 / 3, 34 / 3), (34 / 3, 18.0)]
    assert paper.split_by_length([(0.0, 1.0), (1.0, 1.5), (1.5, 9.5)], 8.0, 2.0) == [(0.0, 9.5)]
    assert paper.split_by_length([(0.0, 8.0), (8.0, 10.0)], 8.0, 2.0) == [(0.0, 8.0), (8.0, 10.0)]
    assert paper.split_by_length([(0.0, 1.0)], 8.0, 2.0) == [(0.0, 1.0)]
    # The axis from (0, 0) to (4, 4): a point straight ahead, one abreast, and two unit squares whose corners point at the rectangle.
    rectangle = paper.Rectangle((0.0, 0.0), (4.0, 4.0), 1.5, 0.5)
    assert math.isclose(rectangle.gap_to_point_m(5.0, 5.0), math.sqrt(2.0) - 0.5)
    assert math.isclose(rectangle.gap_to_point_m(4.0, 0.0), math.sqrt(8.0) - 1.5)
    assert rectangle.gap_to_point_m(2.0, 3.0) == 0.0
    assert math.isclose(rectangle.gap_to_box_m((5.0, 5.0, 6.0, 6.0)), math.sqrt(2.0) - 0.5)
    assert math.isclose(rectangle.gap_to_box_m((4.0, -1.0, 5.0, 0.0)), math.sqrt(8.0) - 1.5)
    assert rectangle.gap_to_box_m((3.0, 0.5, 4.0, 1.5)) < 0.0
    # A quarter of a circle of radius 1 backwards about (0, 1): to (-1, 1), where the robot looks down.
    x, y, theta = paper.arc((0.0, 0.0, 0.0), -1.0, -1.0, math.pi / 2.0)
    assert max(abs(x + 1.0), abs(y - 1.0), abs(theta + math.pi / 2.0)) < 1e-12
    # Backwards over a path along x, 0.1 m beside it at 3 m: the target is 0.8 m behind and 0.1 m to the left.
    robot = core.Robot(0.15, 1.0, 0.6, 0.5, 0.5, math.radians(50.0))
    sampling = core.Sampling(0.02, math.radians(1.0), 0.1, 30, 2.0, "clearance")
    automaton = paper.Automaton(robot, 0.2, sampling, True, (0.2, 0.04, 0.3), (20.0, 20.0), {})
    automaton.take_path([(0.5, 5.0), (18.5, 5.0)], [0.0, 18.0])
    now = paper.Now((3.5, 4.9, 0.0), (0.0, 0.0), 3.0, [], [], [])
    v, omega = automaton.back_up(now)
    assert v == -0.2 and math.isclose(omega, -0.2 * 2.0 * 0.1 / (0.64 + 0.01))
    now.believed = [(2.0, 4.0, 3.0, 6.0)]  # 0.5 m behind the centre: the robot would stand 0.15 m from it
    assert automaton.back_up(now) == (v, omega)
    now.believed = [(2.0, 4.0, 3.14, 6.0)]
    assert automaton.back_up(now) == (0.0, 0.0)
    now.pose = (3.5, 4.9, math.pi / 2.0)  # the tail looks down, the target is at its right, 97 degrees from it
    assert automaton.back_up(now) == (0.0, -0.6)
    # From a stand at 0.5 m/s2: 0.05 m/s and 0.005 m after a tick, 1 m/s after twenty, when it has gone 1.05 m.
    points = automaton.nominal(now)
    assert len(points) == 30 and math.isclose(points[0][0], 3.505) and math.isclose(points[19][0], 4.55) and math.isclose(points[29][0], 5.55)
    # A mover that stands 5 cm less than the margin beside where the robot ends up, and one 5 cm more.
    automaton.region = 0
    for gap, expected in ((0.25, True), (0.35, False)):
        now.movers = [(5.55, 5.0 + 0.45 + gap, 0.3, 0.0, 0.0)]
        assert automaton.in_conflict(now) is expected
    test_states(automaton)
    print("regions, rectangles, conflict, backing up and states are as worked by hand")


def test_states(automaton):
    """The states on a path of 18 m in regions of 6 m, where conflicts and what the dynamic window finds are given."""
    automaton.take_path([(0.5, 5.0), (18.5, 5.0)], [0.0, 18.0])
    automaton.regions = [(0.0, 6.0), (6.0, 12.0), (12.0, 18.0)]
    automaton.back_up = lambda now: (-0.2, 0.0)
    total = 0

    def drive(ticks, s, conflict, finds, state, failures, region=None):
        nonlocal total
        automaton.in_conflict = lambda now: conflict
        automaton.dynamic_window = lambda now: (0.5, 0.0) if finds else None
        for _ in range(ticks):
            automaton.decide(paper.Now((0.0, 0.0, 0.0), (0.0, 0.0), s, [], [], []))
            total += 1
            assert (automaton.state, automaton.failures) == (state, failures), (total, automaton.state, automaton.failures)
            assert region is None or automaton.region == region

    drive(3, 7.0, False, True, "follow", 0, 1)
    drive(1, 7.0, True, True, "avoid", 0)
    drive(9, 7.1, False, True, "avoid", 0)  # clear 1 to 9
    drive(1, 7.2, True, True, "avoid", 0)  # clear 0
    drive(9, 7.2, False, True, "avoid", 0)
    drive(1, 7.2, False, True, "follow", 0)
    drive(10, 7.2, True, False, "retreat", 1, 1)  # region 1 has failed; no way out before ten ticks are over
    drive(5, 6.5, True, False, "retreat", 1)
    drive(1, 6.5, True, True, "avoid", 1)
    drive(10, 6.5, True, False, "retreat", 2)
    drive(1, 6.5, False, False, "follow", 2)
    for attempt in (3, 4, 5):
        drive(10, 6.5, True, False, "retreat", attempt)
        drive(1, 6.5, True, True, "avoid", attempt)
    drive(1, 6.5, True, False, "withdraw", 6)  # the sixth
    drive(20, 3.0, False, True, "withdraw", 6, 0)  # does not look at conflicts; back as far as region 0, which counts as region 1 still
    drive(100, 0.05, True, True, "wait", 6)
    drive(1, 0.05, True, True, "avoid", 0)  # 10 s over
    drive(1, 0.05, True, False, "wait", 1)  # fails, and cannot go back: no tick of retreat
    drive(99, 0.05, True, False, "wait", 1)
    drive(1, 0.05, True, False, "wait", 1)  # 10 s over, fails anew: the count was 0 in between
    drive(9, 0.05, False, False, "wait", 1)
    drive(1, 0.05, False, False, "follow", 0)
    drive(1, 0.05, True, False, "wait", 1)
    drive(8, 0.05, False, False, "wait", 1)
    drive(1, 6.0, False, False, "wait", 0, 1)  # beyond the region that failed; the ninth without conflict
    drive(1, 18.0, False, False, "follow", 0, 2)
    automaton.reverse_speed_max_mps = 0.0
    drive(1, 17.0, True, False, "wait", 1)
    automaton.take_path([(0.5, 5.0), (18.5, 5.0)], [0.0, 18.0])
    drive(1, 1.0, False, False, "follow", 0)


def main():
    path = decisions.DATA / "pdwa_drives.jsonl"
    content = path.read_bytes()
    jobs = []
    for line in content.decode().splitlines():
        if '"drive":' in line:
            jobs.append((len(jobs), []))
        if line:
            jobs[-1][1].append(line)
    with Pool() as pool:
        drives = pool.map(replay, jobs, chunksize=1)
    lines = [mine for _, ticks in drives for _, mine, _ in ticks]
    decisions.write(decisions.DATA / "pdwa_second.csv", path.name, content, COLUMNS, lines)
    show(drives)


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        self_test()
    else:
        main()
