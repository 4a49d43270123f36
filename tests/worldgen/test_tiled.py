"""Tiled's maps: layers, packings, objects moved by hand, and what is refused."""

import base64
import gzip
import json
import math
import zlib

import numpy as np
import pytest

from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop import export_world, import_world, read_map, write_export
from worldgen.world import Pose, Target, World

ROOM = "#####\n#S.G#\n#..##\n#####"
NUMBERS = [int(letter == "#") for row in ROOM.split() for letter in row]
RAW = np.array(NUMBERS, "<u4").tobytes()


@pytest.fixture
def made(tmp_path):
    """The map of a room, changed by a function, written and read."""

    def change(function):
        path = write_export(export_world(drawn(ROOM, radius=0.04), "tiled"), tmp_path, force=True)[
            0
        ]
        parts = json.loads(path.read_text())
        function(parts)
        path.write_text(json.dumps(parts))
        return path

    return change


def test_the_map_has_the_layers_and_pixels_that_tiled_shows():
    parts = json.loads(export_world(drawn(ROOM), "tiled", file="r.tmj").data)
    walls, places = parts["layers"]
    assert (walls["data"], parts["width"], parts["height"]) == (NUMBERS, 5, 4)
    assert [(part["name"], part["x"], part["y"]) for part in places["objects"]] == [
        ("start", 24.0, 24.0), ("target", 56.0 - 0.8, 24.0 - 0.8),
    ]  # fmt: skip
    assert parts["tilesets"][0]["image"] == "r-tile.png"


@pytest.mark.parametrize(
    ("data", "compression"),
    [(RAW, ""), (zlib.compress(RAW), "zlib"), (gzip.compress(RAW), "gzip")],
    ids=["plain", "zlib", "gzip"],
)
def test_packed_tiles_are_the_same_cells(made, data, compression):
    packed = {
        "data": base64.b64encode(data).decode(),
        "encoding": "base64",
        "compression": compression,
    }
    found = read_map(made(lambda parts: parts["layers"][0].update(packed)))
    assert found.walls[::-1].ravel().tolist() == [bool(number) for number in NUMBERS]


def test_flipped_tiles_are_solid_and_flips_alone_are_not(made):
    flipped = [0xE0000001 if number else 0x80000000 for number in NUMBERS]
    found = read_map(made(lambda parts: parts["layers"][0].update(data=flipped)))
    assert found.walls[::-1].ravel().tolist() == [bool(number) for number in NUMBERS]


def test_an_object_moved_and_turned_by_hand_counts(made):
    def move(parts):
        parts["layers"][1]["objects"][0].update(x=40.0, y=40.0, rotation=90)
        parts["layers"][1]["objects"][1].update(width=16, height=16, x=48, y=16)

    found = read_map(made(move))
    assert found.robot.start == (0.25, pytest.approx(0.15), pytest.approx(-math.pi / 2))
    assert found.robot.target == (0.35, 0.25, 0.05)


def test_rounded_pixels_of_another_program_are_no_edit(made):
    def rounded(parts):
        for part in parts["layers"][1]["objects"]:
            part.update(x=round(part["x"], 4), y=round(part["y"], 4))

    world = drawn(ROOM, radius=0.04)
    again = import_world(made(rounded)).world
    assert (again.start, again.target) == (Pose(world.start.x, world.start.y), world.target)


def foreign(parts):
    """A map as a user might draw it: floors and walls in a group, a spawn point, no properties."""
    walls, places = parts["layers"]
    floor = {**walls, "name": "Floor", "data": [7] * len(NUMBERS)}
    places["objects"] = [
        {"name": "", "type": "Spawn", "x": 24, "y": 24},
        {"name": "Goal", "x": 48, "y": 16, "width": 16},
    ]
    parts["layers"] = [
        {"type": "group", "name": "all", "layers": [floor, {**walls, "name": "Collision"}, places]}
    ]
    del parts["properties"]


def test_a_map_drawn_by_someone_else_is_read(made):
    found = read_map(made(foreign))
    assert found.walls.sum() == sum(NUMBERS) and found.cell_size == 0.1
    assert (found.robot.start, found.robot.radius) == ((0.15, 0.25, 0.0), None)
    assert (
        read_map(made(foreign), "tiled+layer=Floor").warnings[0].startswith("every cell has a tile")
    )
    assert read_map(made(foreign), options={"cell_size": 0.5}).cell_size == 0.5


def packed(data, compression="zlib"):
    return lambda parts: parts["layers"][0].update(
        data=base64.b64encode(data).decode(), encoding="base64", compression=compression
    )


BAD = [
    (
        lambda parts: parts.update(infinite=True) or parts["layers"][0].update(chunks=[]),
        {"code": "endless-map"},
    ),
    (lambda parts: parts.update(orientation="isometric"), {"code": "unsupported"}),
    (lambda parts: parts.update(tileheight=8), {"code": "not-square", "width": 16, "height": 8}),
    (
        lambda parts: parts.update(width="5"),
        {"code": "not-a-number", "key": "width", "value": '"5"'},
    ),
    (
        lambda parts: parts.update(width=10**6, height=10**6),
        {"code": "wrong-size", "width": 1000000, "height": 1000000},
    ),
    (lambda parts: parts.update(layers=[1]), {"code": "too-many-layers"}),
    (lambda parts: parts.pop("layers"), {"code": "unknown-format"}),
    (
        lambda parts: parts["layers"][0].update(data=[1]),
        {"code": "wrong-length", "name": "layer 'walls'", "cells": 1, "width": 5},
    ),
    (
        lambda parts: parts["layers"][0].update(data=[-1] * 20),
        {"code": "wrong-type", "name": "layer 'walls'"},
    ),
    (
        lambda parts: parts["layers"][0].update(data=[2.5] * 20),
        {"code": "wrong-type", "name": "layer 'walls'"},
    ),
    (
        lambda parts: parts["layers"][0].update(data=[[1]] * 20),
        {"code": "wrong-type", "name": "layer 'walls'"},
    ),
    (
        lambda parts: parts["layers"][0].update(width=4),
        {"code": "wrong-size", "name": "layer 'walls'", "layer_width": 4, "layer_height": 4},
    ),
    (
        lambda parts: (
            parts["layers"].append({**parts["layers"][0], "name": "b"})
            or parts["layers"][0].update(name="a")
        ),
        {"code": "ambiguous-layer"},
    ),
    (
        packed(zlib.compress(bytes(10**7))),
        {"code": "damaged-file", "name": "layer 'walls'", "size": 80},
    ),
    (
        packed(zlib.compress(RAW)[:-8]),
        {"code": "damaged-file", "name": "layer 'walls'", "size": 80},
    ),
    (packed(b"no zlib"), {"code": "damaged-file", "name": "layer 'walls'"}),
    (packed(RAW, "lzma"), {"code": "unsupported", "name": "layer 'walls'", "compression": "lzma"}),
    (
        lambda parts: parts["layers"][0].update(data="???"),
        {"code": "damaged-file", "name": "layer 'walls'"},
    ),
]


@pytest.mark.parametrize(("function", "expected"), BAD, ids=range(len(BAD)))
def test_a_map_that_is_no_world_is_refused(made, function, expected):
    with raises(FormatError, **expected):
        read_map(made(function), "tiled")


def test_a_large_map_is_packed_and_comes_back(tmp_path):
    walls = np.zeros((1001, 1000), np.bool_)
    walls[::7, ::3] = True
    world = World(walls, Pose(0.15, 0.15), Target(0.25, 0.15, 0.05))
    path = write_export(export_world(world, "tiled"), tmp_path)[0]
    assert path.stat().st_size < 100_000
    assert np.array_equal(read_map(path).walls, walls)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (b"", "not-json"),
        (b"[" * 100_000, "wrong-form"),
        (b'{"layers": \xff}', "not-utf8"),
        (b'{"width": ' + b"9" * 10_000 + b"}", "wrong-form"),
    ],
)
def test_what_tiled_would_not_write_is_refused(tmp_path, text, code):
    (tmp_path / "m.tmj").write_bytes(text)
    with raises(FormatError, code):
        read_map(tmp_path / "m.tmj")


def tmx(body, attributes='width="4" height="3"'):
    return (
        f'<?xml version="1.0"?><map orientation="orthogonal" tilewidth="16" tileheight="16" '
        f"{attributes}>{body}</map>"
    )


def grid(name, rows, attributes=""):
    csv = ",".join(number for row in rows.split() for number in row.split(","))
    return (
        f'<layer name="{name}" width="4" height="3" {attributes}>'
        f'<data encoding="csv">{csv}</data></layer>'
    )


def objects(name, body, attributes=""):
    return f'<objectgroup name="{name}" {attributes}>{body}</objectgroup>'


# A set whose first tile collides in its upper left quarter, its second as a whole, its third never.
SET = (
    '<tileset firstgid="1" tilewidth="16" tileheight="16"><tile id="0"><objectgroup><object x="1" '
    'y="1" width="6" height="6"/></objectgroup></tile><tile id="1"><properties><property '
    'name="solid" type="bool" value="true"/></properties></tile><tile id="2"/></tileset>'
)
NONE = "0,0,0,0 0,0,0,0 0,0,0,0"
NO_TILES = grid("Walls", NONE)


def shape(x, y, width=0, height=0, inner="", more=""):
    sides = f'width="{width}" height="{height}"' if width else ""
    return f'<object x="{x}" y="{y}" {sides} {more}>{inner}</object>'


def wall(*given, **more):
    return NO_TILES + objects("collision", shape(*given, **more))


H, V, D = 1 << 31, 1 << 30, 1 << 29
SHIFTED = grid("a", "1,1,0,0 0,0,0,0 0,0,0,0", 'offsetx="8"')
TWO = grid("Walls", "1,0,0,0 0,0,0,0 0,0,0,0") + grid(
    "a", "0,0,0,0 0,0,0,0 0,0,5,0", 'class="collision"'
)
COLLIDES = '<properties><property name="collides" type="bool" value="true"/></properties>'
TILES = shape(16, 32, 32, 32, more='gid="1"') + shape(
    16, 48, 16, 16, more=f'gid="{2 | H}" rotation="-90"'
)
POLYGON = '<polygon points="0,0 30,0 0,30"/>'
# Each map's body, the cells to a tile, and the solid cells from the top.
DRAWN = {
    "tmx": (grid("walls", "1,0,0,1 0,0,0,0 0,0,0,2"), 1, "#..# .... ...#"),
    "two layers": (TWO, 1, "#... .... ..#."),
    "group and offset": (
        f'<group offsetx="16"><group name="solid" offsety="16">{SHIFTED}</group></group>',
        1,
        ".... .### ....",
    ),
    "rectangle": (wall(16, 16, 32, 16), 1, ".... .##. ...."),
    "turned": (wall(48, 16, 32, 16, more='rotation="90"'), 1, ".... ..#. ..#."),
    "ellipse": (wall(16, 0, 32, 32, "<ellipse/>"), 2, "..####.. " * 4 + "........ " * 2),
    "polygon": (
        wall(16, 16, inner=POLYGON),
        2,
        "........ ........ ..####.. ..###... ..##.... ..#.....",
    ),
    "by property": (
        objects("a", shape(0, 0, 16, 16, COLLIDES) + shape(20, 20) + shape(0, 0, inner="<point/>")),
        1,
        "#... .... ....",
    ),
    "tiles that collide": (
        SET + grid("deco", "1,2,3,0 0,0,0,0 0,0,0,0"),
        2,
        "#.##.... ..##.... " + "........ " * 4,
    ),
    "flips": (
        SET + grid("deco", f"{1 | H},{1 | V},{1 | D},{1 | H | V} 0,0,0,0 0,0,0,0"),
        2,
        ".#..#... ..#....# " + "........ " * 4,
    ),
    "tile objects": (SET + objects("deco", TILES), 1, ".#.. .... #..."),
}


@pytest.mark.parametrize("name", DRAWN)
def test_walls_are_read_as_people_draw_them(tmp_path, name):
    body, detail, rows = DRAWN[name]
    (tmp_path / "m.tmx").write_text(tmx(body))
    found = read_map(tmp_path / "m.tmx", f"tiled+detail={detail}")
    assert [
        "".join(".#"[int(cell)] for cell in row) for row in found.walls[::-1]
    ] == rows.split() and found.unread == ()
    assert found.cell_size == pytest.approx(0.1 / detail)


def test_layers_are_walls_or_free_as_the_user_says(tmp_path):
    body = grid("a", "1,1,1,1 0,0,0,0 0,0,0,0") + grid("b", "0,1,0,0 0,0,0,0 0,0,0,1")
    (tmp_path / "m.tmx").write_text(tmx(body))
    with raises(FormatError, "ambiguous-layer", known=["'a'", "'b'"]):
        read_map(tmp_path / "m.tmx")
    found = read_map(tmp_path / "m.tmx", None, {"layer": "a"})
    assert found.walls.sum() == 4 and found.unread == () and "'b'" in " ".join(found.notes)
    assert read_map(tmp_path / "m.tmx", None, {"layer": "*"}).walls.sum() == 5
    door = read_map(tmp_path / "m.tmx", None, {"layer": "a", "free": "B"})
    assert door.walls[2].tolist() == [True, False, True, True]


def test_an_infinite_map_is_as_large_as_its_tiles(tmp_path):
    chunks = "".join(
        f'<chunk x="{x}" y="{y}" width="2" height="2">{numbers}</chunk>'
        for x, y, numbers in ((-16, -8, "0,0,0,1"), (-14, -8, "0,0,1,1"), (-16, -6, "0,2,0,0"))
    )
    layer = f'<layer name="walls" width="2" height="2"><data encoding="csv">{chunks}</data></layer>'
    robot = objects("o", '<object name="start" x="-200" y="-104"><point/></object>')
    (tmp_path / "m.tmx").write_text(tmx(layer + robot, 'width="9" height="9" infinite="1"'))
    found = read_map(tmp_path / "m.tmx")
    assert found.walls.tolist() == [[True, False, False], [True, True, True]]
    assert found.robot.start == pytest.approx((0.25, 0.1, 0.0), abs=0.051)


def test_a_set_of_tiles_beside_the_map_counts(tmp_path):
    named = '<tileset firstgid="1" source="t.tsx"/>'
    body = (
        named + grid("walls", "0,0,0,0 0,0,0,0 0,0,0,0") + grid("Ground", "1,2,3,3 3,3,3,3 3,3,3,3")
    )
    (tmp_path / "m.tmx").write_text(tmx(body))
    assert read_map(tmp_path / "m.tmx").unread == ("1 layer of tiles besides 'walls'",)
    (tmp_path / "t.tsx").write_text(SET.replace(' firstgid="1"', ""))
    found = read_map(tmp_path / "m.tmx")
    assert found.unread == () and found.walls.sum() == 2
