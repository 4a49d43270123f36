"""Small files in every format that can be read.

They come from our own writer if there is one, and from other programs' output.
"""

import functools
import importlib.util
import io
from dataclasses import replace

import numpy as np
from PIL import Image

from tests.helpers.buildings import building_file
from worldgen.errors import InvalidWorld
from worldgen.files.grid import dumps
from worldgen.generation import generate
from worldgen.interop import FORMATS, export_world
from worldgen.world import Pose, Target, World

# COLLADA and DXF need extras, ``worldgen[collada,dxf]``. Bags need another, and have tests of
# their own: tests/worldgen/test_bags.py.
LACKING = {
    name
    for name, package in (("dae", "collada"), ("dxf", "ezdxf"))
    if importlib.util.find_spec(package) is None
}
READABLE = [
    name for name in FORMATS if FORMATS.get(name).read is not None and name not in {"bag", *LACKING}
]
_WALLS = np.ones((5, 7), np.bool_)
_WALLS[1:-1, 1:-1] = _WALLS[0, 0] = False
_YAML = (
    b"image: %b\nresolution: 0.25\norigin: [-1.5, 2.25, 0.0]\nnegate: 0\noccupied_thresh: "
    b"0.65\nfree_thresh: 0.196\n"
)


def _npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def picture(image, kind="PNG", **options):
    """A picture's bytes."""
    stream = io.BytesIO()
    image.save(stream, kind, **options)
    return stream.getvalue()


_GREY = np.where(_WALLS, 0, 254).astype(np.uint8)
_ROWS = b"\n".join(b" ".join(b"%d" % value for value in row) for row in _GREY)
_PLAIN = b"P2\n# made by hand\n7 5 # sides\n255\n" + _ROWS + b"\n"
# A room of 4 x 3 m with a wall that leaves a door, in the oldest form of DXF.
_LINES = ("0 0 4 0", "4 0 4 3", "4 3 0 3", "0 3 0 0", "2 0 2 2")
DXF = "  0\nSECTION\n  2\nENTITIES\n{}  0\nENDSEC\n  0\nEOF\n".format(
    "".join(
        "  0\nLINE\n  8\nWALLS\n 10\n{}\n 20\n{}\n 11\n{}\n 21\n{}\n".format(*line.split())
        for line in _LINES
    )
).encode()
# The same room, a pixel to 5 cm, with a door in the wall.
BUILDING = b"""coordinate_system: reference_image
levels:
  L1:
    elevation: 0
    lanes:
      - [4, 5, {graph_idx: [2, 0]}]
    measurements:
      - [0, 1, {distance: [3, 4]}]
    vertices:
      - [0, 0, 0, a]
      - [80, 0, 0, ""]
      - [80, 60, 0, ""]
      - [0, 60, 0, ""]
      - [40, 60, 0, ""]
      - [40, 20, 0, ""]
      - [40, 0, 0, "", {is_charger: [4, true]}]
    doors:
      - [5, 6, {name: [1, d], type: [1, hinged]}]
    walls:
      - [0, 1, {texture_name: [1, default]}]
      - [1, 2, {}]
      - [2, 3]
      - [3, 0, {}]
      - [4, 5, {}]
"""
# An arena of 2 x 1 m inside its walls, with a wall that leaves a passage.
WEBOTS = b"""#VRML_SIM R2023b utf8
EXTERNPROTO "webots://projects/objects/floors/protos/RectangleArena.proto"
WorldInfo { title "a # room" basicTimeStep 16 }
Viewpoint { position 0 0 5 }
RectangleArena { floorSize 2 1 wallThickness 0.1 wallHeight 0.3 }
DEF WALL Solid {
  translation 0 -0.2 0.1
  children [ DEF LOOK Shape { appearance PBRAppearance { roughness 1 } geometry Box { size 0.1, 0.6, 0.2 } } ]
  boundingObject USE LOOK
}
"""
# Each sample is contents by file name, the map first. Readers without a writer need one here.
AS_OTHERS_WRITE = {
    "movingai": [
        {"m.map": b"type octile\r\nheight 3\r\nwidth 5\r\nmap\r\n@@TWO\r\n..S.T\r\n...G@\r\n"}
    ],
    "npy": [{"a.npy": _npy(_WALLS)}, {"b.npy": _npy(np.asfortranarray(_WALLS.astype(np.int64)))}],
    "ros": [
        {"p.yaml": _YAML % b"p.pgm", "p.pgm": _PLAIN},
        {"i.yaml": _YAML % b"i.png", "i.png": picture(Image.fromarray(_GREY).convert("P"))},
    ],
    **{kind: [{f"b.{kind}": building_file(kind)}] for kind in ("dae", "glb", "gltf", "obj", "stl")},
    "dxf": [{"plan.dxf": DXF}],
    "building": [{"room.building.yaml": BUILDING}],
    "webots": [{"room.wbt": WEBOTS}],
    "text": [{"t.txt": b"#####\r\n#S..#\r\n#..G#\r\n#####\r\n"}],
}


def _room():
    """A closed room that is not a square, so that swapped sides are noticed."""
    walls = np.ones((6, 7), np.bool_)
    walls[1:-1, 1:-1] = walls[3, 3] = False
    walls[2, 3] = True
    return World(walls, Pose(0.15, 0.15), Target(0.55, 0.45, 0.05), robot_radius=0.04)


def _square():
    walls = np.ones((10, 10), np.bool_)
    walls[1:-1, 1:-1] = False
    return World(walls, Pose(0.35, 0.65), Target(0.55, 0.45, 0.05), robot_radius=0.04)


@functools.cache
def samples(name):
    """Sample files of a format: dicts of contents by file name, the map first."""
    found = list(AS_OTHERS_WRITE.get(name, ()))
    if name == "grid":
        found += [
            {"world.grid": dumps(world)} for world in (_room(), generate("shift", 1, size=16))
        ]
    mazes = [
        replace(generate("maze", 1, size=13, robot_radius=radius), certificate=None)
        for radius in (0.07, 0.04)
    ]  # the second has corridors of one cell
    for world in (_room(), _square(), *mazes):
        try:
            found += [dict(export_world(world, name).files)] if FORMATS.get(name).write else []
        except InvalidWorld:  # the thesis's maps are squares, a micromouse's maze has posts
            continue
    return found
