"""``worldgen explain``: find the smallest changes after which the robot of a failure arrives."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fuzz.commands._options import Duration, code_option
from worldgen.cli.output import (
    PATH,
    check_out,
    emit_json,
    force_option,
    json_option,
    note,
    say,
    write_out,
)
from worldgen.support.plain_text import counted, lasting
from worldgen.support.progress import Work, working

if TYPE_CHECKING:
    from fuzz.failure import Failure

EXAMPLES = (
    "\b\n  worldgen explain failures/loop-wall.grid --picture why.png"
    "\n  worldgen explain failures/ --json"
)
_PICTURES = (".png", ".svg")
# Times the budget that an incomplete explanation is offered.
_MORE = 4


@click.command(epilog=EXAMPLES)
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="PATH|DIR...")
@click.option("--controller", help="Use this controller instead of the one that the file names.")
@click.option(
    "--picture",
    type=PATH,
    metavar="OUT",
    help="Draw a single failure, with the cells that its explanation names: .png or .svg.",
)
@click.option(
    "--budget",
    "seconds",
    type=Duration(),
    metavar="TIME",
    default="1m",
    show_default=True,
    help="Stop trying changes of a failure after this time, such as 30s or 5m.",
)
@code_option
@json_option
@force_option
def explain(
    paths: tuple[Path, ...],
    controller: str | None,
    picture: Path | None,
    seconds: float,
    no_code: bool,
    as_json: bool,
    force: bool,
) -> None:
    """Report what a failure depends on, one change at a time.

    It frees each wall cell near the path, drops each event and each option, and varies start
    heading, radius, speed and time step, one at a time. A change counts only if the target is still
    provably reachable. Failures that depend on randomness, or that an oracle reported, cannot be
    explained this way. Exit code 2 if a file holds no failure that can be explained.
    """
    from fuzz.campaign.store import controller_change
    from fuzz.commands._failure_files import FailureFiles
    from fuzz.overview.explanation import explain_failure
    from sim.clock.controller_time import Effort
    from sim.controllers.catalogue.renewal import survivors_found

    # Refuse a picture of several failures before the work.
    check_out("--picture", picture, *_PICTURES, force=force)
    files = FailureFiles(paths)
    failures: Iterable[tuple[Path, Failure]] = files
    if picture is not None:
        failures = _with_one_failure(files, picture)
    # Explain one failure after another.
    rows: list[dict[str, object]] = []
    explained = 0
    is_complete = True
    said: set[str] = set()
    change_since = functools.cache(controller_change)
    for path, failure in failures:
        began = Effort.so_far()
        with working(f"explaining {path}") as work:
            explanation = explain_failure(
                failure,
                controller,
                with_code=not no_code,
                seconds=seconds,
                progress=_counted_in(work, seconds),
            )
        folder = None if controller is not None else _campaign_folder(path)
        change = change_since(folder, failure.record.controller) if folder is not None else ""
        rows.append(
            {"file": str(path)} | explanation.table() | ({"changed": change} if change else {})
        )
        # The run shows something even if no change explains it, as for a controller that crashes.
        if not as_json and (lines := explanation.text()):
            say(f"{path}: {lines[0]}")
            for line in lines[1:]:
                say(f"  {line}")
        if change and change not in said:
            note(f"note: {change}")
            said.add(change)
        if explanation.why is None:
            note(f"{path}: {explanation.problem}")
            is_complete = False
            continue
        explained += 1
        if not explanation.why.is_complete and began.since().seconds >= seconds:
            note(
                f"{path}: not all changes were tried; --budget {math.ceil(_MORE * seconds)}s gives "
                f"it more time"
            )
        if picture is not None:
            with working(f"drawing {picture}"):
                data = explanation.picture(picture.suffix)
            write_out(picture, data, force=force)
        for sentence in survivors_found([explanation.failure.record.controller], began):
            note(f"note: {sentence}")
    # Print the object, and fail if a file could not be explained.
    if as_json:
        emit_json({"explained": explained, "failures": rows})
    if not (is_complete and files.is_complete):
        raise SystemExit(2)


def _counted_in(work: Work, seconds: float) -> Callable[[int, int], None]:
    """Return a function that adds the runs so far, and an estimate, to the message of some work."""
    message = work.message
    began = time.monotonic()

    def count(done: int, of: int) -> None:
        spent = time.monotonic() - began
        estimate = spent / done * (of - done)
        # A single run of a slow controller has a message of its own, which hides further details
        # and outlasts these figures: say when the work ends, not how long it still takes.
        if done < of and spent + estimate < seconds:
            how_far = f"{done} of about {of} runs, which take about {lasting(spent + estimate)}"
        else:
            how_far = f"{counted(done, 'run')}, for at most {lasting(seconds)}"
        work.message = f"{message}: {how_far}"

    return count


def _with_one_failure(
    failures: Iterable[tuple[Path, Failure]], picture: Path
) -> list[tuple[Path, Failure]]:
    """Return the failures; refuse several, because a picture shows only one."""
    found = list(failures)
    if len(found) > 1:
        raise click.UsageError(f"--picture {picture} shows one failure; pass a single file")
    return found


def _campaign_folder(path: Path) -> Path | None:
    """Return the campaign's folder that holds a failure's file, itself or in its store."""
    from fuzz.campaign.store import MEMORY

    return next((one for one in path.parents[:3] if (one / MEMORY).is_dir()), None)
