"""ROS map_server maps: a YAML file of a few keys, and a picture whose grey says how occupied a cell is.

Source: the map_server of ROS navigation2 (``map_io.cpp``) and its documentation.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import yaml

from worldgen.errors import FormatError, InvalidParameter
from worldgen.family import check_choice
from worldgen.interop.foreign_map import CELL_SIZES, ForeignMap, digest, read_bounded, shown
from worldgen.interop.grey_image import GreyImage, read_grey_image
from worldgen.lattice import exact
from worldgen.rows import flip_rows
from worldgen.world import Value

__all__ = [
    "FREE",
    "OCCUPIED",
    "UNKNOWN",
    "RosMetadata",
    "occupancy",
    "read_metadata",
    "read_ros_map",
    "solid_cells",
]

FREE, OCCUPIED, UNKNOWN = 0, 100, -1  # values of a nav_msgs/OccupancyGrid
MODES = ("trinary", "scale", "raw")
UNKNOWN_CHOICES = ("solid", "free")
_UNKNOWN_GREY = 205  # what map savers write for unknown
_MAX_YAML_BYTES = 64 << 10
_MAX_DEPTH = 8
_REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
_NUMBER = re.compile(r"[+-]?([0-9]{1,40}\.?[0-9]{0,40}|\.[0-9]{1,40})([eE][+-]?[0-9]{1,3})?")
_TRUTH = {
    "0": False,
    "false": False,
    "no": False,
    "off": False,
    "1": True,
    "true": True,
    "yes": True,
    "on": True,
}


@dataclass(frozen=True)
class RosMetadata:
    """What the YAML file says.

    Args:
        image: The picture's path.
        resolution: Side of a cell, m.
        origin: x and y in m of the lower-left corner in the map's frame; the yaw must be 0.
        occupied_thresh: Occupancy, 0 to 1, from which on a cell is occupied.
        free_thresh: Occupancy up to which a cell is free.
        negate: Whether white is occupied.
        mode: ``trinary``, ``scale`` or ``raw``.
    """

    image: Path
    resolution: float
    origin: tuple[float, float]
    occupied_thresh: float
    free_thresh: float
    negate: bool = False
    mode: str = "trinary"


def read_ros_map(path: Path, unknown: str = "solid") -> ForeignMap:
    """A map_server pair.

    Args:
        path: The YAML file; it names the picture.
        unknown: What cells are that are neither occupied nor free: ``solid`` or ``free``.

    Raises:
        FormatError: If the YAML file or the picture breaks a rule, with the line where there is one.
        InvalidParameter: If ``unknown`` is another word.
    """
    check_choice("unknown", unknown, UNKNOWN_CHOICES)
    text = read_bounded(path, _MAX_YAML_BYTES)
    metadata = read_metadata(text, path)
    picture = read_bounded(metadata.image)
    image = read_grey_image(picture, str(metadata.image))
    cells = occupancy(image, metadata)
    solid, unsure = solid_cells(cells, metadata)
    notes = []
    if unsure.any():
        notes.append(
            f"{np.count_nonzero(unsure)} of {unsure.size} cells are neither occupied nor free; "
            f"they are taken as {unknown}"
        )
    walls = solid | unsure if unknown == "solid" else solid
    x, y = metadata.origin
    if x != 0.0 or y != 0.0:
        notes.append(f"the world's (0, 0) is the map's ({x:g}, {y:g}) m; add that to compare with ROS")
    params: dict[str, Value] = {
        "format": "ros", "source": path.name, "sha256": digest(text), "image": metadata.image.name,
        "image_sha256": digest(picture), "mode": metadata.mode, "origin": [x, y], "unknown": unknown,
    }  # fmt: skip
    warnings = tuple(_warnings(image, metadata))
    return ForeignMap(flip_rows(walls), metadata.resolution, params, tuple(notes), warnings)


def occupancy(image: GreyImage, metadata: RosMetadata) -> npt.NDArray[np.int8]:
    """The values that map_server would publish.

    Returns:
        (height, width) int8, top row first: -1 unknown, 0 free to 100 occupied.
    """
    levels = [_level(value, image.maximum, metadata) for value in range(image.maximum + 1)]
    cells: npt.NDArray[np.int8] = np.array(levels, np.int8)[image.values]
    if image.opaque is not None and metadata.mode != "raw":
        cells[~image.opaque] = UNKNOWN
    return cells


def _level(value: int, maximum: int, metadata: RosMetadata) -> int:
    """Occupancy of one grey value. Thresholds are decimals and count exactly, both inclusive."""
    if metadata.mode == "raw":
        byte = math.floor(Fraction(255 * value, maximum) + Fraction(1, 2))
        return byte if byte <= OCCUPIED else UNKNOWN
    filled = Fraction(value if metadata.negate else maximum - value, maximum)
    occupied, free = exact(metadata.occupied_thresh), exact(metadata.free_thresh)
    if filled >= occupied:
        return OCCUPIED
    if filled <= free:
        return FREE
    return round(100 * (filled - free) / (occupied - free)) if metadata.mode == "scale" else UNKNOWN


def solid_cells(
    cells: npt.NDArray[np.int8], metadata: RosMetadata
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Which cells are surely occupied, and which are neither that nor surely free.

    In mode ``raw`` the thresholds part the published values; else 100 is occupied and 0 is free.
    """
    if metadata.mode != "raw":
        solid = cells == OCCUPIED
        return solid, ~solid & (cells != FREE)
    solid = cells >= math.ceil(100 * exact(metadata.occupied_thresh))
    free = (cells >= 0) & (cells <= math.floor(100 * exact(metadata.free_thresh)))
    return solid, ~solid & ~free


def _warnings(image: GreyImage, metadata: RosMetadata) -> list[str]:
    found = []
    if image.maximum == 255 and metadata.mode != "raw" and not metadata.negate:
        taken_as_free = _level(_UNKNOWN_GREY, 255, metadata) == FREE
        if taken_as_free and (image.values == _UNKNOWN_GREY).any():
            found.append(
                f"grey {_UNKNOWN_GREY}, which map savers write for unknown cells, counts as free because "
                f"free_thresh is {metadata.free_thresh:g}; set it to 0.196 if those cells are unknown"
            )
    if image.maximum == 1:
        found.append("the picture's maximum is 1: ROS itself misreads such PGM files, black comes out free")
    return found


class _Entry(NamedTuple):
    """One value of the YAML file, with the line for messages."""

    node: yaml.Node
    line: int


def read_metadata(text: bytes, path: Path) -> RosMetadata:
    """Checks the YAML file's keys.

    Args:
        text: The file.
        path: Where it lies; the picture must lie in the same folder or below it.

    Raises:
        FormatError: If it is no YAML, a key is missing or wrong, the map is turned, or the picture's
            path leads out of the folder.
    """
    source = str(path)
    entries = _entries(text, source)
    missing = [key for key in _REQUIRED if key not in entries]
    if missing:
        raise FormatError(
            f"{', '.join(missing)} missing; a ROS map has the keys {', '.join(_REQUIRED)}, and may have mode",
            source=source,
        )
    resolution = _number(entries, "resolution", source)
    occupied, free = _number(entries, "occupied_thresh", source), _number(entries, "free_thresh", source)
    if not CELL_SIZES[0] <= resolution <= CELL_SIZES[1]:
        least, most = CELL_SIZES
        message = f"resolution is {resolution:g}; it is the side of a pixel, {least:g} to {most:g} m"
        raise _fault(entries, "resolution", message, source)
    if not 0.0 <= free < occupied <= 1.0:
        message = f"free_thresh {free:g}, occupied_thresh {occupied:g}; the rule is 0 <= free < occupied <= 1"
        raise _fault(entries, "free_thresh", message, source)
    return RosMetadata(
        _image_path(entries, path), resolution, _origin(entries, source), occupied, free,
        _negate(entries, source), _mode(entries, source),
    )  # fmt: skip


def _entries(text: bytes, source: str) -> dict[str, _Entry]:
    """Top-level keys with their lines."""
    root = _compose(text, source)
    if not isinstance(root, yaml.MappingNode):
        raise FormatError("holds no keys; a ROS map has `image: map.pgm` and the like", line=1, source=source)
    entries: dict[str, _Entry] = {}
    for key, node in root.value:
        line = key.start_mark.line + 1
        name = key.value if isinstance(key, yaml.ScalarNode) else "a list or mapping"
        if name in entries:
            raise FormatError(f"{shown(name)} is given twice; keep one", line=line, source=source)
        entries[name] = _Entry(node, line)
    return entries


def _compose(text: bytes, source: str) -> yaml.Node | None:
    """The file as nodes only: no value is built, no tag obeyed."""
    try:
        decoded = text.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise FormatError("is not UTF-8 text; give the map's YAML file", line=line, source=source) from error
    try:
        _refuse_tricks(decoded, source)
        return yaml.compose(decoded, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = 1 if mark is None else mark.line + 1
        message = f"is no YAML: {error.problem or error.context}; write `key: value` lines"
        raise FormatError(message, line=line, source=source) from error
    except FormatError:
        raise
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # a forbidden character, raw or as an escape
        line = decoded.count("\n", 0, getattr(error, "position", 0)) + 1
        raise FormatError("has a character that YAML forbids; remove it", line=line, source=source) from error


def _refuse_tricks(text: str, source: str) -> None:
    """Refuses what makes a small YAML file large or deep, before a tree is built."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        line = 1 if event.start_mark is None else event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) is not None:
            raise FormatError(
                "anchors and aliases (& and *) are not read; write the value out", line=line, source=source
            )
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > _MAX_DEPTH:
            raise FormatError(
                f"lists nested deeper than {_MAX_DEPTH}; a ROS map has plain keys", line=line, source=source
            )


def _fault(entries: Mapping[str, _Entry], key: str, message: str, source: str) -> FormatError:
    return FormatError(message, line=entries[key].line, source=source)


def _word(entries: Mapping[str, _Entry], key: str, source: str) -> str:
    node = entries[key].node
    if not isinstance(node, yaml.ScalarNode) or not node.value:
        raise _fault(entries, key, f"{key} must be one value on its line, not a list and not empty", source)
    return str(node.value)


def _parse_number(word: str) -> float | None:
    value = float(word) if _NUMBER.fullmatch(word) else math.nan
    return value if math.isfinite(value) else None


def _number(entries: Mapping[str, _Entry], key: str, source: str) -> float:
    word = _word(entries, key, source)
    value = _parse_number(word)
    if value is None:
        raise _fault(entries, key, f"{key} is {shown(word)}, no finite number; write one like 0.05", source)
    return value


def _origin(entries: Mapping[str, _Entry], source: str) -> tuple[float, float]:
    node = entries["origin"].node
    items = node.value if isinstance(node, yaml.SequenceNode) else []
    words = [item.value for item in items if isinstance(item, yaml.ScalarNode)]
    numbers = [_parse_number(word) for word in words]
    if len(items) != 3 or len(words) != 3 or None in numbers:
        raise _fault(entries, "origin", "origin must be three numbers, [x m, y m, yaw rad]", source)
    x, y, yaw = (number or 0.0 for number in numbers)
    if yaw != 0.0:
        message = f"the map is turned by {yaw:g} rad; only yaw 0 is read; turn the picture and write 0"
        raise _fault(entries, "origin", message, source)
    return x, y


def _negate(entries: Mapping[str, _Entry], source: str) -> bool:
    word = _word(entries, "negate", source)
    if word.lower() not in _TRUTH:
        raise _fault(entries, "negate", f"negate is {shown(word)}; write 0 or 1", source)
    return _TRUTH[word.lower()]


def _mode(entries: Mapping[str, _Entry], source: str) -> str:
    if "mode" not in entries:
        return MODES[0]
    mode = _word(entries, "mode", source).lower()
    try:
        check_choice("mode", mode, MODES)
    except InvalidParameter as error:
        raise _fault(entries, "mode", str(error), source) from error
    return mode


def _image_path(entries: Mapping[str, _Entry], path: Path) -> Path:
    """The picture's path: a map file may name pictures beside it or below it, nothing else."""
    source = str(path)
    name = _word(entries, "image", source)
    if "\0" in name:
        raise _fault(entries, "image", "image has a NUL in its name; correct it", source)
    folder = Path(os.path.realpath(path.parent))
    image = Path(os.path.realpath(folder / name))
    if not image.is_relative_to(folder):
        message = f"image {shown(name, 80)} lies outside the map's folder; copy it there and name it without a path"
        raise _fault(entries, "image", message, source)
    try:
        there = image.is_file()
    except OSError:  # a name too long for the disk
        there = False
    if not there:
        raise _fault(entries, "image", f"image {shown(name, 80)} is not there; put it beside the YAML file", source)
    return path.parent / image.relative_to(folder)
