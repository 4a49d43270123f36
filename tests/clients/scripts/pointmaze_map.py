"""PointMaze on a maze map: places of start and goal, what rays hit, and where a push leads."""

import json
import sys
from pathlib import Path

import gymnasium as gym
import gymnasium_robotics
import mujoco
import numpy as np

gym.register_envs(gymnasium_robotics)
maze_map = json.loads(Path(sys.argv[1]).read_text())
env = gym.make("PointMaze_UMaze-v3", maze_map=maze_map, max_episode_steps=10_000)
maze, inner = env.unwrapped.maze, env.unwrapped.point_env
env.reset(seed=1)
inner.set_state(np.array(maze.unique_reset_locations[0]), np.zeros(2))
rays = []
for x, y, dx, dy in json.loads(sys.argv[2]):
    hit = np.zeros(1, np.int32)
    origin, direction = np.array([x, y, 0.3]), np.array([dx, dy, 0.0])  # above the ball
    rays.append(mujoco.mj_ray(inner.model, inner.data, origin, direction, None, 1, -1, hit))
pushed = []
for action in json.loads(sys.argv[3]):
    inner.set_state(np.array(maze.unique_reset_locations[0]), np.zeros(2))
    for _ in range(600):
        observation = env.step(np.array(action, np.float32))[0]
    pushed.append(observation["achieved_goal"].tolist())
said = {
    "start": np.array(maze.unique_reset_locations).tolist(), "goal": np.array(maze.unique_goal_locations).tolist(),
    "rays": rays, "pushed": pushed,
}  # fmt: skip
print(json.dumps(said))
