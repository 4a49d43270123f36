"""Measure the cost of native search.

It measures robot steps and worlds per second, against the bare simulator and the Hypothesis
strategy. ``python -m benchmarks.native`` prints a table; ``--json`` prints one object; ``--document
docs/notes/search.md`` also writes it to that page. All rates are per second of one core's
processor time, without compilation.

``strategy``: units of the strategy ``native`` as a campaign does them: scenes are drawn, simulated
and screened; failures are proved, judged by its oracle and classified. ``looks``: the same without
the proofs. ``bare``: the simulator's step in the worlds of the same scenes, with everything
prepared before the clock starts: an upper bound for the strategy. ``alone``: one long run in the
maze of :mod:`benchmarks.simulator`. ``simulate_many``: the worlds of the same scenes through the
library. ``features``: the strategy in which Hypothesis draws feature layouts, one example a world.
"""

from __future__ import annotations

import argparse
import functools
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

import click
import numpy as np

from benchmarks.simulator import maze
from benchmarks.worlds import documented
from fuzz.campaign.unit import run_unit
from fuzz.screening import Screening, evaluate
from fuzz.search.native import scenes
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import FailureKey
from sim import RunOptions, simulate_many
from sim.controllers import CONTROLLERS, CompiledController
from sim.episode import prepare
from sim.runners.core_calls import CoreEpisode, Driver
from sim.runners.lattice import LatticeRun
from sim.scenario import Scenario
from worldgen.random_streams import RandomStream

# The words of a round that takes seconds; the gate runs it.
TINY = ("--controllers", "turn-right", "--rounds", "1", "--seconds", "0.1")

NAMES = ("benchmarks.simulator:BOUNCER", "turn-right", "turn-left", "wall-left", "vfh")
ALONE_STEPS = 300_000
# Scenes.
LOOKS = 4_000
# Worlds of simulate_many.
SAME_WORLDS = 300
MARKS = (
    "<!-- table: python -m benchmarks.native --document docs/notes/search.md -->",
    "<!-- end of table -->",
)


@dataclass(frozen=True)
class Row:
    """The rates of one controller, per second of processor time.

    Args:
        controller: Name.
        alone: Steps of the simulator alone.
        bare: Steps of the simulator alone, in the worlds of the screening runs.
        looks_steps: Steps of screening runs.
        looks_worlds: Worlds of screening runs.
        strategy_steps: Steps of whole units of the strategy ``native``.
        strategy_worlds: Worlds of whole units of the strategy ``native``.
        strategy_signatures: Signatures of proved failures in all of these units.
        many_steps: Steps of ``simulate_many`` in the same worlds.
        many_worlds: Worlds of ``simulate_many``.
        features_steps: Steps of whole units of the strategy ``features``.
        features_worlds: Worlds of whole units of the strategy ``features``.
        features_signatures: Signatures of proved failures in the same time of such units.
    """

    controller: str
    alone: float
    bare: float
    looks_steps: float
    looks_worlds: float
    strategy_steps: float
    strategy_worlds: float
    strategy_signatures: int
    many_steps: float
    many_worlds: float
    features_steps: float
    features_worlds: float
    features_signatures: int

    @property
    def shares(self) -> dict[str, float]:
        """The rates of screening and of whole units, as shares of the bare step's."""
        return {
            "looks_share": self.looks_steps / self.bare,
            "strategy_share": self.strategy_steps / self.bare,
        }


def _timed(work: Callable[[], Any]) -> tuple[Any, float]:
    begin = time.process_time()
    return work(), time.process_time() - begin


def _units(scenario: Scenario, strategy: str, budget: float) -> tuple[float, float, int]:
    """Return steps and worlds per second of whole units, and how many signatures they find.

    Compilation does not count.
    """
    config = CampaignConfig(scenario, seed=3, families=(strategy,))
    # The first unit compiles and fills caches; it is not timed.
    run_unit(config, 0)
    steps = 0
    worlds = 0
    unit = 0
    found = set[FailureKey]()
    begin = time.process_time()
    while (taken := time.process_time() - begin) < budget:
        unit += 1
        result = run_unit(config, unit)
        steps = steps + result.steps
        worlds = worlds + result.worlds
        found = found | result.failures.keys()
    return steps / taken, worlds / taken, len(found)


def _alone(scenario: Scenario, rounds: int) -> float:
    """Return steps per second of one long, endless run."""
    run = prepare(maze(), scenario.controller, RunOptions("swept", ALONE_STEPS))
    run.run(10, find_loop=False, record=False, digest=False)
    taken = [
        _timed(lambda: run.run(ALONE_STEPS, find_loop=False, record=False, digest=False))[1]
        for _ in range(rounds)
    ]
    return ALONE_STEPS / median(taken)


def _bare(scenario: Scenario, looks: Screening) -> float:
    """Return steps per second of the screening runs.

    This is only the step and its search for recurrences.
    """
    controller = CONTROLLERS.get(scenario.controller)
    assert isinstance(controller, CompiledController)
    steps = 0
    taken = 0.0
    for n in np.flatnonzero(looks.ran).tolist():
        # Run the same worlds without strategies, as fast as the core alone can.
        world = looks.world(n)
        run = LatticeRun(
            world, controller, looks.scenario_of(n).options(world, int(looks.budget[n]))
        )
        run.settings.steps = int(looks.budget[n])
        run.settings.digest = 0
        run.settings.find_loop = run.search
        episode = CoreEpisode(run.arena(), run.settings, Driver(controller, controller.memory))
        taken += _timed(functools.partial(episode.run, run.settings.steps))[1]
        steps += int(episode.report.steps)
    return steps / taken


def _looks(scenario: Scenario, rounds: int) -> tuple[float, float, float, float, float]:
    """Return bare steps per second, and steps and worlds of screening and ``simulate_many``."""
    drawn = scenes(RandomStream(3), LOOKS)
    seeds = np.arange(LOOKS, dtype=np.uint64)
    evaluate(drawn[:50], scenario, seeds[:50], 0.015)
    done = [_timed(lambda: evaluate(drawn, scenario, seeds, 0.015)) for _ in range(rounds)]
    looks = done[0][0]
    seconds = median(taken for _, taken in done)
    worlds = [looks.world(n) for n in np.flatnonzero(looks.ran)[:SAME_WORLDS].tolist()]
    simulate_many(worlds[:1], scenario.controller, steps=10, workers=1)
    runs, taken = _timed(lambda: simulate_many(worlds, scenario.controller, steps=4000, workers=1))
    return (
        median(_bare(scenario, looks) for _ in range(rounds)),
        looks.simulated / seconds,
        int(looks.ran.sum()) / seconds,
        float(runs.steps.sum()) / taken,
        len(worlds) / taken,
    )


def measure(controllers: tuple[str, ...], rounds: int, budget: float) -> list[Row]:
    """Measure each controller under ``swept``, everything in turn."""
    rows = []
    for name in controllers:
        scenario = Scenario(name)
        bare, looks_steps, looks_worlds, many_steps, many_worlds = _looks(scenario, rounds)
        native = _units(scenario, "native", budget)
        features = _units(scenario, "features", budget)
        alone = _alone(scenario, rounds)
        rows.append(
            Row(
                name,
                alone,
                bare,
                looks_steps,
                looks_worlds,
                *native,
                many_steps,
                many_worlds,
                *features,
            )
        )
    return rows


def _markdown(rows: list[Row]) -> str:
    lines = [
        "| controller | alone | bare | looks | looks / bare | strategy | strategy / bare | simulate_many | "
        "features | worlds "
        "| features | signatures | features |",
        "| --- |" + " ---: |" * 12,
    ]
    for row in rows:
        others = (row.many_steps, row.features_steps)
        cells = [
            row.controller.rpartition(":")[2].lower(),
            f"{row.alone / 1e6:.2f}",
            f"{row.bare / 1e6:.2f}",
        ]
        for rate, share in zip(
            (row.looks_steps, row.strategy_steps), row.shares.values(), strict=True
        ):
            cells += [f"{rate / 1e6:.2f}", f"{share:.2f}"]
        cells += [f"{rate / 1e6:.2f}" for rate in others]
        cells += [f"{rate:,.0f}" for rate in (row.strategy_worlds, row.features_worlds)]
        cells += [str(row.strategy_signatures), str(row.features_signatures)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Run all and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--controllers", default=",".join(NAMES), help="names, with commas between")
    parser.add_argument(
        "--rounds",
        type=int,
        default=3,
        help="of what is not a strategy; the median counts (default 3)",
    )
    parser.add_argument(
        "--seconds",
        type=float,
        default=10.0,
        help="of the processor for each strategy (default 10)",
    )
    parser.add_argument("--document", type=Path, help="put the table into this document too")
    arguments = parser.parse_args()
    rows = measure(tuple(arguments.controllers.split(",")), arguments.rounds, arguments.seconds)
    table = _markdown(rows)
    if arguments.document is not None:
        arguments.document.write_text(documented(arguments.document.read_text(), table, MARKS))
    click.echo(
        json.dumps({"rows": [asdict(row) | row.shares for row in rows]})
        if arguments.json
        else table
    )


if __name__ == "__main__":
    main()
