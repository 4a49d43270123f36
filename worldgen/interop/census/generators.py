"""Take maps from a third-party generator, through a function that yields them one by one.

The function takes ``seed`` and any options of its own as keywords. For each map it yields a tuple:
a name, the walls, and, if the generator has them, the cells of start and target. ``walls`` is a 2D
array, True (or 1) where solid; row 0 is the top row, as it would be printed, and a cell is (row,
column) in it. A generator that works in metres yields a :class:`worldgen.interop.census.CensusMap`
instead.
"""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from worldgen.domain import CELL_SIZES
from worldgen.errors import FormatError, InvalidParameter
from worldgen.family import check_between
from worldgen.interop.census.case import CensusMap, Ends, Refused, cell_ends
from worldgen.interop.format.foreign_map import check_sides
from worldgen.plugins.registry import Registry, user_code
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value

_END = object()
_KINDS = {bool: "yes or no", int: "a whole number", float: "a number"}
_TRUE = ("1", "true", "yes")
_FALSE = ("0", "false", "no")


def _accept(name: str, thing: Any) -> Callable[..., Any]:
    if not callable(thing):
        raise InvalidParameter(
            "wrong-type",
            "generator {name!r} is a {kind}",
            "name a function that yields maps",
            name=name,
            kind=type(thing).__name__,
        )
    return thing  # type: ignore[no-any-return]


GENERATORS: Registry[Callable[..., Any]] = Registry("worldgen.map_generators", "generator", _accept)


@dataclass(frozen=True)
class GeneratedMaps:
    """Maps that the generator makes as the caller iterates.

    Args:
        name: Name of the function, as the user gave it.
        function: The function itself.
        count: Number of maps to take.
        seed: Passed to the function.
        options: More keywords to pass to the function.
        cell_size: Side of a cell, m, of maps without units.
    """

    name: str
    function: Callable[..., Any]
    count: int
    seed: int
    options: Mapping[str, Value]
    cell_size: float = DEFAULT_CELL_SIZE

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[CensusMap | Refused]:
        with user_code(f"generator {self.name!r}"):
            maps = iter(self.function(seed=self.seed, **self.options))
        for index in itertools.count():
            if index == self.count:
                return
            with user_code(f"generator {self.name!r}, map {index + 1}"):
                item = next(maps, _END)
            if item is _END:
                return
            yield self._judgeable(item, index)

    def _judgeable(self, item: Any, index: int) -> CensusMap | Refused:
        name = f"map {index + 1}"
        try:
            # A generator that works in metres yields complete maps.
            if isinstance(item, CensusMap):
                name = str(item.name)
                if not isinstance(item.cell_size, int | float):
                    raise InvalidParameter(
                        "not-a-number",
                        "cell_size={cell_size!r} is not a number",
                        "set the side of a cell in m",
                        cell_size=item.cell_size,
                    )
                check_between("cell_size", item.cell_size, *CELL_SIZES, "m")
                return replace(item, name=name, walls=_walls(item.walls))
            if (
                not isinstance(item, tuple)
                or len(item) not in (2, 4)
                or not isinstance(item[0], str)
            ):
                raise InvalidParameter(
                    "wrong-type",
                    "a {kind} was yielded",
                    "yield (name, walls) or (name, walls, start, target)",
                    kind=type(item).__name__,
                )
            # Any other yields a name, walls, and perhaps both ends.
            name = item[0]
            walls = _walls(item[1])
            ends: tuple[Ends, ...] = ()
            if len(item) == 4:
                start = _cell("start", item[2], walls)
                target = _cell("target", item[3], walls)
                ends = (cell_ends(start, target, self.cell_size),)
            params: dict[str, Value] = {"generator": self.name, "number": index, **self.options}
            return CensusMap(name, flip_rows(walls), self.cell_size, ends, params)
        except (InvalidParameter, FormatError) as error:
            return Refused(name, str(error))


def generated_maps(
    name: str,
    *,
    count: int,
    seed: int,
    options: Mapping[str, str] | None = None,
    cell_size: float = DEFAULT_CELL_SIZE,
) -> GeneratedMaps:
    """Return the first maps of a generator.

    Args:
        name: ``./file.py:function`` or ``package.module:function``.
        count: Number of maps to take.
        seed: Passed to the function.
        options: More keywords of the function, as text; each is converted to its default's type.
        cell_size: Side of a cell, m, of maps without units.

    Raises:
        InvalidParameter: If the function does not exist, takes no ``seed``, or lacks one of the
            options.
    """
    function = GENERATORS.get(name)
    try:
        known = inspect.signature(function).parameters
    except (TypeError, ValueError) as error:
        raise InvalidParameter(
            "no-signature",
            "the parameters of generator {name!r} cannot be determined",
            "wrap it in a function",
            name=name,
        ) from error
    if "seed" not in known:
        raise InvalidParameter(
            "no-seed-parameter",
            "generator {name!r} takes no seed",
            "write it as def maps(seed): ... yield name, walls",
            name=name,
        )
    defaults = {key: given.default for key, given in known.items() if key != "seed"}
    return GeneratedMaps(
        name, function, count, seed, _converted(name, options or {}, defaults), cell_size
    )


def _converted(
    name: str, options: Mapping[str, str], defaults: Mapping[str, Any]
) -> dict[str, Value]:
    found: dict[str, Value] = {}
    # Convert each text to the type of the option's default.
    for key, text in options.items():
        if key not in defaults:
            raise InvalidParameter(
                "unknown-name",
                "generator {name!r} has no option {option!r}",
                "it has {known!l:none}",
                name=name,
                option=key,
                known=list(defaults),
            )
        default = defaults[key]
        try:
            if isinstance(default, bool):
                if text.lower() not in _TRUE + _FALSE:
                    raise ValueError
                found[key] = text.lower() in _TRUE
            else:
                found[key] = type(default)(text) if isinstance(default, int | float) else text
        except ValueError as error:
            kind = _KINDS[type(default)]
            raise InvalidParameter(
                "wrong-type",
                "option {option}={text!r} is not {kind}",
                "use one such as {default}",
                option=key,
                text=text[:40],
                kind=kind,
                default=default,
            ) from error
    return found


def _walls(given: Any) -> Bools:
    try:
        array = np.asarray(given)
    except ValueError:
        array = np.empty(0)
    if array.ndim != 2 or array.dtype.kind not in "biu":
        raise InvalidParameter(
            "wrong-shape",
            "the walls have shape {shape} and type {dtype}",
            "they must be a two-dimensional bool array, True where solid",
            shape=array.shape,
            dtype=str(array.dtype),
        )
    if array.dtype.kind != "b" and ((array != 0) & (array != 1)).any():
        raise InvalidParameter(
            "wrong-values", "the walls have values other than 0 and 1", "yield walls == WALL"
        )
    check_sides(array.shape[1], array.shape[0])
    return array.astype(np.bool_)


def _cell(what: str, cell: Any, walls: Bools) -> tuple[int, int]:
    """Convert a cell given as (row, column) from the top to column and row from below."""
    try:
        row, column = (int(value) for value in cell)
    except (TypeError, ValueError) as error:
        raise InvalidParameter(
            "wrong-form",
            "{what} {cell} is not a cell",
            "it is (row, column), row 0 the top",
            what=what,
            cell=str(cell)[:40],
        ) from error
    height, width = walls.shape
    if not (0 <= row < height and 0 <= column < width):
        raise InvalidParameter(
            "outside-grid",
            "{what} ({row}, {column}) is outside the {height} rows and {width} columns",
            what=what,
            row=row,
            column=column,
            height=height,
            width=width,
        )
    return column, height - 1 - row
