"""The recorded states of one run, in the world's frame, whatever motion model made them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter

__all__ = ["BEHAVIOURS", "Recall", "Trace", "fnv1a", "state_digest"]

BEHAVIOURS = ("collide", "seek", "drive")
"""The behaviours of the thesis's robot."""

Floats = npt.NDArray[np.float64]
Words = npt.NDArray[np.uint64]
Recall: TypeAlias = Callable[[npt.NDArray[np.int64], Callable[[int, Floats], None]], None]
"""Runs again, and shows the memory after each of some steps, which rise."""

_HASH_START = 1469598103934665603
_HASH_PRIME = 1099511628211
_MASK = (1 << 64) - 1


@dataclass(frozen=True, eq=False)
class Trace:
    """States 0..n of a run and the path between them.

    Args:
        time_step: s.
        x: (n + 1,) m; index k is the state after step k, 0 the start.
        y: (n + 1,) m.
        heading: (n + 1,) rad.
        bump: (n + 1,) bool: a wall stopped or bent the step.
        path_x: (m,) m: the polyline that the centre drove, corners inside steps included.
        path_y: (m,) m.
        path_step: (m,) int64: step in which each point was reached; never falls.
        path_share: (m,) when in that step, 0 to 1: its share that was over.
        words: uint64, in any shape: what the digest runs over.
        states: (n + 1, k) uint64: the complete state, what a recurrence repeats.
        complete: Whether ``states`` is really all that decides the future (a controller may hide
            memory).
        memory_at: Where in a state the controller's memory begins, whose words are the bits of
            float64s; below 0: none can be seen.
        recall: Of a recording that was too large to hold the memory: how it is seen after all. Such
            a one has no ``words``, and the memory is not in its ``states``.
        recalled: How many numbers of memory ``recall`` shows.
        active: (n + 1,) int8: which of :data:`BEHAVIOURS` acted in the step, -1 for none; None for
            other robots.
    """

    time_step: float
    x: Floats
    y: Floats
    heading: Floats
    bump: npt.NDArray[np.bool_]
    path_x: Floats
    path_y: Floats
    path_step: npt.NDArray[np.int64]
    path_share: Floats
    words: Words
    states: Words
    complete: bool
    memory_at: int = -1
    active: npt.NDArray[np.int8] | None = None
    recall: Recall | None = None
    recalled: int = 0

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.x) - 1

    @property
    def memory_size(self) -> int:
        """How many numbers the controller's memory has, as far as it can be seen."""
        if self.recall is not None:
            return self.recalled
        return max(0, self.states.shape[1] - self.memory_at) if self.memory_at >= 0 else 0

    def memory(self, step: int) -> Floats:
        """(m,) the controller's memory after a step."""
        found: list[Floats] = []
        self.show_memory(np.array([step]), lambda _, memory: found.append(memory.copy()))
        return found[0]

    def show_memory(
        self, steps: npt.NDArray[np.int64], take: Callable[[int, Floats], None]
    ) -> None:
        """Hands the controller's memory after each of some steps to ``take``.

        It must copy what it keeps.

        Args:
            steps: (n,) rising, of this run.
            take: Gets the step and (m,) the memory.
        """
        if self.recall is not None:
            self.recall(steps, take)
            return
        first = self.states.shape[1] - self.memory_size
        for step in steps.tolist():
            take(step, self.states[step, first:].view(np.float64))

    def __repr__(self) -> str:
        return f"Trace({self.steps} steps, {self.time_step:g} s each, {len(self.path_x)} points)"

    def digest(self) -> str:
        """The trace's digest, worked out afresh from the recorded words: 16 hex digits.

        Raises:
            InvalidParameter: If the recording left them out.
        """
        if self.recall is not None:
            raise InvalidParameter(
                "recording-is-lean",
                "this recording is lean and has no words to work a digest out of",
                "record it whole",
            )
        return fnv1a(self.words)

    def to_csv(self) -> str:
        """Lines ``t,x,y,heading``, one a state, with a header."""
        lines = ["t,x,y,heading"]
        for k, (x, y, heading) in enumerate(zip(self.x, self.y, self.heading, strict=True)):
            lines.append(
                f"{round(k * self.time_step, 9)!r},{float(x)!r},{float(y)!r},{float(heading)!r}"
            )
        return "\n".join(lines) + "\n"


def fnv1a(words: Words) -> str:
    """Rolling FNV-1a over 64-bit words, in plain Python integers: 16 hex digits."""
    value = _HASH_START
    for word in words.ravel().tolist():
        value = ((value ^ word) * _HASH_PRIME) & _MASK
    return f"{value:016x}"


def state_digest(state: Words) -> str:
    """Digest of one complete state."""
    return fnv1a(state)
