"""Find the first edit after which a failure still fails, with the cheapest judgement first."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from fuzz.facts.proofs import certified
from fuzz.oracles import VERDICT
from fuzz.shrink.edits import edited
from fuzz.shrink.passes import Edit
from fuzz.shrink.predicate import StillFails
from fuzz.simplicity import Case, simplicity
from fuzz.unit.constraint import Constraint
from sim._core import lib
from sim.controllers import CompiledController
from sim.motion import MOTIONS
from sim.options.run import TARGET
from sim.runners.edited import ANY_ENDING, CellEdit, EditedRuns, Wanted, has_sure_path
from sim.verdict import Verdict

_WANTED = {
    Verdict.LOOP: Wanted(lib.WG_LOOP, overlap=False),
    Verdict.TUNNEL: Wanted(lib.WG_TUNNEL),
    Verdict.OVERLAP: Wanted(ANY_ENDING, overlap=True),
    Verdict.CONTACT: Wanted(lib.WG_CONTACT),
    Verdict.BURNED: Wanted(lib.WG_BURNED),
    Verdict.INVALID_COMMAND: Wanted(lib.WG_INVALID_COMMAND),
    Verdict.CRASH: Wanted(lib.WG_LIMIT, crash=True),
    Verdict.HANG: Wanted(lib.WG_LIMIT, hang=True),
    Verdict.STALLED: Wanted(lib.WG_LIMIT, overlap=False),
    Verdict.TIMEOUT: Wanted(lib.WG_LIMIT, overlap=False),
}

_AT_ONCE = 256  # edits in one call of the core
_MOST_CELLS = 1_000_000  # limit for screening a world: the flood takes 36 bytes per cell


class Trying:
    """Tries edits.

    A compiled controller on the pose lattice runs in compiled code, together with a flood that
    finds most paths to the target; other controllers run one at a time, unrecorded. Both are
    quick but inexact: the flood may miss a path, and a loop claimed by the kernel is not proved.
    So the final result must be judged by ``still_fails`` and, if it is not confirmed, be shrunk
    again with ``careful``.

    Args:
        still_fails: The exact judge.
        is_over: Returns True once no further edit may be tried.
        constraint: What an edit must not change.

    Attributes:
        careful: Judge every candidate by ``still_fails`` alone.
    """

    def __init__(
        self, still_fails: StillFails, is_over: Callable[[], bool], constraint: Constraint
    ) -> None:
        self.careful = False
        self._constraint = constraint
        self._still_fails = still_fails
        self._is_over = is_over
        self._quick_is_enough = still_fails.oracle == VERDICT and still_fails.is_proved_by_the_run
        run = still_fails.scenario.run
        # The core can't compute the cells to cover in an edited world.
        self._on_lattice = run.task == TARGET and MOTIONS.get(run.motion).on_lattice

    def first(self, case: Case, edits: Sequence[Edit], begin: int) -> tuple[int, Case] | None:
        """Return the first edit from ``begin`` onwards that keeps the failure, and the edited case.

        The case has no certificate.

        Raises:
            TimeoutError: If no further edit may be tried.
        """
        # A pass proposes only edits of cells, or no edits of cells at all.
        cells = [edit for edit in edits if isinstance(edit, CellEdit)]
        runs = self._edited_runs(case) if cells else None
        at = begin
        # Try edits in order, many at a time if the core can run them.
        while at < len(edits):
            if self._is_over():
                raise TimeoutError
            if runs is None:
                edit = edits[at]
                at = at + 1
                kept = self._settled(case, edit, looked=False)
            else:
                before = runs.trials
                some = cells[at : at + _AT_ONCE]
                wanted = _WANTED[Verdict(self._still_fails.verdict)]
                floods = case.world.robots[0].is_round and not case.world.is_dynamic
                found, done = runs.first(some, wanted, way=floods)
                self._still_fails.simulations += runs.trials - before
                at += done
                kept = None if found is None else self._settled(case, cells[at - 1], looked=True)
            if kept is not None:
                return at - 1, kept
        return None

    def _edited_runs(self, case: Case) -> EditedRuns | None:
        """Return the compiled runner for edits, or ``None`` if this case does not allow it."""
        controller = self._still_fails.controller
        budget = self._still_fails.least_budget
        if case.world.is_fleet or not (self._screens_quickly(case) and self._on_lattice):
            return None
        if not isinstance(controller, CompiledController):
            return None
        return EditedRuns(case.world, controller, case.scenario.options(case.world, budget))

    def _screens_quickly(self, case: Case) -> bool:
        return (
            not self.careful
            and self._still_fails.oracle.by_verdict
            and case.world.walls.size <= _MOST_CELLS
        )

    def _settled(self, case: Case, edit: Edit, *, looked: bool) -> Case | None:
        """Return the case after an edit, if it is simpler and still fails.

        Args:
            case: The case before.
            edit: The edit.
            looked: True if compiled code has already seen it fail and, in a world without events
                with a round robot, found the target reachable.
        """
        candidate = _after(case, edit)
        if candidate is None or not self._constraint.allows(candidate):
            return None
        # From the cheapest test to the most expensive one.
        if self._screens_quickly(case):
            if not looked and not self._still_fails.seems_to_fail(*candidate):
                return None
            if not self._still_fails.breach and not self._has_way(
                case, candidate, edit, looked=looked
            ):
                return None
            if self._quick_is_enough:
                return candidate if self._still_fails.keeps_cause(*candidate) else None
        return None if self._still_fails(*candidate) is None else candidate

    def _has_way(self, case: Case, candidate: Case, edit: Edit, *, looked: bool) -> bool:
        """Return True if the target can be reached; False may be wrong."""
        world = candidate.world
        if isinstance(edit, CellEdit) and edit.frees:
            return True  # reachable before, and now with one more free cell
        if world.is_fleet:
            # If one robot is removed, the paths of the others remain valid.
            fewer = len(world.robots) < len(case.world.robots)
            return fewer or certified(world) is not None
        # The flood is for the disc around a body, which seldom fits, and for no car.
        if not world.robots[0].is_round:
            return certified(world) is not None
        if not world.is_dynamic:
            return looked or has_sure_path(world)
        # Ignoring time is cheaper and rules out most worlds.
        if not has_sure_path(world, regardless_of_time=True):
            return False
        return not self._quick_is_enough or has_sure_path(world) or certified(world) is not None


def _after(case: Case, edit: Edit) -> Case | None:
    """Return the case after an edit; ``None`` if it is invalid or not simpler."""
    if isinstance(edit, CellEdit):
        world = edited(case.world, edit)
        return None if world is None else case._replace(world=world)
    candidate = edit()
    return candidate if candidate is not None and simplicity(candidate) < simplicity(case) else None
