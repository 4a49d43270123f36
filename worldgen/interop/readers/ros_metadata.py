"""The YAML file of a ROS map: the picture's name, its scale and place, and what greys mean."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path, PurePosixPath, PureWindowsPath

from worldgen.domain import CELL_SIZES
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld, Message
from worldgen.interop.format.foreign_map import ForeignRobot, read_bounded, sibling_file
from worldgen.interop.readers.places_text import KEYS, from_decimal, read_places
from worldgen.interop.readers.yaml_table import YamlTable, read_yaml
from worldgen.parameters.bounds import check_choice
from worldgen.support.paths import real_path
from worldgen.support.plain_text import quote

MODES = ("trinary", "scale", "raw")
# Key under which our own maps store start, target and robot.
OURS = "worldgen"
_MAX_BYTES = 64 << 10
_REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
_SUFFIXES = (".pgm", ".png", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff")
# Writers of maps print not-a-number in these forms.
_NAN = re.compile(r"[+-]?\.?nan(\(.*\))?", re.IGNORECASE)
# Nav2's thresholds, for a file whose own ones are not numbers.
_USUAL_THRESHOLDS = {"occupied_thresh": 0.65, "free_thresh": 0.196}
_QUARTER = math.pi / 2
# A yaw is a rounded quarter turn only with at least this many decimals: 1.57, but not 1.6 or 2.
_FEWEST_DECIMALS = 2
# Cells that a quarter turn may be off: half the step of the pose lattice, and, for a yaw that is
# one rounded to its decimals, half a cell.
_UNSEEN = 1 / 2048
_MOST_ROUNDED = 0.5


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
        robot: Start, target and robot, if worldgen wrote the map: from the picture's corner, or in
            the map's frame if there is a yaw.
        yaw: Angle, rad, by which the picture is turned counter-clockwise about its lower-left
            corner.
        is_rounded: True if ``yaw`` is a quarter turn, rounded to the decimals in the file.
        notes: Sentences worth knowing.
        warnings: Sentences about likely mistakes.
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
    is_rounded: bool = False
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def turn(self, height: int, width: int) -> tuple[int, float]:
        """Return the yaw of a picture of this size as quarter turns and the rest, rad.

        The rest is 0 if a quarter turn cannot be told from the yaw, or is meant by it.
        """
        quarters = round(self.yaw / _QUARTER)
        rest = self.yaw - quarters * _QUARTER
        moved = abs(rest) * math.hypot(height, width)
        if moved < (_MOST_ROUNDED if self.is_rounded else _UNSEEN):
            rest = 0.0
        return quarters % 4, rest


def read_ros_metadata(path: Path) -> RosMetadata:
    """Read the YAML file of a map.

    Args:
        path: The file; the picture must be in the same folder or below it.

    Raises:
        FormatError: If it isn't YAML, a key is missing or wrong, or the picture is not there.
    """
    # Check that all keys are there.
    table = read_yaml(
        read_bounded(path, _MAX_BYTES), "a ROS map has `image: map.pgm` and similar keys"
    )
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
    warnings: list[str] = []
    resolution = table.number("resolution")
    occupied = _threshold(table, "occupied_thresh", warnings)
    free = _threshold(table, "free_thresh", warnings)
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
            "write fractions, such as {free_fraction:g} and {fraction:g} for these percentages"
            if 1.0 < occupied <= 100.0 and 0.0 <= free < occupied
            else "write 0.196 and 0.65, Nav2's own",
            free_fraction=free / 100,
            fraction=occupied / 100,
            free=free,
            occupied=occupied,
            line=table.line_of("free_thresh"),
        )
    # Read the origin, our own places if there are any, and the rest.
    x, y, yaw, is_rounded = _origin(table, warnings)
    negate = table.truth("negate")
    robot = _places(table, (x, y) if yaw == 0.0 else (0.0, 0.0))
    mode = _mode(table)
    image, notes = _picture(path, table)
    return RosMetadata(
        image, resolution, (x, y), occupied, free, negate, mode, robot, yaw, is_rounded,
        notes, tuple(warnings),
    )  # fmt: skip


def _threshold(table: YamlTable, key: str, warnings: list[str]) -> float:
    if not _NAN.fullmatch(table.word(key)):
        return table.number(key)
    usual = _USUAL_THRESHOLDS[key]
    warnings.append(f"{key} is not a number; it counts as {usual}, Nav2's default")
    return usual


def _origin(table: YamlTable, warnings: list[str]) -> tuple[float, float, float, bool]:
    """Return x, y and yaw, and whether the yaw is a rounded quarter turn."""
    words = table.words("origin") or []
    try:
        numbers = [0.0 if _NAN.fullmatch(word) else from_decimal(word) for word in words]
    except InvalidParameter:
        numbers = []
    if len(numbers) != 3:
        raise FormatError(
            "wrong-type",
            "origin must be three numbers, [x m, y m, yaw rad]",
            line=table.line_of("origin"),
        )
    # Map savers write a yaw of nan for a map without an orientation.
    lost = [
        name for name, word in zip(("x", "y", "yaw"), words, strict=True) if _NAN.fullmatch(word)
    ]
    if lost:
        warnings.append(f"the origin's {' and '.join(lost)}: not a number, counted as 0")
    x, y, yaw = numbers
    if abs(yaw) > 2 * math.pi:
        warnings.append(
            f"the picture is turned by {yaw:g} rad, more than a whole turn; if these are degrees, "
            f"write {math.radians(yaw):.9g}"
        )
    return x, y, yaw, _is_rounded_quarter(words[2], yaw)


def _is_rounded_quarter(word: str, yaw: float) -> bool:
    """Return True if a yaw is a quarter turn with its last decimals rounded or cut off."""
    decimals = len(word.partition(".")[2])
    if decimals < _FEWEST_DECIMALS or not word.lstrip("+-").replace(".", "").isdigit():
        return False
    nearest = round(yaw / _QUARTER) * _QUARTER
    unit = Fraction(10) ** -decimals
    off = abs(Fraction(word) - Fraction(nearest))
    is_cut_off = abs(yaw) < abs(nearest) and off < unit
    return off <= unit / 2 or is_cut_off


def _picture(path: Path, table: YamlTable) -> tuple[Path, tuple[str, ...]]:
    """Return the path of the picture, and a note if it is not where the file says.

    A map that was copied often names a folder of another machine; then the picture of the same
    name next to the file is meant.
    """
    name = table.word("image")
    line = table.line_of("image")
    try:
        return sibling_file(path, "image", name, line=line), ()
    except FormatError as error:
        bare = PureWindowsPath(PurePosixPath(name).name).name
        folder = real_path(path.parent)
        beside = _entry(folder, bare)
        if beside is None or beside == name:
            error.message = _with_another(error.message, folder, bare)
            raise
        found = sibling_file(path, "image", beside, line=line)
    return found, (f"image {quote(name, 80)} is not there; {beside} next to {path.name} was read",)


def _with_another(message: Message, folder: Path, name: str) -> Message:
    """Add to a message about a missing picture the one of the same name with another suffix."""
    stem = PurePosixPath(name).stem
    other = next(filter(None, (_entry(folder, stem + suffix) for suffix in _SUFFIXES)), None)
    if other is None:
        return message
    return message.before(", or write `image: {other}` for the one that is there", other=other)


def _entry(folder: Path, name: str) -> str | None:
    """Return the name of a folder's file that equals a name, or does so in lower case."""
    if not name or "\0" in name:
        return None
    try:
        files = sorted(one.name for one in folder.iterdir() if one.is_file())
    except OSError:
        return None
    same = [one for one in files if one.lower() == name.lower()]
    return name if name in same else same[0] if len(same) == 1 else None


def _places(table: YamlTable, origin: tuple[float, float]) -> ForeignRobot:
    """Return the facts under our own key in a map's file; map_server ignores that key.

    Args:
        table: The file.
        origin: x and y, m, from which places are measured.
    """
    if OURS not in table:
        return ForeignRobot()
    ours = table.tables(OURS)
    if len(ours) != 1:
        raise FormatError(
            "wrong-count",
            "{key} has {tables} tables; it must have one",
            key=OURS,
            tables=len(ours),
            line=table.line_of(OURS),
        )
    strange = [key for key in ours[0] if key not in KEYS]
    if strange:
        raise FormatError(
            "unknown-name",
            "{name!q} is not a key of {key}",
            "it has {known!l}",
            name=strange[0],
            key=OURS,
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
