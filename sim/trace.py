"""Traces: the recorded states of one run, in the world's frame, for every motion model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Bools, Floats, Ints, Words

if TYPE_CHECKING:
    from sim.options.robot import RobotOptions

BEHAVIOURS = ("collide", "seek", "drive")
"""Behaviours of the thesis's robot, in the order of their numbers."""

Recall: TypeAlias = Callable[[Ints, Callable[[int, Floats], None]], None]
"""Runs again, and shows the memory after each of the given steps, which are in rising order."""

_HASH_START = 1469598103934665603
_HASH_PRIME = 1099511628211


@dataclass(frozen=True, eq=False)
class Trace:
    """The states 0..n of a run, and the path between them.

    Args:
        time_step: Duration of a step, s.
        x: (n + 1,) position, m; index k is the state after step k, 0 is the start.
        y: (n + 1,) position, m.
        heading: (n + 1,) rad, counter-clockwise from the x axis.
        bump: (n + 1,) bool, True if a wall stopped or bent the step.
        path_x: (m,) m, the polyline that the centre drove, with corners inside steps.
        path_y: (m,) m.
        path_step: (m,) int64, step in which each point was reached; never decreases.
        path_share: (m,) fraction of that step that had passed, 0 to 1.
        words: uint64, any shape, the words that the digest is computed from.
        states: (n + 1, k) uint64, complete states; a loop is a repetition of one of them.
        complete: Whether ``states`` really decides the future; a controller may hide memory.
        memory_at: Index in a state where the controller's memory begins, stored as the bits of
            float64s; negative if it is not visible.
        active: (n + 1,) int8, index into :data:`BEHAVIOURS` of the one that acted in the step, -1
            for none; ``None`` for other robots.
        recall: Shows the memory of a lean recording, which was too large to hold it. Such a
            recording has no ``words``, and its ``states`` lack the memory.
        recalled: How many numbers of memory ``recall`` shows.
        after_memory: How many words at the end of a state follow the memory: a robot's message to
            others, how many waypoints it has passed, and what a body or a car keeps of its last turn
            and its steering.
        path_heading: (m,) rad, the heading on the way to each point of the path; empty for a disc
            that turns on the spot, whose heading does not matter there.
        robot: Options of the robot in the run; ``None`` for the thesis's robot.
        task: The robot's task: ``target`` or ``cover``.
        passed: (n + 1,) int64, how many of its waypoints the robot has arrived at; empty without
            waypoints.
    """

    time_step: float
    x: Floats
    y: Floats
    heading: Floats
    bump: Bools
    path_x: Floats
    path_y: Floats
    path_step: Ints
    path_share: Floats
    words: Words
    states: Words
    complete: bool
    memory_at: int = -1
    active: npt.NDArray[np.int8] | None = None
    recall: Recall | None = None
    recalled: int = 0
    after_memory: int = 0
    path_heading: Floats = field(default_factory=lambda: np.zeros(0))
    robot: RobotOptions | None = None
    task: str = "target"
    passed: Ints = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.x) - 1

    @property
    def memory_size(self) -> int:
        """How many numbers of the controller's memory can be seen."""
        if self.recall is not None:
            return self.recalled
        if self.memory_at < 0:
            return 0
        return max(0, int(self.states.shape[1]) - self.memory_at - self.after_memory)

    @property
    def moves(self) -> Words:
        """(n + 1, w) the states without the controller's memory, all of them whole numbers."""
        first = self.memory_at
        return np.delete(self.states, np.s_[first : first + self.memory_size], axis=1)

    @property
    def memories(self) -> Floats:
        """(n + 1, m) the controller's memory after each step, of a recording that holds it."""
        first = self.memory_at
        return self.states[:, first : first + self.memory_size].view(np.float64)

    def memory(self, step: int) -> Floats:
        """Return the controller's memory after a step, (m,)."""
        found: list[Floats] = []
        self.show_memory(np.array([step]), lambda _, memory: found.append(memory.copy()))
        return found[0]

    def show_memory(self, steps: Ints, take: Callable[[int, Floats], None]) -> None:
        """Pass the controller's memory after each of some steps to ``take``.

        Args:
            steps: (n,) steps of this run, in rising order.
            take: Receives the step and (m,) the memory, and must copy anything that it keeps.
        """
        if self.recall is not None:
            self.recall(steps, take)
            return
        first = self.states.shape[1] - self.after_memory - self.memory_size
        for step in steps.tolist():
            take(step, self.states[step, first : first + self.memory_size].view(np.float64))

    def __repr__(self) -> str:
        return f"Trace({self.steps} steps, {self.time_step:g} s each, {len(self.path_x)} points)"

    def digest(self) -> str:
        """Compute the trace's digest from the recorded words.

        Returns:
            16 hex digits.

        Raises:
            InvalidParameter: If the recording is lean, and so has no words.
        """
        if self.recall is not None:
            raise InvalidParameter(
                "recording-is-lean",
                "this recording has positions only, so it has no digest",
                "record the full run",
            )
        return fnv1a(self.words)

    def to_csv(self, acted: Sequence[str] = ()) -> str:
        """Return the states as lines ``t,x,y,heading``, after a header.

        Args:
            acted: The behaviour that acted in each step, for an additional column ``behaviour``;
                the start has none.
        """
        lines = ["t,x,y,heading" + (",behaviour" if acted else "")]
        for k, (x, y, heading) in enumerate(zip(self.x, self.y, self.heading, strict=True)):
            who = f",{acted[k - 1] if k else ''}" if acted else ""
            lines.append(
                f"{round(k * self.time_step, 9)!r},{float(x)!r},{float(y)!r},{float(heading)!r}{who}"
            )
        return "\n".join(lines) + "\n"


def fnv1a(words: Words) -> str:
    """Return the rolling FNV-1a hash of 64-bit words as 16 hex digits, in plain Python integers."""
    value = _HASH_START
    for word in words.ravel().tolist():
        value = ((value ^ word) * _HASH_PRIME) & MASK64
    return f"{value:016x}"


def state_digest(state: Words) -> str:
    """Return the digest of one complete state, 16 hex digits."""
    return fnv1a(state)
