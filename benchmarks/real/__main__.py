"""Measure how soon a campaign finds the fault planted in each of twelve real controllers.

``python -m benchmarks.real`` prints a table; ``--json`` prints one object. For each fault it runs three
searches, each in its own CPU time: a plain loop over small worlds on one core, a Hypothesis test over
the same worlds, and ``worldgen fuzz`` on ``--workers`` processes. ``--pace`` pads each call of ``act``
to so many milliseconds by computing. ``--correct`` does the same with the controllers without their
faults, whose campaigns should end without a failure. ``--write FOLDER`` only writes the files.

A fault counts as found by a failure that is stored, that ``worldgen replay`` confirms, and in whose
world the correct controller arrives. A campaign's budget is wall time, so on a busy machine give it
more: ``--budget 180 --within 60`` counts the faults found in 60 CPU seconds.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from benchmarks.real.campaign import campaign
from benchmarks.real.peers import hypothesis_test, plain_loop
from benchmarks.real.planting import DEEP, ROBOTS, Robot, write

# Least CPU seconds in which a campaign is expected to find what the loop finds sooner, and how many
# times as long as the loop it may take.
_LEAST, _TIMES = 2.0, 3.0


def measure(robot: Robot, folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Return one robot's row."""
    faulty = not options.correct
    for_peers = options.peer_budget if options.peer_budget is not None else options.budget
    controller = write(robot, folder / "peers", faulty=faulty, pace=options.pace)
    loop = plain_loop(controller, for_peers)
    test = hypothesis_test(controller, for_peers)
    (folder / "campaign").mkdir()
    found = campaign(
        robot, folder / "campaign", faulty=faulty, pace=options.pace, budget=options.budget,
        workers=options.workers, seed=options.seed,
    )  # fmt: skip
    limit = max(_LEAST, _TIMES * loop.first) if loop.first is not None else None
    in_time = None if limit is None else found.first is not None and found.first <= limit
    return {
        "robot": robot.name or robot.file,
        "faulty": faulty,
        "fault": robot.fault if faulty else "",
        "loop": asdict(loop),
        "hypothesis": asdict(test),
        "campaign": asdict(found),
        "in_time": in_time,
    }


def _table(rows: Sequence[dict[str, Any]], within: float) -> str:
    columns = (
        "loop: first, s", "failing", "Hypothesis: first, s", "fuzz: first, s", "CPU s", "worlds", "calls",
        "counted", "names", "answer", "exit",
    )  # fmt: skip
    lines = [f"| robot | {' | '.join(columns)} |", "| --- |" + " ---: |" * len(columns)]
    for row in rows:
        loop, test, found = (row[name] for name in ("loop", "hypothesis", "campaign"))
        cells = (
            _seconds(loop["first"]), f"{loop['failing']} of {loop['worlds']}", _seconds(test["first"]),
            _seconds(found["first"]), _seconds(found["seconds"]), str(found["worlds"]),
            str(sum(found["calls"].values())), "" if found["counted"] is None else f"{found['counted']:.0%}",
            found["names"], found["answer"], str(found["exit_code"]),
        )  # fmt: skip
        lines.append(f"| `{row['robot']}` | {' | '.join(cells)} |")
    return "\n".join([*lines, f"found in {within:g} CPU s: {_found(rows, within)} of {len(rows)}"])


def _found(rows: Sequence[dict[str, Any]], within: float) -> int:
    firsts = [row["campaign"]["first"] for row in rows]
    return sum(first is not None and first <= within for first in firsts)


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.real",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--pace", type=float, default=0.0, help="CPU time of a call of act, ms")
    parser.add_argument(
        "--budget", type=float, default=60.0, help="of each campaign, s (default 60)"
    )
    parser.add_argument("--peer-budget", type=float, help="of each peer, CPU s (default: --budget)")
    parser.add_argument(
        "--within", type=float, help="count finds within these CPU s (default: --budget)"
    )
    parser.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default=",".join(ROBOTS), help="names, with commas between")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--faulty", action="store_true", help="with their faults (default)")
    which.add_argument("--correct", action="store_true", help="without their faults")
    parser.add_argument("--write", type=Path, help="only write the controllers into this folder")
    parser.add_argument("--keep", type=Path, help="keep controllers and campaigns in this folder")
    options = parser.parse_args()
    robots = [(ROBOTS | DEEP)[name] for name in options.only.split(",")]
    if options.write is not None:
        for robot in robots:
            click.echo(write(robot, options.write, faulty=not options.correct, pace=options.pace))
        return
    within = options.budget if options.within is None else options.within
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        for robot in robots:
            folder = (options.keep or Path(temporary)) / (robot.name or robot.file)
            folder.mkdir(parents=True)
            rows.append(measure(robot, folder, options))
            click.echo(
                f"{robot.name or robot.file}: {_seconds(rows[-1]['campaign']['first'])} s", err=True
            )
    if not options.json:
        click.echo(_table(rows, within))
        return
    given = {name: getattr(options, name) for name in ("pace", "budget", "workers", "seed")}
    click.echo(json.dumps({**given, "within": within, "found": _found(rows, within), "rows": rows}))


if __name__ == "__main__":
    main()
