"""MiniGrid checks both directions.

Its own printed grids are read, and it prints ours as we write them.
"""

import json

import numpy as np

from tests.clients.environments import client
from worldgen import generate
from worldgen.interop import export_world, read_map
from worldgen.interop.formats.text import cell_of

HEADINGS = (
    0.0,
    -np.pi / 2,
    np.pi,
    np.pi / 2,
)  # its directions are right, down, left, up; its y axis points down
SOLID = {"wall", "lava", "key", "ball", "box"}


def test_minigrids_own_grids_are_read_and_ours_are_what_it_prints(tmp_path):
    world = generate("maze", 4, size=13)
    walls = world.walls[::-1]
    ours = {
        "width": world.width, "height": world.height, "walls": np.argwhere(walls)[:, ::-1].tolist(),
        "agent": cell_of(world, world.start.x, world.start.y), "goal": cell_of(world, world.target.x, world.target.y),
        "direction": int(np.argmin([abs(world.start.heading - heading) for heading in HEADINGS])),
    }  # fmt: skip
    (tmp_path / "ours.json").write_text(json.dumps(ours))
    said = client("minigrid").ask("minigrid_grids.py", tmp_path / "ours.json")
    assert export_world(world, "minigrid").data.decode().rstrip("\n") == said["ours"]
    for number, their in enumerate(said["theirs"]):
        path = tmp_path / f"{number}.txt"
        path.write_text(their["text"])
        found = read_map(path)
        solid = [[kind in SOLID for kind in row] for row in their["kinds"]]
        assert found.params["format"] == "minigrid" and found.walls[::-1].tolist() == solid
        x, y = (0.1 * (cell + 0.5) for cell in their["agent"])
        assert np.allclose(
            found.robot.start, (x, 0.1 * len(solid) - y, HEADINGS[their["direction"]])
        )
