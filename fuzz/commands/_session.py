"""Run a campaign at a terminal: progress on stderr, failures in a folder, and what it found."""

from __future__ import annotations

import contextlib
import shlex
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from fuzz.campaign.executors import Executor, WorkersLost
from fuzz.campaign.run import Campaign
from fuzz.campaign.schedule import Beginning
from fuzz.campaign.state import Discovery, Progress, SearchEnded, UnitDone
from fuzz.campaign.store import MEMORY, CampaignRun, Status, Summary, record_error
from fuzz.campaign.summary import describe_speed, summary_of
from fuzz.ci import NO_OUTPUTS, Outputs
from fuzz.commands._ending import Ending
from fuzz.facts.hazards import is_hazard
from fuzz.failure import Failure, ShrinkState
from fuzz.overview.answer import MORE, more_seconds
from fuzz.overview.building import Conclusion, Overview, answer_numbers, build_overview, files_of
from fuzz.overview.limits import seconds_to_conclude
from fuzz.overview.result import CampaignResult, write_overview
from fuzz.shrink.queue import SHRINKING_SECONDS
from fuzz.unit.answer import Answer, AnswerNumbers
from fuzz.unit.live import LiveState, Phase, shown_in
from sim.clock.controller_time import Effort
from sim.clock.stopping import stopping_when
from worldgen.cli.output import note
from worldgen.errors import InvalidParameter, OutputError, WorldgenError
from worldgen.support.plain_text import counted
from worldgen.support.progress import is_verbose, working

# Minimum seconds between two summaries while the search continues.
_SUMMARY_EVERY = 1.0
# Seconds for the runs of all pictures together.
_TO_DRAW = 2.0
# Seconds for natural worlds and explanations after Ctrl-C.
_TO_CONCLUDE_AT_ONCE = 1.0


NO_ANSWER = 4
"""Exit code of a campaign that tried too little to say whether the controller fails."""


class CampaignSession:
    """Runs a campaign and keeps its folder.

    Args:
        campaign_run: The campaign, with its folder and budget; closed by :meth:`run`.
        executor: Where the units run.
        quiet: Print one JSON object at the end instead of text.
        outputs: Reports to write at the end.
        conclusion: What to conclude from, without a time limit. Failures that it knows are only
            counted.
        accepts_no_answer: True if the exit code is 0 although there is no answer.
        count_hazards: True if a robot burned by something its controller cannot sense also makes
            the exit code 1.
        began: When the command began.
        lasts: True if the folder still exists after the command, so that a message can name it.
    """

    def __init__(
        self,
        campaign_run: CampaignRun,
        executor: Executor,
        *,
        quiet: bool = False,
        outputs: Outputs = NO_OUTPUTS,
        conclusion: Conclusion | None = None,
        accepts_no_answer: bool = False,
        count_hazards: bool = False,
        began: Beginning | None = None,
        lasts: bool = True,
    ) -> None:
        self._conclusion = conclusion or Conclusion()
        self._accepts_no_answer = accepts_no_answer
        self._count_hazards = count_hazards
        self._config = campaign_run.config
        self._store = campaign_run.store
        self._quiet = quiet
        self._outputs = outputs
        self._out = campaign_run.store.out
        self._lasts = lasts
        budget = campaign_run.budget
        self._budget = budget
        self._to_conclude = (
            None
            if budget.seconds is None
            else seconds_to_conclude(campaign_run.config, budget.seconds)
        )
        self._campaign = Campaign(
            campaign_run.config,
            units=budget.units,
            seconds=None
            if budget.seconds is None or self._to_conclude is None
            else budget.seconds - self._to_conclude,
            executor=executor,
            store=campaign_run.store,
            is_known=self._conclusion.known.has,
            began=began,
        )
        self._limit = (
            f"{budget.seconds:g} s" if budget.units is None else counted(budget.units, "unit")
        )
        self._overview = Overview(CampaignResult(causes=[]), {}, {})
        # Ids of the failures in the folder's files, by stem.
        self._saved: dict[str, str] = {}
        self._status = Status.RUNNING
        self._has_searched = False
        # This holds until all earlier results have been processed.
        self._goes_on = campaign_run.done > 0
        self._summarised = time.monotonic()

    def run(self) -> int:
        """Do the campaign; return the exit code."""
        # Search. If workers died or the disk is full, report what was kept and how to continue.
        try:
            with shown_in(self._out / MEMORY, self._live), contextlib.closing(self._store):
                stopped = self._search_and_say_how_it_ended()
        except (WorkersLost, OutputError) as error:
            raise self._broken_off(error) from error
        # A run of a slow controller may take longer than the budget.
        end = time.monotonic() + _TO_DRAW
        # Report in the terminal and in files.
        with stopping_when(lambda: time.monotonic() > end):
            ending = self._ending()
            if self._quiet:
                ending.print_json()
            else:
                if is_verbose():
                    ending.print_in_detail()
                ending.print_text()
            if self._outputs:
                self._outputs.write(ending.for_ci(accepts_no_answer=self._accepts_no_answer))
        # Interrupted runs have their own message and exit code.
        if stopped and self._lasts:
            kept = len(self._store.written() if self._goes_on else self._files())
            note(
                f"interrupted; {counted(kept, 'failure')} {'is' if kept == 1 else 'are'} kept in "
                f"{self._out}; {self._way_on}"
            )
        elif stopped:
            note("interrupted; nothing was kept")
        if stopped:
            return 130
        if unfit := self._no_world_fits():
            raise unfit
        if self._failing():
            return 1
        is_open = ending.summary.answer == Answer.NONE and not self._accepts_no_answer
        return NO_ANSWER if is_open else 0

    def _broken_off(self, error: WorkersLost | OutputError) -> OutputError:
        """Return the error of a search that could not go on, with what was kept and what to do."""
        is_full = isinstance(error, OutputError)
        first = "free some space, and " if is_full else ""
        if not self._lasts:
            remedy = f"nothing was kept: {first}start again"
        elif is_full:
            remedy = f"the stored results are intact: {first}{{way_on}}"
        else:
            remedy = "the findings so far are in {out}, and {way_on}"
        return OutputError(
            "broken-off",
            "{reason}",
            remedy,
            at_terminal=self._lasts,
            reason=error.message.problem,
            out=self._out,
            way_on=self._way_on,
        )

    @property
    def _way_on(self) -> str:
        return f"worldgen fuzz --resume {shlex.quote(str(self._out))} continues it"

    def _numbers(self) -> AnswerNumbers:
        return answer_numbers(
            self._config,
            self._campaign.state,
            self._overview.result,
            {one.group for one in self._failing().values()},
        )

    @property
    def _with_more(self) -> str:
        """The command that continues the campaign with several times its budget."""
        command = f"worldgen fuzz --resume {shlex.quote(str(self._out))}"
        if self._budget.seconds is None:
            return f"{command} --units {MORE * max(self._campaign.state.until, 1)}"
        return f"{command} --budget {more_seconds(self._budget.seconds, self._numbers()) // 60}m"

    def _files(self) -> Mapping[str, Failure]:
        """Return the failures that the folder shows, by the stem of their file."""
        return self._overview.files or files_of(self._campaign.state.best.values())

    def _failing(self) -> dict[str, Failure]:
        """Return the shown failures that make the exit code 1."""
        return {
            stem: one
            for stem, one in self._files().items()
            if self._count_hazards or not is_hazard(one)
        }

    def _hazards(self) -> dict[str, Failure]:
        """Return the shown failures whose fire the controller could not have avoided."""
        failing = self._failing()
        return {stem: one for stem, one in self._files().items() if stem not in failing}

    def _no_world_fits(self) -> InvalidParameter | None:
        """Return an error if no world could be run although there was time for it."""
        state = self._campaign.state
        if state.worlds or state.cut or not self._campaign.state.memory.strategies:
            return None
        robots = self._config.robots
        return InvalidParameter(
            "no-world-fits",
            "no world was run in {units}: the robot fits none of them"
            if robots == 1
            else "no world was run in {units}: no world has space for {robots} robots",
            "give it a smaller radius, or other families"
            if robots == 1
            else "use fewer robots, a smaller radius, or larger worlds",
            robots=robots,
            units=counted(state.units, "unit"),
        )

    def _search_and_say_how_it_ended(self) -> bool:
        """Search, and record the outcome before other processes may use the folder.

        Return whether Ctrl-C came.
        """
        self._store.save_status(Status.RUNNING)
        events = self._campaign.run()
        with contextlib.closing(events):
            try:
                executor = self._search(events)
                stopped = executor is None
                unfit = None if stopped else self._no_world_fits()
                if unfit is not None:
                    record_error(self._out, unfit)
                else:
                    stopped = self._conclude(events, executor)
            except WorldgenError:
                # A full disk may be the reason.
                with contextlib.suppress(OutputError):
                    self._keep_status(Status.FAILED)
                raise
        ended = Status.FAILED if unfit else Status.DONE
        self._keep_status(Status.STOPPED if stopped else ended)
        return stopped

    def _conclude(self, events: Generator[Progress, None, None], executor: Executor | None) -> bool:
        """Evaluate and write the findings; return whether Ctrl-C was pressed, now or before.

        Args:
            events: The campaign, which has ended its search.
            executor: Its workers; ``None`` after Ctrl-C.
        """
        self._has_searched = True
        began = Effort.so_far()
        stopped = executor is None
        if executor is not None:
            try:
                with working("running natural worlds and explaining failures"):
                    self._overview = self._build_with(events, executor)
            except KeyboardInterrupt:
                stopped = True
        events.close()
        if stopped:
            self._overview = self._build(_TO_CONCLUDE_AT_ONCE, natural=False)
        # Natural worlds may show what the search did not.
        state = self._campaign.state
        more = began.since()
        state.effort = replace(
            state.effort,
            differences=state.effort.differences | more.differences,
            lines=state.effort.lines | more.lines,
        )
        # Earlier results are not all processed, so the folder's files know more.
        if self._goes_on:
            return stopped
        self._write_examples()
        if not stopped:
            self._remove_outdated()
        write_overview(self._overview.result, self._out)
        return stopped

    def _build_with(self, events: Generator[Progress, None, None], executor: Executor) -> Overview:
        """Return the overview; the campaign's workers run the natural worlds.

        Raises:
            WorkersLost: If they ended before that.
        """

        def release() -> None:
            executor.stop()
            events.close()

        # A single worker is this process. It listens to Ctrl-C at once when the search is over.
        if executor.room == 1:
            release()
            return self._build(self._time_left(), natural=True)
        try:
            return self._build(self._time_left(), natural=True, executor=executor, release=release)
        except Exception as error:
            self._save(with_files=True)
            # The executor knows what it means.
            events.throw(error)
            raise

    def _time_left(self) -> float | None:
        """Return the seconds for the conclusion: its share, and what the search left."""
        if self._to_conclude is None or self._budget.seconds is None:
            return None
        left = self._budget.seconds - sum(self._campaign.state.times.values())
        return max(self._to_conclude, left)

    def _write_examples(self) -> None:
        """Write the failures that the overview shows, and the originals of those it has shrunk."""
        for failure in self._overview.originals:
            self._store.save_original(failure)
        self._write_files()

    def _remove_outdated(self) -> None:
        """Remove what this campaign wrote and no longer shows."""
        shown_now = {f"{stem}.grid" for stem in self._files()}
        # With a time limit, a later run may still have to take up earlier findings.
        if self._campaign.units is None:
            now = {one.group for one in self._files().values()}
            shown_now |= {name for name in self._store.written() if self._group_in(name) not in now}
        self._store.remove_failures_but(shown_now)

    def _group_in(self, name: str) -> str | None:
        """Return the group of the failure in a file; ``None`` if it cannot be read."""
        try:
            return Failure.read(self._out / name).group
        except WorldgenError:
            return None

    def _build(
        self,
        seconds: float | None,
        *,
        natural: bool,
        executor: Executor | None = None,
        release: Callable[[], None] = lambda: None,
    ) -> Overview:
        conclusion = replace(self._conclusion, seconds=seconds)
        return build_overview(
            self._config,
            self._campaign.state,
            conclusion,
            natural=natural,
            executor=executor,
            release=release,
        )

    def _keep_status(self, status: Status) -> None:
        self._status = status
        # Earlier results are not all processed, so the numbers of their summary are kept.
        if self._goes_on:
            self._store.save_status(status)
        else:
            self._store.save_summary(self._summary())

    def _summary(self) -> Summary:
        numbers = None if self._status == Status.RUNNING else self._numbers()
        return summary_of(self._config, self._campaign.state, self._status, numbers)

    def _search(self, events: Iterator[Progress]) -> Executor | None:
        """Do the work; return the workers, which are free, or ``None`` if Ctrl-C stopped it."""
        try:
            return self._watch(events)
        except KeyboardInterrupt:
            self._keep_pending()
            return None
        except WorkersLost:
            self._keep_pending()
            self._save(with_files=True)
            raise

    def _watch(self, events: Iterator[Progress]) -> Executor:
        with working(f"searching ({self._limit})") as work:
            work.say(self._so_far)
            for event in events:
                if isinstance(event, SearchEnded):
                    break
                self._see(event)
            else:
                raise RuntimeError("the campaign has no end")
        self._goes_on = False
        self._keep_pending()
        late = sum(one.shrinking != ShrinkState.DONE for one in self._files().values())
        if late and self._config.shrink:
            self._say_late(late)
        return event.executor

    def _say_late(self, late: int) -> None:
        """Print how many failures were not shrunk to the end, and why.

        If time ran out, print the command that shrinks them, too.
        """
        state = self._campaign.state
        are = (
            f"{late} of {counted(len(self._files()), 'failure')} "
            f"{'is' if late == 1 else 'are'} not fully shrunk"
        )
        if self._campaign.units is not None:
            # Without a time limit, only the limit on a slow controller's steps cuts shrinking short.
            cut = [
                stem
                for stem, one in self._files().items()
                if one.shrinking == ShrinkState.CUT_SHORT
            ]
            if cut:
                note(
                    f"{are}, because a failure gets {SHRINKING_SECONDS:.0f} s of the controller's "
                    f"steps: worldgen shrink {shlex.quote(str(self._path(cut[0])))} continues"
                )
            else:
                note(f"{are}: shrinking could not prove {'it' if late == 1 else 'them'} again")
            return
        folder = shlex.quote(str(self._out))
        note(
            f"{are}, because time ran out before shrinking finished: "
            f"worldgen fuzz --resume {folder} --units {state.until} finishes it"
        )

    def _live(self) -> LiveState:
        """Return the campaign's activity, until it ends."""
        live = self._campaign.live()
        return replace(live, phase=Phase.EXPLAINING) if self._has_searched else live

    def _so_far(self) -> str:
        """Describe the campaign in a few words."""
        live = self._campaign.live()
        if live.phase == Phase.PREPARING:
            examining = "" if self._config.fixed_map is None else " and examining the map"
            return f"preparing: loading in each process, and first runs{examining}"
        state = self._campaign.state
        shrunk = sum(one.shrinking == ShrinkState.DONE for one in state.best.values())
        to_shrink = f", {shrunk} shrunk" if self._config.shrink and state.best else ""
        # Count as the result does: errors with different reasons are one cause, and hazards that the
        # robot cannot sense do not count.
        found = {*state.best.values(), *self._campaign.pending().values()}
        causes = counted(len({one.recorded_cause for one in found if not is_hazard(one)}), "cause")
        if live.phase == Phase.SHRINKING:
            return f"shrinking {counted(live.shrinking, 'failure')}, {causes}{to_shrink}"
        # A run that does not arrive is a failure only once it and a path to the target are proved.
        return (
            f"{counted(live.worlds, 'world')}, {live.failed} not arrived, {causes}{to_shrink}"
            f"{describe_speed(live)}"
        )

    def _see(self, event: Progress) -> None:
        if isinstance(event, UnitDone):
            self._goes_on = event.again
        if not self._goes_on:
            found_one = isinstance(event, Discovery)
            self._save(at_least_after=_SUMMARY_EVERY, with_files=found_one)

    def _save(self, at_least_after: float = 0.0, *, with_files: bool = False) -> None:
        """Write the new failures, and periodically the file that reports read."""
        if with_files:
            self._write_files()
        if time.monotonic() - self._summarised >= at_least_after:
            self._store.save_summary(self._summary())
            self._summarised = time.monotonic()

    def _write_files(self) -> None:
        """Write the files of the shown failures; an unchanged one keeps its date."""
        for stem, failure in self._files().items():
            if self._saved.get(stem) == failure.id:
                continue
            path = self._path(stem)
            data = failure.dumps()
            if not path.is_file() or path.read_bytes() != data:
                self._store.write_failure(path.name, data)
            self._saved[stem] = failure.id

    def _keep_pending(self) -> None:
        """Keep failures that are proved but not yet shrunk, as they were found.

        There are none if earlier results are not all processed.
        """
        if not self._goes_on:
            self._campaign.state.best |= self._campaign.pending()

    def _path(self, stem: str) -> Path:
        return self._out / f"{stem}.grid"

    def _ending(self) -> Ending:
        """Return the campaign as it is shown at its end."""
        state = self._campaign.state
        known = self._conclusion.known
        return Ending(
            config=self._config,
            overview=self._overview,
            summary=self._summary(),
            failing=self._failing(),
            hazards=self._hazards(),
            known=known,
            variants=len({one.key for _, one in state.finds if known.is_new_variant(one)}),
            interrupted_steps=state.effort.broken,
            out=self._out,
            lasts=self._lasts,
            remedy=self._with_more,
        )
