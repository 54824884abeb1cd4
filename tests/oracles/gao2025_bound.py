"""What simrun documents where it does not compute what the paper prints, written from its documentation.

- Clearances are lower bounds: src/plan/local/window/patch.rs (a lattice of squared distances, interpolated) and rollout.rs (between the
  poses). The numbers `PITCHES_PER_CELL` and `cap` are from there and from `patch_cap` in window/mod.rs.
- A robot that believes itself in contact may still drive out: window/mod.rs.
- The command where nothing is admissible, which the paper does not have: window/recovery.rs.
"""

import math

from gao2025_paper import (
    ACCELERATION_MPS2,
    ROBOT_RADIUS_M,
    SPEED_MAX_MPS,
    STEPS,
    TICK_S,
    YAW_ACCELERATION_RADPS2,
    YAW_RATE_MAX_RADPS,
    YAW_RATE_STEP_RADPS,
    movers,
    rollout,
    window,
    wrap,
)

PITCHES_PER_CELL = 10
PITCH_M = 1.0 / PITCHES_PER_CELL

# Squared distance, in pitches², that a robot in contact may lose.
CONTACT_SLACK = 1e-3

# Clearance above which a braking trajectory is no safer.
RECOVERY_ROOM_M = 0.05


class Lattice:
    """Lower bounds of the squared distance to the blocked cells and the border, in units of the pitch."""

    def __init__(self, problem, reach_m):
        need = (reach_m + ROBOT_RADIUS_M) / PITCH_M
        step = SPEED_MAX_MPS * TICK_S / PITCH_M
        self.cap = 1.0001 * (need * need + 0.5 + 0.25 * step * step)
        self.boxes = [tuple(round(side / PITCH_M) for side in box) for box in problem.boxes]
        self.width, self.height = (round(side / PITCH_M) for side in problem.size)
        self.nodes = {}

    def node(self, i, j):
        """Squared distance of a node: a whole number, at most the cap."""
        found = self.nodes.get((i, j))
        if found is None:
            border = max(0, min(i, j, self.width - i, self.height - j))
            found = border * border
            for x_min, y_min, x_max, y_max in self.boxes:
                dx = max(x_min - i, 0, i - x_max)
                dy = max(y_min - j, 0, j - y_max)
                found = min(found, dx * dx + dy * dy)
            found = self.nodes[i, j] = min(found, self.cap)
        return found

    def squared(self, x, y):
        """D ≥ bilinear(D) − f (1 − f) − g (1 − g)."""
        u, v = x / PITCH_M, y / PITCH_M
        i, j = math.floor(u), math.floor(v)
        f, g = u - i, v - j
        low = (1.0 - f) * self.node(i, j) + f * self.node(i + 1, j)
        high = (1.0 - f) * self.node(i, j + 1) + f * self.node(i + 1, j + 1)
        return (1.0 - g) * low + g * high - f * (1.0 - f) - g * (1.0 - g)


class Bound:
    """The lower bound as a `clearance` of gao2025_paper.decide."""

    def __init__(self, problem, reach_m):
        self.problem = problem
        self.lattice = Lattice(problem, reach_m)
        # Where contact is believed already, the distance of now takes the place of the radius.
        self.touch = (ROBOT_RADIUS_M / PITCH_M) ** 2
        here = self.lattice.squared(problem.pose[0], problem.pose[1])
        self.in_contact = here > 0.0 and here - CONTACT_SLACK < self.touch
        if self.in_contact:
            self.touch = here - CONTACT_SLACK

    def along(self, poses, step_m):
        """Lower bound of the clearance, and the number of steps before the first contact."""
        between = 0.25 * (step_m / PITCH_M) ** 2
        least, free = math.inf, len(poses) - 1
        for k, pose in enumerate(poses[1:]):
            squared = self.lattice.squared(pose[0], pose[1])
            if squared <= self.touch + between:
                free = min(free, k)
            least = min(least, squared)
        clearance = math.sqrt(max(0.0, least - between)) * PITCH_M - ROBOT_RADIUS_M
        for x, y, radius, vx, vy in movers(self.problem):
            between_m2 = (0.5 * (step_m + math.hypot(vx, vy) * TICK_S)) ** 2
            touch = radius + ROBOT_RADIUS_M
            least = math.inf
            for k, pose in enumerate(poses[1:]):
                t = (k + 1) * TICK_S
                squared = (pose[0] - x - vx * t) ** 2 + (pose[1] - y - vy * t) ** 2
                if squared <= touch * touch + between_m2:
                    free = min(free, k)
                least = min(least, squared)
            clearance = min(clearance, math.sqrt(max(0.0, least - between_m2)) - touch)
        return clearance, free

    def __call__(self, problem, poses, reach_m):
        step_m = math.dist(poses[0][:2], poses[1][:2])
        clearance, free = self.along(poses, step_m)
        touches = free < len(poses) - 1
        return (0.0 if touches else min(reach_m, max(0.0, clearance))), touches


def recovery(problem, bound):
    """simrun's command where nothing is admissible."""
    x, y, theta = problem.pose
    v, omega = problem.twist
    bearing = wrap(math.atan2(problem.target[1] - y, problem.target[0] - x) - theta)
    stoppable = math.sqrt(2.0 * YAW_ACCELERATION_RADPS2 * abs(bearing))
    wanted = math.copysign(min(YAW_RATE_MAX_RADPS, stoppable, abs(bearing) / TICK_S), bearing)
    lost = ACCELERATION_MPS2 * TICK_S
    speeds = [v - k * lost for k in range(1, STEPS + 1) if v - k * lost > 1e-9]
    if not speeds:
        return 0.0, wanted
    change = YAW_ACCELERATION_RADPS2 * TICK_S
    low, high = max(-YAW_RATE_MAX_RADPS, omega - change), min(YAW_RATE_MAX_RADPS, omega + change)
    now = min(high, max(low, wanted))
    best = None
    for rate in window(omega, change, -YAW_RATE_MAX_RADPS, YAW_RATE_MAX_RADPS, YAW_RATE_STEP_RADPS, (now,)):
        clearance, free = bound.along(rollout(problem.pose, speeds, rate), v * TICK_S)
        room = 0.0 if free < len(speeds) else min(max(0.0, clearance), RECOVERY_ROOM_M)
        key = (free, room, -abs(rate - now))
        if best is None or key > best[0]:
            best = key, rate
    return speeds[0], best[1]
