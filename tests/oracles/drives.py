"""Recorded drives of simrun, the table of a second implementation's answers to them, and what the comparison would notice.

A file of drives is JSON lines: for each drive a line that says what holds throughout, then a line for each tick in which the planner was asked.
A second implementation gives a function that makes a planner of the first; the planner answers the ticks in order.
"""

import json
from collections import Counter
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import Pool

import decisions
import dynamic_window as core
from qin2026_paper import whole

DIFFERENCES = 30  # printed
CHANGED_EVERY = 5  # ticks of which a changed program gives the command

# Keys of every planner's parameters, with the only words that are understood here.
WORDS = {
    "prediction": ["euler"],
    "va_distance": ["arc", "clearance"],
    "dist_mode": ["path_min"],
    "heading_at": ["horizon"],
    "target": ["sub_goal"],
    "normalise": ["sum"],
    "clearances": ["exact"],
    "va_angular": ["printed"],
    "va_uses_clip": [False],
    "va_clip_m": [None],
    "movers_horizon_s": [None],
    "room_m": [0.0],
}
NUMBERS = ["speed_step_mps", "yaw_rate_step_radps", "horizon_s", "d_cap_m", "predict_dynamic"]


@dataclass
class Answer:
    """What is decided at a tick."""

    state: str
    command: tuple = None  # None where it was not asked for
    cap_mps: float = None  # None where there is none
    margin: float = None  # of the score, see dynamic_window.margin
    admissible: int = None
    slack: float = None  # by how much a rule of the states would have to move to change
    flags: dict = field(default_factory=dict)  # counted in the table


@dataclass
class Tick:
    """A line, and the map as it is believed."""

    line: dict
    boxes: list


class Drive:
    """What holds throughout a drive."""

    def __init__(self, head, words, numbers):
        """`words` and `numbers` are the keys of the planner's own parameters."""
        params, limits = head["params"], head["robot"]
        words = {**WORDS, **words}
        for key, allowed in words.items():
            if params[key] not in allowed:
                raise ValueError(f"{key} is {params[key]!r}, expected {' or '.join(map(repr, allowed))}")
        self.params = {key: params[key] for key in [*words, *NUMBERS, *numbers]}
        self.unread = {key: value for key, value in params.items() if key not in self.params}
        self.head, self.tick_s = head, head["dt_s"]
        self.known = {tuple(cell) for cell in head["known"]}
        self.robot = core.Robot(
            radius_m=limits["radius_m"],
            speed_max_mps=limits["speed_max_mps"],
            yaw_rate_max_radps=limits["yaw_rate_max_radps"],
            acceleration_mps2=limits["acceleration_max_mps2"],
            deceleration_mps2=limits["deceleration_max_mps2"],
            yaw_acceleration_radps2=limits["yaw_acceleration_max_radps2"],
        )
        self.sampling = core.Sampling(
            speed_step_mps=params["speed_step_mps"],
            yaw_rate_step_radps=params["yaw_rate_step_radps"],
            tick_s=self.tick_s,
            steps=whole(params["horizon_s"] / self.tick_s),
            cap_m=params["d_cap_m"],
            va_distance=params["va_distance"],
        )
        self.size = (head["cols"] * head["resolution_m"], head["rows"] * head["resolution_m"])

    def boxes(self, added):
        """The squares of the cells that are known or added."""
        side_m = self.head["resolution_m"]
        return [tuple(side * side_m for side in (col, row, col + 1, row + 1)) for col, row in sorted(self.known | added)]

    def ticks(self, lines):
        """The ticks of a drive, from its lines but the first."""
        boxes = self.boxes(set())
        for line in map(json.loads, lines):
            if "added" in line:
                boxes = self.boxes({tuple(cell) for cell in line["added"]})
            yield Tick(line, boxes)

    def surroundings(self, tick):
        """The fields of a problem that a tick gives, and those that hold throughout."""
        return {
            "robot": self.robot,
            "sampling": self.sampling,
            "predict": self.params["predict_dynamic"],
            "size": self.size,
            "pose": tuple(tick.line["pose"]),
            "twist": tuple(tick.line["twist"]),
            "target": tuple(tick.line["sub_goal"]),
            "boxes": tick.boxes,
            "discs": [(x, y, radius, vx, vy) for x, y, vx, vy, radius, _ in tick.line["movers"]],
        }


def read(path):
    """The content of a file of drives, and for each drive its number and its lines."""
    content, jobs = path.read_bytes(), []
    for line in content.decode().splitlines():
        if '"drive":' in line:
            jobs.append((len(jobs), []))
        if line:
            jobs[-1][1].append(line)
    return content, jobs


def replay(make, wanted, job):
    """For each tick of a drive what simrun recorded, and the answer; the head of the drive and what of its parameters nothing reads.

    `make` makes a planner of a head; `wanted` says of the place of a tick in the drive and of its line whether the command is asked for.
    """
    number, lines = job
    head = json.loads(lines[0])["drive"]
    planner = make(head)
    found = []
    for k, tick in enumerate(planner.drive.ticks(lines[1:])):
        found.append((number, tick.line, planner.decide(tick, wanted(k, tick.line))))
    return head, planner.drive.unread, found


def always(_k, _line):
    """Every command is asked for."""
    return True


def cap_of(head, line):
    """simrun's cap at a tick, None where there is none or the planner has none."""
    cap_mps = line["notes"][0] if head["planner"] == "follow_dwa" else None
    return None if cap_mps == head["robot"]["speed_max_mps"] else cap_mps


def differences(head, line, answer):
    """What is not the same: state, cap, command; a state whose command was not asked for is not compared where simrun recovers."""
    found = []
    asked = answer.command is not None
    if answer.state != line["state"] and (asked or line["state"] != "recover"):
        found.append("state")
    mine, theirs = answer.cap_mps, cap_of(head, line)
    if (mine is None) != (theirs is None) or mine is not None and abs(mine - theirs) > 1e-9:
        found.append("cap")
    if asked and any(abs(a - b) > 1e-9 for a, b in zip(line["command"], answer.command)):
        found.append("command")
    return found


def variants(heads):
    """For each drive the parameters in which it differs from another."""
    keys = [key for key in heads[0]["params"] if len({json.dumps(head["params"].get(key)) for head in heads}) > 1]
    return ["; ".join(f"{key} {head['params'][key]}" for key in keys) for head in heads]


def show(drives):
    """Prints a table by parameters and state, transitions, margins, parameters that nothing reads, and the first differences."""
    heads = [head for head, _, _ in drives]
    flags = sorted({key for _, _, ticks in drives for _, _, answer in ticks for key in answer.flags})
    has_cap = heads[0]["planner"] == "follow_dwa"
    kinds = ["state", "cap", "command"] if has_cap else ["state", "command"]
    counts, total, transitions, unread, different = Counter(), Counter(), Counter(), {}, []
    same_drives = 0
    for (head, leftover, ticks), variant in zip(drives, variants(heads)):
        unread.update({key: unread.get(key, set()) | {json.dumps(value)} for key, value in leftover.items()})
        before, is_same = None, True
        for number, line, answer in ticks:
            found = differences(head, line, answer)
            group = (variant, line["state"])
            total[group] += 1
            counts[group, "movers"] += bool(line["movers"])
            counts.update((group, key) for key in flags if answer.flags.get(key))
            counts.update((group, key) for key in kinds if key not in found)
            if before not in (None, answer.state):
                transitions[before, answer.state] += 1
            before = answer.state
            if found:
                different.append((head, number, found, line, answer))
                is_same = False
        same_drives += is_same
    print("| drives with | simrun's state | ticks | with movers |", " | ".join(flags + [f"same {key}" for key in kinds]), "|")
    print("|---" * (4 + len(flags) + len(kinds)) + "|")
    for group in sorted(total):
        cells = [total[group], *(counts[group, key] for key in ("movers", *flags, *kinds))]
        print(f"| {group[0]} | `{group[1]}` |", " | ".join(map(str, cells)), "|")
    print(f"\n{sum(total.values())} ticks, {len(different)} differ; {same_drives} of {len(drives)} drives are the same at every tick")
    print("transitions:", ", ".join(f"{a} to {b} {count}" for (a, b), count in sorted(transitions.items())))
    for name in ("margin", "slack"):
        numbers = sorted(getattr(answer, name) for _, _, ticks in drives for _, _, answer in ticks if getattr(answer, name) is not None)
        if numbers:
            print(f"smallest {name}s:", *(f"{number:.2g}" for number in numbers[:8]), f"median: {numbers[len(numbers) // 2]:.2g}")
    if unread:
        print("parameters that nothing reads:", ", ".join(f"{key} {' or '.join(sorted(values))}" for key, values in sorted(unread.items())))
    for head, number, found, line, answer in different[:DIFFERENCES]:
        where = ", ".join(f"{key} {head[key]}" for key in ("scenario", "stack", "episode", "changes"))
        print(f"\ndrive {number}, {where}, tick {line['tick']}: {', '.join(found)}")
        print("  simrun ", {key: value for key, value in line.items() if key != "added"}, "\n  second ", answer)


def compare(name, make, columns):
    """Answers every tick of `name`_drives.jsonl, writes `name`_second.csv, and prints where they agree."""
    path = decisions.DATA / f"{name}_drives.jsonl"
    content, jobs = read(path)
    with Pool() as pool:
        drives = pool.map(partial(replay, make, always), jobs, chunksize=1)
    lines = []
    for _, _, ticks in drives:
        for number, line, answer in ticks:
            v, omega = map(float, answer.command)
            row = {"drive": number, "tick": line["tick"], "state": answer.state, "v": v, "omega": omega, "cap_mps": answer.cap_mps, "margin": answer.margin}
            lines.append({key: row[key] for key in columns})
    decisions.write(decisions.DATA / f"{name}_second.csv", path.name, content, columns, lines)
    show(drives)


# What the comparison would notice


def sometimes(k, line):
    """Every fifth command is asked for, and all outside the ordinary state."""
    return k % CHANGED_EVERY == 0 or line["state"] != "track"


def changed(make, change, job):
    """How many states or caps and how many commands of a drive differ from simrun's with a change, and how many commands were asked for."""
    kept = [(owner, key, getattr(owner, key)) for owner, key, _ in change]
    for owner, key, value in change:
        setattr(owner, key, value)
    try:
        head, _, ticks = replay(make, sometimes, job)
    finally:
        for owner, key, value in kept:
            setattr(owner, key, value)
    found = [(differences(head, line, answer), answer.command is not None) for _, line, answer in ticks]
    states = sum("state" in each or "cap" in each for each, _ in found)
    return states, sum("command" in each for each, _ in found), sum(asked for _, asked in found), len(found)


def show_changes(name, count, changes):
    """Prints a table of how many ticks differ for each change; `count` gives what `changed` does for the name of a change and a drive."""
    _, jobs = read(decisions.DATA / f"{name}_drives.jsonl")
    print("| change | state or cap differs | command differs |\n|---|---|---|")
    with Pool() as pool:
        for change in changes:
            results = pool.map(partial(count, change), jobs, chunksize=1)
            states, commands, asked, ticks = map(sum, zip(*results))
            print(f"| {change} | {states} of {ticks} | {commands} of {asked} |", flush=True)
