"""``worldgen demo``: the main commands in sequence, on one screen."""

from __future__ import annotations

import contextlib
import shlex
import sys
from pathlib import Path

import click

from worldgen.cli.output import PATH, emit_json, force_option, json_option, note
from worldgen.support.results import results_to

_SEED = 7
# This takes about ten seconds, including shrinking.
_UNITS = 3
_EXAMPLES = 200


@click.command(
    epilog="\b\n  worldgen demo --out demo\n  worldgen demo --controller bug2 --out demo-bug2"
)
@click.option("--out", type=PATH, default=Path("demo"), show_default=True, help="Folder to write.")
@click.option("--controller", default="turn-right", show_default=True, help="Controller to test.")
@click.option("--motion", default="stepped", show_default=True, help="Motion model of the search.")
@json_option
@force_option
def demo(out: Path, controller: str, motion: str, as_json: bool, force: bool) -> None:
    """Make a world, run a robot in it and find its failures, in one command.

    Prints each command before it runs it. Everything is written to one folder. Exits with 0.
    """
    from sim.controllers import CONTROLLERS
    from sim.motion import MOTIONS
    from worldgen.errors import OutputError

    if out.exists() and not force:
        raise OutputError(
            "file-exists",
            "{out} already exists",
            "use --force to overwrite the folder's files, or choose another folder with --out",
            at_terminal=True,
            out=out,
        )
    # Refuse a wrong name before anything is written.
    CONTROLLERS.get(controller)
    MOTIONS.get(motion)
    out.mkdir(parents=True, exist_ok=True)
    world = str(out / "w.grid")
    failures = str(out / "failures")
    page = str(out / "report.html")
    search = ["--controller", controller, "--motion", motion]
    amount = ["--units", str(_UNITS), "--examples", str(_EXAMPLES), "--seed", "1"]
    again = ["--force"] if force else []
    commands = (
        ["maze", "--size", "60", "--seed", str(_SEED), "--out", world, *again],
        ["run", world, "--controller", controller, "--picture", str(out / "run.png"), *again],
        ["fuzz", *search, *amount, "--out", failures, *again],
        ["replay", failures],
        ["report", failures, "--out", page, *again],
    )
    # With --json, the only output on stdout is one object.
    with results_to(sys.stderr) if as_json else contextlib.nullcontext():
        for words in commands:
            note("")
            note(f"$ worldgen {shlex.join(words)}")
            _run(words)
    if as_json:
        emit_json(
            {
                "folder": str(out),
                "page": page,
                "commands": [f"worldgen {shlex.join(words)}" for words in commands],
            }
        )


def _run(words: list[str]) -> None:
    """Run one of the commands, and continue if the robot fails or no answer is found."""
    from worldgen.cli.main import cli

    try:
        cli.main(words, standalone_mode=False)
    except SystemExit as ended:
        if ended.code not in (0, 1, 4):
            raise
