"""How a controller's memory reads for people: names of its numbers, and the map that it keeps.

Both are declared beside the controller and only ever read what a run has left; a run is the same
without them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter

__all__ = ["MemoryField", "MemoryMap", "check_fields"]

Floats = npt.NDArray[np.float64]


class MemoryField(NamedTuple):
    """A number of the memory that has a name.

    Args:
        name: As people read it.
        place: Its index in the memory.
        words: What its values mean, if they are whole: the first word is that of ``least``.
        least: See ``words``.
    """

    name: str
    place: int
    words: tuple[str, ...] = ()
    least: int = 0


def _none() -> Floats:
    return np.zeros((0, 4))


@dataclass(frozen=True, eq=False)
class MemoryMap:
    """What a memory says about the world; lengths in m, in the world's frame.

    Args:
        blocked: (n, 4) lines, x and y of both ends, that the controller holds for walls or ways
            that are closed.
        cells: (n, 4) rectangles, x and y of two corners, that it holds for occupied.
        plan: (n, 2) corners of the way that it means to drive.
        places: Points that it remembers, x and y by name.
    """

    blocked: Floats = field(default_factory=_none)
    cells: Floats = field(default_factory=_none)
    plan: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    places: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def check_fields(name: str, fields: Any) -> None:
    """Refuses what is no tuple of named numbers of a memory.

    Raises:
        InvalidParameter: If it is none.
    """
    if not isinstance(fields, tuple | list) or not all(
        isinstance(one, MemoryField) for one in fields
    ):
        raise InvalidParameter(
            "wrong-declaration",
            "controller {name!r} has memory_fields={fields!r}, which is no tuple of them",
            "write (MemoryField('mode', 0, ('seek', 'turn')),)",
            name=name,
            fields=fields,
        )
