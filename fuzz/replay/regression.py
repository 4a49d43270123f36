"""Worlds as regression tests: is a stored failure fixed, or still as it was.

What to show and keep if not.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.failure import Failure
from fuzz.replay.answer import State, answer
from fuzz.replay.fixed import Checked, RegressionRun, arrives, is_fixed, who_drives
from fuzz.triage.judging import failure_of
from sim.controllers.contract import check_contract
from sim.describe import describe_evidence
from sim.drawing.picture import trail_of
from sim.episode import Episode, simulate
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.files.grid import read_world, write_world
from worldgen.render import draw_terminal
from worldgen.support.plain_text import shown_lines
from worldgen.world import World

__all__ = [
    "CONFIRMED",
    "FIXED",
    "Checked",
    "FailingWorld",
    "RegressionRun",
    "check",
    "fixed",
    "run",
    "tell",
]

FIXED = "fixed"
CONFIRMED = "confirmed"


@dataclass(frozen=True)
class FailingWorld:
    """A failing test's world, for a report.

    Args:
        text: Picture, file and command.
        properties: ``artifact`` and ``replay``, as far as there are any.
    """

    text: str
    properties: Mapping[str, str] = field(default_factory=dict)


def check(path: Path, expect: str = FIXED, controller: str | None = None) -> Checked:
    """Runs a stored failure, or a world, and holds the outcome against what is expected.

    Args:
        path: A ``.grid`` file.
        expect: ``fixed``: the robot now arrives, within the failure's budget or the witness's,
            whichever is longer; where the target is walled off, it goes through no wall; and the
            oracle that the failure names, if it names one, does not object. ``confirmed``: verdict,
                evidence, digest and
            certificate are as stored.
        controller: Instead of the one that the file names; a world without a failure needs one.

    Raises:
        FormatError: If the file cannot be read.
        InvalidParameter: If a name is unknown, or the file holds no failure and no controller is
            named.
        InvalidWorld: If it holds no failure and its target cannot be reached.
    """
    world = read_world(path)
    if expect == CONFIRMED:
        return _confirmed(path, Failure.of(world), controller)
    if expect != FIXED:
        raise InvalidParameter(
            "unknown-name",
            "expect={expect!r} is neither {fixed} nor {confirmed}",
            "give one of them",
            expect=expect,
            fixed=FIXED,
            confirmed=CONFIRMED,
        )
    return fixed(world, controller)


def fixed(world: World, controller: str | None = None) -> Checked:
    """Run a world, or that of a stored failure, and say why it is not fixed, if it is not.

    Args:
        world: From its file, with a failure's record or without.
        controller: Instead of the one that the record names; a world without a failure needs one.

    Raises:
        InvalidParameter: If a name is unknown, or the world holds no failure and no controller is
            named.
        InvalidWorld: If it holds no failure and its target cannot be reached.
    """
    failure = Failure.found_in(world)
    if failure is not None:
        return is_fixed(failure, controller)
    if controller is None:
        raise InvalidParameter(
            "no-failure",
            "this world holds no failure, so it names no controller",
            "give --worldgen-controller",
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
    hint = "; expect it to be fixed" if now.state is State.ARRIVES else ""
    name = driven.record.controller
    return Checked(f"{name} under {failure.record.motion}: not confirmed: {now.words}{hint}", seen)


def run(world: World, controller: str, seed: int = 0) -> tuple[RegressionRun, Episode]:
    """Runs a controller, with variations as the command line takes them, and records it.

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
    """Draws a failing test's world in plain text, and keeps it.

    Args:
        seen: What the test looked at.
        path: The file to keep it in, overwritten; ``None`` to keep nothing.
    """
    lines = []
    properties = {}
    if seen.scenario is not None and seen.episode is not None:
        lines.append(
            f"{who_drives(seen.scenario)}: {seen.episode.verdict}{describe_evidence(seen.episode)}"
        )
    trail = None if seen.episode is None else trail_of(seen.episode, seen.world)
    lines.append(draw_terminal(seen.world, trail=trail, color=False).rstrip("\n"))
    replayed_by = seen.stored
    if not replayed_by and path is not None:
        try:
            replayed_by = _keep(seen, path)
            properties["artifact"] = _near(path)
            lines.append(f"world:  {_near(path)}")
        except (WorldgenError, OSError) as error:
            lines.append(f"the world could not be kept: {error}")
    if replayed_by:
        properties["replay"] = replayed_by
        lines.append(f"replay: {replayed_by}")
    return FailingWorld(shown_lines("\n".join(lines)), properties)


def _keep(seen: RegressionRun, path: Path) -> str:
    """Writes the world, as a failure if it is one; returns the command that shows it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    file = shlex.quote(_near(path))
    if seen.scenario is None or seen.options is None:
        write_world(seen.world, path, force=True)
        return f"worldgen show {file}"
    try:
        failure = failure_of(seen.world, seen.scenario, steps=seen.options.steps)
    except WorldgenError:  # such as a run too long to be recorded
        failure = None
    write_world(seen.world if failure is None else failure.stored, path, force=True)
    if failure is not None:
        return f"worldgen replay {file}"
    label = seen.scenario.label(RunOptions.motion, RunOptions.time_step)
    return f"worldgen run {file} --controller {shlex.quote(label)} --seed {seen.scenario.seed}"


def _near(path: Path) -> str:
    """The path as seen from here, if it is below."""
    try:
        return str(path.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(path)
