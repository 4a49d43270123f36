"""Gazebo's own reader of SDFormat, ``ign sdf`` of Fortress, checks the output of ``export --to
sdf``.
"""

import subprocess
from xml.etree import ElementTree

import pytest

from tests.clients.environments import program
from tests.helpers.drawn_worlds import drawn
from worldgen.interop import export_world
from worldgen.timeline import CellState, Timeline

TINY = """
    #####
    #.#G#
    #...#
    #S..#
    ####."""


def ign(flag, path):
    done = subprocess.run(
        [program("ign"), "sdf", flag, path], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def path(tmp_path):
    """The file of a world that changes, with a robot in it."""
    line = Timeline.of(
        [
            (2.5, 2, 3, CellState.BURNING),
            (4.0, 2, 3, CellState.FREE),
            (0.125, 3, 1, CellState.SOLID),
        ]
    )
    export = export_world(
        drawn(TINY, timeline=line),
        "sdf+robot+plugins=fortress",
        file="world.sdf",
        origin=(-1.05, 2.0),
    )
    (tmp_path / "world.sdf").write_bytes(export.data)
    return tmp_path / "world.sdf"


def test_the_file_is_valid(path):
    assert "Valid." in ign("-k", path)


def said(root):
    """All poses, sizes, radii, masses and names of models, links, collisions, frames and joints, in
    order.
    """
    words = [(element.tag, element.get("name")) for element in root.iter() if element.get("name")]
    numbers = {
        "pose",
        "size",
        "radius",
        "length",
        "mass",
        "static",
        "max_step_size",
        "gravity",
        "ixx",
        "iyy",
        "izz",
    }
    values = [
        (element.tag, [float({"true": "1"}.get(word, word)) for word in element.text.split()])
        for element in root.iter()
        if element.tag in numbers
    ]
    return words, values


def test_everything_written_is_understood_number_by_number(path):
    written, understood = (
        said(ElementTree.parse(path)),
        said(ElementTree.fromstring(ign("-p", path))),
    )
    assert [name for name in written[0] if name not in understood[0]] == []
    assert [value for value in written[1] if value not in understood[1]] == []
    tags = {tag for tag, _ in understood[1]}
    assert {"pose", "size", "radius", "static"} <= tags
