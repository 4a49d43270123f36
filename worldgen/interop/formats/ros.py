"""ROS map_server maps: a short YAML file, and a picture with the occupancy of cells.

Source: the map_server of ROS navigation2 (``map_io.cpp``) and its documentation.
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from worldgen.domain import CELL_SIZES
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld, Note
from worldgen.family import check_choice
from worldgen.interop.format import HELD, Destination, Exported, Format, decimal
from worldgen.interop.format.foreign_map import (
    FLOOR_ROBOT,
    ForeignMap,
    ForeignRobot,
    read_bounded,
    sibling_file,
)
from worldgen.interop.readers.grey_image import GreyImage, pgm_bytes, png_bytes, read_picture_file
from worldgen.interop.readers.nav2_params import MAX_PARAMS_BYTES, nav2_params, read_nav2_params
from worldgen.interop.readers.places_text import KEYS, from_decimal, place_words, read_places
from worldgen.interop.readers.yaml_table import YamlTable, read_yaml
from worldgen.lattice import exact
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import Value, World

# Values of a nav_msgs/OccupancyGrid.
FREE = 0
OCCUPIED = 100
UNKNOWN = -1
MODES = ("trinary", "scale", "raw")
# Grey that map savers write for unknown cells.
_UNKNOWN_GREY = 205
# Occupancy: five greys of 255.
_CLOSE = 0.02
_MAX_YAML_BYTES = 64 << 10
# Key under which our own maps store start, target and robot.
_OURS = "worldgen"
# Largest deviation from a quarter turn, rad; the picture's size may set a smaller one.
_MOST_OFF = 0.01
_REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")


@dataclass(frozen=True)
class RosMetadata:
    """The contents of the YAML file.

    Args:
        image: The picture's path.
        resolution: Side of a cell, m.
        origin: x and y in m of the picture's lower-left corner in the map's frame.
        occupied_thresh: Occupancy, 0 to 1, from which a cell is occupied.
        free_thresh: Occupancy up to which a cell is free.
        negate: True if white is occupied.
        mode: ``trinary``, ``scale`` or ``raw``.
        places: Start, target and robot, if worldgen wrote the map.
        yaw: Angle, rad, by which the picture is turned counter-clockwise about its lower-left
            corner; near a quarter turn.
    """

    image: Path
    resolution: float
    origin: tuple[float, float]
    occupied_thresh: float
    free_thresh: float
    negate: bool = False
    mode: str = "trinary"
    robot: ForeignRobot = field(default_factory=ForeignRobot)
    yaw: float = 0.0


def read_ros_map(
    path: Path, *, unknown: Literal["solid", "free"] = "solid", params: str = ""
) -> ForeignMap:
    """Read a map_server pair of files.

    Args:
        path: The YAML file; it names the picture.
        unknown: How to treat cells that are neither occupied nor free: ``solid`` or ``free``.
        params: A file of Nav2's parameters next to the map, for the robot's footprint or radius and
            for its goal checker.

    Raises:
        FormatError: If the YAML file or the picture breaks a rule, with the line if there is one.
    """
    # Read the YAML file and the picture.
    text = read_bounded(path, _MAX_YAML_BYTES)
    metadata = read_metadata(text, path)
    robot = metadata.robot
    if params:
        robot = _with_params(robot, sibling_file(path, "params", params))
    image, image_digest = read_picture_file(metadata.image)
    # Decide which cells are solid, and turn the map upright.
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
    walls, (x, y) = _turned(solid | unsure if unknown == "solid" else solid, metadata)
    if metadata.yaw != 0.0:
        notes.append(
            f"the picture is turned by {_quarters(metadata.yaw)} quarters, according to its yaw "
            f"of {metadata.yaw:g}"
        )
    if x != 0.0 or y != 0.0:
        notes.append(
            f"the world's (0, 0) is the map's ({x:g}, {y:g}) m; add that to compare with ROS"
        )
    # Record where the map came from.
    made: dict[str, Value] = {
        "image": metadata.image.name,
        "image_sha256": image_digest,
        "mode": metadata.mode,
        "origin": [x, y],
        "unknown": unknown,
    }
    made |= {"yaw": metadata.yaw} if metadata.yaw != 0.0 else {}
    made |= {"params": params} if params else {}
    warnings = tuple(_warnings(image, metadata))
    return ForeignMap(
        flip_rows(walls), metadata.resolution, made, tuple(notes), warnings, origin=(x, y), is_picture=True,
        robots=(robot,),
    )  # fmt: skip


def _with_params(robot: ForeignRobot, path: Path) -> ForeignRobot:
    """Return the robot with the body and the goal of a file of Nav2's parameters."""
    try:
        found = read_nav2_params(read_bounded(path, MAX_PARAMS_BYTES))
    except FormatError as error:
        raise FormatError.of(error.message, line=error.line, source=str(path)) from error
    if found.radius is not None or found.footprint:
        robot = robot._replace(radius=found.radius, footprint=found.footprint)
    return robot if found.goal is None else robot._replace(goal=found.goal)


def _quarters(yaw: float) -> int:
    """Return the nearest number of quarter turns."""
    return round(yaw / (math.pi / 2))


def _turned(walls: Bools, metadata: RosMetadata) -> tuple[Bools, tuple[float, float]]:
    """Return the picture, top row first, turned by whole quarters, and its new lower-left corner.

    Raises:
        FormatError: If the yaw is so far from whole quarters that a cell would move by half its
            side.
    """
    quarters = _quarters(metadata.yaw)
    height, width = walls.shape
    moved = abs(metadata.yaw - quarters * math.pi / 2) * math.sqrt(height**2 + width**2)
    if moved >= 0.5:
        raise FormatError(
            "turned-map",
            "yaw {yaw:g} moves cells by up to {moved:.2g} sides from where a quarter turn puts "
            "them",
            "write its digits, such as 1.57079633, or turn the picture",
            yaw=metadata.yaw,
            moved=moved,
        )
    across, up = ((0, 0), (-height, 0), (-width, -height), (0, -width))[quarters % 4]
    x, y = map(exact, metadata.origin)
    side = exact(metadata.resolution)
    return np.rot90(walls, quarters % 4), (float(x + across * side), float(y + up * side))


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


def read_metadata(text: bytes, path: Path) -> RosMetadata:
    """Check the keys of the YAML file.

    Args:
        text: The file's text.
        path: The file's path; the picture must be in the same folder or below it.

    Raises:
        FormatError: If it isn't YAML, a key is missing or wrong, the map is turned, or the
            picture's path leads out of the folder.
    """
    # Check that all keys are there.
    table = read_yaml(text, "a ROS map has `image: map.pgm` and similar keys")
    missing = [key for key in _REQUIRED if key not in table]
    if missing:
        raise FormatError(
            "missing-key",
            "{missing!l} missing",
            "a ROS map has the keys {keys!l}, and may have mode",
            missing=list(missing),
            keys=list(_REQUIRED),
        )
    # Check the numbers.
    resolution = table.number("resolution")
    occupied = table.number("occupied_thresh")
    free = table.number("free_thresh")
    if not CELL_SIZES[0] <= resolution <= CELL_SIZES[1]:
        least, most = CELL_SIZES
        raise FormatError(
            "out-of-range",
            "resolution is {resolution:g}; it must be the side of a pixel, {low:g} to {high:g} m",
            resolution=resolution,
            low=least,
            high=most,
            line=table.line_of("resolution"),
        )
    if not 0.0 <= free < occupied <= 1.0:
        raise FormatError(
            "wrong-order",
            "free_thresh {free:g}, occupied_thresh {occupied:g}; they must satisfy 0 <= free < "
            "occupied <= 1",
            free=free,
            occupied=occupied,
            line=table.line_of("free_thresh"),
        )
    # Read the origin, and our own places if there are any.
    *origin, yaw = _origin(table)
    negate = table.truth("negate")
    corner = (origin[0], origin[1])
    if yaw != 0.0 and _OURS in table:
        raise FormatError(
            "unsupported",
            "a map with places under {key} must not be turned",
            "write the yaw 0, or delete {key}",
            key=_OURS,
            line=table.line_of("origin"),
        )
    places = _places(table, corner)
    image = sibling_file(path, "image", table.word("image"), line=table.line_of("image"))
    return RosMetadata(image, resolution, corner, occupied, free, negate, _mode(table), places, yaw)


def _origin(table: YamlTable) -> tuple[float, float, float]:
    try:
        numbers = [from_decimal(word) for word in table.words("origin") or ()]
    except InvalidParameter:
        numbers = []
    if len(numbers) != 3:
        raise FormatError(
            "wrong-type",
            "origin must be three numbers, [x m, y m, yaw rad]",
            line=table.line_of("origin"),
        )
    x, y, yaw = numbers
    if not abs(yaw) <= 2 * math.pi or abs(yaw - _quarters(yaw) * math.pi / 2) > _MOST_OFF:
        raise FormatError(
            "turned-map",
            "the map is turned by {yaw:g} rad; only quarter turns can be read, such as 0 and "
            "1.57079633",
            "turn the picture, or write 0 if your programs ignore the yaw",
            yaw=yaw,
            line=table.line_of("origin"),
        )
    return x, y, yaw


def _places(table: YamlTable, origin: tuple[float, float]) -> ForeignRobot:
    """Return the facts under our own key in a map's file; map_server ignores that key."""
    if _OURS not in table:
        return ForeignRobot()
    ours = table.tables(_OURS)
    if len(ours) != 1:
        raise FormatError(
            "wrong-count",
            "{key} has {tables} tables; it must have one",
            key=_OURS,
            tables=len(ours),
            line=table.line_of(_OURS),
        )
    strange = [key for key in ours[0] if key not in KEYS]
    if strange:
        raise FormatError(
            "unknown-name",
            "{name!q} is not a key of {key}",
            "it has {known!l}",
            name=strange[0],
            key=_OURS,
            known=list(KEYS),
            line=ours[0].line_of(strange[0]),
        )
    # Check one by one, so that a fault is reported with its line; a car's belong together.
    read: dict[str, list[str]] = {}
    for key in sorted(ours[0], key=list(KEYS).index):
        words = ours[0].words(key)
        read[key] = [ours[0].word(key)] if words is None else words
        if key == "drive" and "turning_radius" in ours[0]:
            continue
        try:
            read_places(read, origin)
        except (InvalidParameter, InvalidWorld) as error:
            raise FormatError.of(error.message, line=ours[0].line_of(key)) from error
    return read_places(read, origin)


def _mode(table: YamlTable) -> str:
    if "mode" not in table:
        return MODES[0]
    mode = table.word("mode").lower()
    try:
        check_choice("mode", mode, MODES)
    except InvalidParameter as error:
        raise FormatError.of(error.message, line=table.line_of("mode")) from error
    return mode


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
    x, y = (decimal(shift) for shift in destination.origin)
    lines = [
        f"image: {_yaml_text(picture)}",
        f"mode: {mode}",
        f"resolution: {decimal(world.cell_size)}",
        f"origin: [{x}, {y}, 0.0]",
        f"negate: {int(negate)}",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
        f"{_OURS}:",
    ]
    for key, words in place_words(world, destination).items():
        # Nav2, too, writes a footprint as a text.
        word = json.dumps(words[0]) if key == "footprint" else words[0]
        lines.append(f"  {key}: {word if KEYS[key] == 1 else '[' + ', '.join(words) + ']'}")
    data = pgm_bytes(greys) if image == "pgm" else png_bytes(greys)
    files = {destination.name: ("\n".join(lines) + "\n").encode(), picture: data}
    if nav2:
        files[destination.sibling_file("-nav2.yaml")] = nav2_params(world.robots[0]).encode()
    return Exported(files)


def _yaml_text(name: str) -> str:
    """Return a file name as a plain word if that is safe, otherwise in quotes."""
    if re.fullmatch(r"[A-Za-z][\w.-]*", name, re.ASCII):
        return name
    # YAML's double-quoted strings understand JSON's escapes.
    return json.dumps(name, ensure_ascii=False)


_HARMLESS = frozenset({
    "author", "comment", "date", "description", "frame_id", "license", "map_name", "name", "stamp", "timestamp",
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
