"""``worldgen replay``: run saved failures again and compare them bit for bit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fuzz.commands._options import output_options
from worldgen.cli.output import PATH, emit_json, force_option, json_option, note, say
from worldgen.support.progress import working

if TYPE_CHECKING:
    from fuzz.ci import CiFinding
    from fuzz.regression.answer import State


def _check(_context: click.Context, _option: click.Parameter, name: str | None) -> str | None:
    """Refuse a missing controller once, instead of once per failure."""
    from sim.controllers import CONTROLLERS

    if name is not None:
        CONTROLLERS.get(name)
    return name


@click.command(
    epilog="\b\n  worldgen replay failures/\n  worldgen replay failures/tunnel-post.grid --show"
)
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="PATH|DIR...")
@click.option(
    "--controller",
    callback=_check,
    help="Use this controller instead of the one that the file names.",
)
@click.option("--show", "with_picture", is_flag=True, help="Draw each failure in the terminal.")
@click.option(
    "--transcript",
    type=PATH,
    metavar="OUT",
    help="Save what was sent to a program (cmd:) in a single failure, for use in a debugger.",
)
@output_options
@json_option
@force_option
def replay(
    paths: tuple[Path, ...],
    controller: str | None,
    with_picture: bool,
    transcript: Path | None,
    as_json: bool,
    force: bool,
    **outputs: Path | None,
) -> None:
    """Run saved failures again and report what has changed.

    A failure is confirmed if it is the same, bit for bit: verdict, evidence, trace digest and
    certificate. Exits with 0 if all are confirmed, with 1 if any of them is not (even if the robot
    now arrives), with 2 if PATH or DIR holds no failure, if a file cannot be read, or if the
    controller cannot be loaded. Other worlds in a folder are only counted.
    """
    from fuzz.ci import Outputs
    from fuzz.commands._failure_files import FailureFiles
    from fuzz.regression.answer import answer
    from sim.clock.controller_time import Effort
    from sim.controllers.catalogue.renewal import survivors_found
    from sim.episode.describe import describe_frames
    from sim.episode.transcript import transcribed

    # Check that the reports can be written.
    reports = Outputs(**outputs, force=force)
    reports.check()
    results: list[dict[str, object]] = []
    findings: list[CiFinding] = []
    states: list[State] = []
    surviving: list[str] = []
    files = FailureFiles(paths)
    # Replay one failure after another.
    for path, failure in files:
        if transcript is not None and results:
            raise click.UsageError(
                f"--transcript {transcript} records one failure; give replay one file"
            )
        name = controller or failure.record.controller
        began = Effort.so_far()
        with working("replaying") as work, transcribed(name, transcript, force=force):
            work.say(f"{path}, failure {len(results) + 1}")
            now = answer(failure, controller)
        surviving += map(str, survivors_found([name], began))
        # Record the result for the terminal, for JSON and for the reports.
        confirmed = now.replay.confirmed
        states.append(now.state)
        results.append(
            {
                "file": str(path),
                "verdict": now.replay.verdict,
                "confirmed": confirmed,
                "state": now.state.value,
                "words": now.words,
            }
        )
        if not as_json:
            say(f"{path}: {now.words}")
            if with_picture and confirmed:
                from fuzz.overview.building import explained
                from fuzz.overview.describe import describe

                say(describe(failure, path, why=explained(failure.driven_by(controller))))
            elif now.episode is not None:
                say(describe_frames(now.episode.evidence), nl=False)
        if reports:
            from fuzz.ci import CiFinding, FindingState

            findings.append(
                CiFinding.of(
                    failure,
                    path,
                    FindingState.CONFIRMED if confirmed else FindingState.NOT_CONFIRMED,
                    now.words,
                    controller,
                )
            )
    for sentence in dict.fromkeys(surviving):
        note(f"note: {sentence}")
    # Write the reports and the summary; the exit code tells whether all are confirmed.
    if reports:
        from fuzz.ci import Report

        reports.write(Report("replay", tuple(findings)))
    _summarise(results, states, files.others, as_json=as_json)
    if not all(result["confirmed"] for result in results):
        raise SystemExit(1)
    if not files.is_complete:
        raise SystemExit(2)


def _summarise(
    results: list[dict[str, object]], states: list[State], others: int, *, as_json: bool
) -> None:
    """Print how many failures are confirmed."""
    from fuzz.regression.answer import describe_summary

    if as_json:
        confirmed = sum(bool(result["confirmed"]) for result in results)
        emit_json(
            {
                "replayed": len(results),
                "confirmed": confirmed,
                "others": others,
                "failures": results,
            }
        )
    else:
        say(describe_summary(states))
