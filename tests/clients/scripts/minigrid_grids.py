"""MiniGrid prints its own environments, and a grid built from a file's walls, agent and goal."""

import json
import sys
from pathlib import Path

import gymnasium as gym
import minigrid  # noqa: F401 - registers its environments
from minigrid.core.grid import Grid
from minigrid.core.world_object import Goal, Wall


def described(env):
    world = env.unwrapped
    kinds = [
        [getattr(world.grid.get(x, y), "type", None) for x in range(world.width)]
        for y in range(world.height)
    ]
    agent = [int(value) for value in world.agent_pos]
    return {
        "text": world.pprint_grid(),
        "kinds": kinds,
        "agent": agent,
        "direction": int(world.agent_dir),
    }


theirs = []
for name in ("MiniGrid-FourRooms-v0", "MiniGrid-DoorKey-8x8-v0", "MiniGrid-LavaCrossingS9N2-v0"):
    env = gym.make(name)
    env.reset(seed=3)
    theirs.append(described(env))
said = json.loads(Path(sys.argv[1]).read_text())
world = gym.make("MiniGrid-Empty-8x8-v0").unwrapped
world.reset(seed=1)
world.width, world.height = said["width"], said["height"]
world.grid = Grid(world.width, world.height)
for x, y in said["walls"]:
    world.grid.set(x, y, Wall())
world.grid.set(*said["goal"], Goal())
world.agent_pos, world.agent_dir = said["agent"], said["direction"]
print(json.dumps({"theirs": theirs, "ours": world.pprint_grid()}))
