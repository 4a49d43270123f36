"""Compare strategies, alone and together: signatures of failures for equal CPU seconds of one core.

``python -m benchmarks.strategies`` gives every way of sharing a campaign's budget the same CPU
seconds for each controller: the campaign's own plan, all its strategies in turn, and some
strategies alone. It prints how many signatures each finds, and how large their smallest worlds are
before shrinking; ``--json`` prints one object. Kernels are compiled before that.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace

import click

from fuzz.campaign.unit import run_unit
from fuzz.search.plan import strategies_for
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import SearchState
from sim.scenario import Scenario

# The words of a round that takes seconds; the gate runs it.
TINY = ("--seconds", "0.1", "--controller", "wall-left")

CASES = (
    ("turn-right", "swept"), ("turn-right", "stepped"), ("turn-left", "endpoint"), ("wall-left", "swept"),
    ("vfh", "swept"), ("three-layer", "swept"), ("fuzz.faults:X", "swept"),
)  # fmt: skip
"""Controllers and motion models of the table."""

_ALONE = ("native", "archive", "features", "boundary")
# Size of a unit: a quarter of a campaign's, so that a strategy's share shows within a few seconds.
_EXAMPLES = 100
# A unit that is far from all others.
_COMPILES = 10**6


@dataclass(frozen=True)
class Row:
    """One way of sharing the budget, for one controller and one seed.

    Args:
        controller: Name of the controller.
        motion: Motion model.
        way: ``plan``, ``in turn``, or a strategy's name.
        seed: Seed of the campaign.
        units: Units done.
        worlds: Worlds simulated.
        steps: Steps simulated.
        proved: Number of proved failures.
        signatures: Their signatures, sorted.
        solid_cells: Total solid cells of the smallest world of each signature.
    """

    controller: str
    motion: str
    way: str
    seed: int
    units: int
    worlds: int
    steps: int
    proved: int
    signatures: tuple[str, ...]
    solid_cells: int


def strategies_at(way: str, config: CampaignConfig) -> Callable[[int], tuple[str, ...]]:
    """Return the strategies that a unit may use."""
    if way == "plan":
        return lambda unit: ()
    names = strategies_for(config, SearchState()) if way == "in turn" else (way,)
    return lambda unit: (names[unit % len(names)],)


def campaign(controller: str, motion: str, way: str, seed: int, seconds: float) -> Row:
    """Return a campaign without shrinking, for some CPU time after all strategies are compiled."""
    config = CampaignConfig(
        Scenario.parse(controller, motion=motion), seed=seed, examples=_EXAMPLES
    )
    at = strategies_at(way, config)
    # Compile and cache everything before the clock starts.
    for name in strategies_for(config, SearchState()):
        run_unit(replace(config, families=(name,), examples=1), _COMPILES)
    memory = SearchState()
    known = [SearchState(), SearchState()]
    unit = 0
    started = time.process_time()
    # CPU time, so that other processes on the machine don't take from the budget.
    while time.process_time() - started < seconds:
        memory = memory.after(
            run_unit(replace(config, families=at(unit)), unit, known[unit // config.epoch])
        )
        unit += 1
        # Later epochs know what earlier ones found, as in a real campaign.
        if unit % config.epoch == 0:
            known.append(memory)
    brought = memory.strategies.values()
    failures = memory.failures
    return Row(
        controller, motion, way, seed, unit,
        worlds=sum(strategy.worlds for strategy in brought),
        steps=sum(strategy.steps for strategy in brought),
        proved=sum(strategy.failures for strategy in brought),
        signatures=tuple(sorted(signature for _, signature in failures)),
        solid_cells=sum(failure.world.solid_cells for failure in failures.values()),
    )  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--seconds", type=float, default=20.0, help="CPU seconds of each campaign (default 20)"
    )
    parser.add_argument("--seeds", type=int, default=1, help="campaigns of each kind (default 1)")
    parser.add_argument("--controller", help="only this one")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    rows = []
    for controller, motion in CASES:
        if given.controller in (None, controller):
            config = CampaignConfig(Scenario.parse(controller, motion=motion))
            fit = [name for name in _ALONE if name in strategies_for(config, SearchState())]
            for way in ("plan", "in turn", *fit):
                for seed in range(1, given.seeds + 1):
                    rows.append(campaign(controller, motion, way, seed, given.seconds))
                    if not given.json:
                        click.echo(_in_words(rows[-1]))
    if given.json:
        click.echo(json.dumps({"seconds": given.seconds, "rows": [asdict(row) for row in rows]}))


def _in_words(row: Row) -> str:
    cells = row.solid_cells / max(len(row.signatures), 1)
    return (
        f"{row.controller:<34} {row.motion:<9} {row.way:<9} {row.units:>4} units {row.worlds:>8} "
        f"worlds "
        f"{row.steps / 1e6:>7.1f} M steps {row.proved:>5} proved {len(row.signatures):>3} signatures of "
        f"{cells:.0f} cells"
    )


if __name__ == "__main__":
    main()
