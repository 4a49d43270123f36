"""ROS map_server maps: a short YAML file, and a picture with the occupancy of cells.

Source: the map_server of ROS navigation2 (``map_io.cpp``) and its documentation.
"""

from __future__ import annotations

import json
import math
import re
from fractions import Fraction
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError, Note
from worldgen.interop.format import HELD, Destination, Exported, Format, decimal
from worldgen.interop.format.foreign_map import (
    FLOOR_ROBOT,
    ForeignMap,
    ForeignRobot,
    naming,
    origin_of,
    read_bounded,
    sibling_file,
)
from worldgen.interop.geometry.turned_pixels import cells_reached
from worldgen.interop.readers.grey_image import GreyImage, pgm_bytes, png_bytes, read_picture_file
from worldgen.interop.readers.nav2_params import MAX_PARAMS_BYTES, nav2_params, read_nav2_params
from worldgen.interop.readers.places_text import KEYS, place_words
from worldgen.interop.readers.ros_layout import RosLayout
from worldgen.interop.readers.ros_metadata import OURS, RosMetadata, read_ros_metadata
from worldgen.lattice import exact
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import Value, World

# Values of a nav_msgs/OccupancyGrid.
FREE = 0
OCCUPIED = 100
UNKNOWN = -1
# Grey that map savers write for unknown cells.
_UNKNOWN_GREY = 205
# Occupancy: five greys of 255.
_CLOSE = 0.02


def read_ros_map(
    path: Path,
    *,
    unknown: Literal["solid", "free"] = "solid",
    params: str = "",
    walls: str = "",
    frame: Literal["map", "picture"] = "map",
) -> ForeignMap:
    """Read a map_server pair of files.

    Args:
        path: The YAML file; it names the picture.
        unknown: How to treat cells that are neither occupied nor free: ``solid`` or ``free``.
        params: A file of Nav2's parameters next to the map, for the robot's footprint or radius and
            for its goal checker.
        walls: Another map next to it in the same frame, such as a keepout mask or a costmap's
            layer; its occupied cells become walls too.
        frame: Which way cells lie if the picture is turned: along the axes of the ``map`` frame, or
            of the ``picture``.

    Raises:
        FormatError: If a YAML file or a picture breaks a rule, with the line if there is one.
    """
    # Read the YAML file and the picture.
    metadata = read_ros_metadata(path)
    robot = metadata.robot
    if params:
        robot = _with_params(robot, sibling_file(path, "params", params))
    image, image_digest = read_picture_file(metadata.image)
    solid, unsure, notes = _judged(image, metadata, unknown)
    pixels = flip_rows(solid | unsure if unknown == "solid" else solid)
    # Lay the cells along the axes of the map, or leave them as they are.
    layout = RosLayout.of(metadata, pixels.shape, frame)
    cells = layout.cells(pixels)
    notes += layout.notes(metadata)
    is_resampled = layout.rest != 0.0
    # Record where the map came from.
    made: dict[str, Value] = {
        "image": metadata.image.name,
        "image_sha256": image_digest,
        "mode": metadata.mode,
        "origin": list(layout.corner),
        "unknown": unknown,
    }
    made |= {"yaw": metadata.yaw} if metadata.yaw != 0.0 else {}
    made |= {"picture": [*metadata.origin, metadata.yaw]} if layout.is_picture else {}
    made |= {"params": params} if params else {}
    # Close what another map closes.
    if walls:
        closed, is_aligned, image_digest, more = _other_walls(path, walls, layout)
        notes += [*more, f"{walls} closes {np.count_nonzero(closed & ~cells):,} more cells"]
        cells = cells | closed
        is_resampled |= not is_aligned
        made |= {"walls": walls, "walls_sha256": image_digest}
    warnings = (*metadata.warnings, *_warnings(image, metadata), *layout.warnings(metadata))
    return ForeignMap(
        cells, metadata.resolution, made, (*metadata.notes, *notes), warnings, origin=layout.corner,
        is_picture=True, robots=(layout.placed(robot, metadata),), is_resampled=is_resampled,
    )  # fmt: skip


def _judged(
    image: GreyImage, metadata: RosMetadata, unknown: str
) -> tuple[Bools, Bools, list[str]]:
    """Return which pixels are solid and which are unknown, top row first, with notes on these."""
    cells = occupancy(image, metadata)
    solid, unsure = solid_cells(cells, metadata)
    notes: list[str] = []
    opaque = None if metadata.mode == "raw" else image.opaque
    clear = 0 if opaque is None else np.count_nonzero(~opaque)
    if clear:
        notes.append(
            Note(
                "transparent",
                "{clear:,} of {cells:,} cells are transparent, hence unknown, as in Nav2; they count as "
                "{unknown}",
                "save the picture without transparency, or use --from ros+unknown=free",
                at_terminal=True,
                clear=clear,
                cells=cells.size,
                unknown=unknown,
            )
        )
    # The note above covers the transparent cells.
    others = np.count_nonzero(unsure if opaque is None else unsure & opaque)
    if others:
        notes.append(
            f"{others:,} of {unsure.size:,} cells are neither occupied nor free; they count as "
            f"{unknown}"
        )
    return solid, unsure, notes


def _other_walls(path: Path, name: str, layout: RosLayout) -> tuple[Bools, bool, str, list[str]]:
    """Return the cells that another map's occupied cells reach into.

    What it leaves unknown, or does not cover, stays as it is.

    Returns:
        The cells; whether its pixels fill whole cells; its picture's digest; notes.
    """
    other = sibling_file(path, "walls", name)
    with naming(other):
        metadata = read_ros_metadata(other)
        image, image_digest = read_picture_file(metadata.image)
    solid, _ = solid_cells(occupancy(image, metadata), metadata)
    frame = layout.other(metadata, solid.shape)
    closed = cells_reached(flip_rows(solid), frame, layout.shape, outside=False)
    return closed, frame.is_aligned, image_digest, [*metadata.notes, *metadata.warnings]


def _with_params(robot: ForeignRobot, path: Path) -> ForeignRobot:
    """Return the robot with the body and the goal of a file of Nav2's parameters."""
    try:
        found = read_nav2_params(read_bounded(path, MAX_PARAMS_BYTES))
    except FormatError as error:
        raise FormatError.of(error.message, line=error.line, source=str(path)) from error
    if found.radius is not None or found.footprint:
        robot = robot._replace(radius=found.radius, footprint=found.footprint)
    return robot if found.goal is None else robot._replace(goal=found.goal)


def occupancy(image: GreyImage, metadata: RosMetadata) -> npt.NDArray[np.int8]:
    """Return the values that map_server would publish.

    Returns:
        (height, width) int8, top row first: -1 unknown, 0 free to 100 occupied.
    """
    levels = [_level(value, image.maximum, metadata) for value in range(image.maximum + 1)]
    cells: npt.NDArray[np.int8] = np.array(levels, np.int8)[image.values]
    if image.opaque is not None and metadata.mode != "raw":
        cells[~image.opaque] = UNKNOWN
    return cells


def _level(value: int, maximum: int, metadata: RosMetadata) -> int:
    """Return the occupancy of a grey value.

    Thresholds are exact decimals, and both are inclusive.
    """
    if metadata.mode == "raw":
        byte = math.floor(Fraction(255 * value, maximum) + Fraction(1, 2))
        return byte if byte <= OCCUPIED else UNKNOWN
    filled = Fraction(value if metadata.negate else maximum - value, maximum)
    occupied = exact(metadata.occupied_thresh)
    free = exact(metadata.free_thresh)
    if filled >= occupied:
        return OCCUPIED
    if filled <= free:
        return FREE
    return round(100 * (filled - free) / (occupied - free)) if metadata.mode == "scale" else UNKNOWN


def solid_cells(cells: npt.NDArray[np.int8], metadata: RosMetadata) -> tuple[Bools, Bools]:
    """Return which cells are certainly occupied, and which are uncertain.

    In mode ``raw`` the thresholds apply to the published values; otherwise 100 is occupied and 0 is
    free.
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
                f"grey {_UNKNOWN_GREY}, which map savers write for unknown cells, counts as free "
                f"because free_thresh is {metadata.free_thresh:g}; set it to 0.196 if those cells "
                "are unknown"
            )
    found += _near_thresholds(image, metadata)
    if image.maximum == 1:
        found.append(
            "the picture's maximum is 1: ROS itself misreads such PGM files, and black becomes free"
        )
    return found


def _near_thresholds(image: GreyImage, metadata: RosMetadata) -> list[str]:
    """Return a warning if one grey covers most of the map and is almost another kind of cell."""
    if metadata.mode == "raw":
        return []
    counts = np.bincount(image.values.ravel())
    value = int(np.argmax(counts))
    share = int(counts[value]) / image.values.size
    filled = (value if metadata.negate else image.maximum - value) / image.maximum
    level = _level(value, image.maximum, metadata)
    # Map savers' grey for unknown cells is meant to be just above their threshold.
    is_usual = value == _UNKNOWN_GREY and image.maximum == 255 and not metadata.negate
    if share <= 0.5 or (is_usual and level != OCCUPIED):
        return []
    kind = {FREE: "free", OCCUPIED: "occupied"}.get(level, "unknown")
    return [
        f"grey {value} covers {100 * share:.0f} % of the map and counts as {kind}, but its occupancy, "
        f"{filled:.3f}, is close to {name} {threshold:g}; check that these cells are {kind}"
        for name, threshold in (
            ("occupied_thresh", metadata.occupied_thresh),
            ("free_thresh", metadata.free_thresh),
        )
        if abs(filled - threshold) <= _CLOSE
    ]


def write_ros_map(
    world: World,
    destination: Destination,
    *,
    image: Literal["pgm", "png"] = "pgm",
    mode: Literal["trinary", "scale", "raw"] = "trinary",
    negate: bool = False,
    nav2: bool = False,
) -> Exported:
    """Write a map_server pair; every cell is certainly occupied or certainly free in every mode.

    Args:
        world: The world.
        destination: Where the YAML file is written; the picture goes next to it.
        image: Format of the picture.
        mode: How map_server should interpret the greys.
        negate: True if white is occupied; ``raw`` ignores it.
        nav2: True to write the robot's footprint or radius, and a goal checker, as parameters of
            Nav2 to a third file.
    """
    solid = flip_rows(world.walls)
    black, white = (OCCUPIED, FREE) if mode == "raw" else (255, 1) if negate else (0, 254)
    greys = np.where(solid, np.uint8(black), np.uint8(white))
    picture = destination.sibling_file(f".{image}")
    words = place_words(world, destination)
    x, y, yaw = (*(decimal(shift) for shift in destination.origin), "0.0")
    pose = (0.0, 0.0, 0.0) if world.provenance is None else world.provenance.map_pose
    # The cells of a turned picture go back to where ROS shows them.
    if pose[2] != 0.0 and destination.origin == origin_of(world):
        words = _turned_words(place_words(world, Destination(destination.name)), pose)
        x, y, yaw = map(decimal, pose)
    lines = [
        f"image: {_yaml_text(picture)}",
        f"mode: {mode}",
        f"resolution: {decimal(world.cell_size)}",
        f"origin: [{x}, {y}, {yaw}]",
        f"negate: {int(negate)}",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
        f"{OURS}:",
    ]
    for key, values in words.items():
        # Nav2, too, writes a footprint as a text.
        word = json.dumps(values[0]) if key == "footprint" else values[0]
        lines.append(f"  {key}: {word if KEYS[key] == 1 else '[' + ', '.join(values) + ']'}")
    data = pgm_bytes(greys) if image == "pgm" else png_bytes(greys)
    files = {destination.name: ("\n".join(lines) + "\n").encode(), picture: data}
    if nav2:
        files[destination.sibling_file("-nav2.yaml")] = nav2_params(world.robots[0]).encode()
    return Exported(files)


def _turned_words(
    words: dict[str, list[str]], pose: tuple[float, float, float]
) -> dict[str, list[str]]:
    """Return the words of a world's places in the frame in which the world has a pose."""
    left, low, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    found = dict(words)
    for key, turn in (("start", yaw), ("target", 0.0)):
        x, y, third = map(float, words[key])
        place = (left + c * x - s * y, low + s * x + c * y, third + turn)
        found[key] = [decimal(value) for value in place]
    if "target_heading" in words:
        heading, _, tolerance = words["target_heading"][0].partition(":")
        found["target_heading"] = [f"{decimal(float(heading) + yaw)}:{tolerance}"]
    return found


def _yaml_text(name: str) -> str:
    """Return a file name as a plain word if that is safe, otherwise in quotes."""
    if re.fullmatch(r"[A-Za-z][\w.-]*", name, re.ASCII):
        return name
    # YAML's double-quoted strings understand JSON's escapes.
    return json.dumps(name, ensure_ascii=False)


# A map's name and kind, where it came from, and where robots begin.
_HARMLESS = frozenset({
    "author", "comment", "date", "description", "frame_id", "license", "map_name", "map_path", "map_type", "name",
    "stamp", "starting_positions", "timestamp", "type",
})  # fmt: skip

ros = Format(
    "ros",
    "ROS map_server, .yaml with .pgm or .png",
    (".yaml", ".yml"),
    re.compile(rb"(?s).*?(?m:^)image[ \t]*:"),
    read_ros_map,
    write_ros_map,
    holds=frozenset(HELD) - {"waypoints"},
    client="ROS map_server, Nav2",
    usual_robot=FLOOR_ROBOT,
    harmless=_HARMLESS,
)
