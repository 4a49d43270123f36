"""Writing drawings and arrays; reading them is tested with the command."""

import io
from dataclasses import replace

import numpy as np

from tests.helpers.drawn_worlds import drawn
from worldgen.interop import export_world, read_map, write_export
from worldgen.world import Pose, Target

ROOM = "#####\n#S.G#\n#..##\n#####\n"


def test_a_drawing_is_what_a_person_would_draw():
    export = export_world(drawn(ROOM, target_radius=0.05), "text")
    assert export.data.decode() == ROOM
    assert export.lost == ()


def test_a_drawing_says_what_it_has_moved():
    world = replace(drawn(ROOM), start=Pose(0.36, 0.25, 1.0))
    export = export_world(world, "text")
    assert export.data.decode() == ROOM.replace("S", ".").replace("G", "S")
    assert export.lost == (
        "the start is stored as the centre of the cell in column 3, row 1 from the top",
        "the target is not drawn, because its cell is the start's",
        "the heading, 1 rad, is not drawn",
        "the target's radius, 0.005 m, is drawn as half a cell",
    )


def test_the_radius_of_a_target_that_is_not_drawn_comes_back(tmp_path):
    world = replace(drawn(ROOM, target_radius=0.05), target=Target(0.16, 0.25, 0.05))
    found = read_map(write_export(export_world(world, "text"), tmp_path)[0])
    assert found.robot.target == (0.16, 0.25, 0.05)


def test_an_open_world_is_told_by_its_walls_farther_down(tmp_path):
    path = write_export(export_world(drawn("...\nS#G\n..."), "text", file="no-ending"), tmp_path)[0]
    assert read_map(path).params["format"] == "text"


def test_an_array_is_what_numpy_loads():
    cells = np.load(io.BytesIO(export_world(drawn(ROOM), "npy").data))
    assert cells.dtype == np.bool_ and cells.flags.c_contiguous
    assert cells.astype(int).tolist() == [
        [int(letter == "#") for letter in row] for row in ROOM.split()
    ]
