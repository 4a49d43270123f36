"""``worldgen check-scenarios``: solve the problems of the MovingAI benchmark."""

from __future__ import annotations

from pathlib import Path

import click

from worldgen.cli.output import PATH, SEED, emit_json, force_option, json_option, note, say
from worldgen.files.whole import write_bytes

EXAMPLES = (
    "\b\n  worldgen check-scenarios hog2/maps/dao hog2/scenarios/dao\n"
    "  worldgen check-scenarios maps/ scenarios/ --rows 100 --seed 1 --csv checked.csv"
)


@click.command("check-scenarios", epilog=EXAMPLES)
@click.argument("paths", metavar="PATH...", nargs=-1, required=True, type=PATH)
@click.option(
    "--rows",
    type=click.IntRange(1),
    help="Number of problems to draw from each scenario file.  [default: all]",
)
@click.option(
    "--seed", type=SEED, default=0, show_default=True, help="Seed for drawing the problems."
)
@click.option(
    "--csv",
    "table",
    type=PATH,
    metavar="OUT",
    help="Write one line for each scenario file and map.",
)
@json_option
@force_option
def check_scenarios(
    paths: tuple[Path, ...],
    rows: int | None,
    seed: int,
    table: Path | None,
    as_json: bool,
    force: bool,
) -> None:
    """Check the path lengths that MovingAI problems state.

    PATH is a .map or .scen file, or a folder that contains such files. The map of a scenario file
    is found by the name in the file. Paths are octile and do not cut corners; lengths are compared
    to the published digits.

    Exits with 0 if all agree, with 1 if some do not, and with 2 if there is nothing to check.
    """
    from worldgen.files.whole import check_output
    from worldgen.interop import scenario_check as library
    from worldgen.support.progress import working

    if table is not None:
        check_output(table, force)
    # Solve the problems of every scenario file.
    with working("checking scenarios") as work:
        found = library.find_scenarios(paths)
        reports = list(found.refused)
        for done, (scenario, maps) in enumerate(found.pairs):
            work.count(done, len(found.pairs), "scenario files")
            reports += library.check_scenario(scenario, maps, rows=rows, seed=seed)
    # Print and write the report.
    if as_json:
        emit_json({**library.total(reports), "reports": [vars(report) for report in reports]})
    else:
        say(library.as_text(reports), nl=False)
    if table is not None:
        write_bytes(table, library.as_csv(reports).encode(), force=force)
        note(f"wrote {table}")
    if any(report.fault for report in reports):
        raise click.exceptions.Exit(1)
