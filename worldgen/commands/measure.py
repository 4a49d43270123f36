"""``worldgen measure``: print how hard worlds are, as a table."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import PATH, emit_data, emit_json, json_option, note, say, skip_bad_file
from worldgen.errors import InvalidWorld
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.world import World


@click.command(
    epilog="\b\n  worldgen measure w.grid\n  worldgen measure worlds/ --csv > worlds.csv"
)
@click.argument("paths", metavar="PATH...", nargs=-1, required=True, type=PATH)
@click.option(
    "--csv", "as_csv", is_flag=True, help="Print comma-separated values, one line for each world."
)
@json_option
def measure(paths: tuple[Path, ...], as_csv: bool, as_json: bool) -> None:
    """Measure how hard worlds are.

    Metrics are computed again, from the file's own witness; a map without a certificate is decided
    first. Metrics that a world does not have are left empty. For a folder or an archive, its .grid
    files are measured. docs/reference/tables.md defines every metric.
    """
    from worldgen.difficulty import OF_DISCS
    from worldgen.difficulty import measure as measured
    from worldgen.files.worlds import read_worlds
    from worldgen.reach.decision import unread_reason

    if as_csv and as_json:
        raise click.UsageError("--csv and --json are two forms of the same output; use one of them")
    results: list[tuple[Path, dict[str, float]]] = []
    try:
        with working("measuring") as work:
            for path, world in read_worlds(paths, skip_bad_file):
                work.say(f"{path}, world {len(results) + 1}")
                _check_its_own(path, world)
                if world.unread:
                    note(f"warning: {path}: {unread_reason(world.unread)}")
                if any(not robot.is_disc or robot.drive.is_car for robot in world.robots):
                    note(
                        f"note: {path}: {', '.join(sorted(OF_DISCS))} are about discs that turn on "
                        "the spot, and left out for this robot"
                    )
                results.append((path, measured(world).as_dict()))
    # Measurements are printed even if the work ends early.
    finally:
        if results:
            _tell(results, as_csv=as_csv, as_json=as_json)


def _check_its_own(path: Path, world: World) -> None:
    """Reject a file with an invalid certificate: metrics are measured along its witness.

    Raises:
        InvalidWorld: If it is invalid.
    """
    from worldgen.reach import check_certificate

    if world.certificate is not None and not (report := check_certificate(world)).valid:
        raise InvalidWorld(
            "certificate-invalid",
            "{path}: its certificate proves nothing, because {reason}",
            "remove it; the world is then decided before it is measured",
            path=path,
            reason=report.reason,
        )


def _tell(results: Sequence[tuple[Path, dict[str, float]]], *, as_csv: bool, as_json: bool) -> None:
    if as_json:
        found = [{"path": str(path), "metrics": metrics} for path, metrics in results]
        emit_json(found[0] if len(found) == 1 else {"files": found})
    elif as_csv:
        emit_data(_comma_separated(results))
    else:
        say(_table(results))


def _comma_separated(results: Sequence[tuple[Path, dict[str, float]]]) -> str:
    from worldgen.difficulty import METRICS

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["path", *METRICS])
    writer.writerows(
        [str(path), *(_cell(metrics.get(name)) for name in METRICS)] for path, metrics in results
    )
    return text.getvalue()


def _table(results: Sequence[tuple[Path, dict[str, float]]]) -> str:
    """Format one world per line, or one metric per line if there is only one world."""
    from worldgen.difficulty import METRICS
    from worldgen.support.plain_text import aligned, stacked

    if len(results) == 1:
        path, metrics = results[0]
        lines = [
            [name, _cell(metrics.get(name)), METRICS[name].unit, METRICS[name].meaning]
            for name in METRICS
        ]
        return stacked([str(path), aligned([line for line in lines if line[1]], right={1})])
    used = [name for name in METRICS if any(name in metrics for _, metrics in results)]
    head = [["", *used], ["", *(METRICS[name].unit for name in used)]]
    rows = [[str(path), *(_cell(metrics.get(name)) for name in used)] for path, metrics in results]
    return aligned([*head, *rows], right=range(1, 1 + len(used)))


def _cell(value: Any) -> str:
    return "" if value is None else f"{value:g}"
