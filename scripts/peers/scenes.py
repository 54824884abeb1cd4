"""Reads the scenes of benches/scenes, and times what a peer does with them."""

import json
import os
import statistics
import time


def read_world(file):
    """A .world file: key -> numbers, `moving` and `static` -> a list of them."""
    world = {"moving": [], "static": []}
    for words in lines(file):
        values = [float(word) for word in words[1:]]
        if words[0] in ("moving", "static"):
            world[words[0]].append(values)
        else:
            world[words[0]] = values
    return world


def read_grid(file):
    """A MovingAI map: rows from the top, true where a cell is free."""
    text = open(file).read().split("\n")
    begin = next(number for number, line in enumerate(text) if line.strip() == "map") + 1
    return [[cell in ".GS" for cell in line] for line in text[begin:] if line]


def read_queries(file):
    """A MovingAI scenario: start, goal (column, row) and the optimal length of each query."""
    rows = [line.split() for line in open(file) if not line.startswith("version")]
    return [((int(r[4]), int(r[5])), (int(r[6]), int(r[7])), float(r[8])) for r in rows if r]


def lines(file):
    for line in open(file):
        words = line.split()
        if words and not words[0].startswith("#") and words[0] != "type":
            yield words


def pin(core):
    os.sched_setaffinity(0, {core})


def seconds(work, repetitions):
    """Median processor time of one call, after one that does not count."""
    work()
    times = []
    for _ in range(repetitions):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return statistics.median(times)


def report(**values):
    print(json.dumps(values))
