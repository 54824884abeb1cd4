"""A query of a peer's grid planner on a MovingAI map, no corners cut.

    python planners.py tcod|pathfinding|python_motion_planning MAP SCENARIO CORE QUERIES

Paths are checked against the optimum of the scenario. Building what the planner keeps of a map is not timed.
"""

import math
import os
import sys
import time

import scenes

os.environ.setdefault("MPLBACKEND", "Agg")


def tcod(free):
    """C, whole costs of 10000 and 14142, octile estimate."""
    import numpy as np
    from tcod.path import CustomGraph, Pathfinder

    cells = np.array(free, dtype=np.int32)
    height, width = cells.shape
    graph = CustomGraph((height, width), order="C")
    padded = np.pad(cells, 1)
    for dy, dx in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        graph.add_edge((dy, dx), 10000, cost=cells)
    for dy in (-1, 1):
        for dx in (-1, 1):
            sides = padded[1 + dy:1 + dy + height, 1:1 + width] & padded[1:1 + height, 1 + dx:1 + dx + width]
            graph.add_edge((dy, dx), 14142, cost=cells, condition=np.ascontiguousarray(sides.astype(np.int32)))
    graph.set_heuristic(cardinal=10000, diagonal=14142)

    def answer(start, goal):
        begin = time.process_time()
        search = Pathfinder(graph)
        search.add_root(start[::-1])
        path = search.path_to(goal[::-1])
        return time.process_time() - begin, [(int(col), int(row)) for row, col in path]

    return answer


def pathfinding(free):
    """Pure Python."""
    from pathfinding.core.diagonal_movement import DiagonalMovement
    from pathfinding.core.grid import Grid
    from pathfinding.finder.a_star import AStarFinder

    grid = Grid(matrix=[[int(cell) for cell in row] for row in free])
    finder = AStarFinder(diagonal_movement=DiagonalMovement.only_when_no_obstacle)

    def answer(start, goal):
        grid.cleanup()
        begin = time.process_time()
        path, _ = finder.find_path(grid.node(*start), grid.node(*goal), grid)
        return time.process_time() - begin, [(node.x, node.y) for node in path]

    return answer


def python_motion_planning(free):
    """Python with numba, Euclidean estimate; only plan() is timed, not the distance field that its constructor makes."""
    from python_motion_planning.common import TYPES, Grid
    from python_motion_planning.path_planner import AStar

    height, width = len(free), len(free[0])
    grid = Grid(bounds=[[0, width], [0, height]], strict_collision=True)
    for row in range(height):
        for col in range(width):
            if not free[row][col]:
                grid.type_map[col, row] = TYPES.OBSTACLE
    grid.update_esdf()
    grid.update_connectivity()

    def answer(start, goal):
        planner = AStar(map_=grid, start=start, goal=goal)
        begin = time.process_time()
        path, _ = planner.plan()
        return time.process_time() - begin, [tuple(int(value) for value in cell) for cell in path]

    return answer


def main():
    tool, map_file, scenario, core, count = sys.argv[1:]
    scenes.pin(int(core))
    answer = globals()[tool](scenes.read_grid(map_file))
    queries = scenes.read_queries(scenario)[:int(count)]
    answer(*queries[0][:2])
    total_s = 0.0
    for start, goal, optimum in queries:
        time_s, path = answer(start, goal)
        total_s += time_s
        length = sum(math.dist(a, b) for a, b in zip(path, path[1:]))
        assert {path[0], path[-1]} == {start, goal}, f"{tool}: no path from {start} to {goal}"
        assert abs(length - optimum) < 1e-3 * optimum, f"{tool}: {length} instead of {optimum}"
    scenes.report(us=1e6 * total_s / len(queries))


main()
