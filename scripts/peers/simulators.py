"""One step of a peer's simulator in the world of benches/scenes/world30.world.

    python simulators.py navground|irsim WORLD CORE

navground: the robot, a two-wheeled differential drive, is driven by the behaviour HL (human-like); the discs are obstacles that it
knows, the movers are agents without avoidance that it senses within 5 m. It has no global planner.
irsim: the robot drives straight to its goal (dash) and avoids nothing.
Building the world is not timed.
"""

import logging
import math
import os
import sys
import tempfile

import scenes

os.environ.setdefault("MPLBACKEND", "Agg")
STEPS = 900


def navground(world):
    from navground import core, sim

    dt = world["dt"][0]
    x, y, goal_x, goal_y, radius, speed = world["robot"]

    def agent(x, y, theta, radius, speed, waypoints, behavior, kinematics, loop, estimations):
        behavior = core.Behavior.make_type(behavior)
        behavior.kinematics = kinematics
        behavior.radius, behavior.optimal_speed, behavior.safety_margin, behavior.horizon = radius, speed, 0.1, 5.0
        task = sim.tasks.WaypointsTask(waypoints=waypoints, loop=loop, tolerance=0.3)
        agent = sim.Agent(
            radius=radius, behavior=behavior, kinematics=kinematics, task=task,
            state_estimations=estimations, control_period=0.0,
        )
        agent.pose = core.Pose2((x, y), theta)
        return agent

    def build():
        made = sim.World()
        drive = core.kinematics.TwoWheelsDifferentialDriveKinematics(speed, 0.4)
        theta = math.atan2(goal_y - y, goal_x - x)
        senses = [sim.state_estimations.BoundedStateEstimation(5.0)]
        made.add_agent(agent(x, y, theta, radius, speed, [(goal_x, goal_y)], "HL", drive, False, senses))
        for x0, y0, x1, y1, r, v in world["moving"]:
            drive = core.kinematics.OmnidirectionalKinematics(v, 1.0)
            made.add_agent(agent(x0, y0, 0.0, r, v, [(x1, y1), (x0, y0)], "Dummy", drive, True, []))
        for at_x, at_y, r in world["static"]:
            made.add_obstacle(core.Disc((at_x, at_y), r))
        width, height = world["size"]
        corners = [(0, 0), (width, 0), (width, height), (0, height)]
        for begin, end in zip(corners, corners[1:] + corners[:1]):
            made.add_wall(core.LineSegment(begin, end))
        made.seed = 1
        return made

    return build, lambda made: made.run(STEPS, dt), lambda made: list(map(float, made.agents[0].position))


def irsim(world):
    import irsim
    import yaml

    logging.disable(logging.CRITICAL)
    dt = world["dt"][0]
    x, y, goal_x, goal_y, radius, speed = world["robot"]
    dash = {"name": "dash"}

    def disc(x, y, radius, **more):
        return {"shape": {"name": "circle", "radius": radius}, "state": [x, y, 0], **more}

    robot = disc(x, y, radius, kinematics={"name": "diff"}, goal=[goal_x, goal_y, 0], vel_max=[speed, 1.0],
                 vel_min=[-speed, -1.0], behavior=dash)
    robot["state"] = [x, y, math.atan2(goal_y - y, goal_x - x)]
    movers = [
        disc(x0, y0, r, kinematics={"name": "omni"}, goal=[[x1, y1, 0], [x0, y0, 0]] * 6, vel_max=[v, v],
             vel_min=[-v, -v], behavior=dash)
        for x0, y0, x1, y1, r, v in world["moving"]
    ]
    width, height = world["size"]
    text = {
        "world": {"width": width, "height": height, "step_time": dt, "sample_time": dt,
                  "collision_mode": "unobstructed_obstacles", "control_mode": "auto"},
        "robot": [robot],
        "obstacle": movers + [disc(*values) for values in world["static"]],
    }
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", delete=False) as file:
        yaml.safe_dump(text, file)

    def drive(made):
        for _ in range(STEPS):
            made.step()

    def where(made):
        return made.robot.state.flatten().tolist()[:2]

    return lambda: irsim.make(file.name, headless=True, log_level="CRITICAL"), drive, where


def main():
    tool, file, core = sys.argv[1:]
    scenes.pin(int(core))
    world = scenes.read_world(file)
    build, drive, where = {"navground": navground, "irsim": irsim}[tool](world)
    ended = []

    def once(made):
        drive(made)
        ended[:] = where(made)

    # A world is driven once: each repetition has its own, built outside the timed part.
    repetitions = 15 if tool == "navground" else 1
    worlds = [build() for _ in range(repetitions + 1)]
    time_s = scenes.seconds(lambda: once(worlds.pop()), repetitions)
    begin = world["robot"][:2]
    assert math.dist(begin, ended) > 1.0, f"the robot has not driven: it is at {ended}"
    scenes.report(us=1e6 * time_s / STEPS)


main()
