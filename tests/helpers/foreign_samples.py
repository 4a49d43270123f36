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

# COLLADA needs an extra, ``worldgen[collada]``. Bags need another, and have tests of their own:
# tests/worldgen/test_bags.py.
LACKING = {"dae"} if importlib.util.find_spec("collada") is None else set()
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
