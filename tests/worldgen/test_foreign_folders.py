"""Folders of other people's maps.

``WORLDGEN_FOREIGN_MAPS=FOLDER python -m pytest -m nightly`` reads them all. docs/notes/census.md
lists which ones were read, and the results.
"""

import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image, UnidentifiedImageError

from tests.helpers.map_server import published
from worldgen.errors import WorldgenError
from worldgen.interop import read_map

FOLDER = os.environ.get("WORLDGEN_FOREIGN_MAPS")
pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(
        not FOLDER, reason="WORLDGEN_FOREIGN_MAPS names no folder; docs/notes/census.md says which"
    ),
]
_RULES = ("negate", "occupied_thresh", "free_thresh")


def ros_pairs():
    """Return YAML files that have a map's keys and whose picture exists."""
    files = sorted(Path(FOLDER or ".").rglob("*.y*ml")) if FOLDER else []
    for path in files:
        try:
            keys = yaml.safe_load(path.read_text())
        except (yaml.YAMLError, UnicodeDecodeError):
            continue
        if isinstance(keys, dict) and {"image", "resolution", "origin", *_RULES} <= keys.keys():
            picture = path.parent / str(keys["image"])
            if picture.is_file() and np.all(np.array(keys["origin"][2:]) == 0):
                yield path, keys, picture


def expected(keys, picture):
    """Solid cells, row 0 the lowest, as map_server publishes them.

    Unknown cells are solid.
    """
    with Image.open(picture) as image:
        colours = image.convert("RGBA")
    rgba, greys = np.asarray(colours), np.asarray(colours.convert("L")).astype(float)
    mode = str(keys.get("mode", "trinary")).lower()
    cells = published(greys, mode=mode, **{rule: keys[rule] for rule in _RULES})
    return ((cells != 0) | (rgba[..., 3] < 255))[::-1]


def test_ros_maps_have_the_cells_sizes_and_places_that_map_server_publishes():
    read = 0
    for path, keys, picture in ros_pairs():
        try:
            solid = expected(keys, picture)
        except UnidentifiedImageError:
            continue
        found = read_map(path, "ros")
        assert np.array_equal(found.walls, solid), path
        assert (found.cell_size, list(found.origin)) == (keys["resolution"], keys["origin"][:2]), (
            path
        )
        read += 1
    print(f"{read} ROS maps read")
    assert read


def test_every_file_that_looks_like_a_map_is_read_or_refused_in_one_sentence():
    counts = {"read": 0, "refused": 0}
    for path in sorted(Path(FOLDER).rglob("*")):
        if path.is_file() and path.suffix.lower() in {
            ".yaml",
            ".yml",
            ".world",
            ".map",
            ".tmj",
            ".inc",
        }:
            try:
                read_map(path)
                counts["read"] += 1
            except WorldgenError as error:
                assert "\n" not in str(error)
                counts["refused"] += 1
    print(counts)
    assert counts["read"]
