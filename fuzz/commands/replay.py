"""``worldgen replay``: every failure, from its file, with the same verdict and digest."""

from __future__ import annotations

from pathlib import Path

import click

from fuzz.commands._options import output_options
from worldgen.cli.output import emit_json, force_option, json_option, note, shown
from worldgen.progress import working

__all__ = ["replay"]


@click.command(epilog="\b\n  worldgen replay failures/\n  worldgen replay failures/tunnel-post.grid --show")
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="PATH|DIR...")
@click.option("--controller", help="Use this controller instead of the one that the file names.")
@click.option("--show", "with_picture", is_flag=True, help="Draw each failure in the terminal.")
@output_options
@json_option
@force_option
def replay(
    paths: tuple[Path, ...],
    controller: str | None,
    with_picture: bool,
    as_json: bool,
    force: bool,
    **outputs: Path | None,
) -> None:
    """Run saved failures again and compare verdict, evidence, trace digest and certificate.

    Exit code 0 if every one is confirmed, 1 if one is not, else 2 if a file holds no failure.
    """
    from fuzz.ci import Finding, Outputs, Report, State
    from fuzz.failure import replay as replay_failure
    from fuzz.telling import describe
    from worldgen.world_files import read_worlds

    reports = Outputs(**outputs, force=force)
    reports.check()
    results: list[dict[str, object]] = []
    findings: list[Finding] = []
    without = 0
    for path, world in read_worlds(paths):
        if world.failure is None:
            note(f"{shown(path)}: this world holds no failure; worldgen run simulates it")
            without += 1
            continue
        with working("replaying") as work:
            work.say(f"{path}, failure {len(results) + 1}")
            outcome = replay_failure(world, controller)
        results.append({"file": str(path), "verdict": outcome.verdict, "confirmed": outcome.confirmed})
        if not as_json:
            click.echo(
                f"{shown(path)}: {outcome.verdict} "
                + ("confirmed" if outcome.confirmed else f"NOT confirmed: {shown(outcome.reason)}")
            )
            if with_picture and outcome.confirmed:
                click.echo(describe(world, path))
        if reports:
            state: State = "confirmed" if outcome.confirmed else "not confirmed"
            findings.append(Finding.of(world, path, state, outcome.reason, controller))
    reports.write(Report("replay", tuple(findings)))
    confirmed = sum(bool(result["confirmed"]) for result in results)
    if as_json:
        emit_json({"replayed": len(results), "confirmed": confirmed, "failures": results})
    else:
        click.echo(f"{confirmed} of {len(results)} confirmed")
    if confirmed < len(results):
        raise SystemExit(1)
    if without:
        raise SystemExit(2)
