"""``worldgen run``: one controller, one world, one verdict."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from sim.commands.notes import note_unused
from sim.verdict import ARRIVALS, Verdict
from worldgen.cli.output import (
    CONTROLLER_HELP,
    emit_json,
    force_option,
    json_option,
    note,
    write_bytes,
)
from worldgen.support.progress import working

if TYPE_CHECKING:
    from sim.episode import Episode
    from sim.scenario import Scenario
    from worldgen.world import World

__all__ = ["run"]

EXAMPLES = (
    "\b\n  worldgen run w.grid --controller turn-right --trail run.png\n"
    "  worldgen run w.grid --controller ./mine.py:Robot --motion endpoint --json\n"
    "  worldgen run w.grid --controller thesis-1+noise+sensor_range=50 --motion stepped"
)
OUT = click.Path(path_type=Path)
_BLOCKED = (
    "the target cannot be reached in this world, whatever the controller does: `worldgen "
    "verify` says why"
)
_UNDECIDED = "it is undecided whether the target can be reached in this world"
_PICTURES = (".png", ".svg", ".html", ".gif")


@click.command(epilog=EXAMPLES)
@click.argument("path", type=click.Path(path_type=Path))
@click.option("--controller", required=True, help=CONTROLLER_HELP)
@click.option("--motion", default="swept", show_default=True, help="Motion model.")
@click.option("--steps", type=int, help="Budget in steps [default: 50 times the witness's time].")
@click.option("--time-step", type=float, help="Duration of a step, s [default: 0.015].")
@click.option(
    "--seed", type=click.IntRange(0, 2**64 - 1), default=0, help="Seed of random controllers."
)
@click.option(
    "--trail",
    type=OUT,
    metavar="OUT",
    help="Draw world and trail: .png, .svg, .html, or .gif, which moves.",
)
@click.option("--trace", type=OUT, metavar="OUT", help="Write t,x,y,heading per step, as CSV.")
@click.option(
    "--transcript",
    type=OUT,
    metavar="OUT",
    help="Write what a program (cmd:) is sent, to feed it to it in a debugger.",
)
@json_option
@force_option
def run(
    path: Path,
    controller: str,
    motion: str,
    steps: int | None,
    time_step: float | None,
    seed: int,
    trail: Path | None,
    trace: Path | None,
    transcript: Path | None,
    as_json: bool,
    force: bool,
) -> None:
    """Run a controller in a world and report how it ends.

    Exit code 0 if the robot arrives, 1 if it does not.
    """
    from sim.controllers.contract import check_contract
    from sim.controllers.programs.transcript import transcribed
    from sim.describe import describe_frames
    from sim.episode import simulate
    from sim.options.run import RunOptions
    from sim.scenario import Scenario
    from worldgen.files.grid import read_world
    from worldgen.files.whole import check_output
    from worldgen.support.plain_text import shown_lines

    world = read_world(path)
    duration = RunOptions.time_step if time_step is None else time_step
    scenario = Scenario.parse(controller, motion=motion, time_step=duration, seed=seed)
    options = scenario.options(world, steps)
    note_unused([scenario], seeds=["seed"])
    for out in (trail, trace):
        if out is not None:
            check_output(out, force)
    if trail is not None and trail.suffix not in _PICTURES:
        raise click.UsageError(f"--trail {trail}: name a {', '.join(_PICTURES)} file")
    with (
        transcribed(scenario.controller, transcript, force=force),
        working(f"running {scenario.label()} in {path}"),
    ):
        episode = simulate(
            world, scenario.controller, options, record=trail is not None or trace is not None
        )
    check_contract(scenario.controller, episode.evidence, episode.steps)
    reachable = _is_reachable(world, episode)
    uncertain = _why_uncertain(world, scenario)
    if as_json:
        emit_json(
            {**_summary(episode), "reachable": reachable, "arrival_uncertain": uncertain or None}
        )
    else:
        click.echo(_sentence(episode))
        click.echo(shown_lines(describe_frames(episode.evidence)), nl=False)
    if transcript is not None:
        note(f"wrote {transcript}")
    if reachable is not True and episode.verdict not in ARRIVALS:
        note(_BLOCKED if reachable is False else _UNDECIDED)
    if uncertain and episode.verdict not in ARRIVALS:
        note(f"with these disturbances no controller is sure to arrive: {uncertain}")
    if trace is not None and episode.trace is not None:
        write_bytes(trace, episode.trace.to_csv().encode(), force=force)
        note(f"wrote {trace}")
    if trail is not None:
        title = (
            f"{scenario.label()}, {scenario.run.motion}: {_sentence(episode)}, "
            f"{episode.area_covered:.4g} m2 covered"
        )
        with working(f"drawing {trail}"):
            picture = _picture(world, episode, title, trail.suffix)
        write_bytes(trail, picture, force=force)
        note(f"wrote {trail}")
    if episode.verdict not in ARRIVALS:
        raise SystemExit(1)


def _why_uncertain(world: World, scenario: Scenario) -> str:
    from sim.options.disturbances import why_arrival_is_not_certain

    return why_arrival_is_not_certain(world, scenario.run.robot)


def _is_reachable(world: World, episode: Episode) -> bool | None:
    """Return True if the target can be reached at all; None if that is undecided.

    A file without a certificate is decided only if the robot did not arrive, because that can take
    as long as the run.
    """
    from worldgen.reach import decide
    from worldgen.world import Witness

    if world.certificate is not None:
        return isinstance(world.certificate, Witness)
    if episode.verdict == Verdict.REACHED:
        return True
    return {"reachable": True, "blocked": False}.get(decide(world).result)


def _summary(episode: Episode) -> dict[str, object]:
    from sim.evidence import evidence_table

    return {
        "verdict": episode.verdict,
        "steps": episode.steps,
        "time": episode.time,
        "path_length": episode.path_length,
        "collisions": episode.collisions,
        "area_covered": episode.area_covered,
        "trace_digest": episode.trace_digest,
        "evidence": evidence_table(episode.evidence),
    }


def _sentence(episode: Episode) -> str:
    from sim.describe import describe_evidence
    from worldgen.support.plain_text import counted

    return (
        f"{episode.verdict}{describe_evidence(episode)}: {counted(episode.steps, 'step')}, "
        f"{episode.time:g} s, "
        f"{episode.path_length:.3f} m driven, {counted(episode.collisions, 'collision')}, trace "
        f"{episode.trace_digest}"
    )


def _picture(world: World, episode: Episode, title: str, suffix: str) -> bytes:
    from sim.drawing.picture import drive_of, trail_of
    from worldgen import render

    trail = trail_of(episode, world)
    if suffix == ".gif":
        return render.draw_gif(world, [drive_of(episode, world)], title=title)
    if suffix == ".svg":
        return render.draw_svg(world, trail=trail, title=title).encode()
    if suffix == ".html":
        return render.draw_html(world, trail=trail, title=title).encode()
    return render.draw_png(world, trail=trail, title=title)
