"""A campaign at a terminal: progress on stderr, failures into a folder, a summary at the end."""

from __future__ import annotations

import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.progress import Progress as Bar
from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn

from fuzz.asked import Asked, Trial
from fuzz.campaign import Campaign, Found
from fuzz.ci import NO_OUTPUTS, Finding, Outputs, Report
from fuzz.config import CampaignConfig
from fuzz.failure import certified
from fuzz.lanes.drawn import LAYOUT_LANES, SEALED, TIME_STEPS, can_breach
from fuzz.telling import describe, replay_line
from fuzz.variation import Variation
from sim.episode import prepare
from sim.motion import MOTIONS
from sim.run_options import RunOptions
from sim.scenario import Scenario
from worldgen.cli.output import emit_json, note, shown
from worldgen.errors import InvalidParameter, OutputError
from worldgen.family import FAMILIES
from worldgen.grid_file import write_world
from worldgen.world import Pose, Target, World

__all__ = ["CampaignSession", "configure"]

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
    shrink: bool | None = None,
    oracles: tuple[str, ...] = (),
) -> CampaignConfig:
    """Checks a campaign's parts before any work begins.

    Raises:
        InvalidParameter: If a name is unknown, or controller and motion model do not fit.
        InvalidWorld: If the map leaves no room.
    """
    for name in families:
        if name not in LAYOUT_LANES:
            FAMILIES.get(name)
    usual = RunOptions.time_step
    scenario = Scenario.parse(controller, motion=motion, time_step=usual if time_step is None else time_step)
    if SEALED in families and not can_breach(scenario):
        raise InvalidParameter(
            f"family {SEALED!r} has walled-off targets, which only a robot reaches that goes on past a wall: take "
            "--motion stepped without +keep_going, or another family"
        )
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
        scenario, seed, families, time_steps, varied, fixed_map, examples=examples, shrink=wanted, oracles=oracles
    )


def _try_out(scenario: Scenario, asked: list[Asked]) -> None:
    """One short run in an empty arena, judged by each oracle, so that a name or a compile error shows at once."""
    arena = World(np.zeros((8, 8), bool), Pose(0.35, 0.35, 0.0), Target(0.6, 0.6, 0.05))
    run = prepare(arena, scenario.controller, scenario.options(arena, 2))
    outcome = run.run(2, find_loop=False, record=False, digest=False)
    if outcome.verdict == "hang" and outcome.steps == 1:  # so would every run, each for the whole start-up deadline
        raise InvalidParameter(
            f"{scenario.controller} does not answer its first observation within {outcome.fault['deadline']} s; does "
            "it flush its output after each line? docs/controllers.md has the protocol"
        )
    proved = certified(arena)
    for oracle in asked:
        oracle.objection(Trial(arena if proved is None else proved, scenario.controller, scenario.options(arena, 2)))


class CampaignSession:
    """Runs a campaign and keeps its folder.

    Args:
        config: What to look for.
        out: Folder of the failures; made if it is missing.
        units: Amount of work, or ``None``.
        seconds: Time to search, or ``None``.
        workers: Processes.
        force: Whether files of the same name may be replaced.
        quiet: Print one JSON object at the end instead of text.
        outputs: Reports to write at the end.
    """

    def __init__(
        self,
        config: CampaignConfig,
        out: Path,
        *,
        units: int | None,
        seconds: float | None,
        workers: int,
        force: bool,
        quiet: bool,
        outputs: Outputs = NO_OUTPUTS,
    ) -> None:
        self._config, self._out, self._quiet, self._outputs = config, out, quiet, outputs
        self._campaign = Campaign(config, units=units, seconds=seconds, workers=workers)
        self._limit = f"{units} units" if units else f"{seconds:g} s"
        _prepare_folder(out, force)

    def run(self) -> int:
        """Does the campaign; returns the exit code."""
        started, stopped = time.monotonic(), False
        try:
            self._watch()
        except KeyboardInterrupt:
            stopped = True
            self._save_pending()
        except BrokenProcessPool as error:
            self._save_pending()
            raise OutputError(
                f"a worker process died, perhaps killed by the controller or for want of memory ({error}); "
                f"what was found until then is in {self._out}"
            ) from error
        best = self._campaign.state.best
        self._report(time.monotonic() - started)
        if self._outputs:
            self._outputs.write(self._as_report(time.monotonic() - started))
        if stopped:
            note(f"interrupted; {len(best)} failures are kept in {self._out}")
            return 130
        return 1 if best else 0

    def _watch(self) -> None:
        console = Console(stderr=True)
        columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
        with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task(f"searching ({self._limit})", total=None)
            for event in self._campaign.run():
                state = self._campaign.state
                if isinstance(event, Found):
                    self._save(event.kind, event.world)
                bar.update(
                    task,
                    description=f"searching ({self._limit}): {state.worlds} worlds, "
                    f"{sum(n for verdict, n in state.verdicts.items() if verdict not in _NO_FAILURE)} failed, "
                    f"{len(state.best)} classes",
                )

    def _save(self, kind: str, world: World) -> None:
        write_world(world, self._path(kind), force=True)

    def _save_pending(self) -> None:
        """After Ctrl-C: what was proved but not shrunk yet is kept as it is."""
        for kind, world in self._campaign.pending().items():
            if kind not in self._campaign.state.best:
                self._campaign.state.best[kind] = world
                self._save(kind, world)

    def _path(self, kind: str) -> Path:
        return self._out / f"{kind}.grid"

    def _report(self, seconds: float) -> None:
        state = self._campaign.state
        if self._quiet:
            emit_json(self._summary(seconds))
            return
        for kind, world in sorted(state.best.items()):
            click.echo(describe(world, self._path(kind), met=state.met))
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in state.verdicts.most_common())
        click.echo(
            f"seed {self._config.seed}: {state.units} units, {state.worlds} worlds, {state.steps} steps "
            f"in {seconds:.1f} s; at first look {verdicts or 'nothing'}"
        )
        if not state.best:
            click.echo(f"no failure of {self._config.scenario.label()} under {self._config.scenario.motion} found")

    def _as_report(self, seconds: float) -> Report:
        """The campaign for the programs that run tests for a team."""
        state, scenario = self._campaign.state, self._config.scenario
        best = sorted(state.best.items())
        facts = {"controller": shown(scenario.label(scenario.motion, scenario.time_step)), "motion": scenario.motion}
        numbers = {"seed": self._config.seed, "units": state.units, "worlds": state.worlds, "steps": state.steps}
        facts |= {name: str(number) for name, number in numbers.items()} | {"seconds": f"{seconds:.1f}"}
        return Report("fuzz", tuple(Finding.of(world, self._path(kind), "new") for kind, world in best), facts)

    def _summary(self, seconds: float) -> dict[str, object]:
        state = self._campaign.state
        return {
            "seed": self._config.seed,
            "units": state.units,
            "worlds": state.worlds,
            "steps": state.steps,
            "seconds": round(seconds, 3),
            "verdicts": dict(state.verdicts),
            "failures": [
                {
                    "file": str(self._path(kind)),
                    "verdict": world.failure.verdict if world.failure else "",
                    "class": kind,
                    "solid_cells": world.solid_cells,
                    "replay": replay_line(self._path(kind)),
                }
                for kind, world in sorted(state.best.items())
            ],
        }


def _prepare_folder(out: Path, force: bool) -> None:
    if out.exists() and not out.is_dir():
        raise OutputError(f"{out} is a file; name a folder")
    if out.is_dir() and not force and any(out.glob("*.grid")):
        raise OutputError(
            f"{out} holds .grid files already; give --force to add to them and replace those of the same name, "
            "or name another folder"
        )
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / ".worldgen-probe"
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        raise OutputError(f"{out}: cannot be written: {error.strerror or error}") from error
