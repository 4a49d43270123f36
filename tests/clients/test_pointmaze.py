"""Gymnasium-Robotics' PointMaze checks the output of ``export --to pointmaze``, its geometry by
MuJoCo's rays.
"""

import json

import pytest

from tests.clients.environments import client
from tests.helpers.drawn_worlds import drawn
from worldgen.interop import export_world, write_export

ROOM = """
########
#S..#..#
#.#.#.G#
#......#
########
"""
BALL = 0.1  # m, its radius
WAYS = [(1, 0), (-1, 0), (0, 1), (0, -1)]


def free_way(world, x, y, dx, dy):
    """Distance, in cells, from a cell's centre to the first wall, straight on."""
    distance = 0.5
    while not world.walls[y + dy, x + dx]:
        x, y, distance = x + dx, y + dy, distance + 1
    return distance


@pytest.mark.parametrize("rows", [ROOM, "S.#..\n.##..\n....G"], ids=["closed", "open"])
def test_rays_meet_our_walls_and_a_pushed_ball_stops_at_them(tmp_path, rows):
    world = drawn(rows, radius=0.04)
    centre = [world.width / 2, world.height / 2]
    places = [[value / 0.1 - half for value, half in zip(point, centre, strict=True)] for point in (
        (world.start.x, world.start.y), (world.target.x, world.target.y))]  # fmt: skip
    path = write_export(export_world(world, "pointmaze"), tmp_path)[0]
    rays = [[*place, *way] for place in places for way in WAYS]
    said = client("pointmaze").ask("pointmaze_map.py", path, json.dumps(rays), json.dumps(WAYS))
    assert said["start"] == [pytest.approx(places[0])] and said["goal"] == [
        pytest.approx(places[1])
    ]
    closed = _closed(world)
    cells = [(int(x + centre[0]) + 1, int(y + centre[1]) + 1) for x, y in places]
    assert said["rays"] == pytest.approx(
        [free_way(closed, *cell, *way) for cell in cells for way in WAYS]
    )
    for way, end in zip(WAYS, said["pushed"], strict=True):
        gone = sum(
            (now - then) * along for now, then, along in zip(end, places[0], way, strict=True)
        )
        assert gone == pytest.approx(free_way(closed, *cells[0], *way) - BALL, abs=0.02)


def _closed(world):
    """The world with a ring of solid cells around it."""
    row = "#" * (world.width + 2)
    rows = ["".join(".#"[int(cell)] for cell in cells) for cells in world.walls[::-1]]
    inner = [f"#{cells}#" for cells in rows]
    text = "\n".join([row, *inner, row])
    free = [at for at, letter in enumerate(text) if letter == "."]
    letters = list(text)
    letters[free[0]], letters[free[1]] = "SG"
    return drawn("".join(letters), radius=0.04)
