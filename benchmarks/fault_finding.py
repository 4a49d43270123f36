"""How well a campaign finds seeded faults: for each, after how many worlds and seconds, and how small it gets.

``python -m benchmarks.fault_finding`` gives each fault of ``fuzz.faults`` the same fixed amount of work and prints a
table, with ``--json`` one object. A fault counts as found if a failure has the expected verdict and the controller
without the fault arrives in that very world, so a failure that is no fault of the fault counts for nothing.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import click

from fuzz.campaign import Campaign, Found
from fuzz.faults import FAULTS, Fault
from fuzz.session import configure
from sim.episode import simulate
from sim.run_options import RunOptions
from sim.scenario import Scenario
from worldgen.grid_file import write_world
from worldgen.world import World

__all__ = ["Row", "controller_name", "look_for", "tells"]

UNITS = 6  # feature layouts come thrice, and three families
EXAMPLES = 400  # draws of a unit of feature layouts


@dataclass(frozen=True)
class Row:
    """What became of one fault.

    Args:
        fault: Its name.
        base: The controller without it.
        sentence: What is wrong.
        expected: Verdict.
        found: Whether a failure tells the fault from the base.
        worlds: Scenarios tried until the unit with the first such failure was done, or in all.
        seconds: Likewise, shrinking included.
        kind: Class of the smallest such failure; empty without one.
        cells: Cells of its world.
        solid_cells: Solid ones.
        base_arrives: Share of the campaign's failing classes in whose smallest world the base arrives.
    """

    fault: str
    base: str
    sentence: str
    expected: str
    found: bool
    worlds: int
    seconds: float
    kind: str
    cells: int
    solid_cells: int
    base_arrives: float


def controller_name(fault: Fault) -> str:
    """The name under which a command takes the fault, with the variations of its run."""
    return f"fuzz.faults:{fault.name.replace('-', '_')}{fault.variations}"


def tells(fault: Fault, world: World) -> bool:
    """Whether the controller without the fault arrives in the world of a failure."""
    record = world.failure
    if record is None or fault.base is None:
        return False
    options = RunOptions.of(record.motion, record.seed, record.parameters)
    return simulate(replace(world, failure=None), fault.base, options).verdict == "reached"


def look_for(fault: Fault, *, units: int = UNITS, seed: int = 1, examples: int = EXAMPLES) -> tuple[Row, World | None]:
    """A campaign of a fixed amount of work against one fault: what came of it, and the smallest world that tells."""
    scenario = Scenario.parse(controller_name(fault))
    config = configure(
        controller=controller_name(fault), motion=scenario.motion, families=(), fixed_map=None,
        time_step=scenario.time_step, examples=examples, seed=seed,
    )  # fmt: skip
    campaign, started = Campaign(config, units=units), time.monotonic()
    first: tuple[int, float] | None = None
    telling: list[World] = []
    for event in campaign.run():
        if isinstance(event, Found) and _is_it(fault, event.world):
            telling.append(event.world)
            first = first or (campaign.state.worlds, time.monotonic() - started)
    worlds, seconds = first or (campaign.state.worlds, time.monotonic() - started)
    smallest = min(telling, key=lambda world: (world.solid_cells, world.width * world.height), default=None)
    record = smallest.failure if smallest else None
    row = Row(
        fault.name, fault.base.name if fault.base else "", fault.sentence, fault.expected, smallest is not None,
        worlds, round(seconds, 1), str(record.details["class"]) if record else "",
        smallest.width * smallest.height if smallest else 0, smallest.solid_cells if smallest else 0,
        _share(tells(fault, world) for world in campaign.state.best.values()),
    )  # fmt: skip
    return row, smallest


def _is_it(fault: Fault, world: World) -> bool:
    return world.failure is not None and world.failure.verdict == fault.expected and tells(fault, world)


def _share(flags: Iterable[bool]) -> float:
    all_of_them = list(flags)
    return round(sum(all_of_them) / len(all_of_them), 3) if all_of_them else 0.0


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--units", type=int, default=UNITS, help=f"work for each fault (default {UNITS})")
    parser.add_argument("--seed", type=int, default=1, help="seed of the campaigns (default 1)")
    parser.add_argument("--fault", action="append", choices=sorted(FAULTS), help="only this one; may be repeated")
    parser.add_argument("--out", type=Path, help="folder for the smallest world of each")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    rows = []
    for name in given.fault or FAULTS:
        row, world = look_for(FAULTS[name], units=given.units, seed=given.seed)
        rows.append(row)
        if given.out and world:
            write_world(world, given.out / f"{name}.grid", force=True)
        if not given.json:
            click.echo(_in_words(rows[-1]))
    found = sum(row.found for row in rows)
    if given.json:
        summary = {"units": given.units, "seed": given.seed, "faults": len(rows), "found": found}
        click.echo(json.dumps({**summary, "rows": [asdict(row) for row in rows]}))
    else:
        click.echo(f"{found} of {len(rows)} found")


def _in_words(row: Row) -> str:
    what = f"{row.kind}, {row.solid_cells} solid of {row.cells} cells" if row.found else "not found"
    return f"{row.fault:<40} {row.expected:<16} {row.worlds:>6} worlds {row.seconds:>7.1f} s  {what}"


if __name__ == "__main__":
    main()
