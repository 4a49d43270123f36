"""Measure what campaigns cost, and what a billion worlds would cost.

``python -m benchmarks.campaigns``; ``--json`` prints one object. For each strategy it measures
worlds and steps per second and core, including proof and classification of failures. For a whole
campaign it measures bytes per unit on disk, and the time to store a unit and to shrink a failure.
With the extra ``[dask]`` it also measures what a piece of work costs client and scheduler together.
``--units`` is the number of units of each strategy (default 3). Times are processor times, so other
work on the machine matters little; kernels are loaded before the clock starts.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click

from fuzz.campaign.executors import cluster_executor
from fuzz.campaign.run import Campaign
from fuzz.campaign.state import CampaignState
from fuzz.campaign.store import Budget, begin
from fuzz.campaign.unit import run_unit
from fuzz.search.plan import strategies_for
from fuzz.shrink.queue import shrunk_or_same
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import FirstMet, SearchState, UnitResult
from sim.scenario import Scenario

# The words of a round that takes seconds; the gate runs it. All failures of this controller are one
# crash, so only one is shrunk; any controller that loops has dozens of classes to shrink.
_ONE_CLASS = "fuzz.faults:potential_field_gap_in_whole_cells"
TINY = ("--units", "1", "--examples", "1", "--controller", _ONE_CLASS)

WORLDS = 1_000_000_000
# Units done first: after them every kernel is loaded.
_WARM = 4
# Empty pieces of work for the cluster.
_TASKS = 300
# Number of failures.
_SHRUNK = 10


def strategies(config: CampaignConfig, units: int, memory: SearchState) -> Iterator[dict[str, Any]]:
    """Do units of each strategy.

    Returns:
        ``strategy``, ``units``, ``worlds``, ``steps``, ``rate`` (worlds a second and core) and
        ``step_rate``.
    """
    for name in strategies_for(config, memory):
        only = CampaignConfig(
            config.scenario, config.seed, families=(name,), examples=config.examples
        )
        run_unit(only, 0, memory)
        results: list[UnitResult] = []
        taken = _seconds(lambda only=only, results=results: _do_units(only, units, memory, results))
        worlds = sum(one.worlds for one in results)
        steps = sum(one.steps for one in results)
        row = {"strategy": name, "units": units, "worlds": worlds, "steps": steps}
        yield row | {"rate": worlds / taken, "step_rate": steps / taken}


def _do_units(
    config: CampaignConfig, units: int, memory: SearchState, results: list[UnitResult]
) -> None:
    results += [run_unit(config, unit, memory) for unit in range(1, units + 1)]


def whole(config: CampaignConfig, units: int) -> tuple[CampaignState, dict[str, float]]:
    """Measure a campaign with its folder: its files, and the time of its parts.

    Returns:
        Its state, and ``worlds_per_unit``, ``bytes_per_unit`` and ``files_per_unit`` (upper bounds,
        because the first units write most), ``save_s`` for a unit and ``shrink_s`` for a failure.
    """
    with tempfile.TemporaryDirectory() as place:
        campaign_run = begin(config, Path(place) / "out", Budget(units=units))
        campaign = Campaign(config, units=units, store=campaign_run.store)
        for _ in campaign.run():
            pass
        state = campaign.state
        files = [file for file in Path(place).rglob("*") if file.is_file()]
        # Time one save of a unit with failures, which later units rarely have.
        failures = dict(list(state.memory.failures.items())[:2])
        found = UnitResult(
            "features", failures=failures, first_met=dict.fromkeys(failures, FirstMet(1, 1, 0.0))
        )
        save = _seconds(lambda: campaign_run.store.save_unit(units, found, 0.0))
        campaign_run.store.close()
        some = list(state.memory.failures.values())[:_SHRUNK]
        shrink = _seconds(lambda: [shrunk_or_same(one) for one in some])
        return state, {
            "worlds_per_unit": state.worlds / units,
            "bytes_per_unit": sum(file.stat().st_size for file in files) / units,
            "files_per_unit": len(files) / units,
            "save_s": save,
            "shrink_s": shrink / max(len(some), 1),
        }


def scheduler(config: CampaignConfig) -> float | None:
    """Return the seconds of client and scheduler, in one process here, for a piece of work.

    It is ``None`` without the extra.
    """
    try:
        from distributed import LocalCluster  # noqa: PLC0415 - an extra
    except ModuleNotFoundError:
        return None
    with (
        LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        cluster_executor(cluster.scheduler_address, config) as executor,
    ):
        executor.submit(int, 0).result()
        return (
            _seconds(
                lambda: [
                    future.result() for future in [executor.submit(int, k) for k in range(_TASKS)]
                ]
            )
            / _TASKS
        )


def model(
    rates: list[dict[str, Any]], costs: dict[str, float], task_s: float | None
) -> list[dict[str, float | str]]:
    """Return the cost of a billion worlds of each strategy.

    Returns:
        ``strategy``, ``core_hours``, ``units``, ``gigabytes`` and ``scheduler_hours``.
    """
    rows: list[dict[str, float | str]] = []
    for one in rates:
        units = WORLDS * one["units"] / max(one["worlds"], 1)
        rows.append(
            {
                "strategy": one["strategy"],
                "core_hours": WORLDS / one["rate"] / 3600 if one["rate"] else 0.0,
                "units": units,
                "gigabytes": units * costs["bytes_per_unit"] / 1e9,
                "scheduler_hours": units * (task_s or 0.0) / 3600,
            }
        )
    return rows


def measure(units: int, controller: str, examples: int) -> dict[str, Any]:
    """Return everything: ``strategies``, ``campaign``, ``task_s`` and ``billion``."""
    config = CampaignConfig(Scenario(controller), seed=1, examples=examples)
    state, costs = whole(config, _WARM + units)
    rates = list(strategies(config, units, state.memory))
    task_s = scheduler(config)
    return {
        "strategies": rates,
        "campaign": costs,
        "task_s": task_s,
        "billion": model(rates, costs, task_s),
    }


def _seconds(work: Callable[[], object]) -> float:
    before = time.process_time()
    work()
    return time.process_time() - before


def main() -> None:
    """Print the tables, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--units", type=int, default=3)
    parser.add_argument("--controller", default="turn-right")
    parser.add_argument("--examples", type=int, default=400, help="worlds that a unit tries")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    result = measure(options.units, options.controller, options.examples)
    if options.json:
        click.echo(json.dumps(result))
        return
    click.echo(
        "strategy        worlds/s  steps/s   a billion worlds: core hours      units        GB  "
        "scheduler hours"
    )
    for rate, cost in zip(result["strategies"], result["billion"], strict=True):
        click.echo(
            f"{rate['strategy']:<11} {rate['rate']:>8.0f} {rate['step_rate']:>8.2g} "
            f"{cost['core_hours']:>29.0f} "
            f"{cost['units']:>10.3g} {cost['gigabytes']:>9.0f} {cost['scheduler_hours']:>16.1f}"
        )
    click.echo(", ".join(f"{name} {value:.3g}" for name, value in result["campaign"].items()))
    click.echo(
        f"a piece of work costs client and scheduler {1e3 * (result['task_s'] or 0.0):.2f} ms"
    )


if __name__ == "__main__":
    main()
