"""Measure how many worlds per second a campaign tries against controllers that users bring.

These are classes and programs. ``python -m benchmarks.classes`` prints a table; ``--json`` prints
one object; ``--document docs/notes/search.md`` also writes it to that page. Rates are per
second of one core's processor time, without compilation. For a program they are per second of wall
time, because most of its time is spent in another process.

``short``: screening runs of at most 60 steps. ``looks``: screening runs with their own budgets.
``strategy``: whole units of the strategy ``native``, including the proofs of their failures.
``features``: the strategy in which Hypothesis draws worlds, formerly the only one for such
controllers. ``user``: the share of the time of ``looks`` spent in the controller's own code.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks.as_classes import AsClass
from benchmarks.worlds import documented
from fuzz.campaign.unit import run_unit
from fuzz.screening import Screening, evaluate
from fuzz.search.native import scenes
from fuzz.unit.config import CampaignConfig
from sim import Command, Observation, RobotOptions
from sim.clock.controller_time import Effort
from sim.controllers import CONTROLLERS, ProcessController
from sim.scenario import Scenario
from tests.helpers.interpreted import Interpreted
from worldgen.random_streams import RandomStream

# The words of a round that takes seconds; the gate runs it.
TINY = ("--controllers", "example", "--seconds", "0.1")

# Steps.
SHORT = 60
BEAMS = 36
PROGRAM = f"cmd:{sys.executable} {Path(__file__).parents[1] / 'sim' / 'examples' / 'process.py'}"
MARKS = (
    "<!-- table: python -m benchmarks.classes --document docs/notes/search.md -->",
    "<!-- end of table -->",
)
# Least seconds over which a rate is measured.
_FOR = 0.5
_MOST_SCENES = 20_000


@dataclass(frozen=True)
class Widest:
    """Drive into the widest of 36 beams near the target's direction, computed with NumPy."""

    senses = ("bump", "heading", "target_heading", "beams")
    needs = RobotOptions(beams=BEAMS)

    def reset(self) -> tuple[float, ...]:
        """Return an empty memory."""
        return ()

    def act(
        self, observation: Observation, memory: tuple[float, ...]
    ) -> tuple[Command, tuple[float, ...]]:
        """Score each beam by its length and by its angle from the target's direction."""
        bearings = np.linspace(0.0, 2 * np.pi, BEAMS, endpoint=False)
        off = np.cos(bearings - (observation.target_heading - observation.heading))
        best = bearings[int(np.argmax(np.minimum(observation.beams, 0.5) + 0.3 * off))]
        turn = (best + np.pi) % (2 * np.pi) - np.pi
        return Command(observation.top_speed, float(turn) / observation.time_step), memory


CASES = {
    "example": "sim.controllers.examples.python:Example",
    "turn-right": "benchmarks.classes:turn_right",
    "wall-left": "benchmarks.classes:wall_left",
    "random-walk": "benchmarks.classes:random_walk",
    "bug2": "benchmarks.classes:bug2",
    "bug2, interpreted": "benchmarks.classes:plain_bug2",
    "q-learning": "benchmarks.classes:q_learning",
    "numpy, 36 beams": "benchmarks.classes:Widest",
    "vfh": "benchmarks.classes:vfh",
    "potential-field": "benchmarks.classes:potential_field",
    "tangent-bug": "benchmarks.classes:tangent_bug",
    "three-layer": "benchmarks.classes:three_layer",
    "example, vector": "sim.controllers.examples.vector:Example",
    "example, program": PROGRAM,
}
"""Controllers of the table: twelve classes, then a vector class and a program."""


def __getattr__(name: str) -> Any:
    if name.startswith("_"):
        raise AttributeError(name)
    if name == "plain_bug2":
        return Interpreted(CONTROLLERS.get("bug2"))
    return AsClass(name.replace("_", "-"))


@dataclass(frozen=True)
class Row:
    """The rates of one controller, per second of processor time.

    Args:
        controller: Name.
        short: Worlds of screening runs of 60 steps.
        looks: Worlds of screening runs.
        steps: Steps of these.
        user: Share of their time in the controller's own code.
        strategy: Worlds of units of the strategy ``native``.
        features: Worlds of units of the strategy ``features``.
    """

    controller: str
    short: float
    looks: float
    steps: float
    user: float
    strategy: float
    features: float

    @property
    def gain(self) -> float:
        """Worlds of ``strategy`` for each world of ``features``."""
        return self.strategy / self.features


def measure(name: str, controller: str, seconds: float) -> Row:
    """Measure one controller under ``swept``."""
    scenario = Scenario(controller)
    clock = (
        time.monotonic
        if isinstance(CONTROLLERS.get(controller), ProcessController)
        else time.process_time
    )
    short, _ = _looks(scenario, SHORT, clock)
    looks, steps = _looks(scenario, None, clock)
    strategy, features = (
        _units(scenario, which, seconds, clock) for which in ("native", "features")
    )
    return Row(name, short, looks, steps, _share_of_user(scenario), strategy, features)


def _looks(
    scenario: Scenario, budget: int | None, clock: Callable[[], float]
) -> tuple[float, float]:
    """Return worlds and steps per second of screening runs."""
    _look(scenario, 20, budget)
    count = 100
    # Take more scenes until the run is long enough to be timed.
    while True:
        begin = clock()
        looks = _look(scenario, count, budget)
        spent = clock() - begin
        if spent >= _FOR or count >= _MOST_SCENES:
            return int(looks.ran.sum()) / spent, looks.simulated / spent
        count *= 4


def _look(scenario: Scenario, count: int, budget: int | None) -> Screening:
    return evaluate(
        scenes(RandomStream(3), count), scenario, np.arange(count, dtype=np.uint64), 0.015, budget
    )


def _units(scenario: Scenario, strategy: str, seconds: float, clock: Callable[[], float]) -> float:
    """Return worlds per second of whole units, without compilation."""
    config = CampaignConfig(scenario, seed=3, families=(strategy,))
    run_unit(CampaignConfig(scenario, seed=3, families=(strategy,), examples=8), 0)
    worlds = 0
    unit = 0
    begin = clock()
    while (spent := clock() - begin) < seconds:
        unit += 1
        worlds += run_unit(config, unit).worlds
    return worlds / spent


def _share_of_user(scenario: Scenario) -> float:
    """Return the share of screening time spent in the controller's code or in waiting for it."""
    is_program = isinstance(CONTROLLERS.get(scenario.controller), ProcessController)
    began = Effort.so_far()
    _look(scenario, 20 if is_program else 400, None)
    return began.since().share


def _markdown(rows: list[Row]) -> str:
    lines = [
        "| controller | short | looks | steps | user | strategy | features | gain |",
        "| --- |" + " ---: |" * 7,
    ]
    for row in rows:
        rates = [f"{rate:,.0f}" for rate in (row.short, row.looks, row.steps)]
        cells = [
            *rates,
            f"{row.user:.0%}".replace("%", " %"),
            f"{row.strategy:,.0f}",
            f"{row.features:,.0f}",
        ]
        lines.append(f"| {row.controller} | {' | '.join(cells)} | {row.gain:.0f} |")
    return "\n".join(lines)


def main() -> None:
    """Measure all and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--controllers", default=";".join(CASES), help="names of the table, with semicolons between"
    )
    parser.add_argument(
        "--seconds", type=float, default=4.0, help="of the processor for each strategy (default 4)"
    )
    parser.add_argument("--document", type=Path, help="put the table into this document too")
    arguments = parser.parse_args()
    rows = [
        measure(name, CASES[name], arguments.seconds) for name in arguments.controllers.split(";")
    ]
    table = _markdown(rows)
    if arguments.document is not None:
        arguments.document.write_text(documented(arguments.document.read_text(), table, MARKS))
    whole = [{**asdict(row), "gain": row.gain} for row in rows]
    click.echo(json.dumps({"rows": whole}) if arguments.json else table)


if __name__ == "__main__":
    main()
