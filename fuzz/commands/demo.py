"""``worldgen demo``: the whole workflow on one screen, with the commands for each step."""

from __future__ import annotations

from pathlib import Path

import click

from worldgen.cli.output import emit_json, force_option, json_option, note

__all__ = ["demo"]

_SEED = 7
# This takes about ten seconds, including shrinking.
_UNITS = 3
_EXAMPLES = 200


@click.command(
    epilog="\b\n  worldgen demo --out demo\n  worldgen demo --controller bug2 --out demo-bug2"
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("demo"),
    show_default=True,
    help="Folder.",
)
@click.option("--controller", default="turn-right", show_default=True, help="Controller to test.")
@click.option("--motion", default="stepped", show_default=True, help="Motion model of the search.")
@json_option
@force_option
def demo(out: Path, controller: str, motion: str, as_json: bool, force: bool) -> None:
    """Make a world, run a robot in it and find its failures, in one go.

    Everything is written to one folder; each step prints its command. Exit code 0.
    """
    import os

    from fuzz.campaign.executors import local_executor
    from fuzz.campaign.options import CampaignOptions
    from fuzz.campaign.session import CampaignSession, configure
    from fuzz.campaign.store import Budget, begin
    from fuzz.report import write_report
    from worldgen.errors import OutputError

    # Make the folder, a world and a run in it.
    if out.exists() and not force:
        raise OutputError(
            "file-exists",
            "{out} already exists",
            "give --force to overwrite the folder's files, or choose another folder with --out",
            at_terminal=True,
            out=out,
        )
    out.mkdir(parents=True, exist_ok=True)
    _world_and_run(out, controller)
    # Search for failures.
    failures = out / "failures"
    amount = f"--units {_UNITS} --examples {_EXAMPLES} --seed 1"
    _say(f"worldgen fuzz --controller {controller} --motion {motion} {amount} --out {failures}")
    config = configure(CampaignOptions(controller=controller, motion=motion, examples=_EXAMPLES), 1)
    campaign_run = begin(config, failures, Budget(units=_UNITS), force=True)
    code = CampaignSession(campaign_run, local_executor(os.cpu_count() or 1), quiet=as_json).run()
    if code not in (0, 1):
        raise SystemExit(code)
    # Replay, draw and report them.
    replayed = _replay_and_draw(failures)
    page = out / "report.html"
    _say(f"worldgen report {failures} --out {page}")
    write_report([failures], page, force=True)
    note(f"wrote {page}")
    if as_json:
        emit_json({"folder": str(out), "page": str(page), "failures": replayed})


def _say(command: str) -> None:
    note(f"\n$ {command}")


def _world_and_run(out: Path, controller: str) -> None:
    from sim import simulate
    from sim.drawing.picture import trail_of
    from worldgen import generate, write_world
    from worldgen.cli.output import write_bytes
    from worldgen.render import draw_png

    path = out / "w.grid"
    picture = out / "run.png"
    _say(f"worldgen maze --size 60 --seed {_SEED} --out {path}")
    world = generate("maze", _SEED, size=60)
    write_world(world, path, force=True)
    _say(f"worldgen run {path} --controller {controller} --trail {picture}")
    episode = simulate(world, controller, record=True)
    title = f"{controller}, swept: {episode.verdict}"
    write_bytes(picture, draw_png(world, trail=trail_of(episode, world), title=title), force=True)
    note(f"{episode.verdict} after {episode.steps} steps; wrote {picture}")


def _replay_and_draw(folder: Path) -> list[dict[str, object]]:
    from fuzz.describe import run_to_draw
    from fuzz.failure import Failure
    from fuzz.triage.judging import replay
    from sim.drawing.picture import trails_of
    from worldgen.cli.output import write_bytes
    from worldgen.render import draw_png

    _say(f"worldgen replay {folder}")
    replayed: list[dict[str, object]] = []
    for path in sorted(folder.glob("*.grid")):
        failure = Failure.read(path)
        picture = path.with_suffix(".png")
        again = replay(failure)
        trail = trails_of(run_to_draw(failure)[0], failure.world)
        write_bytes(picture, draw_png(failure.stored, trail=trail, title=path.stem), force=True)
        said = "confirmed" if again.confirmed else f"not confirmed: {again.reason}"
        note(f"{path.name}: {again.verdict} {said}; drawn in {picture}")
        replayed.append({"file": str(path), "verdict": again.verdict, "confirmed": again.confirmed})
    return replayed
