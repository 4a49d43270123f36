"""``worldgen watchdog``: measure what a watchdog misses, and what it interrupts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fuzz.commands._options import Duration
from worldgen.cli.output import PATH, SEED, emit_json, emit_list, json_option, note
from worldgen.support.plain_text import counted
from worldgen.support.progress import working

if TYPE_CHECKING:
    from fuzz.watchdogs import WatchdogResult

EXAMPLES = (
    "\b\n  worldgen watchdog ./mine.py:Progress failures/"
    "\n  worldgen watchdog simple-progress,simple-progress+movement_time_allowance=5 failures/"
)
_COLUMNS = {
    "watchdog": "watchdog",
    "missed": "loops missed",
    "interrupted": "arrivals interrupted",
    "typical": "alarm after, median",
    "late": "90 %",
    "last": "longest",
}


@click.command(epilog=EXAMPLES)
@click.argument("watchdogs", metavar="A,B,C")
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="PATH|DIR...")
@click.option(
    "--worlds",
    type=click.IntRange(0, 100_000),
    default=100,
    show_default=True,
    help="Number of natural worlds in which each controller of the failures drives.",
)
@click.option("--seed", type=SEED, default=0, show_default=True, help="Seed of these worlds.")
@click.option(
    "--horizon",
    type=Duration(),
    default="60s",
    show_default=True,
    metavar="TIME",
    help="Time after a loop's beginning in which the alarm has to come; at least two periods.",
)
@json_option
def watchdog(
    watchdogs: str, paths: tuple[Path, ...], worlds: int, seed: int, horizon: float, as_json: bool
) -> None:
    """Measure how well watchdogs tell robots that never arrive.

    A watchdog is code next to a controller that raises an alarm when the robot makes no progress.
    It runs here over the proved loops in PATH or DIR, and over runs of the same controllers in
    natural worlds that are proved to loop or arrive. simple-progress, pose-progress and oscillation
    come with worldgen; docs/howto/watchdog.md shows how to write your own.
    """
    from fuzz.commands._failure_files import FailureFiles
    from fuzz.watchdogs import WATCHDOGS, drives_of, judge, watchdog_named

    names = [name for name in watchdogs.split(",") if name]
    if not names:
        raise click.UsageError(f"name a watchdog, such as {', '.join(WATCHDOGS)}")
    # A wrong name or field is refused before anything runs.
    for name in names:
        watchdog_named(name)
    files = FailureFiles(paths)
    with working("running") as work:
        drives, left_out = drives_of(
            ((str(path), failure) for path, failure in files), worlds, seed=seed, progress=work.say
        )
        results = judge(names, drives, horizon=horizon, progress=work.say)
    if left_out:
        note(f"skipped {counted(left_out, 'failure')} without a proved loop of one robot")
    if as_json:
        facts = [_facts(result) for result in results]
        emit_json({"watchdogs": facts, "horizon": horizon, "left_out": left_out})
    else:
        emit_list("watchdogs", [_row(one) for one in results], _COLUMNS, as_json=False)
        for result in results:
            _name_examples(result)
    if not files.is_complete:
        raise SystemExit(2)


def _row(result: WatchdogResult) -> dict[str, str]:
    times = [result.latency(share) for share in (0.5, 0.9, 1.0)]
    typical, late, last = ("-" if time is None else f"{time:.1f} s" for time in times)
    return {
        "watchdog": result.watchdog,
        "missed": _rate(len(result.missed), result.loops, result.missed_interval),
        "interrupted": _rate(len(result.interrupted), result.arrivals, result.interrupted_interval),
        "typical": typical,
        "late": late,
        "last": last,
    }


def _rate(count: int, total: int, interval: tuple[float, float]) -> str:
    if not total:
        return "none ran"
    low, high = interval
    return f"{count} of {total} ({100 * low:.0f} to {100 * high:.0f} %)"


def _name_examples(result: WatchdogResult) -> None:
    """Name a run of each mistake, for the user to look at."""
    for names, what in ((result.missed, "missed"), (result.interrupted, "interrupted")):
        if names:
            note(f"{result.watchdog} {what} {names[0]}" + (", ..." if len(names) > 1 else ""))


def _facts(result: WatchdogResult) -> dict[str, object]:
    return {
        "watchdog": result.watchdog,
        "loops": result.loops,
        "missed": result.missed,
        "missed_interval": result.missed_interval,
        "arrivals": result.arrivals,
        "interrupted": result.interrupted,
        "interrupted_interval": result.interrupted_interval,
        "latencies": result.latencies,
    }
