"""Measure what a campaign finds against each controller of the library, by family.

``python -m benchmarks.library_campaigns`` gives each controller the same units of feature layouts
and of every family and prints the table of ``docs/notes/library.md``; ``--json`` prints one
object. A unit's draws depend only on the seed, so the figures are the same on every machine.
Failures are proved, but not shrunk.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import click

from benchmarks.library import controllers
from fuzz.campaign.unit import run_unit
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario
from worldgen.family import FAMILIES

# The words of a round that takes seconds; the gate runs it.
TINY = ("--units", "1", "--controller", "bug2")

# Units of each strategy.
UNITS = 1
FEATURES = "features"


@dataclass(frozen=True)
class Found:
    """The results of one controller's units of one strategy.

    Args:
        controller: Name of the controller.
        strategy: A family, or feature layouts.
        worlds: Worlds tried.
        failed: Proved failures by cause; at most 24 of one verdict and cause per unit.
    """

    controller: str
    strategy: str
    worlds: int
    failed: dict[str, int]


def search(controller: str, strategy: str, *, units: int, seed: int) -> Found:
    """Return a campaign of one controller over one strategy."""
    config = CampaignConfig(Scenario.parse(controller), seed=seed, families=(strategy,))
    worlds = 0
    met = Counter[str]()
    for unit in range(units):
        result = run_unit(config, unit)
        worlds += result.worlds
        for (cause, _), count in result.met.items():
            met[cause] += count
    return Found(controller, strategy, worlds, dict(sorted(met.items())))


def _in_words(found: Sequence[Found], strategies: Sequence[str]) -> str:
    cells = {(entry.controller, entry.strategy): entry for entry in found}
    lines = ["| | " + " | ".join(strategies) + " |", "| --- |" + " ---: |" * len(strategies)]
    for name in dict.fromkeys(entry.controller for entry in found):
        row = [cells[name, strategy] for strategy in strategies]
        lines.append(
            f"| `{name}` | "
            + " | ".join(str(sum(entry.failed.values()) or "") for entry in row)
            + " |"
        )
    return "\n".join(lines)


def main() -> None:
    """Print the table."""
    # Parse the options.
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--units", type=int, default=UNITS, help=f"units of each strategy (default {UNITS})"
    )
    parser.add_argument("--seed", type=int, default=1, help="of every campaign (default 1)")
    parser.add_argument("--controller", action="append", help="only this one; may be repeated")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    if given.units < 1:
        parser.error(f"--units {given.units} is below 1; use a number of units")
    # Search with every controller and strategy.
    strategies = [FEATURES, *FAMILIES.names()]
    found = []
    begun = time.perf_counter()
    for name in given.controller or controllers():
        for strategy in strategies:
            found.append(search(name, strategy, units=given.units, seed=given.seed))
            click.echo(
                f"{name} {strategy}: {found[-1].worlds} worlds, {found[-1].failed}", err=True
            )
    # Print the results.
    if given.json:
        click.echo(
            json.dumps(
                {
                    "seed": given.seed,
                    "units": given.units,
                    "found": [asdict(entry) for entry in found],
                }
            )
        )
        return
    worlds = sum(entry.worlds for entry in found)
    click.echo(_in_words(found, strategies))
    click.echo(f"\n{worlds} worlds, {time.perf_counter() - begun:.0f} s")


if __name__ == "__main__":
    main()
