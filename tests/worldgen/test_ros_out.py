"""Exports for ROS map_server, read by an independent loader."""

import numpy as np
import pytest

from tests.helpers.drawn_worlds import drawn
from tests.helpers.map_server import occupied_at, published, published_map
from tests.helpers.raising import raises
from worldgen.errors import FormatError, OutputError
from worldgen.generation import generate
from worldgen.interop import export_world, import_world, read_map, write_export

ROOM = """
#####
#S.G#
#..##
#####
"""
# The values that ROS gives to greys with 0.65 and 0.196.
GOLDEN = {0: 100, 89: 100, 90: -1, 205: -1, 206: 0, 254: 0, 255: 0}


def test_the_loader_of_these_tests_agrees_with_the_golden_table():
    rules = {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196, "mode": "trinary"}
    assert published(np.array(list(GOLDEN), float), **rules).tolist() == list(GOLDEN.values())
    assert published(np.array([205.0]), **{**rules, "free_thresh": 0.25}).tolist() == [0]


@pytest.mark.parametrize(
    "options", ["", "+image=png", "+mode=scale", "+mode=raw", "+negate", "+mode=scale+negate"]
)
def test_map_server_publishes_100_and_0_at_the_cells_places(tmp_path, options):
    world = generate("maze", 1, size=13)
    path = write_export(export_world(world, f"ros{options}", origin=(-1.5, 2.25)), tmp_path)[0]
    resolution, origin, data = published_map(path)
    assert (resolution, origin) == (0.1, [-1.5, 2.25, 0.0])
    assert np.array_equal(data, np.where(world.walls, 100, 0))
    assert occupied_at(path, -1.5 + world.start.x, 2.25 + world.start.y) == 0


def test_the_pair_has_the_greys_and_thresholds_that_every_loader_agrees_on():
    export = export_world(drawn(ROOM), "ros", file="office.yaml")
    assert export.files["office.pgm"] == b"P5\n5 4\n255\n" + b"".join(
        bytes(0 if letter == "#" else 254 for letter in row) for row in ROOM.split()
    )
    assert export.data.decode() == (
        "image: office.pgm\nmode: trinary\nresolution: 0.1\norigin: [0, 0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\nworldgen:\n  start: [0.15, 0.25, 0]\n"
        "  target: [0.35, 0.25, 0.005]\n  robot_radius: 0.07\n  robot_speed: 2\n"
    )
    assert export.lost == () and export.sidecar is None


def test_a_name_with_odd_characters_is_quoted(tmp_path):
    world = drawn(ROOM, radius=0.04)
    path = write_export(export_world(world, "ros", file='a: "b" # é.yaml'), tmp_path)[0]
    assert published_map(path)[2].shape == world.walls.shape
    assert import_world(path).world.start == world.start


BAD_PLACES = [
    ("worldgen: 3", 8, {"code": "wrong-type", "key": "worldgen"}),
    (
        "worldgen:\n  goal: [1, 2, 3]",
        9,
        {"code": "unknown-name", "name": "goal", "key": "worldgen"},
    ),
    (
        "worldgen:\n  start: [1, 2]",
        9,
        {"code": "wrong-count", "key": "start", "values": 2, "count": 3},
    ),
    ("worldgen:\n  start: [1, 2, north]", 9, {"code": "not-a-number", "word": "north"}),
    ("worldgen:\n  target: [1, 2, 0]", 9, {"code": "not-positive", "key": "target"}),
    ("worldgen:\n  robot_radius: 1e999", 9, {"code": "not-a-number", "word": "1e999"}),
]


@pytest.mark.parametrize(("text", "line", "expected"), BAD_PLACES, ids=range(len(BAD_PLACES)))
def test_a_place_that_cannot_be_is_named_with_its_line(tmp_path, text, line, expected):
    path = write_export(export_world(drawn(ROOM), "ros"), tmp_path)[0]
    path.write_text(path.read_text().partition("worldgen:")[0] + text)
    with raises(FormatError, **expected) as caught:
        read_map(path)
    assert caught.value.line == line


def test_a_failed_export_takes_back_what_it_wrote_and_nothing_of_another_program_s(
    tmp_path, monkeypatch
):
    export = export_world(drawn(ROOM), "ros")
    first, *others = (tmp_path / name for name in export.files)
    assert others

    def write_but_not_the_first(path, data, **options):
        if path == first:
            first.write_bytes(b"mine")
            raise OutputError("file-exists", "it is there")
        path.write_bytes(data)

    monkeypatch.setattr("worldgen.interop.exporting.write_bytes", write_but_not_the_first)
    with raises(OutputError, "file-exists"):
        write_export(export, tmp_path)
    assert first.read_bytes() == b"mine" and not any(path.exists() for path in others)
