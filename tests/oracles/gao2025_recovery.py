"""The command where nothing is admissible. The paper has none; this is what simrun documents (src/plan/local/window/recovery.rs).

Brake, and turn towards the target: at once if the robot stands, else at the yaw rate whose braking arc gets farthest, then has the most
room, then is nearest to the wanted turn.
"""

import math

from gao2025_paper import (
    ACCELERATION_MPS2,
    STEPS,
    TICK_S,
    YAW_ACCELERATION_RADPS2,
    YAW_RATE_MAX_RADPS,
    YAW_RATE_STEP_RADPS,
    clearances_m,
    rollout,
    window,
    wrap,
)

# Clearance above which a braking arc is no safer.
ROOM_M = 0.05


def recovery(problem):
    """The twist that is commanded."""
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

    def rank(rate):
        clearances = clearances_m(problem, rollout(problem.pose, speeds, rate), ROOM_M)
        free = next((k for k, clearance in enumerate(clearances) if clearance <= 0.0), len(speeds))
        return free, max(0.0, min(clearances)), -abs(rate - now)

    rates = window(omega, change, -YAW_RATE_MAX_RADPS, YAW_RATE_MAX_RADPS, YAW_RATE_STEP_RADPS, (now,))
    return speeds[0], max(rates, key=rank)
