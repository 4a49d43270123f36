"""Run until the outcome is certain: find a recurrence and prove it, or let the budget decide.

The core does the same for many runs at once (``WgRun`` in ``sim/core/runs/wg_runs.h``).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from sim.options.run import check_recordable
from sim.outcome import LIMIT, Ending
from sim.verdict import Verdict


class _Claims(Protocol):
    """The core's claims about a run."""

    @property
    def ending(self) -> Ending: ...
    @property
    def steps(self) -> int: ...
    @property
    def entry(self) -> int: ...
    @property
    def period(self) -> int: ...


Claims_co = TypeVar("Claims_co", bound=_Claims, covariant=True)
Proof_co = TypeVar("Proof_co", covariant=True)


class _Run(Protocol[Claims_co, Proof_co]):
    """A run of one robot or of several; see :class:`sim.outcome.Runnable`."""

    def run(self, steps: int, *, find_loop: bool, record: bool) -> Claims_co: ...

    def prove(self, entry: int, period: int, *, record: bool) -> Proof_co | None: ...


def decide(
    run: _Run[Claims_co, Proof_co],
    budget: int,
    *,
    record: bool,
    at_once: bool = False,
    renewed: Callable[[], _Run[Claims_co, Proof_co]] | None = None,
    prove_otherwise: Callable[[int], Proof_co | None] = lambda _steps: None,
) -> Claims_co | Proof_co:
    """Run to a certain outcome.

    Args:
        run: The run.
        budget: Steps.
        record: Whether to keep every state.
        at_once: Whether to record in the first run already, because a second one would be slow.
        renewed: Returns the run with its controller as it was loaded, for when it hides memory.
        prove_otherwise: Proves a loop without a recurrence in a run that has spent its budget, if
            it can; takes the steps of that run.

    Returns:
        The outcome, or the proof of a loop, whose run ends with its first period.
    """
    outcome = run.run(budget, find_loop=True, record=at_once)
    if outcome.ending == Verdict.LOOP:
        if record:
            check_recordable(outcome.entry + outcome.period)
        # Without its whole state, no recurrence is a proof, and a second run need not try.
        hides_memory = not getattr(outcome, "complete", True)
        proof = None if hides_memory else run.prove(outcome.entry, outcome.period, record=record)
        if proof is None:
            # The controller hides memory that it does not declare, so only the budget decides. The
            # runs so far may have changed that memory.
            again = run if renewed is None else renewed()
            return again.run(budget, find_loop=False, record=record)
        return proof
    proof = prove_otherwise(outcome.steps) if outcome.ending == LIMIT else None
    if proof is not None:
        return proof
    if record and getattr(outcome, "trace", None) is None:
        check_recordable(outcome.steps)
        return run.run(outcome.steps, find_loop=False, record=True)
    return outcome
