"""Describe how a controller arbitrates among behaviours: its parts, and which of them acts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from sim.trace import Trace

__all__ = ["ALWAYS", "NOBODY", "Arbitration", "PartFacts", "acting", "shares"]

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Number of memories that are read at once.
_PORTION = 4096

ALWAYS = "always"
"""The trigger of a behaviour that always applies, in words."""

NOBODY = "none"
"""The word for a step in which no behaviour applies."""


class PartFacts(NamedTuple):
    """Describe one part for a chart or a list.

    Args:
        name: Its name.
        trigger: When it applies, in words.
        action: What it then does, in words.
        priority: Of the parts that apply, the one with the highest priority acts.
        duration: Number of steps that it acts; infinity if it decides that itself.
        interruptible: True if a part of higher priority can take over before it is done.
    """

    name: str
    trigger: str
    action: str
    priority: float
    duration: float
    interruptible: bool


@dataclass(frozen=True)
class Arbitration:
    """How a controller arbitrates, for traces, charts and pages; a run never asks for it.

    Args:
        parts: The parts in the order in which the memory counts them.
        arbiter: ``priority``, ``vote`` or ``learning``.
        acted: Takes (n + 1, m) the memories of a run from its start on, and returns (n,) the part
            that acted in each step; -1 for none.
    """

    parts: tuple[PartFacts, ...]
    arbiter: str
    acted: Callable[[Floats], Ints]

    @property
    def names(self) -> tuple[str, ...]:
        """The parts' names; a name that occurs twice gets a number."""
        found: list[str] = []
        for part in self.parts:
            again = sum(name.partition("#")[0] == part.name for name in found)
            found.append(f"{part.name}#{again + 1}" if again else part.name)
        return tuple(found)


def acting(arbitration: Arbitration, trace: Trace) -> list[str]:
    """Return the name of the part that acted in each step of a run; :data:`NOBODY` if none did."""
    names = (*arbitration.names, NOBODY)
    found: list[str] = []
    kept: list[Floats] = []

    def take(step: int, memory: Floats) -> None:
        # Read a portion at a time, because all memories of a long run can take gigabytes.
        kept.append(memory.copy())
        if len(kept) > _PORTION or step == trace.steps:
            found.extend(names[part] for part in arbitration.acted(np.array(kept)).tolist())
            del kept[:-1]

    trace.show_memory(np.arange(trace.steps + 1, dtype=np.int64), take)
    return found


def shares(arbitration: Arbitration, acted: list[str]) -> dict[str, float]:
    """Return the share of steps in which each part acted, and in which no part did, if any.

    Args:
        arbitration: The controller's.
        acted: The result of :func:`acting`.
    """
    known = (*arbitration.names, *([NOBODY] if NOBODY in acted else []))
    return {name: round(acted.count(name) / max(len(acted), 1), 6) for name in known}
