"""A vector drawing: shapes with the names of their layers, before they become cells.

Walls are areas, or lines with a thickness. What is free is drawn over them and removes their area,
as a door's opening does.
"""

from __future__ import annotations

import fnmatch
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import shapely

from worldgen.errors import FormatError, InvalidParameter, Note
from worldgen.interop.account import report_unread
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot
from worldgen.interop.geometry.drawing_options import DrawingOptions
from worldgen.interop.geometry.raster import painted
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.support.arrays import Floats
from worldgen.support.plain_text import quote
from worldgen.world import Value

UNITS = {
    "m": 1.0,
    "dm": 0.1,
    "cm": 0.01,
    "mm": 0.001,
    "um": 1e-6,
    "km": 1000.0,
    "in": 0.0254,
    "ft": 0.3048,
    "yd": 0.9144,
    "mi": 1609.344,
}
"""Lengths of units, m."""
DEGREES = "deg"
NO_LAYER = "no layer"
"""The name of the layer of a shape that is in none."""

# Segments of a full turn; the chord is then within 1e-4 of the radius.
TURN = 256
_MOST_PARTS = 400_000
_MOST_POINTS = 6_000_000
# Corners of one shape.
_MOST_CORNERS = 1_000_000
# Neighbouring segments meet, so even a plain outline has a few pairs for each.
_MOST_MEETINGS = 400_000
_MOST_ERASED = 300_000
# Lines with fewer corners are quick even if all of them cross.
_FEW = 200
_BOXES = 16
_FARTHEST = 1e15
_USUAL_CELL = Fraction(1, 20)
_COARSER: list[Fraction] = [
    Fraction(factor * 10**power, 20) for power in range(4) for factor in (1, 2, 5)
]
_MOST_SIDE = 2000
# Free space around a drawing that is a single line, m.
_AROUND = 1.0
_MOST_LISTED = 12
# Options that a world's provenance has, if they were given.
_RECORDED = ("layer", "free", "unit", "cell_size", "thickness", "outlines")


class Part(NamedTuple):
    """A shape of a drawing.

    Args:
        shape: A shapely geometry in the drawing's units, y up; a line has no area yet.
        layers: The names by which a user may choose it; the first is listed in messages.
        is_free: True if it removes the walls below it instead of adding one.
    """

    shape: Any
    layers: tuple[str, ...]
    is_free: bool = False


@dataclass
class Drawing:
    """What a reader found in a file.

    Args:
        guesses: Lengths of a unit, m, to try in this order if neither the file nor the user has
            one; the first in which the drawing is smaller than 200 m counts.
        unit: Length of a unit, m, if the file has it.
        unit_from: Where that is from, in words.
        page: Left, low, right and high, in units: the part that is shown; None for all of it.
        origin: The place in the file's frame, m, of the drawing's (0, 0).
        notes: Sentences worth knowing.
        robot: Start, target and robot, if the file has them; m, from the grid's corner.
        cell_size: Side of a cell, m, if the file has it.
    """

    guesses: tuple[float, ...] = (1.0, 0.001)
    unit: float | None = None
    unit_from: str = ""
    page: tuple[float, float, float, float] | None = None
    origin: tuple[float, float] = (0.0, 0.0)
    notes: list[Any] = field(default_factory=list)
    robot: ForeignRobot = field(default_factory=ForeignRobot)
    cell_size: float = 0.0
    parts: list[Part] = field(default_factory=list)
    _unread: Counter[tuple[str, tuple[str, ...]]] = field(default_factory=Counter)
    _points: int = 0

    def add(self, shape: Any, layers: Sequence[str], *, is_free: bool = False) -> None:
        """Add a shape.

        Raises:
            FormatError: If there are too many, or a coordinate is not finite.
        """
        if shape is None or shape.is_empty:
            return
        self._points += shapely.get_num_coordinates(shape)
        if len(self.parts) >= _MOST_PARTS or self._points > _MOST_POINTS:
            raise too_large()
        finite(shapely.get_coordinates(shape))
        self.parts.append(Part(shape, tuple(dict.fromkeys(layers)) or (NO_LAYER,), is_free))

    def unread(self, what: str, layers: Sequence[str]) -> None:
        """Report an element that is not read; it counts only if its layer is one of the walls."""
        self._unread[what, tuple(layers)] += 1

    def map(self, options: DrawingOptions, params: dict[str, Value] | None = None) -> ForeignMap:
        """Return the walls as cells: those that the walls' area reaches into.

        Raises:
            FormatError: If there are no walls, or there is no such layer.
            InvalidParameter: If an option is out of range.
        """
        # Choose the walls and the openings.
        check_between("thickness", options.thickness, 0.0, 100.0, "m")
        walls, openings, notes = self._chosen(options)
        unread: Counter[str] = Counter()
        for (what, layers), count in self._unread.items():
            if _is_chosen(layers, options.layer) and not _matches(layers, options.free):
                unread[what] += count
        for what, count in unread.items():
            report_unread(what, count)
        if not walls:
            raise FormatError(
                "no-walls",
                "has no walls: nothing of it is an area or a line; not read: {unread!l:nothing}",
                "draw the walls as visible shapes, not as text, pictures or solids",
                unread=[f"{count} {what}" for what, count in unread.most_common(_MOST_LISTED)],
            )
        unit = self._unit(options)
        # Give them their thickness, and open them.
        half = options.thickness / unit / 2
        shapes = _opened(
            [_thick(_outlined(part.shape, options), half) for part in walls],
            openings,
            max(
                2 * half, float(_USUAL_CELL if not options.cell_size else options.cell_size) / unit
            ),
        )
        # Choose the grid.
        drawn = np.array([part.shape.bounds for part in self.parts])
        page = self.page or (*drawn[:, :2].min(axis=0), *drawn[:, 2:].max(axis=0))
        metres = [exact(float(value)) * exact(unit) for value in page]
        if self.page is None:
            grown = options.thickness / 2 if half else 0.0
            metres = [
                value + exact(sign * grown)
                for value, sign in zip(metres, (-1, -1, 1, 1), strict=True)
            ]
            if min(metres[2] - metres[0], metres[3] - metres[1]) < exact(_AROUND) / 10:
                notes.append(f"the drawing is a line, so {_AROUND:g} m around it is free")
                metres = [
                    value + sign * exact(_AROUND)
                    for value, sign in zip(metres, (-1, -1, 1, 1), strict=True)
                ]
        cell = self._cell(options, metres)
        if self.page is None:
            metres[:2] = [value // cell * cell for value in metres[:2]]
        left, low, right, high = metres
        notes.extend(self._size_notes(options, unit, right - left, high - low))
        # Paint.
        scale = unit / float(cell)
        shift = np.array([float(left / cell), float(low / cell)])
        geometries = shapely.transform(np.array(shapes, object), lambda xy: xy * scale - shift)
        raster = painted((right - left, high - low), cell, lambda raster: raster.shapes(geometries))
        if raster.partly and not self.cell_size:
            notes.append(
                f"{raster.partly} of {np.count_nonzero(raster.solid)} solid cells of "
                f"{float(cell):g} m are only partly covered; a smaller --cell is more accurate"
            )
        warnings = []
        if raster.solid.all():
            warnings.append(
                "every cell is solid; name the layers of walls with --layer, or, if rooms are drawn as "
                "areas, make walls of their outlines with +areas=outline"
            )
        given = {name: value for name in _RECORDED if (value := getattr(options, name))}
        origin = float(left) + self.origin[0], float(low) + self.origin[1]
        return ForeignMap(
            raster.solid, float(cell), {**given, **(params or {})}, (*self.notes, *notes),
            tuple(warnings), robots=(self.robot,), origin=origin, is_picture=self.page is not None,
        )  # fmt: skip

    def _unit(self, options: DrawingOptions) -> float:
        """Return the length of a unit, m."""
        if options.unit:
            return parse_unit(options.unit)
        if self.unit is not None:
            return self.unit
        bounds = self.page or shapely.total_bounds(np.array([part.shape for part in self.parts]))
        extent = max(bounds[2] - bounds[0], bounds[3] - bounds[1]) if self.parts else 0.0
        return next((guess for guess in self.guesses if extent * guess <= 200.0), self.guesses[-1])

    def _size_notes(
        self, options: DrawingOptions, unit: float, width: Fraction, height: Fraction
    ) -> list[Any]:
        if options.unit or self.cell_size:
            return []
        source = f"by {self.unit_from}" if self.unit is not None else "as the file has no unit"
        return [
            Note(
                "no-scale",
                "a unit counts as {unit:g} m, {source}, so the drawing is {width:.4g} x "
                "{height:.4g} m",
                "--unit says another, such as {other}",
                at_terminal=True,
                other="in" if unit == UNITS["mm"] else "mm",
                unit=unit,
                source=source,
                width=float(width),
                height=float(height),
            )
        ]

    def _cell(self, options: DrawingOptions, metres: list[Fraction]) -> Fraction:
        """Return the side of a cell, m."""
        given = options.cell_size or self.cell_size
        if given:
            return exact(given)
        longest = max(metres[2] - metres[0], metres[3] - metres[1])
        fitting = (size for size in _COARSER if longest <= _MOST_SIDE * size)
        return next(fitting, _COARSER[-1])

    def _chosen(
        self, options: DrawingOptions
    ) -> tuple[list[Part], list[tuple[Any, int]], list[Any]]:
        """Return the walls, the openings with the number of walls below each, and notes."""
        known = list(dict.fromkeys(name for part in self.parts for name in part.layers))
        for option, patterns in (("layer", options.layer), ("free", options.free)):
            for pattern in _patterns(patterns):
                if not _matches(known, pattern):
                    raise FormatError(
                        "layer-missing",
                        "there is no layer {name!q}; layers: {known!l:none}",
                        "name some of these with --{option}",
                        at_terminal=True,
                        name=pattern,
                        known=[quote(name) for name in known[:30]],
                        option=option,
                    )
        walls: list[Part] = []
        openings: list[tuple[Any, int]] = []
        counts: dict[str, Counter[str]] = {"solid": Counter(), "free": Counter(), "left": Counter()}
        everything = len(self.parts)
        for part in self.parts:
            first = part.layers[0]
            if _matches(part.layers, options.free):
                openings.append((part.shape, everything))
                counts["free"][first] += 1
            elif options.layer and not _matches(part.layers, options.layer):
                counts["left"][first] += 1
            elif part.is_free:
                openings.append((part.shape, len(walls)))
                counts["free"][first] += 1
            else:
                walls.append(part)
                counts["solid"][first] += 1
        return walls, openings, list(_layer_notes(counts, options))


def _layer_notes(counts: dict[str, Counter[str]], options: DrawingOptions) -> Iterable[Any]:
    words = {name: _listed(counted) for name, counted in counts.items()}
    yield Note(
        "walls-are",
        "walls: {solid}; free: {free}",
        "--layer names the walls, and --free what robots may drive through",
        at_terminal=True,
        solid=words["solid"],
        free=words["free"],
    )
    if counts["left"]:
        yield f"neither, as --layer does not name it: {words['left']}"


@contextmanager
def geometry_errors() -> Iterator[None]:
    """Turn the errors of shapely, which come from damaged shapes only, into errors of the file."""
    try:
        yield
    except shapely.errors.ShapelyError as error:
        raise FormatError(
            "damaged-file",
            "has a shape that cannot be computed: {reason}",
            "simplify its outlines, or name the layers of walls with --layer",
            at_terminal=True,
            reason=" ".join(str(error).split())[:80],
        ) from error


def _listed(counted: Counter[str]) -> str:
    names = [f"{quote(name)} ({count})" for name, count in counted.most_common(_MOST_LISTED)]
    more = len(counted) - len(names)
    return (", ".join(names) or "nothing") + (f" and {more} more layers" if more else "")


def _patterns(text: str) -> list[str]:
    return [word.strip().lower() for word in text.split(",") if word.strip()]


def _matches(layers: Iterable[str], patterns: str) -> bool:
    wanted = _patterns(patterns)
    return any(fnmatch.fnmatchcase(name.lower(), one) for one in wanted for name in layers)


def is_layer(name: str, options: DrawingOptions) -> bool:
    """Return True if a user names a layer as walls or as openings."""
    return _matches((name,), options.layer) or _matches((name,), options.free)


def _is_chosen(layers: Sequence[str], patterns: str) -> bool:
    return not patterns or _matches(layers, patterns)


def parse_unit(text: str) -> float:
    """Return the length of a unit, m: of a name such as mm, or a number of metres.

    Raises:
        InvalidParameter: If it is neither.
    """
    word = text.strip().lower()
    try:
        value = UNITS[word] if word in UNITS else float(word)
    except ValueError:
        value = math.nan
    if not 1e-9 <= value <= 1e9:
        raise InvalidParameter(
            "wrong-form",
            "unit={text!q} is neither a unit nor a length in m",
            "use one of {known!l}, or a number of metres such as 0.05",
            text=text[:40],
            known=list(UNITS),
        )
    return value


def too_large() -> FormatError:
    """Return the error about a drawing of too many shapes."""
    return FormatError(
        "too-large",
        "has more than {parts:,} shapes, or {points:,} corners, once its copies are drawn",
        "export only the walls",
        parts=_MOST_PARTS,
        points=_MOST_POINTS,
    )


def _outlined(shape: Any, options: DrawingOptions) -> Any:
    return shape.boundary if options.outlines and shape.area > 0 else shape


def _thick(shape: Any, half: float) -> Any:
    """Return a shape whose lines have a thickness."""
    if half == 0.0 or shapely.get_dimensions(shape) != 1:
        return shape
    check_crossings([shape])
    return shapely.buffer(shape, half, cap_style="flat", join_style="mitre")


def _opened(walls: list[Any], openings: list[tuple[Any, int]], width: float) -> list[Any]:
    """Return the walls without the area of openings that were drawn after them."""
    if not openings or not walls:
        return walls
    tree = shapely.STRtree(walls)
    erased = 0
    for opening, below in openings:
        # An opening that is a line has to be wider than the wall that it opens.
        is_line = shapely.get_dimensions(opening) < 2
        area = shapely.buffer(opening, width, cap_style="flat") if is_line else opening
        shapely.prepare(area)
        hit = [index for index in tree.query(area, "intersects").tolist() if index < below]
        erased += len(hit)
        if erased > _MOST_ERASED:
            raise too_large()
        for index in hit:
            walls[index] = shapely.difference(walls[index], area)
    return [wall for wall in walls if not wall.is_empty]


def finite(points: Floats) -> Floats:
    """Return points, (n, 2), after checking that each is a number.

    Raises:
        FormatError: If one is not.
    """
    # This is also false for what is not a number.
    if not (np.abs(points) < _FARTHEST).all():
        raise FormatError(
            "not-a-number",
            "a shape has a coordinate that is not a number, or is beyond {farthest:g}",
            "delete the shape",
            farthest=_FARTHEST,
        )
    return points


def check_crossings(lines: Iterable[Any]) -> None:
    """Refuse lines whose corners cross far too often, because crossings grow with their square.

    Raises:
        FormatError: If there are more than some hundred thousand.
    """
    corners = shapely.get_coordinates(np.array(list(lines), object))
    if len(corners) <= _FEW:
        return
    if len(corners) > _MOST_CORNERS:
        raise too_large()
    ends = np.stack([corners[:-1], corners[1:]], axis=1)
    boxes = shapely.box(
        ends[..., 0].min(axis=1), ends[..., 1].min(axis=1),
        ends[..., 0].max(axis=1), ends[..., 1].max(axis=1),
    )  # fmt: skip
    tree = shapely.STRtree(boxes)
    meetings = 0
    # A few at a time, because each may meet all others.
    for at in range(0, len(boxes), _BOXES):
        meetings += tree.query(boxes[at : at + _BOXES]).shape[1]
        if meetings > _MOST_MEETINGS + 8 * at:
            raise FormatError(
                "crosses-itself",
                "a shape of {corners:,} corners crosses itself too often",
                "draw it as several",
                corners=len(corners),
            )


def filled(rings: Sequence[Floats], *, even_odd: bool) -> Any:
    """Return the area that rings enclose.

    Args:
        rings: (n, 2) corners of each, open or closed.
        even_odd: True if an area in an even number of rings is outside, as in a hatch; otherwise
            rings that run in opposite directions cancel each other (SVG's nonzero).

    Raises:
        FormatError: If they cross too often.
    """
    closed = [_distinct(finite(np.vstack([ring, ring[:1]]))) for ring in rings if len(ring) > 2]
    closed = [ring for ring in closed if len(ring) > 3]
    if not closed:
        return None
    if len(closed) == 1 and len(closed[0]) < 10_000:
        check_crossings([shapely.LineString(closed[0])])
        plain = shapely.Polygon(closed[0])
        if plain.is_valid:
            return plain
    lines = [shapely.LineString(ring) for ring in closed]
    check_crossings(lines)
    faces = shapely.get_parts(shapely.polygonize([shapely.union_all(lines)]))
    if not len(faces):
        return None
    points = shapely.get_coordinates(shapely.point_on_surface(faces))
    edges = np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in closed])
    if len(points) * len(edges) > 400_000_000:
        raise too_large()
    turns = np.concatenate([_windings(some, edges) for some in _chunks(points, len(edges))])
    inside = turns % 2 != 0 if even_odd else turns != 0
    return shapely.union_all(faces[inside]) if inside.any() else None


def _distinct(line: Floats) -> Floats:
    """Return a line without corners that repeat the one before."""
    keep = np.ones(len(line), np.bool_)
    keep[1:] = (line[1:] != line[:-1]).any(axis=1)
    return line[keep]


def _chunks(points: Floats, width: int) -> list[Floats]:
    return np.array_split(points, max(1, len(points) * width // 2_000_000))


def _windings(points: Floats, edges: Floats) -> Any:
    """Return how often closed rings, (m, 4) edges, go around each of (n, 2) points."""
    x, y = points[:, :1], points[:, 1:]
    ax, ay, bx, by = edges.T
    side = (bx - ax) * (y - ay) - (x - ax) * (by - ay)
    upwards = (ay <= y) & (by > y) & (side > 0)
    downwards = (ay > y) & (by <= y) & (side < 0)
    return upwards.sum(axis=1) - downwards.sum(axis=1)


def arc_points(
    centre: tuple[float, float], radii: tuple[float, float], tilt: float, begin: float, turn: float
) -> Floats:
    """Return points of an elliptic arc, (n, 2).

    Args:
        centre: Its centre.
        radii: Along its own two axes.
        tilt: Direction of the first axis, rad.
        begin: Where it begins, rad from the first axis.
        turn: How far it goes, rad, counter-clockwise if positive.
    """
    count = max(2, math.ceil(abs(turn) / math.tau * TURN) + 1)
    angles = begin + turn * np.linspace(0.0, 1.0, count)
    x, y = radii[0] * np.cos(angles), radii[1] * np.sin(angles)
    cos, sin = math.cos(tilt), math.sin(tilt)
    return np.stack([centre[0] + x * cos - y * sin, centre[1] + x * sin + y * cos], axis=1)
