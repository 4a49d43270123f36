"""A controller's memory as the page draws it: named numbers by row, and a map that changes.

The map is a list of shapes, each with the first and last step in which it exists. A map that grows
is therefore stored only once, and drawing a step only takes one comparison per shape.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzz.player.streams import MOST, numbers
from sim.controllers.base import Controller
from sim.controllers.memory_view import MemoryField, MemoryMap, check_fields
from sim.trace import Trace
from worldgen.errors import InvalidParameter
from worldgen.lattice import UNIT
from worldgen.support.arrays import Floats, Ints

BLOCKED, CELL, PLAN, PLACE, NODE, EDGE, DEGREE = range(7)
"""Numbers of the kinds of shapes.

They are a blocked line, an occupied rectangle, part of the plan, a remembered point, a place of a
graph, an edge between two such places, and a rectangle with a degree.
"""

KINDS = ("blocked", "cell", "plan", "place", "node", "edge")
"""Their names in the page; the numbers after them are degrees."""

_SCALE = 1000  # a named number is shown to thousandths
# Times at which a map is read. If it changes more often, only every second change is used, or every
# fourth, and so on.
_MOST_MAPS = 400

Shape = tuple[int, int, int, int, int]
# Number of steps in which degrees are shown. The kinds from DEGREE on are rectangles, the worst
# first.
_DEGREES = 4


def drawn_memory(
    trace: Trace, controller: Controller, kept: Ints, rows: Ints, *, cell_size: float, most: int
) -> dict[str, Any] | None:
    """Return the memory of a recorded run; ``None`` if the controller does not describe it.

    Args:
        trace: The run.
        controller: The controller.
        kept: The steps that the page includes.
        rows: The step of each of the page's rows.
        cell_size: Size of a cell, m.
        most: Limit on shapes; a map that needs more is stored with fewer changes.

    Returns:
        ``fields``: each with ``name``, ``words``, ``least``, and ``values`` by row; ``one``: the
        value that stands for 1; ``missing``: the value that stands for no number. ``map``: columns
        ``kind`` (index into ``kinds``, or beyond them one of ``degrees``: how good a rectangle is),
        ``x0``, ``y0``, ``x1``, ``y1`` (parts of a cell as in the run; for a point ``x1`` is the
        number of its name; a place of a graph has the second pair 0), ``since`` and ``until``
        (steps), and ``names``; null if there is no map. ``fault``: why nothing can be shown, or "".
    """
    read = getattr(controller, "memory_map", None)
    fields = getattr(controller, "memory_fields", ())
    if not trace.memory_size or (read is None and not fields):
        return None
    # This calls the controller's own code. Only this picture depends on it, so any error is shown
    # instead of the memory.
    try:
        check_fields(type(controller).__name__, fields)
        watched = _Watched(trace, controller, fields, len(kept))
        trace.show_memory(kept, watched.take)
        shown = [
            watched.field(column, np.searchsorted(kept, rows)) for column in range(len(fields))
        ]
        drawn = None if read is None else _map(watched, read, trace.steps + 1, cell_size, most)
    except Exception as error:  # noqa: BLE001
        fault = f"its memory cannot be shown: {type(error).__name__}: {error}"[:300]
        return {"fields": [], "map": None, "fault": fault}
    return {"fields": shown, "one": _SCALE, "missing": MOST, "map": drawn, "fault": ""}


class _Watched:
    """A memory during a run: its named numbers, and its full contents at some map changes."""

    def __init__(
        self, trace: Trace, controller: Controller, fields: Sequence[MemoryField], rows: int
    ) -> None:
        for field in fields:
            if not 0 <= field.place < trace.memory_size:
                raise InvalidParameter(
                    "out-of-range",
                    "field {name!r} is number {place} of a memory of {memory_size}",
                    name=field.name,
                    place=field.place,
                    memory_size=trace.memory_size,
                )
        # Read the map only when a number that it depends on has changed.
        places = tuple(getattr(controller, "memory_map_on", ())) or range(trace.memory_size)
        self.fields = fields
        self.values = np.zeros((rows, len(fields)))
        self.at: list[int] = []
        self.memories: list[Floats] = []
        self._named = np.array([field.place for field in fields], np.int64)
        self._columns = np.array(places, np.int64)
        self._seen = np.zeros(0, np.int64)
        self._row = 0
        self._changes = 0
        self._each = 1
        self._reads = getattr(controller, "memory_map", None) is not None
        self._last: tuple[int, Floats] | None = None

    def take(self, step: int, memory: Floats) -> None:
        """Process the memory after a step."""
        self.values[self._row] = memory[self._named]
        self._row += 1
        now = memory.view(np.int64)[self._columns] if self._reads else self._seen
        if np.array_equal(now, self._seen):
            return
        self._seen = now
        self._last = (step, memory.copy())
        if self._changes % self._each == 0:
            self._keep(*self._last)
        self._changes += 1

    def _keep(self, step: int, memory: Floats) -> None:
        """Keep a memory; if there are too many, keep only every second one, past and future."""
        self.at.append(step)
        self.memories.append(memory)
        if len(self.at) == _MOST_MAPS:
            self.at = self.at[::2]
            self.memories = self.memories[::2]
            self._each = 2 * self._each

    def maps(self) -> list[tuple[int, Floats]]:
        """Return the memories kept, and the last one, whose map is the most complete."""
        found = list(zip(self.at, self.memories, strict=True))
        return (
            found if self._last is None or self._last[0] in self.at[-1:] else [*found, self._last]
        )

    def field(self, column: int, rows: Ints) -> dict[str, Any]:
        """Return a named number by row; values that are not finite become an impossible number."""
        name, _, words, least = self.fields[column]
        values = self.values[rows, column]
        whole = np.where(
            np.isfinite(values), np.rint(np.clip(values, -1e11, 1e11) * _SCALE), float(MOST)
        )
        return {"name": name, "words": list(words), "least": least, "values": numbers(whole)}


def _map(
    watched: _Watched, read: Callable[[Floats], MemoryMap], end: int, cell_size: float, most: int
) -> dict[str, Any] | None:
    """Return the shapes of a map with the steps between which they exist.

    ``None`` if the map is too large to draw.
    """
    names: dict[str, int] = {}
    maps = watched.maps()
    at = np.array([step for step, _ in maps], np.int64)
    seen = [_shapes(read(memory), cell_size, names) for _, memory in maps]
    # Drop every second map until there are few enough shapes. The last map is the most complete,
    # so it always stays.
    while True:
        lives = _lives(seen, at, end)
        if len(lives) <= most:
            break
        if len(seen) == 1:
            return None
        last = seen[-1], at[-1:]
        seen = [*seen[:-1:2], last[0]]
        at = np.concatenate((at[:-1:2], last[1]))
    columns = np.array(lives, np.int64).reshape(-1, 7).T
    keys = ("kind", "x0", "y0", "x1", "y1", "since", "until")
    return {
        **{key: numbers(column) for key, column in zip(keys, columns, strict=True)},
        "kinds": list(KINDS),
        "degrees": _DEGREES,
        "names": list(names),
    }


def _shapes(read: MemoryMap, cell_size: float, names: dict[str, int]) -> set[Shape]:
    """Return one map as shapes in lattice units."""
    plan = np.asarray(read.plan, np.float64).reshape(-1, 2)
    lines = (
        (BLOCKED, read.blocked),
        (CELL, read.cells),
        (PLAN, np.column_stack((plan[:-1], plan[1:]))),
        (EDGE, read.edges),
    )
    found: set[Shape] = set()
    for kind, ends in lines:
        units = _units(ends, 4, cell_size)
        found.update((kind, x0, y0, x1, y1) for x0, y0, x1, y1 in units.tolist())
    found.update((NODE, x, y, 0, 0) for x, y in _units(read.nodes, 2, cell_size).tolist())
    degrees = np.asarray(read.degrees, np.float64).reshape(-1, 5)
    steps = np.clip(np.floor(degrees[:, 4] * _DEGREES), 0, _DEGREES - 1).astype(np.int64)
    corners = _units(degrees[:, :4], 4, cell_size)
    found.update(
        (kind, x0, y0, x1, y1)
        for kind, (x0, y0, x1, y1) in zip((DEGREE + steps).tolist(), corners.tolist(), strict=True)
    )
    for name, place in read.places.items():
        x, y = (round(value / cell_size * UNIT) for value in place)
        found.add((PLACE, x, y, names.setdefault(name, len(names)), 0))
    return found


def _units(lengths: npt.ArrayLike, columns: int, cell_size: float) -> Ints:
    """Return lengths, m, as a table of lattice units."""
    table = np.asarray(lengths, np.float64).reshape(-1, columns)
    return np.rint(table / cell_size * UNIT).astype(np.int64)


def _lives(seen: list[set[Shape]], at: Ints, end: int) -> list[tuple[int, ...]]:
    """Return each shape with the first and last step of its existence, earliest first."""
    alive: dict[Shape, int] = {}
    lives: list[tuple[int, ...]] = []
    for step, shapes in zip(at.tolist(), seen, strict=True):
        for shape in alive.keys() - shapes:
            lives.append((*shape, alive.pop(shape), step))
        for shape in shapes - alive.keys():
            alive[shape] = step
    lives += [(*shape, since, end) for shape, since in alive.items()]
    return sorted(lives, key=lambda life: (life[5], life))
