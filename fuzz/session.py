"""A campaign at a terminal: progress on stderr, failures into a folder, a summary at the end."""

from __future__ import annotations

import contextlib
import shlex
import time
from pathlib import Path

import click
from rich.console import Console
from rich.progress import Progress as Bar
from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn

from fuzz.asked import Asked, Trial
from fuzz.campaign import Campaign, Found, Progress
from fuzz.ci import NO_OUTPUTS, Finding, Outputs, Report
from fuzz.config import CampaignConfig
from fuzz.corpus import Baseline
from fuzz.crews import Crew, WorkersLost
from fuzz.failure import certified
from fuzz.lanes import check_lane
from fuzz.lanes.database import DATABASE
from fuzz.lanes.drawn import TIME_STEPS
from fuzz.ledger import Sitting
from fuzz.summary import lanes_in_words, summary_of
from fuzz.telling import describe, replay_line
from fuzz.variation import Variation
from sim.motion import MOTIONS
from sim.run_options import RunOptions
from sim.scenario import Scenario
from sim.try_out import EMPTY_ARENA, try_out
from worldgen.cli.output import emit_json, note, shown
from worldgen.errors import InvalidParameter, OutputError
from worldgen.files import write_bytes
from worldgen.grid_file import dumps
from worldgen.plain_text import counted
from worldgen.workers import ctrl_c_kept
from worldgen.world import World

__all__ = ["CampaignSession", "configure"]

_SUMMARY_EVERY = 1.0  # s, at least, between two summaries while the search goes on
_NO_FAILURE = ("reached", "sealed")  # verdicts at first look


def configure(
    *,
    controller: str,
    motion: str,
    families: tuple[str, ...],
    fixed_map: World | None,
    time_step: float | None,
    examples: int,
    seed: int,
    vary: tuple[str, ...] = (),
    database: str = "",
    shrink: bool | None = None,
    oracles: tuple[str, ...] = (),
    epoch: int = CampaignConfig.epoch,
) -> CampaignConfig:
    """Checks a campaign's parts before any work begins.

    Raises:
        InvalidParameter: If a name is unknown, or controller and motion model do not fit.
        InvalidWorld: If the map leaves no room.
    """
    usual = RunOptions.time_step
    scenario = Scenario.parse(controller, motion=motion, time_step=usual if time_step is None else time_step)
    for name in families:
        check_lane(name, scenario)
    time_steps: tuple[float, ...] = (scenario.time_step,)
    if time_step is None and scenario.time_step == usual and MOTIONS.get(scenario.motion).name == "endpoint":
        time_steps = TIME_STEPS
    varied = tuple(Variation.parse(text, scenario) for text in vary)
    names = [one.name for one in varied]
    if twice := {name for name in names if names.count(name) > 1}:
        raise InvalidParameter(f"--vary {min(twice)} is given twice; put all its values into one, after commas")
    _try_out(scenario, [Asked.parse(text) for text in oracles])
    wanted = fixed_map is None if shrink is None else shrink
    return CampaignConfig(
        scenario,
        seed,
        families,
        time_steps,
        varied,
        fixed_map,
        examples=examples,
        shrink=wanted,
        oracles=oracles,
        database=database,
        epoch=epoch,
    )


def _try_out(scenario: Scenario, asked: list[Asked]) -> None:
    """One short run in an empty arena, judged by each oracle, so that a name or a compile error shows at once."""
    outcome = try_out(scenario)
    if outcome.verdict == "hang" and outcome.steps == 1:  # so would every run, each for the whole start-up deadline
        raise InvalidParameter(
            f"{scenario.controller} does not answer its first observation within {outcome.fault['deadline']} s; does "
            "it flush its output after each line? docs/controllers.md has the protocol"
        )
    proved = certified(EMPTY_ARENA) or EMPTY_ARENA
    for oracle in asked:
        oracle.objection(Trial(proved, scenario.controller, scenario.options(EMPTY_ARENA, 2)))


class CampaignSession:
    """Runs a campaign and keeps its folder.

    Args:
        sitting: The campaign, with its folder and how long it is to search; closed by :meth:`run`.
        crew: Who does the work.
        quiet: Print one JSON object at the end instead of text.
        outputs: Reports to write at the end.
        baseline: Failures whose classes are known: they are counted only; none if left out.
    """

    def __init__(
        self,
        sitting: Sitting,
        crew: Crew,
        *,
        quiet: bool = False,
        outputs: Outputs = NO_OUTPUTS,
        baseline: Baseline | None = None,
    ) -> None:
        self._baseline = baseline or Baseline()
        self._config, self._folder, self._quiet, self._outputs = sitting.config, sitting.folder, quiet, outputs
        self._out = sitting.folder.out
        goal = sitting.goal
        self._campaign = Campaign(
            sitting.config,
            units=goal.units,
            seconds=goal.seconds,
            crew=crew,
            ledger=sitting.folder,
            is_known=self._baseline.has,
        )
        self._limit = f"{goal.seconds:g} s" if goal.units is None else counted(goal.units, "unit")
        self._unsaved: set[str] = set()
        self._goes_on = sitting.done > 0  # until all that was done before has been gone through
        self._summarised = time.monotonic()

    def run(self) -> int:
        """Does the campaign; returns the exit code."""
        way_on = f"worldgen fuzz --resume {shlex.quote(str(self._out))} goes on"
        try:
            with contextlib.closing(self._folder):
                stopped = self._search()
        except WorkersLost as error:
            raise OutputError(f"{error}; what was found until then is in {self._out}, and {way_on}") from error
        except OutputError as error:
            raise OutputError(f"{error}; what is there is whole: make room, and {way_on}") from error
        self._report()
        if self._outputs:
            self._outputs.write(self._as_report())
        if stopped:
            kept = counted(len(self._campaign.state.best), "failure")
            note(f"interrupted; {kept} {'is' if kept.startswith('1 ') else 'are'} kept in {self._out}; {way_on}")
            return 130
        self._check_that_anything_ran()
        return 1 if self._campaign.state.best else 0

    def _check_that_anything_ran(self) -> None:
        """Raises if no world could be run: a build must not take that for a controller without failures."""
        state = self._campaign.state
        if state.worlds == 0 and state.memory.lanes.keys() - {DATABASE}:
            raise InvalidParameter(
                f"no world was run in {counted(state.units, 'unit')}: the robot fits none of them; give it a smaller "
                "radius, or other families"
            )

    def _search(self) -> bool:
        """Does the work; returns whether Ctrl-C stopped it."""
        try:
            self._watch()
        except KeyboardInterrupt:
            self._save_pending()
            return True
        except WorkersLost:
            self._save_pending()
            raise
        return False

    def _watch(self) -> None:
        console = Console(stderr=True)
        columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
        events = self._campaign.run()
        with (
            Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar,
            ctrl_c_kept() as listen,
            contextlib.closing(events),
        ):
            task = bar.add_task(f"searching ({self._limit})", total=None)
            for event in events:
                listen()
                self._see(event)
                state = self._campaign.state
                bar.update(
                    task,
                    description=f"searching ({self._limit}): {state.worlds} worlds, "
                    f"{sum(n for verdict, n in state.verdicts.items() if verdict not in _NO_FAILURE)} failed, "
                    f"{counted(len(state.best), 'class', 'classes')}",
                )
        self._goes_on = False
        if (late := len(self._save_pending())) and self._config.shrink:
            kinds, units = len(self._campaign.state.best), self._campaign.state.units
            note(
                f"{late} of {counted(kinds, 'class', 'classes')} {'is' if late == 1 else 'are'} as found, for the time "
                f"was over before shrinking was: worldgen fuzz --resume {shlex.quote(str(self._out))} --units {units} "
                "does the rest"
            )

    def _see(self, event: Progress) -> None:
        if isinstance(event, Found):
            self._unsaved.add(event.kind)
        else:
            self._goes_on = event.again
        if not self._goes_on:
            self._save(at_least_after=_SUMMARY_EVERY)

    def _save(self, at_least_after: float = 0.0) -> None:
        """Writes the failures that are new, and from time to time what reports read."""
        for kind in sorted(self._unsaved):
            data = dumps(self._campaign.state.best[kind])
            path = self._path(kind)
            if not path.is_file() or path.read_bytes() != data:  # when it was first seen stays
                write_bytes(path, data, force=True)
        self._unsaved.clear()
        if time.monotonic() - self._summarised >= at_least_after:
            self._folder.save_summary(summary_of(self._config, self._campaign.state))
            self._summarised = time.monotonic()

    def _save_pending(self) -> dict[str, World]:
        """What was proved but not shrunk yet is kept as it is; nothing where not even the earlier is gone through."""
        if self._goes_on:
            return {}
        pending = self._campaign.pending()
        self._campaign.state.best |= pending
        self._unsaved |= pending.keys()
        self._save()
        return pending

    def _path(self, kind: str) -> Path:
        return self._out / f"{kind}.grid"

    def _report(self) -> None:
        state = self._campaign.state
        if self._quiet:
            emit_json(summary_of(self._config, state) | {"failures": self._failures()})
            return
        for kind, world in sorted(state.best.items()):
            click.echo(describe(world, self._path(kind), met=state.met))
        click.echo(lanes_in_words(state))
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in state.verdicts.most_common())
        click.echo(
            f"seed {self._config.seed}: {counted(state.units, 'unit')}, {counted(state.worlds, 'world')}, "
            f"{counted(state.steps, 'step')} in {state.seconds:.1f} s; at first look {verdicts or 'nothing'}"
        )
        if state.known:
            often = ", ".join(f"{shown(kind)} {counted(times, 'time')}" for kind, times in sorted(state.known.items()))
            click.echo(f"known: {counted(len(state.known), 'class', 'classes')}, met {often}")
        if not state.best:
            what = "new failure" if state.known else "failure"
            click.echo(f"no {what} of {self._config.scenario.label()} under {self._config.scenario.motion} found")

    def _as_report(self) -> Report:
        """The campaign for the programs that run tests for a team."""
        state, scenario = self._campaign.state, self._config.scenario
        best = sorted(state.best.items())
        facts = {"controller": shown(scenario.label(scenario.motion, scenario.time_step)), "motion": scenario.motion}
        numbers = {"seed": self._config.seed, "units": state.units, "worlds": state.worlds, "steps": state.steps}
        facts |= {name: str(number) for name, number in numbers.items()} | {"seconds": f"{state.seconds:.1f}"}
        new = [Finding.of(world, self._path(kind), "new") for kind, world in best]
        known = sorted((key[2], path, world) for key, (path, world) in self._baseline.failures.items())
        met = [Finding.of(world, path, "known") for kind, path, world in known if state.known[kind]]
        return Report("fuzz", (*new, *met), facts)

    def _failures(self) -> list[dict[str, object]]:
        return [
            {
                "file": str(self._path(kind)),
                "verdict": world.failure.verdict if world.failure else "",
                "class": kind,
                "solid_cells": world.solid_cells,
                "shrunk": world.failure is not None and "shrunk_from" in world.failure.details,
                "replay": replay_line(self._path(kind)),
            }
            for kind, world in sorted(self._campaign.state.best.items())
        ]
