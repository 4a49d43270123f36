"""Describe how a controller arbitrates among behaviours: its parts, and which of them acts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from worldgen.support.arrays import Floats, Ints

if TYPE_CHECKING:
    from sim.trace import Trace

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
        priority: The part with the highest priority acts, among those that apply.
        duration: Number of steps that it acts; infinity if it decides that itself.
        interruptible: True if a part of higher priority can take over before it is done.
    """

    name: str
    trigger: str
    action: str
    priority: float
    duration: float
    interruptible: bool

    @property
    def when(self) -> str:
        """When it applies, as the beginning of a sentence."""
        return self.trigger if self.trigger == ALWAYS else f"when {self.trigger}"

    @property
    def control(self) -> str:
        """How long it keeps control, in words, unless its action says so already."""
        ends = "can be interrupted" if self.interruptible else "keeps control"
        if f" {self.duration:g} steps" in self.action:
            return ends
        if self.duration > 1 and math.isfinite(self.duration):
            return f"{self.duration:g} steps; {ends}"
        if self.interruptible and self.duration <= 1:
            return f"one step at a time; {ends}"
        return ends if " until " in self.action else f"until it is done; {ends}"


@dataclass(frozen=True)
class Arbitration:
    """How a controller arbitrates, for traces, charts and pages; runs do not use it.

    Args:
        parts: The parts in the order in which the memory counts them.
        arbiter: ``priority``, ``vote`` or ``learning``.
        acted: Takes (n + 1, m) the memories of a run from its start, and returns (n,) the part
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


def acted_at(arbitration: Arbitration, trace: Trace, steps: Ints) -> Ints:
    """Return the index of the part that acted in each of some steps of a run; -1 for none.

    Args:
        arbitration: The robot's, see :attr:`sim.scenario.Scenario.arbitration`.
        trace: The run.
        steps: (n,) steps in rising order; in step 0, the start, nothing acts.
    """
    # The thesis's own program counts its behaviours itself.
    if trace.active is not None:
        return trace.active[steps].astype(np.int64)
    found = np.full(len(steps), -1, np.int64)
    at: list[int] = []
    kept: list[Floats] = []

    def read() -> None:
        acted = arbitration.acted(np.array(kept))
        after = np.array(at[1:])
        asked = np.isin(after, steps)
        found[np.searchsorted(steps, after[asked])] = acted[asked]

    # The part that acted shows in the memories before and after a step. Read a portion at a time,
    # because all memories of a long run can take gigabytes.
    def take(step: int, memory: Floats) -> None:
        at.append(step)
        kept.append(memory.copy())
        if len(kept) > _PORTION:
            read()
            del kept[:-1], at[:-1]

    trace.show_memory(np.union1d(steps, np.maximum(steps - 1, 0)), take)
    if len(kept) > 1:
        read()
    return found


def acting(arbitration: Arbitration, trace: Trace) -> list[str]:
    """Return the name of the part that acted in each step of a run; :data:`NOBODY` if none did."""
    names = (*arbitration.names, NOBODY)
    steps = np.arange(1, trace.steps + 1, dtype=np.int64)
    return [names[part] for part in acted_at(arbitration, trace, steps).tolist()]


def sentences(arbitration: Arbitration) -> list[str]:
    """Return a sentence on each part, the highest priority first: the chart in words."""
    parts = sorted(
        zip(arbitration.names, arbitration.parts, strict=True), key=lambda one: -one[1].priority
    )
    return [
        f"{part.priority:g} {name}: {part.when}, {part.action}; {part.control}"
        for name, part in parts
    ]


def in_words(sentence: str, values: Mapping[str, str]) -> str:
    """Replace the names that a sentence has in backquotes by their values."""
    for name, value in values.items():
        sentence = sentence.replace(f"`{name}`", value)
    return sentence


def shares(arbitration: Arbitration, acted: list[str]) -> dict[str, float]:
    """Return the share of steps in which each part acted, and in which no part did, if any.

    Args:
        arbitration: The controller's.
        acted: The result of :func:`acting`.
    """
    known = (*arbitration.names, *([NOBODY] if NOBODY in acted else []))
    return {name: round(acted.count(name) / max(len(acted), 1), 6) for name in known}
