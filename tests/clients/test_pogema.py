"""POGEMA checks the output of ``export --to pogema``, and pogema-toolbox ``--to movingai``."""

import json
from collections import deque

import numpy as np

from tests.clients.environments import client
from worldgen import generate
from worldgen.interop import export_world, write_export
from worldgen.interop.formats.text import cell_of

STEPS = {"up": (-1, 0), "down": (1, 0), "left": (0, -1), "right": (0, 1)}


def shortest(walls, start, goal):
    """Moves between free cells from (row, column) to another, the top row first, and the cells they
    lead to.
    """
    came, waiting = {start: None}, deque([start])
    while waiting:
        cell = waiting.popleft()
        for word, (down, right) in STEPS.items():
            beside = (cell[0] + down, cell[1] + right)
            if not walls[beside] and beside not in came:
                came[beside] = (word, cell)
                waiting.append(beside)
    way = [goal]
    while came[way[-1]]:
        way.append(came[way[-1]][1])
    return [came[cell][0] for cell in way[-2::-1]], [list(cell) for cell in way[-2::-1]]


def test_its_obstacles_are_our_walls_and_its_agent_walks_our_way_to_the_target(tmp_path):
    world = generate(
        "maze", 4, size=21, robot_radius=0.04
    )  # corridors of one cell: the start is at a wall
    start, target = (
        cell_of(world, place.x, place.y)[::-1] for place in (world.start, world.target)
    )
    walls = world.walls[::-1]
    moves, cells = shortest(walls, start, target)
    into = next(
        word for word, (down, right) in STEPS.items() if walls[start[0] + down, start[1] + right]
    )
    path = write_export(export_world(world, "pogema"), tmp_path)[0]
    said = client("pogema").ask("pogema_map.py", path, json.dumps([into, *moves]))
    assert said["obstacles"] == walls.astype(int).tolist()
    assert (said["agents"], said["targets"]) == ([list(start)], [list(target)])
    assert said["trail"] == [list(start), *cells]
    assert said["arrived"]


def test_the_toolbox_reads_the_same_cells_from_a_movingai_map(tmp_path):
    world = generate("cave", 4, size=31)
    path = write_export(export_world(world, "movingai"), tmp_path)[0]
    rows = client("pogema-toolbox").ask("pogema_toolbox_map.py", path)[str(path)]
    assert np.array_equal([[letter == "#" for letter in row] for row in rows], world.walls[::-1])
