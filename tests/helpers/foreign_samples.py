"""Small files of every format that is read, by its own writer where there is one, to be damaged by tests."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.generation import generate
from worldgen.grid_file import dumps
from worldgen.interop import FORMATS, export_world
from worldgen.world import Pose, Target, World

READABLE = [name for name in FORMATS if FORMATS.get(name).read is not None]
BY_HAND = Path(__file__).parents[1] / "data" / "foreign"
"""A folder for each format that has no writer, and for files as other programs write them; in it a folder a sample,
whose first file by name is the map."""


def _room():
    """A closed room that is no square, so that exchanged sides are noticed."""
    walls = np.ones((6, 7), np.bool_)
    walls[1:-1, 1:-1] = walls[3, 3] = False
    walls[2, 3] = True
    return World(walls, Pose(0.15, 0.15), Target(0.55, 0.45, 0.05), robot_radius=0.04)


def _square():
    walls = np.ones((10, 10), np.bool_)
    walls[1:-1, 1:-1] = False
    return World(walls, Pose(0.35, 0.65), Target(0.55, 0.45, 0.05), robot_radius=0.04)


def samples(name):
    """What a format's files look like: dicts of contents by file name, the map first."""
    if name == "grid":
        return [{"world.grid": dumps(world)} for world in (_room(), generate("shift", 1, size=16))]
    found = []
    for world in (_room(), _square(), replace(generate("maze", 1, size=13), certificate=None)):
        try:
            files = export_world(world, name).files if FORMATS.get(name).write else {}
        except InvalidWorld:  # the thesis's maps are squares, a micromouse's maze has posts
            continue
        found += [dict(files)] if files else []
    for folder in sorted((BY_HAND / name).glob("*/")):
        found.append({file.name: file.read_bytes() for file in sorted(folder.iterdir())})
    return found
