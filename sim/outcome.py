"""What one run found, in the same words for every motion model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, TypeAlias

from sim._core import lib
from sim.evidence import FaultEvidence
from sim.trace import Trace, Words
from sim.verdict import AT_ONCE, Verdict

__all__ = ["ENDINGS", "LIMIT", "Ending", "Outcome", "Runnable"]

LIMIT: Literal["limit"] = "limit"
"""The ending of a run that spent its budget."""

Ending: TypeAlias = Verdict | Literal["limit"]

ENDINGS: Mapping[int, Ending] = {
    lib.WG_LIMIT: LIMIT,
    lib.WG_REACHED: Verdict.REACHED,
    lib.WG_LOOP: Verdict.LOOP,
    lib.WG_TUNNEL: Verdict.TUNNEL,
    lib.WG_BURNED: Verdict.BURNED,
    lib.WG_INVALID_COMMAND: Verdict.INVALID_COMMAND,
    lib.WG_CRASH: Verdict.CRASH,
}
"""By the core's number."""


@dataclass(frozen=True)
class Outcome:
    """The core's claims about a run; evidence checks confirm them from the trace.

    Args:
        ending: ``limit``, ``reached``, ``loop``, ``tunnel``, ``burned``, or one of
            :data:`sim.verdict.BY_THE_CONTROLLER`.
        steps: Steps simulated.
        period: Steps of the recurrence, for ``loop``.
        entry: Where it begins, for ``loop``; -1.
        path_length: m.
        collisions: Times that the robot began to touch a wall.
        digest: 16 hex digits; of no meaning if it was not asked for.
        last_new_cell: Last step in which the centre entered a cell for the first time.
        hit_step: Step of the tunnel, fire or debris; -1.
        hit_cell: Its cell (ix, iy).
        hit_state: ``solid`` or ``burning``, for ``burned``.
        overlap_step: First step whose path cut a wall by more than the tolerance; -1.
        overlap_cell: Its cell.
        cause: Of a tunnel or overlap under ``stepped``: the move that let the robot into the wall,
            ``slide``, ``back-off`` or ``corner``; else empty.
        cause_step: The step of that move, from which on the robot overlapped a wall; -1.
        wall_step: First step that ended with the centre in a wall, where that ends no run; -1.
        random_draws: Random numbers used.
        complete: Whether the recorded state is all that decides the future.
        fault: What the controller did wrong, without the step; ``None`` if it did nothing or only
            the core knows.
        trace: The recording, if one was asked for.
    """

    ending: Ending
    steps: int
    period: int
    path_length: float
    collisions: int
    digest: str
    last_new_cell: int
    hit_step: int
    hit_cell: tuple[int, int]
    hit_state: str
    overlap_step: int
    overlap_cell: tuple[int, int]
    random_draws: int
    entry: int = -1
    cause: str = ""
    cause_step: int = -1
    wall_step: int = -1
    complete: bool = True
    fault: FaultEvidence | None = None
    trace: Trace | None = None

    @property
    def verdict(self) -> Verdict:
        """The verdict; ``loop`` is the core's claim here, for the episode to prove."""
        ending = self.ending
        if ending in AT_ONCE:
            return Verdict(ending)
        if self.overlap_step >= 0:
            return Verdict.OVERLAP
        if ending != LIMIT:
            return ending
        return Verdict.STALLED if self.last_new_cell <= self.steps // 2 else Verdict.TIMEOUT


class Runnable(Protocol):
    """A world, a controller and options, packed for the core."""

    @property
    def last_event_step(self) -> int:
        """Step at whose beginning the world changes for the last time; 0 if it never does."""
        ...

    def run(self, steps: int, *, find_loop: bool, record: bool, digest: bool = True) -> Outcome:
        """Runs up to ``steps`` steps from the start.

        Args:
            steps: Budget.
            find_loop: Whether a recurrence ends the run, when it is found: at the end of the
                budget, or before.
            record: Whether to keep every state.
            digest: Whether to work out the trace's digest, which takes a fifth of the time.
        """
        ...

    def prove(self, entry: int, period: int, *, record: bool) -> tuple[Outcome, Words] | None:
        """Runs to the end of a loop's first period and compares the complete states at both of its ends.

        Args:
            entry: Where the loop begins, as :meth:`run` found it.
            period: Its steps.
            record: Whether to keep every state.

        Returns:
            The outcome up to there and the state at the entry; ``None`` if the state there does not
            come back.
        """
        ...
