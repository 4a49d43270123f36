"""Print how POGEMA reads a map file:

its obstacles, agent and target, and where each move of a list leads.
"""

import json
import sys
from pathlib import Path

from pogema import GridConfig, pogema_v0

RADIUS = 2  # cells of padding that POGEMA puts around a map for the agent's view

config = GridConfig(map=Path(sys.argv[1]).read_text(), obs_radius=RADIUS, max_episode_steps=100_000)
env = pogema_v0(grid_config=config)
env.reset()
grid = env.unwrapped.grid
names = {(-1, 0): "up", (1, 0): "down", (0, -1): "left", (0, 1): "right"}
moves = {
    names[tuple(move)]: number for number, move in enumerate(config.MOVES) if tuple(move) in names
}
trail, arrived = [], False
for word in json.loads(sys.argv[2]):
    arrived = bool(env.step([moves[word]])[2][0])
    trail.append([value - RADIUS for value in grid.positions_xy[0]])
said = {
    "obstacles": grid.obstacles[RADIUS:-RADIUS, RADIUS:-RADIUS].astype(int).tolist(),
    "agents": config.agents_xy, "targets": config.targets_xy, "trail": trail, "arrived": arrived,
}  # fmt: skip
print(json.dumps(said))
