"""The command where nothing is admissible. The papers have none; this is what simrun documents (src/plan/local/window/recovery.rs).

Brake, and turn towards the target: at once if the robot stands, else at the yaw rate whose braking arc gets farthest, then has the most
room, then is nearest to the wanted turn.
"""

import math

from dynamic_window import bearing_from, clearances_m, rollout, yaw_rates

# Clearance above which a braking arc is no safer.
ROOM_M = 0.05


def recovery(problem):
    """The twist that is commanded."""
    robot, tick_s = problem.robot, problem.sampling.tick_s
    v, omega = problem.twist
    bearing = bearing_from(problem.pose, problem.target)
    stoppable = math.sqrt(2.0 * robot.yaw_acceleration_radps2 * abs(bearing))
    wanted = math.copysign(min(robot.yaw_rate_max_radps, stoppable, abs(bearing) / tick_s), bearing)
    lost = robot.deceleration_mps2 * tick_s
    speeds = [v - k * lost for k in range(1, problem.sampling.steps + 1) if v - k * lost > 1e-9]
    if not speeds:
        return 0.0, wanted
    change = robot.yaw_acceleration_radps2 * tick_s
    low, high = max(-robot.yaw_rate_max_radps, omega - change), min(robot.yaw_rate_max_radps, omega + change)
    now = min(high, max(low, wanted))

    def rank(rate):
        clearances = clearances_m(problem, rollout(problem.pose, speeds, rate, tick_s), ROOM_M)
        free = next((k for k, clearance in enumerate(clearances) if clearance <= 0.0), len(speeds))
        return free, max(0.0, min(clearances)), -abs(rate - now)

    return speeds[0], max(yaw_rates(problem, (now,)), key=rank)
