"""Print what IR-SIM's lidar measures at poses, and where straight drives end.

Arguments: the world's YAML file; JSON with ``poses``, a list of [x, y, heading], and ``drives``, of
{"pose": ..., "command": [v, w], "steps": n}.
"""

import json
import sys

import irsim
import numpy as np


def scan(env, pose):
    env.robot.set_state(np.array(pose, float).reshape(3, 1), init=True)
    env.reset()
    env.robot.sensor_step()
    return [float(value) for value in env.get_lidar_scan(0)["ranges"]]


def drive(env, pose, command, steps):
    env.robot.set_state(np.array(pose, float).reshape(3, 1), init=True)
    env.reset()
    for _ in range(steps):
        env.step(np.array(command, float).reshape(2, 1))
        if env.robot.collision or env.robot.arrive:
            break
    x, y = (float(value) for value in env.robot.state[:2, 0])
    return {
        "x": x,
        "y": y,
        "collision": bool(env.robot.collision),
        "arrive": bool(env.robot.arrive),
    }


env = irsim.make(sys.argv[1], display=False, save_ani=False, log_level="ERROR")
asked = json.loads(sys.argv[2])
robot = env.robot
print(
    json.dumps(
        {
            "ranges": [scan(env, pose) for pose in asked["poses"]],
            "drives": [
                drive(env, one["pose"], one["command"], one["steps"]) for one in asked["drives"]
            ],
            "radius": float(robot.radius),
            "goal": [float(value) for value in robot.goal[:2, 0]],
            "goal_threshold": float(robot.goal_threshold),
            "fastest": float(robot.vel_max[0, 0]),
            "robots": [
                {
                    "state": [float(value) for value in one.init_state[:3, 0]],
                    "goal": [float(value) for value in one.goal[:2, 0]],
                    "radius": float(one.radius),
                }
                for one in env.robot_list
            ],
        }
    )
)
