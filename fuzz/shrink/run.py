"""Runs the passes until a whole round changes nothing, within a budget of time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fuzz.failure import failure_by, failure_of, scenario_of, seeds_that_fail
from fuzz.shrink.edits import bare
from fuzz.shrink.minimal import removable
from fuzz.shrink.order import PASSES, Pass
from fuzz.shrink.predicate import StillFails
from sim.episode import simulate
from sim.run_options import MAX_STEPS, RunOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.world import World

__all__ = ["Shrunk", "shrink"]

# A simpler world may need longer until it fails than the one that it came from.
_MORE_STEPS, _FEWEST_STEPS = 4, 2_000


@dataclass(frozen=True)
class Shrunk:
    """The result of shrinking.

    Args:
        world: The failure, with fresh certificate, evidence and digest.
        before: Solid cells before.
        after: Solid cells now.
        simulations: Runs that it took.
        left: What could still be removed; empty if the world is 1-minimal.
        complete: Whether every pass ended by itself, not by the clock.
    """

    world: World
    before: int
    after: int
    simulations: int
    left: tuple[str, ...]
    complete: bool


def shrink(
    failure: World,
    *,
    seconds: float | None = None,
    progress: Callable[[World], None] | None = None,
    keep_on_interrupt: bool = False,
) -> Shrunk:
    """Makes a failure's world as small as it can be, keeping verdict, its cause or kind, and certificate.

    Args:
        failure: A world with a failure record.
        seconds: Stop after this time with the best so far; a fixed amount of work without it.
        progress: Called with each simpler world.
        keep_on_interrupt: Let Ctrl-C end shrinking with the best so far, instead of raising.

    Returns:
        The shrunk failure.

    Raises:
        InvalidParameter: If the world holds no failure, or it does not fail (any more).
    """
    record, options = scenario_of(failure)
    scenario = Scenario.of(record.controller, options)
    budget = _MORE_STEPS * _steps_to_fail(failure, scenario, options) + _FEWEST_STEPS
    still_fails = StillFails.of(failure, min(budget, MAX_STEPS))
    best = still_fails(bare(failure))
    if best is None:
        by = "" if still_fails.asked is None else f" with an objection of oracle {still_fails.asked.text}"
        raise InvalidParameter(
            f"{record.controller} under {record.motion} does not end as {record.verdict!r}{by} in this world, or its "
            f"target is not {'walled off' if still_fails.breach else 'reachable'}; replay the file first: "
            "worldgen replay"
        )
    reducer = _Reducer(best, still_fails, None if seconds is None else time.monotonic() + seconds, progress)
    complete = False
    left: tuple[str, ...] = ("not checked: stopped early",)
    try:
        if reducer.run():
            complete, left = True, tuple(removable(reducer.best, still_fails))
    except KeyboardInterrupt:
        if not keep_on_interrupt:
            raise
    details: dict[str, Any] = dict(record.details) | {
        "shrunk_from": failure.solid_cells,
        "one_minimal": not left,
        "simulations": still_fails.simulations,
    }
    for fresh in ("class", "motion_version"):
        details.pop(fresh, None)
    if still_fails.asked is not None:
        world = failure_by(reducer.best, scenario, still_fails.asked, **details)
    else:
        details |= seeds_that_fail(reducer.best, scenario)
        world = failure_of(reducer.best, scenario, steps=still_fails.proof_budget, **details)
    if world is None:
        raise InvalidParameter(f"the shrunk world of {record.verdict!r} was not confirmed by its oracle")
    return Shrunk(world, failure.solid_cells, world.solid_cells, still_fails.simulations, left, complete)


def _steps_to_fail(failure: World, scenario: Scenario, options: RunOptions) -> int:
    """Steps after which the failure is decided."""
    reached = failure.failure.evidence.get("reached") if failure.failure else None
    if isinstance(reached, int):
        return reached
    return simulate(failure, scenario.controller, options).steps


class _Reducer:
    """Holds the best world so far, so that the clock or Ctrl-C can stop it at any time."""

    def __init__(
        self,
        best: World,
        still_fails: StillFails,
        deadline: float | None,
        progress: Callable[[World], None] | None,
    ) -> None:
        self.best, self._still_fails, self._deadline, self._progress = best, still_fails, deadline, progress

    def run(self) -> bool:
        """Passes until a whole round changes nothing; False if the time is up before."""
        try:
            before = None
            while before is not self.best:
                before = self.best
                for simplify in PASSES:
                    self._exhaust(simplify)
        except TimeoutError:
            return False
        return True

    def _exhaust(self, simplify: Pass) -> None:
        """Takes every edit that still fails; after one is taken the pass goes on from there, not afresh."""
        first, taken = 0, True
        while taken:
            taken = False
            for index, edit in enumerate(simplify(bare(self.best))):
                if index < first:
                    continue
                if self._deadline is not None and time.monotonic() > self._deadline:
                    raise TimeoutError
                candidate = edit()
                kept = None if candidate is None else self._still_fails(candidate)
                if kept is not None:
                    self.best, first, taken = kept, index, True
                    if self._progress is not None:
                        self._progress(kept)
                    break
