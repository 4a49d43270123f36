"""Print the thesis's table of times next to what its robots do in the worlds of corpora/thesis.

``python -m benchmarks.thesis_table`` prints the table of ``corpora/thesis/README.md``: the
comparison, the figures that the thesis published, and how well the two agree. ``--json`` prints the
agreement as one object.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from sim.compare.comparison import Comparison, ComparisonCell, NamedWorld, compare, standing
from sim.compare.report import as_text
from sim.scenario import Scenario
from worldgen import read_world
from worldgen.support.plain_text import aligned

# The words of a round that takes seconds; the gate runs it.
TINY = ("--seeds", "1", "--steps", "2000")

FOLDER = Path(__file__).parents[1] / "corpora" / "thesis"
NAMES = tuple(f"config-{k:02d}" for k in range(1, 11))
ROBOTS = ("thesis-1", "thesis-2", "thesis-3")
# s
TICK = 0.015
# Five minutes: most of the endless runs are proved to be loops by then.
STEPS = 20_000
# Fractions between which the middle 95 % of the seeds are.
_MIDDLE = (0.025, 0.975)
# s; times are rounded to this.
_SAME = 1e-9

Times = dict[tuple[str, str], list[float]]
"""Published times, s, by world and robot; ``inf`` for "never"."""


def published() -> Times:
    """Read the thesis's figures; two cells of a world may have a figure of the text, too."""
    found: Times = {}
    text = (FOLDER / "published.csv").read_text(encoding="utf-8")
    for row in csv.DictReader(io.StringIO(text)):
        time = math.inf if row["time"] == "never" else float(row["time"])
        found.setdefault((row["world"], row["controller"]), []).append(time)
    return found


def run(seeds: int = 100, first_seed: int = 0, steps: int = STEPS) -> Comparison:
    """Run the thesis's robots in its ten worlds."""
    worlds = [NamedWorld(name, read_world(FOLDER / f"{name}.grid")) for name in NAMES]
    robots = {
        name: Scenario.parse(name, motion="stepped", time_step=TICK, seed=first_seed)
        for name in ROBOTS
    }
    return compare(worlds, robots, seeds=seeds, steps=steps)


@dataclass(frozen=True)
class Agreement:
    """How well the published table agrees with ours.

    Args:
        rankings: Number of worlds in which both rank the robots in the same order.
        never: Number of cells in which both have "never", and of cells in which either has.
        within: Number of published times of the random rule within the middle 95 % of our seeds,
            and of all of them.
        largest: Largest relative deviation of a rule without randomness; of several figures for one
            cell, the nearest counts.
    """

    rankings: int
    never: tuple[int, int]
    within: tuple[int, int]
    largest: float


def agreement(comparison: Comparison, figures: Times) -> Agreement:
    """Compare a table with the published figures."""
    cells = [cell for row in comparison.cells for cell in row]
    pairs = [(cell, figures[cell.world, cell.label]) for cell in cells]
    never = [(cell.is_unended, math.inf in times) for cell, times in pairs]
    low, high = _MIDDLE
    within = [
        _share(cell, time + _SAME) >= low and _share(cell, time - _SAME) <= high
        for cell, times in pairs
        for time in times
        if cell.random and time < math.inf
    ]
    deviations = [
        min(((cell.time - time) / time for time in times), key=abs)
        for cell, times in pairs
        if not cell.random and cell.time is not None and math.inf not in times
    ]
    same = sum(
        _order([cell.rank_time for cell in row])
        == _order([_nearest(cell, figures[cell.world, cell.label]) for cell in row])
        for row in comparison.cells
    )
    return Agreement(
        same,
        (sum(ours and theirs for ours, theirs in never), sum(map(any, never))),
        (sum(within), len(within)),
        max(deviations, key=abs, default=0.0),
    )


def _share(cell: ComparisonCell, time: float) -> float:
    return sum(run.time <= time for run in cell.arrivals) / len(cell.runs)


def _nearest(cell: ComparisonCell, times: Sequence[float]) -> float:
    """Return the published time to rank by: of several, the one nearest to ours."""
    return min(
        times, key=lambda time: 0.0 if time == cell.rank_time else abs(time - cell.rank_time)
    )


def _order(times: Sequence[float]) -> list[int]:
    """Return each time's rank; ties share one."""
    places = sorted(set(times))
    return [places.index(time) for time in times]


def table(comparison: Comparison, figures: Times) -> str:
    """Return the published figures, with the difference of ours, and how well they agree."""
    rows = [["published", *comparison.labels, "best", "worst"]]
    for row in comparison.cells:
        times = [figures[cell.world, cell.label] for cell in row]
        best, worst = standing([own[0] for own in times])
        told = [
            "; ".join(_described(cell, t) for t in own)
            for cell, own in zip(row, times, strict=True)
        ]
        rows.append(
            [
                row[0].world,
                *told,
                *(", ".join(ROBOTS[k] for k in places) for places in (best, worst)),
            ]
        )
    agreed = agreement(comparison, figures)
    return (
        f"{aligned(rows)}\n"
        "In brackets: our time minus the published one; for random controllers, the share of seeds "
        "that are no later.\n\n"
        f"Same ranking in {agreed.rankings} of {len(comparison.cells)} worlds; no arrival in both "
        f"in {agreed.never[0]} of {agreed.never[1]} cells; {agreed.within[0]} of "
        f"{agreed.within[1]} figures of the random\nrule within the middle 95 % of our seeds; "
        f"largest deviation without randomness {agreed.largest:+.1%}."
    )


def _described(cell: ComparisonCell, time: float) -> str:
    if time == math.inf:
        return "never"
    if cell.random:
        return f"{time:.3f} ({_share(cell, time + _SAME):.0%})"
    return f"{time:.3f}" if cell.time is None else f"{time:.3f} ({cell.time - time:+.3f})"


@click.command()
@click.option("--seeds", default=100, show_default=True, help="Seeds of the random rule.")
@click.option("--steps", default=STEPS, show_default=True, help="Budget of each run.")
@click.option("--json", "as_json", is_flag=True)
def main(seeds: int, steps: int, as_json: bool) -> None:
    """Compare the thesis's robots with its table."""
    comparison = run(seeds, steps=steps)
    figures = published()
    if as_json:
        click.echo(json.dumps(vars(agreement(comparison, figures))))
        return
    click.echo(as_text(comparison))
    click.echo(table(comparison, figures))


if __name__ == "__main__":
    main()
