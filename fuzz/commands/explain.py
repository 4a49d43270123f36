"""``worldgen explain``: find the smallest changes after which the robot of a failure arrives."""

from __future__ import annotations

from pathlib import Path

import click

from worldgen.cli.output import PATH, emit_json, json_option, note
from worldgen.support.plain_text import shown
from worldgen.support.progress import working

EXAMPLES = "\b\n  worldgen explain failures/loop-wall.grid\n  worldgen explain failures/ --json"


@click.command(epilog=EXAMPLES)
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="PATH|DIR...")
@click.option("--controller", help="Use this controller instead of the one that the file names.")
@json_option
def explain(paths: tuple[Path, ...], controller: str | None, as_json: bool) -> None:
    """Report what a failure depends on, one change at a time.

    It frees each wall cell near the path, drops each event and each option, and varies start
    heading, radius, speed and time step, one at a time. A change counts only if the target is still
    provably reachable. Failures that depend on randomness, or that an oracle reported, cannot be
    explained this way. Exit code 2 if a file holds no failure that can be explained.
    """
    from fuzz.failure import Failure
    from fuzz.overview.counterfactual import counterfactuals
    from sim.runners.renewal import survivors_found
    from worldgen.errors import WorldgenError
    from worldgen.files.worlds import read_worlds

    # Explain one failure after another; skip files that have none.
    explained: list[dict[str, object]] = []
    unexplained = 0
    for path, world in read_worlds(paths):
        failure = Failure.found_in(world)
        if failure is None:
            note(f"{shown(path)}: this world has no failure; worldgen run simulates it")
            unexplained += 1
            continue
        failure = failure.driven_by(controller)
        try:
            with working(f"explaining {path}"):
                found = counterfactuals(failure)
        except WorldgenError as error:
            note(f"{shown(path)}: {error}")
            unexplained += 1
            continue
        if not as_json:
            click.echo(f"{shown(path)}: {shown(failure.who)}: {failure.verdict}")
            click.echo(f"  {shown(found.describe())}")
        explained.append({"file": str(path), "verdict": failure.verdict, **found.table()})
        for sentence in survivors_found([failure.record.controller]):
            note(f"note: {sentence}")
    # Print the object, and fail if a file could not be explained.
    if as_json:
        emit_json({"explained": len(explained), "failures": explained})
    if unexplained:
        raise SystemExit(2)
