"""Create pieces from families, worlds, files, drawings and rectangles."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from os import PathLike
from pathlib import Path

import numpy as np
import numpy.typing as npt

from worldgen.compose.marks import START, TARGET, Mark, frozen, marks_of
from worldgen.compose.piece import Piece
from worldgen.compose.sizes import check_size, whole
from worldgen.compose.world import kind_of
from worldgen.domain import MAX_SIDE
from worldgen.errors import FormatError, InvalidParameter
from worldgen.family import FAMILIES, Family
from worldgen.generation import generate
from worldgen.interop.recognising import read_map
from worldgen.lattice import in_cells
from worldgen.random_streams import RandomStream
from worldgen.reach.decision import unread_reason
from worldgen.support.rows import flip_rows
from worldgen.world import Value, World

_SIGNS = {"#": True, ".": False, "S": False, "G": False}
_NOTHING = "_"
_HALF = Fraction(1, 2)


def of_world(world: World) -> Piece:
    """Create a piece from a world's cells, start, target, timeline and robot."""
    return Piece(
        world.walls,
        np.ones_like(world.walls),
        marks=marks_of(world),
        timeline=world.timeline,
        cell_size=world.cell_size,
        robot_radius=world.robot_radius,
        robot_speed=world.robot_speed,
        robot=kind_of(world.robots[0]),
    )


def of_cells(solid: npt.ArrayLike) -> Piece:
    """Create a piece from an array of cells.

    Args:
        solid: (height, width) bool, True is solid; row 0 is the lowest y.

    Raises:
        InvalidParameter: If the array has another shape, or too many cells.
    """
    cells = np.array(solid, dtype=np.bool_)
    return Piece(cells, np.ones_like(cells))


def of_family(name: str | Family, seed: int | RandomStream = 0, **params: Value) -> Piece:
    """Create a piece from a family's world.

    Args:
        name: A family, or its name.
        seed: A seed gives the same world as ``generate``. A stream gives a layout that
            is drawn from the stream, without a proof.
        **params: Parameters of the family.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, or a value is out of range.
        GenerationFailed: If the family finds no solvable world for this seed.
    """
    if isinstance(seed, RandomStream):
        made_by = name if isinstance(name, Family) else FAMILIES.get(name)
        # A piece is a map with one start and one target; the world as a whole has the robots.
        complete = made_by.complete({**params, "robots": 1})
        return of_world(made_by.build(seed, **complete))
    return of_world(generate(name, seed, **params))


def read(path: str | PathLike[str]) -> Piece:
    """Read a map file of any format that ``worldgen import`` accepts.

    The piece also has the file's marks, timeline and robot, if the format stores them.

    Raises:
        FormatError: If the file cannot be read, or breaks its format's rules.
    """
    found = read_map(Path(path))
    if found.unread:
        raise FormatError(
            "part-not-read",
            "{reason}, so no world can be made of it",
            "if it cannot, import the map with --ignore-unread, and use that .grid file",
            at_terminal=True,
            reason=unread_reason(found.unread),
            source=str(path),
        )
    if found.world is not None:
        return of_world(found.world)
    marks: dict[str, Mark] = {}
    if found.robot.target is not None:
        x, y, *radius = (in_cells(value, found.cell_size) for value in found.robot.target)
        marks[TARGET] = Mark(x, y, radius=radius[0] if radius else _HALF)
    return Piece(found.walls, np.ones_like(found.walls), frozen(marks), cell_size=found.cell_size)


def drawn(rows: str | Sequence[str]) -> Piece:
    """Create a piece from a drawing made of characters, top row first.

    Args:
        rows: Lines of equal length, or one text that contains them. ``#`` is solid, ``.`` is free
            and ``_`` is undefined. ``S`` and ``G`` mark start and target, small letters other
            marks; each is the centre of a free cell.

    Raises:
        InvalidParameter: If the lines differ in length, a character is unknown, or a mark occurs
            twice.
    """
    lines = rows.strip("\n").split("\n") if isinstance(rows, str) else list(rows)
    lines = [line.rstrip("\r") for line in lines]
    if not lines or not lines[0]:
        raise InvalidParameter("empty", "a drawing has no cells", "draw rows of # and .")
    check_size("a drawing", max(len(line) for line in lines), len(lines))
    marks: dict[str, Mark] = {}
    solid = np.zeros((len(lines), len(lines[0])), dtype=np.bool_)
    mask = np.ones_like(solid)
    for number, line in enumerate(lines, start=1):
        if len(line) != len(lines[0]):
            raise InvalidParameter(
                "ragged-rows",
                "row {row} of a drawing has {signs} signs, but the first has {width}",
                "make all equally long",
                row=number,
                signs=len(line),
                width=len(lines[0]),
            )
        solid[number - 1] = [sign == "#" for sign in line]
        mask[number - 1] = [sign != _NOTHING for sign in line]
        for column, sign in enumerate(line):
            if sign not in "#._":
                _note(marks, sign, number, column, len(lines))
    return Piece(flip_rows(solid), flip_rows(mask), frozen(marks))


def _note(marks: dict[str, Mark], sign: str, row: int, column: int, rows: int) -> None:
    """Add the mark for a character of a drawing."""
    if sign not in _SIGNS and not ("a" <= sign <= "z"):
        raise InvalidParameter(
            "unknown-sign",
            "row {row} of a drawing has {sign!r} at {column}",
            "use # solid, . free, _ nothing, S, G, a to z",
            row=row,
            sign=sign,
            column=column + 1,
        )
    name = {"S": START, "G": TARGET}.get(sign, sign)
    if name in marks:
        raise InvalidParameter(
            "twice",
            "row {row} of a drawing has a second {sign!r}; each mark can appear only once",
            row=row,
            sign=sign,
        )
    marks[name] = Mark(column + _HALF, rows - row + _HALF)


def rectangle(width: int, height: int, *, solid: bool = False) -> Piece:
    """Create a rectangle of cells that are all free or all solid.

    Raises:
        InvalidParameter: If the rectangle has no cells, or too many.
    """
    width, height = (whole(n, v, 1, MAX_SIDE) for n, v in (("width", width), ("height", height)))
    check_size("a rectangle", width, height)
    return of_cells(np.full((height, width), solid))
