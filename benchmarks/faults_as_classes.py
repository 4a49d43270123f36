"""Measure how soon a campaign finds the seeded faults, compiled and as Python classes.

``python -m benchmarks.faults_as_classes`` runs a campaign, with its own plan and without shrinking,
against each fault of :mod:`benchmarks.faults` until it finds a failure that reveals the fault: with the
verdict expected of it, confirmed by replay, in a world in which the controller without the fault
arrives. It prints the CPU seconds of one core that this took; ``--json`` prints one object.
``class``: the fault as a class whose ``act`` calls the compiled function. ``interpreted``: the same
with the function's own Python, as a user would have written it.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import click

from benchmarks.faults import FAULTS
from benchmarks.finding import shows
from benchmarks.searchers import strategies
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario

# The words of a round that takes seconds; the gate runs it.
TINY = ("--seconds", "0.1", "--faults", "bug2-stale-line")

WAYS = {
    "compiled": "fuzz.faults:",
    "class": "benchmarks.as_classes:",
    "interpreted": "tests.reference.fuzz.as_classes:",
}
"""How a fault's controller is supplied, and the prefix of its name."""

# A seed whose units are done before the clock starts.
_COMPILES = 1 << 40


@dataclass(frozen=True)
class Row:
    """One campaign.

    Args:
        fault: Name of the fault.
        way: How its controller was supplied.
        found: Whether a failure revealed it.
        seconds: CPU seconds until then, or in total.
        worlds: Worlds run until then, or in total.
    """

    fault: str
    way: str
    found: bool
    seconds: float
    worlds: int


def look_for(fault: str, way: str, seconds: float, seed: int = 1) -> Row:
    """Run a campaign until a failure reveals a fault, or its time is over."""
    controller = FAULTS[fault]
    scenario = Scenario.parse(f"{WAYS[way]}{fault.replace('-', '_')}{controller.variations}")
    config = CampaignConfig(scenario, seed=seed, time_steps=(scenario.run.time_step,))
    # Compiles what they need.
    for strategy in ("native", "archive", "features"):
        next(strategies(strategy)(replace(config, seed=_COMPILES, examples=1)))
    worlds = 0
    begun = time.process_time()
    for result in strategies()(config):
        worlds += result.worlds
        found = any(shows(controller, world) for world in result.failures.values())
        spent = time.process_time() - begun
        if found or spent >= seconds:
            return Row(fault, way, found, round(spent, 2), worlds)
    raise AssertionError("a campaign has no end")


def _table(rows: Sequence[Row], ways: Sequence[str]) -> str:
    lines = [f"| fault | {' | '.join(ways)} |", "| --- |" + " ---: |" * len(ways)]
    for fault in dict.fromkeys(row.fault for row in rows):
        cells = [
            f"{row.seconds:.1f} s" if row.found else "not found"
            for row in rows
            if row.fault == fault
        ]
        lines.append(f"| `{fault}` | {' | '.join(cells)} |")
    found = [
        f"{sum(row.found for row in rows if row.way == way)} of {len(rows) // len(ways)}"
        for way in ways
    ]
    return "\n".join([*lines, f"| found | {' | '.join(found)} |"])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--seconds", type=float, default=60.0, help="CPU seconds for each fault (default 60)"
    )
    parser.add_argument("--faults", default=",".join(FAULTS), help="names, with commas between")
    parser.add_argument(
        "--ways", default=",".join(WAYS), help="of compiled, class, interpreted (default all)"
    )
    given = parser.parse_args()
    ways = given.ways.split(",")
    rows = [
        look_for(fault, way, given.seconds) for fault in given.faults.split(",") for way in ways
    ]
    found = {"seconds": given.seconds, "rows": [asdict(row) for row in rows]}
    click.echo(json.dumps(found) if given.json else _table(rows, ways))


if __name__ == "__main__":
    main()
