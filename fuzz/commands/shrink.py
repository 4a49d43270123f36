"""``worldgen shrink``: make a failure's world as small as possible."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fuzz.commands._options import Duration
from worldgen.cli.output import PATH, emit_data, emit_json, force_option, json_option, note, say
from worldgen.support.plain_text import lasting
from worldgen.support.progress import working

if TYPE_CHECKING:
    from fuzz.failure import Failure
    from fuzz.shrink import Shrunk
    from worldgen.world import World


# Seconds from which an estimate is shown.
_WORTH_SAYING = 1.0


def _list_passes(context: click.Context, option: click.Parameter, wanted: bool) -> None:
    """Print what shrinking simplifies, and how, and exit."""
    from fuzz.shrink import ORDER, PASSES

    if not wanted or context.resilient_parsing:
        return
    say("Passes, in order; they repeat until none of them makes the failure simpler:")
    for one in PASSES:
        say(f"  {one.name:15} {one.says}")
    say(
        "A failure is simpler than another if it has less of the following; the first difference "
        "decides:"
    )
    for measure in ORDER:
        say(f"  {measure.name:15} {measure.says}")
    context.exit()


@click.command(
    epilog="\b\n  worldgen shrink big.grid --out small.grid\n"
    "  worldgen shrink big.grid --budget 10s\n"
    "  worldgen shrink big.grid --snippet > test_small.py"
)
@click.argument("path", type=PATH)
@click.option(
    "--out",
    type=PATH,
    help="File to write.  [default: NAME.shrunk.grid, or no file with --snippet]",
)
@click.option(
    "--budget",
    "seconds",
    type=Duration(),
    metavar="TIME",
    help="Stop after this time, such as 30s or 5m, and keep the smallest world so far.",
)
@click.option(
    "--snippet",
    "as_snippet",
    is_flag=True,
    help="Print a test module that contains the shrunk world; write no file unless --out names "
    "one.",
)
@click.option(
    "--passes", is_flag=True, is_eager=True, expose_value=False, callback=_list_passes,
    help="List the passes and what simpler means.",
)  # fmt: skip
@json_option
@force_option
def shrink(
    path: Path,
    out: Path | None,
    seconds: float | None,
    as_snippet: bool,
    as_json: bool,
    force: bool,
) -> None:
    """Make the world of a failure as small as possible.

    It frees cells, drops rows, columns and events, and simplifies the start, the robot and the
    numbers, until nothing more can be removed without losing the verdict or the cause; the result is
    checked independently. Ctrl-C keeps the smallest world so far.
    """
    from fuzz.failure import Failure, ShrinkState
    from fuzz.overview.describe import describe
    from fuzz.shrink import snippet
    from sim.clock.controller_time import Effort
    from sim.controllers.catalogue.renewal import survivors_found
    from worldgen.files.whole import check_output

    if as_snippet and as_json:
        raise click.UsageError("--snippet and --json both choose what to print; use one of them")
    target = out
    # With --snippet, the test contains the world, so write a file only if one is named.
    if target is None and not as_snippet:
        name = path.name.removesuffix(".gz").removesuffix(".grid")
        target = path.with_name(f"{name}.shrunk.grid")
    if target is not None:
        check_output(target, force)
    # Shrink, and write the result.
    failure = Failure.read(path)
    began = Effort.so_far()
    result = _watched(failure, seconds)
    for sentence in survivors_found([failure.record.controller], began):
        note(f"note: {sentence}")
    if target is not None:
        result.failure.write(target, force=force)
    # Print the result in the requested form.
    if as_json and target is not None:
        emit_json(_summary(result, target))
        return
    if target is None or as_snippet:
        emit_data(snippet(result.failure))
    else:
        say(describe(result.failure, target))
    is_done = result.failure.shrinking == ShrinkState.DONE
    further = (
        "a larger --budget" if target is None else f"worldgen shrink {shlex.quote(str(target))}"
    )
    state = "1-minimal" if is_done else f"shrinking cut short, {further} continues"
    note(
        f"{f'wrote {target}: ' if target else ''}{result.before} -> {result.after} solid cells, "
        f"{state}, {result.simulations} runs"
    )
    if result.interrupted:
        note("interrupted; the smallest world so far is kept")
        raise SystemExit(130)


def _watched(failure: Failure, seconds: float | None) -> Shrunk:
    """Shrink, and report progress."""
    from fuzz.shrink import shrink as shrink_failure

    with working("shrinking") as work:
        began = time.monotonic()
        failure.run()
        run = time.monotonic() - began

        def say(world: World) -> None:
            # The check at the end frees each solid cell once, which takes a run.
            left = run * world.solid_cells
            about = f", at least {lasting(left)} left" if left >= _WORTH_SAYING else ""
            # The message stays visible while a run of a slow controller reports its steps.
            work.message = f"shrinking {_size(world)}{about}"

        say(failure.world)
        return shrink_failure(failure, seconds=seconds, progress=say, keep_on_interrupt=True)


def _size(world: World) -> str:
    return f"{world.width} x {world.height} cells, {world.solid_cells} solid"


def _summary(result: Shrunk, target: Path) -> dict[str, object]:
    return {
        "file": str(target),
        "solid_cells_before": result.before,
        "solid_cells": result.after,
        "width": result.failure.world.width,
        "height": result.failure.world.height,
        "simulations": result.simulations,
        "shrinking": result.failure.shrinking.value,
        "one_minimal": not result.left,
        "complete": result.complete,
        "interrupted": result.interrupted,
    }
