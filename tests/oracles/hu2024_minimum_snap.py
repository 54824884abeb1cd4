"""Minimum snap by a dense system: all coefficients of all segments, with a Lagrange multiplier for every constraint.

The stage `minimum_snap` solves for the derivatives at the nodes instead. Written from Hu, Wang, Zhang, Engineering Letters 32(3), 2024, eq. 6 to 13,
as systems.md 6 reads them (H-A6 to H-A9). Needs NumPy. Writes tests/data/minimum_snap.csv, one row per segment: the nodes at its ends, its duration
and the coefficients of its polynomials in u from 0 to 1.

    python3 tests/oracles/hu2024_minimum_snap.py
"""

import math
import os
import random

import numpy as np

DEGREE = 7
COEFFICIENTS = DEGREE + 1


def derivative_row(order, t):
    """The derivative of this order at t, as a row of factors of the coefficients."""
    row = np.zeros(COEFFICIENTS)
    for i in range(order, COEFFICIENTS):
        row[i] = math.factorial(i) / math.factorial(i - order) * t ** (i - order)
    return row


def snap(duration):
    """Q of eq. 9 on [0, duration]."""
    q = np.zeros((COEFFICIENTS, COEFFICIENTS))
    for r in range(4, COEFFICIENTS):
        for c in range(4, COEFFICIENTS):
            falling = math.factorial(r) / math.factorial(r - 4) * math.factorial(c) / math.factorial(c - 4)
            q[r, c] = falling * duration ** (r + c - 7) / (r + c - 7)
    return q


def solve(positions, durations, continuity):
    """Coefficients by time since the beginning of the segment, for one axis."""
    k = len(durations)
    rows, right = [], []

    def constrain(parts, value):
        row = np.zeros(COEFFICIENTS * k)
        for segment, part in parts:
            row[COEFFICIENTS * segment : COEFFICIENTS * (segment + 1)] += part
        rows.append(row)
        right.append(value)

    for i in range(k):
        constrain([(i, derivative_row(0, 0.0))], positions[i])
        constrain([(i, derivative_row(0, durations[i]))], positions[i + 1])
    for order in (1, 2):
        constrain([(0, derivative_row(order, 0.0))], 0.0)
        constrain([(k - 1, derivative_row(order, durations[-1]))], 0.0)
    for i in range(k - 1):
        for order in range(1, continuity + 1):
            constrain([(i, derivative_row(order, durations[i])), (i + 1, -derivative_row(order, 0.0))], 0.0)
    a = np.array(rows)
    n, m = COEFFICIENTS * k, len(rows)
    system = np.zeros((n + m, n + m))
    for i in range(k):
        at = slice(COEFFICIENTS * i, COEFFICIENTS * (i + 1))
        system[at, at] = 2.0 * snap(durations[i])
    system[:n, n:] = a.T
    system[n:, :n] = a
    b = np.concatenate([np.zeros(n), right])
    x = np.linalg.solve(system, b)
    for _ in range(3):
        residual = b.astype(np.longdouble) - system.astype(np.longdouble) @ x.astype(np.longdouble)
        x = x + np.linalg.solve(system, residual.astype(float))
    return x[:n].reshape(k, COEFFICIENTS)


def main():
    draw = random.Random(20240324)
    lines = ["case,continuity,time_alloc,from_x,from_y,to_x,to_y,duration," + ",".join(
        f"{axis}{i}" for axis in "xy" for i in range(COEFFICIENTS)
    )]
    case = 0
    for k in (1, 2, 3, 5, 9):
        for continuity in (3, 2):
            for time_alloc in ("equal", "proportional"):
                points = [(draw.randint(0, 80) / 4, draw.randint(0, 80) / 4)]
                while len(points) < k + 1:
                    point = (points[-1][0] + draw.randint(-24, 24) / 4, points[-1][1] + draw.randint(-24, 24) / 4)
                    if math.dist(point, points[-1]) >= 1.0:
                        points.append(point)
                lengths = [math.dist(a, b) for a, b in zip(points, points[1:])]
                durations = [1.0] * k
                if time_alloc == "proportional":
                    durations = [length / sum(lengths) * k for length in lengths]
                axes = [solve([p[axis] for p in points], durations, continuity) for axis in (0, 1)]
                for i in range(k):
                    scaled = [c * durations[i] ** j for axis in axes for j, c in enumerate(axis[i])]
                    numbers = [*points[i], *points[i + 1], durations[i], *scaled]
                    lines.append(f"{case},{continuity},{time_alloc}," + ",".join(repr(float(x)) for x in numbers))
                case += 1
    path = os.path.join(os.path.dirname(__file__), "..", "data", "minimum_snap.csv")
    with open(path, "w", encoding="utf-8") as out:
        out.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
