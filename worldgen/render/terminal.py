"""Draw a world in the terminal: two cells per character with colours, or letters without."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import TextIO

import numpy as np

from worldgen.render.body_parts import BodyPose, outline
from worldgen.render.caption import facts
from worldgen.render.content import Changes
from worldgen.render.marks import MARKS, SPECIFICATION, hue, mix, rgb
from worldgen.render.overlay import Trail, Trails, each_trail
from worldgen.render.polyline import along, arc_length
from worldgen.support.arrays import Bools, Bytes, Floats
from worldgen.support.plain_text import Styled, shown
from worldgen.support.rows import flip_rows
from worldgen.world import JointWitness, Robot, Witness, World

# Limit on the rows of dots or letters; a taller world is scaled down.
MOST_ROWS = 100
# Approximate side, in dots, to which a smaller world is scaled up in colour.
SMALL = 60
# Columns, and lines, of the frame around a picture of letters.
_FRAME = 2
# Letters of the targets of robots 1 to 9, whose starts are digits.
_TARGETS = "ABCDEFGHI"
# Letters of the first waypoints of a single robot.
_NUMBERS = "123456789"
# Where each step of the signal ends if only 256 colours are available.
BLUE_ENDS = (0.15, 0.35, 0.60, 0.80)

# The meaning of a dot; a higher number hides a lower one.
FREE, PARTLY, SOLID, CLOSES, BURNS, WITNESS, WAY, LOOPS, START_DOT, TARGET_DOT, TUNNELS = range(11)
# Only where a cell is solid.
OPENS = 11
NAMED_CELL = 12


@dataclass(frozen=True, slots=True)
class Sign:
    """A dot's letter without colours, its colour, and its word in the key."""

    letter: str
    colour: str
    word: str = ""


SIGNS = {
    FREE: Sign(".", hue("floor")),
    PARTLY: Sign("%", mix(hue("floor"), hue("wall"), 0.6), "partly solid"),
    SOLID: Sign("#", hue("wall")),
    CLOSES: Sign("x", mix(hue("floor"), hue("quiet"), 0.6), "closes later"),
    BURNS: Sign("^", mix(hue("floor"), hue("fire"), 0.7), "burns"),
    OPENS: Sign("-", hue("quiet"), "opens later"),
    WITNESS: Sign(",", mix(hue("floor"), hue("start"), 0.6), "a path that fits"),
    WAY: Sign("*", mix(hue("floor"), hue("loop"), MARKS["approach"].fade[-1]), "trail"),
    LOOPS: Sign("o", hue("loop"), "loop"),
    START_DOT: Sign("S", hue("start"), "start"),
    TARGET_DOT: Sign("G", hue("target"), "target"),
    TUNNELS: Sign("!", hue("breach"), "through a wall"),
    NAMED_CELL: Sign("?", hue("named"), "cell named in the text"),
}

# Order of the entries in the key.
_IN_KEY = (
    START_DOT, TARGET_DOT, WITNESS, WAY, LOOPS, TUNNELS, NAMED_CELL, PARTLY, CLOSES, OPENS, BURNS,
)  # fmt: skip


def wants_color(stream: TextIO) -> bool:
    """Return True if a stream is a terminal that shows colours and half blocks.

    It obeys NO_COLOR, FORCE_COLOR and TERM=dumb.
    """
    try:
        "\u2580".encode(getattr(stream, "encoding", None) or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def draw_terminal(
    world: World,
    *,
    trail: Trails = None,
    width: int | None = None,
    color: bool = True,
    truecolor: bool | None = None,
) -> Styled:
    """Return a world, and a run in it, as lines of text.

    Without colours one character is one cell, as in a ``.grid`` file, with a frame around a world
    whose outermost cells are not all solid; up to nine robots are numbered. With colours a
    character is two dots, one above the other, and a small world gets several dots per cell. A
    world too large for the terminal is scaled down; then a dot is several cells, and shows a wall
    if any of them is solid.

    Args:
        world: What to draw.
        trail: A robot's trail; for several robots, one trail for each.
        width: Columns to use; the terminal's width if omitted.
        color: True for half-block characters with ANSI colours, False for plain ASCII.
        truecolor: True for 24-bit colours instead of 256; taken from COLORTERM if omitted.

    Returns:
        The picture, a key to its signs, and its scale; ends with a line end.
    """
    columns = max(8, shutil.get_terminal_size((80, 24)).columns if width is None else width)
    has_frame = not color and not _is_walled(world)
    edges = _FRAME if has_frame else 0
    grid = _Grid.of(world, columns - edges, MOST_ROWS - edges, color=color)
    dots = grid.dots(world, each_trail(trail))
    deep = os.environ.get("COLORTERM") in {"truecolor", "24bit"} if truecolor is None else truecolor
    lines = (
        _half_blocks(_colours(dots, grid, world, deep=deep), deep=deep)
        if color
        else _letters(dots, grid, world)
    )
    if has_frame:
        lines = _framed(lines)
    robots = _robots_with_signs(world, color=color)
    # A start or a target may be hidden by another one.
    drawn = set("".join(lines)) if robots else set()
    own: dict[int, str] = {}
    if robots:
        own = {
            START_DOT: f"{_span(_NUMBERS, drawn)} starts",
            TARGET_DOT: f"{_span(_TARGETS, drawn)} their targets",
        }
    elif not color and not world.is_fleet and world.robots[0].waypoints:
        numbers = _NUMBERS[: len(world.robots[0].waypoints)]
        own = {TARGET_DOT: f"G target  {_span(numbers, numbers)} waypoints"}
    key = _key(dots, own, color=color, deep=deep)
    scale = (
        f"; 1 character is {grid.cells} x {grid.cells * (2 if color else 1)} cells"
        if grid.cells > 1
        else ""
    )
    origin = "; cell (0, 0) is at the bottom left"
    return Styled("\n".join([*lines, key, shown(facts(world)) + origin + scale, ""]))


def _is_walled(world: World) -> bool:
    walls = world.walls
    return bool(walls[[0, -1]].all() and walls[:, [0, -1]].all())


def _robots_with_signs(world: World, *, color: bool) -> int:
    """Return the number of robots whose starts and targets have their own signs; 0 for one sign."""
    count = len(world.robots)
    return count if not color and 1 < count <= len(_TARGETS) else 0


def _letters(dots: Bytes, grid: _Grid, world: World) -> list[str]:
    """Return the rows of a picture without colours, the highest first."""
    letters = np.array([SIGNS[sign].letter for sign in range(len(SIGNS))])[dots]
    count = _robots_with_signs(world, color=False)
    # Where signs share a dot, keep the one that is on top.
    for number, robot in enumerate(world.robots[:count], 1):
        for pose, sign, letter in (
            (robot.target, TARGET_DOT, _TARGETS[number - 1]),
            (robot.start, START_DOT, str(number)),
        ):
            place = grid.place(dots, pose.x, pose.y)
            if dots[place] == sign:
                letters[place] = letter
    if not world.is_fleet:
        for goal, letter in zip(world.robots[0].waypoints, _NUMBERS, strict=False):
            letters[grid.place(dots, goal.x, goal.y)] = letter
    return ["".join(row) for row in flip_rows(letters)]


def _framed(rows: Sequence[str]) -> list[str]:
    edge = f"+{'-' * len(rows[0])}+"
    return [edge, *(f"|{row}|" for row in rows), edge]


@dataclass(frozen=True, slots=True)
class _Grid:
    """The dots of a picture.

    Each covers ``cells`` cells per side, or each cell covers ``dots_per_cell`` dots.
    """

    cells: int
    dots_per_cell: int
    # Side of a dot, m.
    dot_size: float

    @classmethod
    def of(cls, world: World, columns: int, lines: int, *, color: bool) -> _Grid:
        rows = lines * (2 if color else 1)
        cells = max(1, math.ceil(world.width / columns), math.ceil(world.height / rows))
        fine = 1
        if color and cells == 1:
            fine = max(1, min(columns // world.width, SMALL // max(world.width, world.height)))
        return cls(cells, fine, world.cell_size * cells / fine)

    def shrunk(self, mask: Bools) -> Floats:
        """Return a (rows, columns) float64 array: the share of each dot's cells that are set."""
        if self.cells == 1:
            return (
                mask.repeat(self.dots_per_cell, 0).repeat(self.dots_per_cell, 1).astype(np.float64)
            )
        starts = [np.arange(0, side, self.cells) for side in mask.shape]
        sums = np.add.reduceat(mask, starts[0], axis=0, dtype=np.float64)
        sums = np.add.reduceat(sums, starts[1], axis=1)
        sizes = [
            np.diff(np.append(first, side)) for first, side in zip(starts, mask.shape, strict=True)
        ]
        return np.asarray(sums / np.outer(*sizes), np.float64)

    def dots(self, world: World, trails: Sequence[Trail]) -> Bytes:
        """Return a (rows, columns) uint8 array: the meaning of each dot, row 0 the lowest."""
        solid = self.shrunk(world.walls)
        dots = np.where(solid >= 1.0, SOLID, np.where(solid > 0.0, PARTLY, FREE)).astype(np.uint8)
        if world.is_dynamic:
            changes = Changes.of(world)
            for mask, sign in (
                # Later signs are drawn on top: burning cells cover those that open and close.
                (changes.closes, CLOSES),
                (changes.opens, OPENS),
                (changes.burns, BURNS),
            ):
                dots[self.shrunk(mask) > 0.0] = sign
        # Paths above the map, then target and start above the paths.
        for trail in trails:
            self._line(dots, trail.approach, WAY)
        for trail in trails:
            self._line(dots, trail.loop, LOOPS)
        # Without a run, show the paths that fit.
        if not trails and self.dots_per_cell > 1:
            proof = world.certificate
            paths = proof.paths if isinstance(proof, JointWitness) else (proof,)
            for path in paths:
                if isinstance(path, Witness):
                    self._line(dots, np.column_stack((path.x, path.y)), WITNESS)
        for robot in world.robots:
            for goal in robot.goals:
                self._disc(dots, goal.x, goal.y, goal.radius, TARGET_DOT)
        for robot in world.robots:
            if robot.is_disc:
                self._disc(dots, robot.start.x, robot.start.y, robot.radius, START_DOT)
            else:
                self._body(dots, robot, START_DOT)
        for trail in trails:
            for x, y in trail.places("tunnel"):
                dots[self.place(dots, x, y)] = TUNNELS
            for ix, iy in trail.named:
                self._cell(dots, world, ix, iy, NAMED_CELL)
        return dots

    def place(self, dots: Bytes, x: float, y: float) -> tuple[int, int]:
        """Return the row and column of the dot at a point, or of the nearest one."""
        rows, columns = dots.shape
        row = math.floor(y / self.dot_size)
        column = math.floor(x / self.dot_size)
        return min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)

    def _cell(self, dots: Bytes, world: World, ix: int, iy: int, sign: int) -> None:
        """Fill a cell, or mark the dot that shows it."""
        if self.dots_per_cell > 1:
            side = self.dots_per_cell
            dots[iy * side : (iy + 1) * side, ix * side : (ix + 1) * side] = sign
        else:
            size = world.cell_size
            dots[self.place(dots, (ix + 0.5) * size, (iy + 0.5) * size)] = sign

    def _line(self, dots: Bytes, points: Floats, sign: int) -> None:
        if not len(points):
            return
        total = float(arc_length(points)[-1])
        count = min(4 * dots.size, math.ceil(3.0 * total / self.dot_size) + 1)
        samples = np.concatenate((points, along(points, np.linspace(0.0, total, count))))
        spots = np.floor(samples / self.dot_size).astype(np.int64)
        rows, columns = dots.shape
        dots[np.clip(spots[:, 1], 0, rows - 1), np.clip(spots[:, 0], 0, columns - 1)] = sign

    def _body(self, dots: Bytes, robot: Robot, sign: int) -> None:
        """Fill the polygon of a robot at its start; its axle is always shown."""
        rows, columns = dots.shape
        start = robot.start
        if self.dots_per_cell > 1:
            x = ((np.arange(columns) + 0.5) * self.dot_size)[None, :]
            y = ((np.arange(rows) + 0.5) * self.dot_size)[:, None]
            corners = outline(robot, BodyPose(start.x, start.y, start.heading))
            inside = np.ones(dots.shape, np.bool_)
            for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                inside &= (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
            dots[inside] = sign
        dots[self.place(dots, start.x, start.y)] = sign

    def _disc(self, dots: Bytes, x: float, y: float, radius: float, sign: int) -> None:
        rows, columns = dots.shape
        if self.dots_per_cell > 1:
            dx = (np.arange(columns) + 0.5) * self.dot_size - x
            dy = (np.arange(rows) + 0.5) * self.dot_size - y
            dots[(dx * dx + (dy * dy)[:, None] <= radius * radius)] = sign
        dots[self.place(dots, x, y)] = sign


def _colours(dots: Bytes, grid: _Grid, world: World, *, deep: bool) -> Bytes:
    """Return a (rows, columns, 3) uint8 array of colours.

    The floor is tinted by the signal; everything else has its sign's colour.
    """
    rows, columns = dots.shape
    table = np.array([rgb(SIGNS[sign].colour) for sign in range(len(SIGNS))], np.uint8)
    colours = table[dots]
    x = (np.arange(columns) + 0.5) * grid.dot_size - world.target.x
    y = (np.arange(rows) + 0.5) * grid.dot_size - world.target.y
    # The tint follows the logarithm of the distance, so it is visible next to the target.
    square = np.maximum(x * x + (y * y)[:, None], world.target.radius**2)
    ratio = np.log(square / world.target.radius**2)
    share = ratio / max(float(ratio.max()), 1e-9)
    if deep:
        tint = np.array(rgb(MARKS["signal"].full_tint), np.float64)
        floor = np.rint(tint + share[:, :, None] * (np.array(rgb(hue("floor"))) - tint)).astype(
            np.uint8
        )
    else:
        floor = np.array([rgb(blue) for blue in SPECIFICATION.blues], np.uint8)[
            np.searchsorted(BLUE_ENDS, share)
        ]
    free = dots == FREE
    colours[free] = floor[free]
    part = dots == PARTLY
    solid = (0.35 + 0.65 * grid.shrunk(world.walls))[:, :, None]
    shade = np.rint(floor + solid * (np.array(rgb(hue("wall"))) - floor)).astype(np.uint8)
    colours[part] = shade[part]
    return colours


def _half_blocks(colours: Bytes, *, deep: bool) -> list[str]:
    top_first = flip_rows(colours).tolist()
    # An odd number of rows leaves the last half block without a lower half.
    if len(top_first) % 2:
        top_first.append([None] * len(top_first[0]))
    lines = []
    for upper, lower in zip(top_first[::2], top_first[1::2], strict=True):
        words: list[str] = []
        last = None
        for pair in zip(upper, lower, strict=True):
            # Escape codes are written only where the colour changes, because they are most of the
            # text.
            if pair != last:
                over, under = pair
                words.append(
                    _ansi(over, 38, deep=deep)
                    + (_ansi(under, 48, deep=deep) if under else "\x1b[49m")
                )
                last = pair
            words.append("\u2580")
        lines.append("".join(words) + "\x1b[0m")
    return lines


def _ansi(colour: list[int], layer: int, *, deep: bool) -> str:
    if deep:
        red, green, blue = colour
        return f"\x1b[{layer};2;{red};{green};{blue}m"
    return f"\x1b[{layer};5;{_xterm(colour)}m"


# xterm's 6 x 6 x 6 cube, followed by 24 greys.
LEVELS = (0, 95, 135, 175, 215, 255)


def _xterm(colour: list[int]) -> int:
    """Return the nearest of xterm's 240 fixed colours."""
    steps = [min(range(6), key=lambda k, c=channel: abs(LEVELS[k] - c)) for channel in colour]  # type: ignore[misc]
    grey = min(max(round((sum(colour) / 3 - 8) / 10), 0), 23)
    off_cube = sum(
        (LEVELS[step] - channel) ** 2 for step, channel in zip(steps, colour, strict=True)
    )
    off_grey = sum((8 + 10 * grey - channel) ** 2 for channel in colour)
    return 232 + grey if off_grey < off_cube else 16 + 36 * steps[0] + 6 * steps[1] + steps[2]


def _span(letters: str, drawn: Container[str]) -> str:
    """Return the letters that are drawn: ``A-C``, or ``A C`` if one between is not."""
    found = "".join(letter for letter in letters if letter in drawn)
    return f"{found[0]}-{found[-1]}" if found in letters and len(found) > 1 else " ".join(found)


def _key(dots: Bytes, own: Mapping[int, str], *, color: bool, deep: bool) -> str:
    """Return what the signs mean.

    Args:
        dots: The picture.
        own: Entries of signs that several robots have instead of the usual ones.
        color: True if the signs are colours.
        deep: True for 24-bit colours.
    """
    words = []
    for sign in _IN_KEY:
        if (dots == sign).any():
            if sign in own:
                words.append(own[sign])
                continue
            drawn = SIGNS[sign]
            swatch = (
                f"{_ansi(list(rgb(drawn.colour)), 38, deep=deep)}\u2588\x1b[0m"
                if color
                else drawn.letter
            )
            words.append(f"{swatch} {drawn.word}")
    return "  ".join(words)
