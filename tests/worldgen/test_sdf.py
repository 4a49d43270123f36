"""Writing SDFormat; Gazebo and PyBullet themselves are tested in tests/clients."""

import ast
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.interop import export_world, import_world, write_export
from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Target, World

GOLDEN = Path(__file__).parent / "golden"
TINY = """
    #####
    #.#G#
    #...#
    #S..#
    ####."""
NAMES = {
    'a"b<c>&d': "a_b_c_d",
    "world": "worldgen_world",
    "__world__": "worldgen_world",
    "ä\x01\udcff": "worldgen",
    "]]>": "worldgen",
    "7": "worldgen_7",
    "-->x": "worldgen_--_x",
    "a b/../c": "c",
    "office-2": "office-2",
}


def tiny():
    """Walls that merge, a cell that burns, one that falls; an open corner."""
    events = [
        (2.5, 2, 3, CellState.BURNING),
        (4.0, 2, 3, CellState.FREE),
        (0.125, 3, 1, CellState.SOLID),
    ]
    return drawn(TINY, timeline=Timeline.of(events))


def test_a_tiny_world_is_these_bytes():
    to = "sdf+robot+height=0.4+plugins=harmonic"
    files = export_world(tiny(), to, file="tiny.sdf", origin=(-1.05, 2.0)).files
    assert list(files) == ["tiny.sdf", "tiny_player.py", "tiny_events.json"]
    assert files["tiny.sdf"].decode() == (GOLDEN / "tiny.sdf").read_text()
    assert '"world": "tiny",' in files["tiny_events.json"].decode()


def test_boxes_have_full_sizes_about_their_middles_exactly():
    world = replace(drawn(TINY, cell_size=0.05), start=Pose(0.075, 0.07500000000000001))
    root = ElementTree.fromstring(export_world(world, "sdf+height=0.7", origin=(1e-3, -7.0)).data)
    covered = []
    for shape in root.iterfind(".//model[@name='walls']/link/collision"):
        pose, size = (
            list(map(Fraction, shape.find(tag).text.split()))
            for tag in ("pose", "geometry/box/size")
        )
        assert size[2] == Fraction("0.7") and pose[2:] == [Fraction("0.35"), 0, 0, 0]
        middle = [pose[0] - Fraction("0.001"), pose[1] + 7]
        ends = [
            [(place + sign * side / 2) * 20 for sign in (-1, 1)]
            for place, side in zip(middle, size, strict=False)
        ]
        assert all(end.denominator == 1 for axis in ends for end in axis)
        covered += [
            (ix, iy) for ix in range(*map(int, ends[0])) for iy in range(*map(int, ends[1]))
        ]
    padded = np.pad(world.walls, 1, constant_values=True)
    assert sorted(covered) == [(ix - 1, iy - 1) for ix, iy in np.argwhere(padded.T).tolist()]
    assert (
        root.find(".//model[@name='start']/pose").text == "0.076 -6.92499999999999999 0.0005 0 0 0"
    )


@pytest.mark.parametrize("options", ["", "+robot+plugins=fortress", "+height=3"])
def test_what_went_to_gazebo_comes_back_whole(tmp_path, options):
    start, target = Pose(0.1625, 0.15, 0.7), Target(0.35, 0.35, 0.03)
    world = replace(drawn(TINY, radius=0.04, robot_speed=1.5), start=start, target=target)
    path = write_export(
        export_world(world, f"sdf{options}", file="w.sdf", origin=(-1.05, 2.0)), tmp_path
    )[0]
    back = import_world(path).world
    assert np.array_equal(back.walls, world.walls) and (back.start, back.target) == (start, target)
    assert (back.cell_size, back.robot_radius, back.robot_speed) == (0.1, 0.04, 1.5)
    assert back.provenance.params["origin"] == [-1.05, 2.0]


@pytest.mark.parametrize("name", NAMES)
def test_names_of_files_become_names_that_gazebo_takes(name):
    root = ElementTree.fromstring(export_world(tiny(), "sdf", file=f"{name}.sdf").data)
    assert root.find("world").get("name") == NAMES[name]


@pytest.mark.parametrize(("plugins", "systems"), [("none", 0), ("fortress", 3), ("harmonic", 3)])
def test_systems_are_those_of_the_release(plugins, systems):
    root = ElementTree.fromstring(export_world(tiny(), f"sdf+plugins={plugins}").data)
    files = [plugin.get("filename") for plugin in root.iter("plugin")]
    prefix = {"fortress": "ignition-gazebo-", "harmonic": "gz-sim-"}.get(plugins, "none")
    assert len(files) == systems and all(
        re.fullmatch(rf"{prefix}[a-z-]+-system", file) for file in files
    )


def test_many_boxes_are_worth_a_word():
    walls = np.indices((65, 65)).sum(axis=0) % 2 == 0
    walls[:2] = False
    export = export_world(World(walls, Pose(0.1, 0.1), Target(6.3, 0.1, 0.1)), "sdf")
    assert [note for note in export.notes if "boxes: Gazebo falls behind real time" in note]


def test_the_player_is_python_of_the_standard_library_alone():
    tree = ast.parse(export_world(tiny(), "sdf", file="w.sdf").files["w_player.py"])
    modules = {
        node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
    }
    assert modules <= {
        "__future__",
        "itertools",
        "json",
        "pathlib",
        "re",
        "shutil",
        "subprocess",
        "sys",
        "time",
        "typing",
    }


@pytest.mark.parametrize("option", ["height=0", "height=1e300", "timestep=-1", "timestep=1e300"])
def test_sizes_that_cannot_be_are_refused(option):
    with raises(InvalidParameter, "out-of-range", low=1e-06):
        export_world(tiny(), f"sdf+{option}")
