"""``worldgen shrink``: a failure's world, as small as it can be."""

from __future__ import annotations

from pathlib import Path

import click

from worldgen.cli.output import emit_json, force_option, json_option, note

__all__ = ["shrink"]


@click.command(epilog="\b\n  worldgen shrink big.grid --out small.grid")
@click.argument("path", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Where to write [default: NAME.shrunk.grid].")
@click.option("--seconds", type=click.FloatRange(0, min_open=True), help="Stop after this time with the best so far.")
@json_option
@force_option
def shrink(path: Path, out: Path | None, seconds: float | None, as_json: bool, force: bool) -> None:
    """Make a failure's world as small as it can be, keeping verdict and certificate.

    Frees cells, drops rows, columns and events, simplifies the start, until nothing more can go, and checks
    that independently. Ctrl-C keeps the best so far.
    """
    from fuzz.shrink import shrink as shrink_failure
    from fuzz.telling import describe
    from worldgen.errors import OutputError
    from worldgen.grid_file import read_world, write_world

    target = out or path.with_name(f"{path.name.removesuffix('.gz').removesuffix('.grid')}.shrunk.grid")
    if target.exists() and not force:
        raise OutputError(f"{target} is there already; give --force to overwrite it, or --out another name")
    result = shrink_failure(read_world(path), seconds=seconds, keep_on_interrupt=True)
    write_world(result.world, target, force=force)
    if as_json:
        emit_json(
            {
                "file": str(target),
                "solid_cells_before": result.before,
                "solid_cells": result.after,
                "width": result.world.width,
                "height": result.world.height,
                "simulations": result.simulations,
                "one_minimal": not result.left,
                "complete": result.complete,
            }
        )
        return
    click.echo(describe(result.world, target))
    state = "1-minimal" if not result.left else f"not 1-minimal: {result.left[0]}"
    note(f"wrote {target}: {result.before} -> {result.after} solid cells, {state}, {result.simulations} runs")
