"""Campaigns for failures: units find them, they are shrunk, and all results are stored.

It yields events and prints nothing.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from functools import partial

from fuzz.campaign.executors import Executor, local_executor
from fuzz.campaign.schedule import Beginning, Schedule
from fuzz.campaign.scheduler import Goal, Scheduler, Work
from fuzz.campaign.state import CampaignState, Discovery, Progress, SearchEnded, UnitDone
from fuzz.campaign.store import MEMORY, Find, FolderStore
from fuzz.campaign.unit import run_unit
from fuzz.failure import SHRINKING, Failure, ShrinkState
from fuzz.shrink.queue import (
    MOST_SHRUNK,
    SHRINKING_SECONDS,
    Shrinking,
    ShrinkJob,
    ShrinkQueue,
    shrunk_or_same,
)
from fuzz.unit.config import CampaignConfig
from fuzz.unit.live import LiveCounts, LiveState, Phase, not_arrived
from fuzz.unit.result import FailureKey, SearchState, UnitResult


class Campaign(Goal[Progress]):
    """A search for failures, with a budget.

    Args:
        config: Definition of the campaign.
        units: Amount of work; with it, the corpus depends only on the seed.
        seconds: Time, ignored if ``units`` is given. Three quarters of it are for the search, the
            rest for shrinking. Units in progress are then cut short, and keep their findings.
            Failures not shrunk by the end are pending.
        executor: Runs the units; this process if omitted.
        store: Stores results, so that another campaign of the same configuration continues from
            them.
        is_known: Returns whether a failure is known: such failures are counted, but neither shrunk
            nor kept.
        began: When the time began; if omitted, when the campaign is made.

    Iterating over :meth:`run` does the work. No matter how it is stopped, ``state.best`` and
    :meth:`pending` keep all findings. However often a campaign is stopped, its state is the same
    once it has continued to the same number of units.
    """

    def __init__(
        self,
        config: CampaignConfig,
        *,
        units: int | None = None,
        seconds: float | None = None,
        executor: Executor | None = None,
        store: FolderStore | None = None,
        is_known: Callable[[Failure], bool] = lambda _: False,
        began: Beginning | None = None,
    ) -> None:
        schedule = Schedule(
            None if units is not None else seconds, shrinks=config.shrink, began=began
        )
        self._scheduler = Scheduler(
            [config.scenario], executor or local_executor(1), schedule, units
        )
        self._schedule = schedule
        self.config = config
        self.units = units
        self.state = CampaignState()
        self._is_known = is_known
        self._store = store
        # Failures whose shrinking ended before any simpler world was proved, by id.
        self._cut_short: set[str] = set()
        self._queue = ShrinkQueue(shrinks=config.shrink, by_size=not self._schedule.is_unlimited)
        # Findings of cut units are kept and shown. The knowledge of later units, and what is stored
        # about them, depends only on complete units; otherwise an interrupted campaign would
        # diverge from an uninterrupted one.
        self._memory = SearchState()
        # Groups of which a known failure was met.
        self._known_groups: set[str] = set()
        # Failures of whole units, by group and whether they are known.
        self._met_whole: Counter[tuple[str, bool]] = Counter()
        # Search states by epoch.
        self._known = [SearchState(), SearchState()]
        # First epoch whose search state lacks the findings of a cut unit.
        self._knows_too_little = math.inf
        self._steps_to_shrink = (
            config.pace.steps_in(SHRINKING_SECONDS) if schedule.is_unlimited else math.inf
        )
        self._handed_in = LiveCounts()
        self._has_ended = False
        # Units that this run has done.
        self._units_now = 0
        # Seconds of earlier runs.
        self._before = 0.0
        self._earlier = 0.0 if store is None else store.seconds()

    def pending(self) -> dict[FailureKey, Failure]:
        """Return a failure of each group of which none is shrunk yet.

        This is useful after an interruption, or when time is up.
        """
        return {
            one.key: one.noting(**{SHRINKING: ShrinkState.CUT_SHORT.value})
            if one.id in self._cut_short
            else one
            for one in self._queue.unshrunk(self.state.best)
        }

    def live(self) -> LiveState:
        """Return the campaign's activity, with the runs of units in progress.

        May be called in another thread.
        """
        counted = self._scheduler.executor.counts() or self._handed_in
        more = counted.without(self._handed_in)
        state = self.state
        failed = not_arrived(dict(state.verdicts))
        tried = state.worlds + more.worlds
        to_shrink = self._scheduler.others_in_progress + len(self._queue)
        # Without a time limit, the first unit loads what it needs.
        has_begun = tried or state.until or not self._schedule.is_unlimited
        if not self._schedule.is_ready or not has_begun:
            phase = Phase.PREPARING
        else:
            only_shrinks = to_shrink and not self._scheduler.is_searching
            phase = Phase.SHRINKING if only_shrinks else Phase.SEARCHING
        elapsed = self._schedule.elapsed()
        effort = state.effort
        handed_in = self._handed_in.worlds
        return LiveState(
            phase,
            tried,
            state.steps + more.steps,
            failed + more.failed,
            to_shrink,
            elapsed,
            rate=60.0 * (handed_in + more.worlds) / elapsed if elapsed else 0.0,
            cost=effort.seconds / handed_in if handed_in else 0.0,
            own=effort.share,
            left=self._seconds_left(elapsed),
        )

    def _seconds_left(self, elapsed: float) -> float:
        """Return the seconds until the units are done, at the speed of this run's units so far."""
        if self.units is None or not self._units_now:
            return 0.0
        return elapsed * max(self.units - self._scheduler.next_merged, 0) / self._units_now

    def run(self) -> Generator[Progress, None, None]:
        """Run the campaign, or the rest of it.

        Raises:
            KeyboardInterrupt: After Ctrl-C, once the units in progress have returned their results.
            WorkersLost: If the workers ended before the work did.
        """
        try:
            yield from self._scheduler.run(self)
        finally:
            self._count_time()

    def conclude(self) -> Iterator[Progress]:
        """Yield the search's end, with all of its findings."""
        if self.units is None and self._store is not None:
            self._take_from_earlier(self._store)
        self._count_time()
        self._has_ended = True
        yield SearchEnded(self._scheduler.executor)

    def _count_time(self) -> None:
        """Update the times in the state.

        Restored work adds the time of earlier runs, including shrinking.
        """
        if self._has_ended:
            return
        self.state.seconds = self._before + self._schedule.elapsed()
        self.state.times = self._schedule.times()

    def _take_from_earlier(self, store: FolderStore) -> None:
        """Add findings from an earlier run's cut units that this run did not get to."""
        for unit in store.units_cut():
            if unit >= self._scheduler.next_merged and (result := store.cut_unit(unit)):
                self._add(unit, result)

    def next_work(self) -> Work[Progress] | None:
        """Return a unit, or a failure to shrink.

        The first failure of each group is shrunk before the search continues, the others after it.
        If the budget is a time, shrinking has its share of it, during the search and after it.
        """
        job = self._next_job(first_only=self._schedule.search_comes_first)
        # Search if nothing more urgent is waiting.
        if job is None and self._schedule.may_search:
            unit = self._next_unit()
            if unit is not None:
                return unit
        # Otherwise shrink the next failure, if there is one.
        job = job or self._next_job()
        if job is None:
            return None
        self._scheduler.get_ready()
        in_progress = len(self._scheduler.others)
        seconds, end = self._schedule.for_shrinking(
            self._queue.as_urgent_as(job) + in_progress + 1,
            max(self._scheduler.executor.room - 1, 1),
        )
        call = partial(
            shrunk_or_same, job.failure, seconds=seconds, end=end, most_steps=self._steps_to_shrink
        )
        return Work(call, partial(self._take_shrunk, job), is_unit=False)

    def _next_job(self, *, first_only: bool = False) -> ShrinkJob | None:
        """Return a failure to shrink, the first of each group before others.

        It is ``None`` if none is due.
        """
        if self._schedule.is_over() or (first_only and self._schedule.shrank_enough()):
            return None
        return self._queue.take(first_only=first_only)

    def _next_unit(self) -> Work[Progress] | None:
        """Return the next unit, or the stored one; ``None`` if none may begin now."""
        unit = self._scheduler.next_unit
        epoch = unit // self.config.units_of_a_round
        # What the unit is to know depends on units that may not be merged yet.
        if not self._scheduler.has_more_units or epoch >= len(self._known):
            return None
        done = self._store and self._store.unit(unit)
        if done:
            return Work.done(done, partial(self._merge, unit))
        # Loading takes part of the time.
        self._scheduler.get_ready()
        if not self._schedule.may_search:
            return None
        # Nothing is to be shrunk until the first failure comes.
        deadline = self._schedule.deadline(shrinks=bool(self.state.finds))
        before = self._store and self._store.cut_unit(unit)
        screened = before.screened if before else {}
        call = partial(run_unit, self.config, unit, self._known[epoch], deadline, screened)
        return Work(call, partial(self._merge, unit))

    def _merge(self, unit: int, result: UnitResult) -> Iterator[Progress]:
        """Add a unit's result, and queue its failures for shrinking unless that is done."""
        jobs = self._add(unit, result)
        yield UnitDone(unit, self.state, result.stored_at is not None)
        for job in jobs:
            done = self._store and self._store.shrunk(job.failure)
            if self.config.shrink and done is None:
                self._queue.add(job)
            else:
                yield from self._take_shrunk(job, Shrinking(done or job.failure), is_stored=True)

    def _add(self, unit: int, result: UnitResult) -> list[ShrinkJob]:
        """Add a unit's result to the totals and to the store.

        Return the failures to shrink, which are the same for any timing.
        """
        state = self.state
        stored_at = result.stored_at
        if stored_at is None:
            state.effort += result.effort
            self._units_now += 1
            self._handed_in = self._handed_in.plus(result.worlds, result.steps, result.verdicts)
            result = self._more_of(unit, result)
            # A unit with too little knowledge counts as cut, because it must be done again.
            if unit // self.config.units_of_a_round >= self._knows_too_little:
                state.too_early += not result.cut
                result = replace(result, cut=True)
        else:
            # A unit's own figure excludes failures that were shrunk after the last unit.
            self._before = max(stored_at, self._earlier)
        # Add it to the totals.
        self._count_time()
        seconds = state.seconds if stored_at is None else stored_at
        state.units += not result.cut
        state.cut += result.cut
        state.until = max(state.until, unit + 1)
        state.worlds += result.worlds
        state.steps += result.steps
        state.verdicts += result.verdicts
        state.tried += result.tried
        state.judged += result.judged
        state.met += result.met
        # Select the results worth storing, and store them.
        jobs, kept = self._enter_failures(unit, result, seconds)
        elites = {
            cell: elite
            for cell, elite in result.elites.items()
            if self._memory.is_better(cell, elite)
        }
        # The search state then has the same order as the store.
        result = replace(result, failures=kept, elites=elites)
        if stored_at is None and self._store:
            self._store.save_unit(unit, result, seconds)
        # Units that were cut short change the displayed state, but not what later units know.
        state.memory = state.memory.after(result)
        if result.cut:
            self._knows_too_little = min(
                self._knows_too_little, unit // self.config.units_of_a_round + 2
            )
        else:
            self._memory = self._memory.after(result)
        if (unit + 1) % self.config.units_of_a_round == 0:
            self._known.append(self._memory)
        return jobs

    def _enter_failures(
        self, unit: int, result: UnitResult, seconds: float
    ) -> tuple[list[ShrinkJob], dict[FailureKey, Failure]]:
        """Return a unit's failures to shrink, and those to store."""
        state = self.state
        jobs: list[ShrinkJob] = []
        kept: dict[FailureKey, Failure] = {}
        finds: list[tuple[Find, Failure]] = []
        # The smallest of each group come first, since only a few are shrunk.
        ordered = sorted(result.failures.values(), key=lambda one: (one.group, one.order))
        for failure in ordered:
            group = failure.group
            is_known = self._is_known(failure)
            is_interesting = state.memory.is_interesting(failure)
            if is_interesting:
                finds.append((self._find(unit, result, failure, seconds), failure))
            # The stored result depends only on complete units, so that a resumed campaign agrees.
            few_whole = self.config.shrink and self._met_whole[group, is_known] < MOST_SHRUNK
            if few_whole or self._memory.is_interesting(failure):
                kept[failure.key] = failure
            self._met_whole[group, is_known] += not result.cut
            if is_known:
                self._known_groups.add(group)
            job = self._queue.job_for(failure, is_known=is_known, is_interesting=is_interesting)
            if job is not None:
                jobs.append(job)
        # The totals are rounded; the order must not depend on how long the unit took.
        state.finds += sorted(finds, key=lambda one: result.first_met[one[1].key].order)
        # A restored unit has only the failures that were worth keeping, so its totals count.
        met = state.met_by_group
        state.known = Counter({group: met[group] for group in self._known_groups})
        return jobs, kept

    def _find(self, unit: int, result: UnitResult, failure: Failure, seconds: float) -> Find:
        """Return when a failure was found, in totals of the campaign."""
        at = result.first_met[failure.key]
        return Find(
            unit=unit,
            strategy=result.strategy,
            cause=failure.group,
            solid_cells=failure.world.solid_cells,
            worlds=self.state.worlds - result.worlds + at.worlds,
            steps=self.state.steps - result.steps + at.steps,
            seconds=round(max(seconds - at.seconds_left, 0.0), 3),
            file=f"{MEMORY}/failures/{failure.id}.grid",
        )

    def _more_of(self, unit: int, result: UnitResult) -> UnitResult:
        """Return a unit's result with an earlier run's part, or that if it got further."""
        before = self._store and self._store.cut_unit(unit)
        if not before:
            return result
        # Lines that only runs of the earlier part reached have run, too.
        lines = before.lines | result.lines
        if result.cut and before.worlds > result.worlds:
            result = replace(before, interrupted=result.interrupted, stored_at=None)
        return replace(result, lines=lines)

    def _take_shrunk(
        self, job: ShrinkJob, result: Shrinking, *, is_stored: bool = False
    ) -> Iterator[Progress]:
        """Keep a shrunk failure if it is the smallest of its key, and yield it."""
        shrunk = result.failure
        self.state.effort += result.effort
        if result.complete and not is_stored and self._store:
            self._store.save_shrunk(job.failure, shrunk)
        self._count_time()
        # Time ran out before any simpler world was proved.
        if not result.complete and shrunk.shrinking == ShrinkState.NONE:
            self._cut_short.add(job.failure.id)
            return
        # The smaller world may be another case: that of a hazard, or a known one.
        is_same = shrunk.group == job.failure.group and not self._is_known(shrunk)
        for failure in (shrunk,) if is_same else (shrunk, job.failure):
            before = self.state.best.get(failure.key)
            is_first = before is None or failure.order < before.order
            if is_first and not self._is_known(failure):
                self.state.best[failure.key] = failure
                yield Discovery(failure, before is not None)
