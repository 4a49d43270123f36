"""How well a campaign finds seeded faults: for each, after how many worlds and seconds, and how small it gets.

``python -m benchmarks.fault_finding`` gives each fault of ``fuzz.faults`` the same amount of work at most, and prints a
table, with ``--json`` one object. A fault counts as found if a failure has the expected verdict and the controller
without the fault arrives in that very world, so a failure that is no fault of the fault counts for nothing.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import click

from fuzz.campaign import Campaign, Found, shrunk_or_same
from fuzz.faults import FAULTS, Fault
from fuzz.session import configure
from sim.episode import simulate
from sim.run_options import RunOptions
from sim.scenario import Scenario
from worldgen.grid_file import write_world
from worldgen.world import World

__all__ = ["Row", "controller_name", "look_for", "tells"]

UNITS = 16  # of work for each fault at most; a campaign stops when the fault is found
EXAMPLES = 100  # draws of a unit of feature layouts; a quarter of that of other families


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
        seconds: Likewise.
        kind: Class of that failure, shrunk; empty without one.
        cells: Cells of its shrunk world.
        solid_cells: Solid ones.
        shrunk_tells: Whether the controller without the fault arrives in the shrunk world, too.
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
    shrunk_tells: bool


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
    """A campaign of a fixed amount of work against one fault: what came of it, and the world that tells."""
    scenario = Scenario.parse(controller_name(fault))
    config = configure(
        controller=controller_name(fault), motion=scenario.motion, families=(), fixed_map=None,
        time_step=scenario.time_step, examples=examples, seed=seed, shrink=False,
    )  # fmt: skip
    campaign, started = Campaign(config, units=units), time.monotonic()
    failures = (event.world for event in campaign.run() if isinstance(event, Found))
    raw = next((world for world in failures if _is_it(fault, world)), None)
    worlds, seconds = campaign.state.worlds, time.monotonic() - started
    small = None if raw is None else shrunk_or_same(raw)
    shrunk_tells = small is not None and _is_it(fault, small)
    record = small.failure if small else None
    row = Row(
        fault=fault.name,
        base=fault.base.name if fault.base else "",
        sentence=fault.sentence,
        expected=fault.expected,
        found=raw is not None,
        worlds=worlds,
        seconds=round(seconds, 1),
        kind=str(record.details["class"]) if record else "",
        cells=small.width * small.height if small else 0,
        solid_cells=small.solid_cells if small else 0,
        shrunk_tells=shrunk_tells,
    )
    return row, small if shrunk_tells else raw


def _is_it(fault: Fault, world: World) -> bool:
    return world.failure is not None and world.failure.verdict == fault.expected and tells(fault, world)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--units", type=int, default=UNITS, help=f"work for each fault (default {UNITS})")
    parser.add_argument("--seed", type=int, default=1, help="seed of the campaigns (default 1)")
    parser.add_argument("--fault", action="append", choices=sorted(FAULTS), help="only this one; may be repeated")
    parser.add_argument("--out", type=Path, help="folder for the worlds")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    rows = []
    for name in given.fault or FAULTS:
        row, world = look_for(FAULTS[name], units=given.units, seed=given.seed)
        rows.append(row)
        if given.out and world:
            given.out.mkdir(parents=True, exist_ok=True)
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
    what = (
        f"{row.kind}, {row.solid_cells} solid of {row.cells} cells{'' if row.shrunk_tells else ', where both fail'}"
        if row.found
        else "not found"
    )
    return f"{row.fault:<40} {row.expected:<16} {row.worlds:>6} worlds {row.seconds:>7.1f} s  {what}"


if __name__ == "__main__":
    main()
