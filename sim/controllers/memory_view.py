"""Show a controller's memory to users: names of its numbers, and the map that it keeps.

A controller declares both, and pages use them to interpret the memory of a run. They never affect a
run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Floats


class MemoryField(NamedTuple):
    """A number of the memory that has a name.

    Args:
        name: The name to show.
        place: Its index in the memory.
        words: The meanings of its values if they are whole numbers, starting with that for
            ``least``.
        least: The smallest value.
    """

    name: str
    place: int
    words: tuple[str, ...] = ()
    least: int = 0


@dataclass(frozen=True, eq=False)
class MemoryMap:
    """The part of the world that a memory represents; lengths in m, in the world's frame.

    Args:
        blocked: (n, 4) line segments, x and y of both ends, that the controller treats as walls or
            closed passages.
        cells: (n, 4) rectangles, x and y of two corners, that it treats as occupied.
        plan: (n, 2) corners of the path that it plans to drive.
        places: Points that it remembers, x and y by name.
        nodes: (n, 2) places of a graph, such as a topological map, or points on walls.
        edges: (n, 4) ways between them, x and y of both ends.
        degrees: (n, 5) rectangles, x and y of two corners, and how good the controller takes them
            to be, from 0 (bad) to 1 (good).
    """

    blocked: Floats = field(default_factory=partial(np.zeros, (0, 4)))
    cells: Floats = field(default_factory=partial(np.zeros, (0, 4)))
    plan: Floats = field(default_factory=partial(np.zeros, (0, 2)))
    places: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    nodes: Floats = field(default_factory=partial(np.zeros, (0, 2)))
    edges: Floats = field(default_factory=partial(np.zeros, (0, 4)))
    degrees: Floats = field(default_factory=partial(np.zeros, (0, 5)))


def check_fields(name: str, fields: Any) -> None:
    """Check that a declaration is a tuple of :class:`MemoryField`.

    Raises:
        InvalidParameter: If it is anything else.
    """
    if not isinstance(fields, tuple | list) or not all(
        isinstance(one, MemoryField) for one in fields
    ):
        raise InvalidParameter(
            "wrong-declaration",
            "controller {name!r} has memory_fields={fields!r}, which is not a tuple of MemoryField",
            "write (MemoryField('mode', 0, ('seek', 'turn')),)",
            name=name,
            fields=fields,
        )
