"""Made-up drives for planners whose recorded ones leave some of their rules untried: a bent path, many movers of several sizes, at all angles.

    python3 tests/oracles/situations.py    writes tests/data/PLANNER_situations.jsonl for barr_dwa and follow_dwa

The answers in these files are those of the second implementations, and the robot drives as they say. A head is taken from each kind of recorded
drive. The numbers are drawn with fixed seeds, so the files come out the same. The standard library is enough.
"""

import json
import math
import random
from functools import partial
from multiprocessing import Pool

import decisions
import drives
import hu2024_follow_dwa
import zhao2025_barr_dwa
from qin2026_paper import Path

PLANNERS = {"barr_dwa": zhao2025_barr_dwa.Planner, "follow_dwa": hu2024_follow_dwa.Planner}
# Corners of the paths, in shares of the map's sides.
BENDS = {
    "barr_dwa": [(0.1, 0.3), (0.5, 0.4), (0.85, 0.75)],
    "follow_dwa": [(0.1, 0.2), (0.35, 0.3), (0.5, 0.6), (0.8, 0.7), (0.85, 0.85)],
}
TICKS = 400
SEED = 1000


def heads(name):
    """One head of each kind of recorded drive."""
    kinds = {}
    for _, lines in drives.read(decisions.DATA / f"{name}_drives.jsonl")[1]:
        head = json.loads(lines[0])["drive"]
        kinds.setdefault(json.dumps([head[key] for key in ("params", "robot", "scenario", "stack")]), head)
    return list(kinds.values())


def beside_m(path, point):
    """Distance of a point from the path, m."""
    places = range(int(path.at_m[-1] * 5) + 1)
    return min(math.dist(point, path.point(0.2 * place)) for place in places)


def place(head, bends, draw):
    """The head with another path and some cells beside it."""
    side_m = head["resolution_m"]
    width_m, height_m = head["cols"] * side_m, head["rows"] * side_m
    points = [[round(x * width_m, 3), round(y * height_m, 3)] for x, y in bends]
    path, known = Path(points), []
    for _ in range(8):
        cell = [draw.randrange(head["cols"]), draw.randrange(head["rows"])]
        centre = [(number + 0.5) * side_m for number in cell]
        if beside_m(path, centre) > 0.9 * side_m + 0.4 and cell not in known:
            known.append(cell)
    head = dict(head, path=points, known=known, goal=points[-1], key_nodes_m=path.at_m[:])
    return head, path, (width_m, height_m)


def mover(path, s, number, speed_max_mps, draw):
    """A mover ahead of a robot at `s` on the path: along it, across it, lingering in it, or anyhow."""
    kind = draw.random()
    s += draw.uniform(0.6, 5)
    (x, y), radius_m = path.point(s), draw.choice([0.15, 0.25, 0.3, 0.5, 0.6])
    before, after = path.point(s - 0.2), path.point(s + 0.2)
    ahead = math.atan2(after[1] - before[1], after[0] - before[0])
    side = draw.choice([-1, 1])
    if kind < 0.35:
        angle, speed, aside = ahead + math.radians(draw.uniform(-35, 35)), draw.uniform(0.6, 1.0) * speed_max_mps, draw.uniform(-0.7, 0.7)
    elif kind < 0.75:
        angle, speed, aside = ahead + side * math.radians(draw.uniform(35, 145)), draw.choice([0.05, 0.12, 0.3, 0.6, 1.0]), draw.uniform(-1.2, 1.2)
    elif kind < 0.9:
        angle, speed, aside = ahead + side * math.radians(draw.uniform(60, 120)), draw.uniform(0.1, 0.16), draw.uniform(-0.3, 0.3)
    else:
        angle, speed, aside = draw.uniform(-3.1, 3.1), draw.uniform(0, 1.5), draw.uniform(-2, 2)
    x, y = x - aside * math.sin(ahead), y + aside * math.cos(ahead)
    return [x, y, speed * math.cos(angle), speed * math.sin(angle), radius_m, number]


def drive(name, job):
    """The lines of a made-up drive."""
    number, head = job
    draw = random.Random(SEED + number)
    head, path, (width_m, height_m) = place(head, BENDS[name], draw)
    planner = PLANNERS[name](json.loads(json.dumps(head)))
    boxes, speed_max_mps = planner.drive.boxes(set()), head["robot"]["speed_max_mps"]
    turn = 0.1 * head["robot"]["yaw_acceleration_max_radps2"]
    lines = ['{"drive":' + json.dumps(head, separators=(",", ":")) + "}"]
    (x0, y0), (x1, y1) = head["path"][:2]
    pose, twist = [x0, y0, math.atan2(y1 - y0, x1 - x0) + 0.3], [0.0, 0.0]
    movers, ages, drawn = [], {}, 0
    for tick in range(TICKS):
        places = range(int(path.at_m[-1] * 20) + 1)
        s = min((math.dist(path.point(0.05 * at), pose[:2]), 0.05 * at) for at in places)[1]
        for each in movers[:]:
            ages[each[5]] -= 1
            if ages[each[5]] <= 0 or math.dist(each[:2], pose[:2]) > 6:
                movers.remove(each)
        while len(movers) < draw.choice([0, 1, 2, 3, 3]) and draw.random() < 0.5:
            new = mover(path, s, drawn, speed_max_mps, draw)
            drawn += 1
            if math.dist(new[:2], pose[:2]) > new[4] + 0.45:
                movers.append(new)
                ages[new[5]] = draw.choice([5, 20, 60, 160])
        if draw.random() < 0.2:
            draw.shuffle(movers)
        line = {
            "tick": tick,
            "pose": [round(each, 6) for each in pose],
            "twist": [round(each, 12) for each in twist],
            "progress_m": round(s, 6),
            "sub_goal": [round(each, 6) for each in path.point(min(path.at_m[-1], s + 4))],
            "movers": [[*(round(each, 6) for each in one[:5]), float(one[5])] for one in movers],
        }
        answer = planner.decide(drives.Tick(line, boxes), True)
        line["state"] = answer.state
        line["notes"] = [] if name == "barr_dwa" else [speed_max_mps if answer.cap_mps is None else answer.cap_mps]
        line["command"] = list(answer.command)
        lines.append(json.dumps(line, separators=(",", ":")))
        twist = [max(0.0, answer.command[0]), twist[1] + min(turn, max(-turn, answer.command[1] - twist[1]))]
        x, y, theta = pose
        x, y = x + 0.1 * twist[0] * math.cos(theta), y + 0.1 * twist[0] * math.sin(theta)
        pose = [min(width_m - 0.3, max(0.3, x)), min(height_m - 0.3, max(0.3, y)), theta + 0.1 * twist[1]]
        if s > path.at_m[-1] - 0.4 or draw.random() < 0.004:
            # Set back somewhere on the path.
            s = draw.uniform(0, 0.7) * path.at_m[-1]
            (x, y), ahead = path.point(s), path.point(s + 0.3)
            pose = [x, y, math.atan2(ahead[1] - y, ahead[0] - x) + draw.uniform(-0.5, 0.5)]
            twist = [draw.choice([0.0, 0.3, 0.8]) * speed_max_mps * 0.9, 0.0]
        for each in movers:
            each[0] += 0.1 * each[2]
            each[1] += 0.1 * each[3]
    return lines


def main():
    for name in PLANNERS:
        with Pool() as pool:
            made = pool.map(partial(drive, name), list(enumerate(heads(name))), chunksize=1)
        text = "".join(f"{line}\n" for lines in made for line in lines)
        (decisions.DATA / f"{name}_situations.jsonl").write_text(text)


if __name__ == "__main__":
    main()
