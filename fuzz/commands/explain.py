"""``worldgen explain``: find the smallest changes after which the robot of a failure arrives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import (
    PATH,
    check_out,
    emit_json,
    force_option,
    json_option,
    note,
    write_out,
)
from worldgen.support.plain_text import shown
from worldgen.support.progress import working

if TYPE_CHECKING:
    from fuzz.failure import Failure
    from fuzz.overview.counterfactual import Counterfactuals

EXAMPLES = (
    "\b\n  worldgen explain failures/loop-wall.grid --picture why.png"
    "\n  worldgen explain failures/ --json"
)
_PICTURES = (".png", ".svg")


@click.command(epilog=EXAMPLES)
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="PATH|DIR...")
@click.option("--controller", help="Use this controller instead of the one that the file names.")
@click.option(
    "--picture",
    type=PATH,
    metavar="OUT",
    help="Draw a single failure, with the cells that its explanation names: .png or .svg.",
)
@json_option
@force_option
def explain(
    paths: tuple[Path, ...],
    controller: str | None,
    picture: Path | None,
    as_json: bool,
    force: bool,
) -> None:
    """Report what a failure depends on, one change at a time.

    It frees each wall cell near the path, drops each event and each option, and varies start
    heading, radius, speed and time step, one at a time. A change counts only if the target is still
    provably reachable. Failures that depend on randomness, or that an oracle reported, cannot be
    explained this way. Exit code 2 if a file holds no failure that can be explained.
    """
    from fuzz.failure import Failure
    from fuzz.overview.counterfactual import counterfactuals
    from fuzz.triage.run_facts import RunFacts, run_facts
    from sim.runners.controller_time import Effort
    from sim.runners.renewal import survivors_found
    from worldgen.errors import WorldgenError
    from worldgen.files.worlds import read_worlds

    check_out("--picture", picture, *_PICTURES, force=force)
    # Explain one failure after another; skip files that have none.
    explained: list[dict[str, object]] = []
    unexplained = 0
    for path, world in read_worlds(paths):
        failure = Failure.found_in(world)
        if failure is None:
            note(f"{shown(path)}: this world has no failure; worldgen run simulates it")
            unexplained += 1
            continue
        if picture is not None and explained:
            raise click.UsageError(f"--picture {picture} shows one failure; pass a single file")
        failure = failure.driven_by(controller)
        began = Effort.so_far()
        found = problem = None
        facts = RunFacts()
        try:
            with working(f"explaining {path}"):
                facts = run_facts(failure, failure.run())
                found = counterfactuals(failure)
        except WorldgenError as error:
            problem = error
        # The run shows something even if no change explains it, as for a controller that crashes.
        if not as_json and (found or facts.text()):
            click.echo(f"{shown(path)}: {shown(failure.who)}: {failure.verdict}")
            for line in (*([shown(found.describe())] if found else []), *facts.text()):
                click.echo(f"  {line}")
        if found is None:
            note(f"{shown(path)}: {problem}")
            unexplained += 1
            continue
        if picture is not None:
            with working(f"drawing {picture}"):
                data = _picture(failure, found, picture.suffix)
            write_out(picture, data, force=force)
        about = {"file": str(path), "verdict": failure.verdict}
        explained.append({**about, **found.table(), **facts.table()})
        for sentence in survivors_found([failure.record.controller], began):
            note(f"note: {sentence}")
    # Print the object, and fail if a file could not be explained.
    if as_json:
        emit_json({"explained": len(explained), "failures": explained})
    if unexplained:
        raise SystemExit(2)


def _picture(failure: Failure, found: Counterfactuals, suffix: str) -> bytes:
    from fuzz.describe import run_to_draw
    from sim.drawing.picture import trails_of
    from worldgen import render
    from worldgen.render.overlay import naming

    trail = naming(trails_of(run_to_draw(failure)[0], failure.world), found.cells)
    title = f"{failure.verdict}: {found.describe()}"
    if suffix == ".svg":
        return render.draw_svg(failure.stored, trail=trail, title=title).encode()
    return render.draw_png(failure.stored, trail=trail, title=title)
