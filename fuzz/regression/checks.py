"""Worlds as regression tests: check that a stored failure is fixed, or unchanged.

If the check fails, show the world and save it.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.failure import Failure
from fuzz.regression.answer import State, answer
from fuzz.regression.fixed import Checked, RegressionRun, arrives, is_fixed, who_drives
from fuzz.triage.judging import failure_of
from sim.controllers.contract import check_contract
from sim.drawing.picture import trails_of
from sim.episode import Episode, simulate
from sim.episode.describe import describe_evidence
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.files.grid import read_world, write_world
from worldgen.parameters.bounds import check_choice
from worldgen.render import draw_terminal
from worldgen.support.paths import real_path
from worldgen.support.plain_text import printed, shown, stacked
from worldgen.world import World

FIXED = "fixed"
CONFIRMED = "confirmed"


@dataclass(frozen=True)
class FailingWorld:
    """The world of a failing test, for a report.

    Args:
        text: Picture, file and command.
        properties: ``artifact`` and ``replay``, if they exist.
    """

    text: str
    properties: Mapping[str, str] = field(default_factory=dict)


def check(path: Path, expect: str = FIXED, controller: str | None = None) -> Checked:
    """Run a stored failure, or a world, and compare the outcome with the expected one.

    Args:
        path: A ``.grid`` file.
        expect: ``fixed``: the robot now arrives, within the failure's budget or the witness's,
            whichever is longer; if the target is walled off, it goes through no wall; and the
            oracle that the failure names, if any, finds nothing wrong. ``confirmed``: verdict,
            evidence, digest and certificate are as stored.
        controller: A controller to use instead of the recorded one; required for a world without a
            failure.

    Raises:
        FormatError: If the file cannot be read.
        InvalidParameter: If a name is unknown, or if the file holds no failure and no controller
            is given.
        InvalidWorld: If the file holds no failure and its target cannot be reached.
    """
    world = read_world(path)
    if expect == CONFIRMED:
        return _confirmed(path, Failure.of(world), controller)
    check_choice("expect", expect, (FIXED, CONFIRMED))
    return fixed(world, controller)


def fixed(world: World, controller: str | None = None) -> Checked:
    """Run a world, or a stored failure's world; if it is not fixed, report why.

    Args:
        world: The world, with or without a failure's record.
        controller: A controller to use instead of the recorded one; required for a world without a
            failure.

    Raises:
        InvalidParameter: If a name is unknown, or if the world holds no failure and no controller
            is given.
        InvalidWorld: If the world holds no failure and its target cannot be reached.
    """
    failure = Failure.found_in(world)
    if failure is not None:
        return is_fixed(failure, controller)
    if controller is None:
        raise InvalidParameter(
            "no-failure",
            "this world has no failure, so it does not name a controller",
            "use --worldgen-controller",
            at_terminal=True,
        )
    return arrives(world, controller)


def _confirmed(path: Path, failure: Failure, controller: str | None) -> Checked:
    now = answer(failure, controller)
    again = failure.replay_command(Path(_near(path)), controller)
    driven = failure.driven_by(controller)
    seen = RegressionRun(failure.world, driven.scenario, failure.options, now.episode, again)
    if now.state is State.SAME:
        return Checked("", seen)
    hint = "; the test should now expect it to be fixed" if now.state is State.ARRIVES else ""
    return Checked(f"{driven.who}: not confirmed: {now.words}{hint}", seen)


def run(world: World, controller: str, seed: int = 0) -> tuple[RegressionRun, Episode]:
    """Run a controller, with variations as on the command line, and record it.

    Raises:
        InvalidParameter: If a name or an option is unknown.
        InvalidWorld: If the robot cannot stand at the start.
    """
    scenario = Scenario.parse(controller, seed=seed % 2**64)
    options = scenario.options(world)
    episode = simulate(world, scenario.controller, options, record=True)
    check_contract(scenario.controller, episode.evidence, episode.steps)
    return RegressionRun(world, scenario, options, episode), episode


def tell(seen: RegressionRun, path: Path | None) -> FailingWorld:
    """Draw a failing test's world in plain text, and save it.

    Args:
        seen: The run that was checked.
        path: The file to save the world to, overwriting it; ``None`` to save nothing.
    """
    # Describe what happened, with the picture.
    lines = []
    properties = {}
    if seen.scenario is not None and seen.episode is not None:
        lines.append(
            f"{who_drives(seen.scenario)}: {seen.episode.verdict}{describe_evidence(seen.episode)}"
        )
    trail = None if seen.episode is None else trails_of(seen.episode, seen.world)
    lines += draw_terminal(seen.world, trail=trail, color=False).splitlines()
    # Add the command to replay it: the stored file's if that shows the same, otherwise that of a
    # newly saved file.
    replayed_by = seen.stored
    if not replayed_by and path is not None:
        try:
            replayed_by = _keep(seen, path)
            properties["artifact"] = _near(path)
            lines.append(f"world:  {_near(path)}")
        except (WorldgenError, OSError) as error:
            lines.append(f"the world could not be saved: {error}")
    if replayed_by:
        properties["replay"] = replayed_by
        lines.append(f"replay: {replayed_by}")
    safe = {name: shown(value) for name, value in properties.items()}
    return FailingWorld(printed(stacked(lines)), safe)


def _keep(seen: RegressionRun, path: Path) -> str:
    """Save the world, as a failure if it is one; return the command that shows it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    file = shlex.quote(_near(path))
    if seen.scenario is None or seen.options is None:
        write_world(seen.world, path, force=True)
        return f"worldgen show {file}"
    try:
        failure = failure_of(seen.world, seen.scenario, steps=seen.options.steps)
    except WorldgenError:  # such as for a run too long to be recorded
        failure = None
    write_world(seen.world if failure is None else failure.stored, path, force=True)
    if failure is not None:
        return f"worldgen replay {file}"
    label = seen.scenario.label(RunOptions.motion, RunOptions.time_step)
    return f"worldgen run {file} --controller {shlex.quote(label)} --seed {seen.scenario.run.seed}"


def _near(path: Path) -> str:
    """Return the path relative to the current folder, if it is below it."""
    try:
        return str(real_path(path).relative_to(Path.cwd()))
    except ValueError:
        return str(path)
