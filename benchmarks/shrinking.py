"""Measure how fast and how good shrinking is, against Hypothesis on the same failures.

``python -m benchmarks.shrinking`` finds failures of several controllers under each motion model
with fixed seeds, shrinks each, and prints the table of ``docs/notes/shrinking.md``; ``--json``
prints one object. ``--each N`` is the most failures of a case (default 6), ``--hypothesis N`` the
most that Hypothesis shrinks too (default 1). Times are CPU milliseconds.

Hypothesis shrinks the bytes of the feature layout (:mod:`fuzz.layouts.features`) that the failure
was drawn from, through public calls only: its property fails if the layout's world fails with the
same verdict. So it never leaves the layouts.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import median
from typing import Any

import click
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.database import InMemoryExampleDatabase

from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from fuzz.shrink import removable, shrink
from fuzz.shrink.predicate import StillFails
from fuzz.strategies import layouts
from fuzz.triage.judging import failure_of
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.errors import WorldgenError
from worldgen.random_streams import RandomStream

# The words of a round that takes seconds; the gate runs it.
TINY = ("--each", "1", "--hypothesis", "0")

CASES = (
    ("turn-right", "swept", 0.015), ("turn-left", "swept", 0.015), ("wall-left", "swept", 0.015),
    ("vfh", "swept", 0.015), ("potential-field", "swept", 0.015), ("tangent-bug", "swept", 0.015),
    ("turn-right", "endpoint", 0.015), ("turn-left", "endpoint", 0.06), ("bug2", "endpoint", 0.06),
    ("turn-right", "stepped", 0.015), ("turn-random", "stepped", 0.015),
)  # fmt: skip
_SEED = 3
_DRAWS = 2_000
_PROOF_STEPS = 20_000


@dataclass(frozen=True)
class Found:
    """A failure, and the layout that it was drawn from."""

    data: bytes
    failure: Failure
    scenario: Scenario


@dataclass(frozen=True)
class Row:
    """The results of one method of shrinking on one case's failures.

    Args:
        milliseconds: CPU time of each.
        solid: Solid cells of each result.
        cells: Cells of each result's grid.
        minimal: How many results are 1-minimal.
    """

    milliseconds: list[float]
    solid: list[int]
    cells: list[int]
    minimal: int

    def summary(self) -> dict[str, Any]:
        """Return median, 95th percentile and share."""
        if not self.solid:
            return {"failures": 0}
        ordered = sorted(self.milliseconds)
        return {
            "failures": len(self.solid),
            "median_ms": round(median(ordered), 1),
            "p95_ms": round(ordered[min(int(0.95 * len(ordered)), len(ordered) - 1)], 1),
            "median_solid_cells": median(self.solid),
            "median_cells": median(self.cells),
            "one_minimal": round(self.minimal / len(self.solid), 3),
        }


def failures_of(controller: str, motion: str, time_step: float, most: int) -> list[Found]:
    """Return failures in layouts of fixed seeds, covering as many verdicts as possible."""
    stream = RandomStream(_SEED).child(controller, CASES.index((controller, motion, time_step)))
    by_verdict: dict[str, list[Found]] = {}
    for number in range(_DRAWS):
        if sum(map(len, by_verdict.values())) >= 2 * most:
            break
        data = b"".join(stream.next64().to_bytes(8, "little") for _ in range(LAYOUT_BYTES // 8))
        scenario = Scenario(controller, RunOptions(motion, time_step=time_step, seed=number))
        failure = _failure(data, scenario)
        if failure is not None:
            by_verdict.setdefault(failure.verdict, []).append(Found(data, failure, scenario))
    ranked = sorted(
        (rank, verdict) for verdict, found in by_verdict.items() for rank in range(len(found))
    )
    return [by_verdict[verdict][rank] for rank, verdict in ranked[:most]]


def _failure(data: bytes, scenario: Scenario) -> Failure | None:
    world = certified(decode_world(data))
    try:
        return None if world is None else failure_of(world, scenario, fewest_steps=_PROOF_STEPS)
    except WorldgenError:
        return None


def measure(found: list[Found], reduce: Callable[[Found], Failure]) -> Row:
    """Shrink each failure and check, outside the clock, whether the result is 1-minimal."""
    row = Row([], [], [], 0)
    minimal = 0
    for one in found:
        began = time.process_time()
        small = reduce(one)
        row.milliseconds.append((time.process_time() - began) * 1000)
        row.solid.append(small.world.solid_cells)
        row.cells.append(small.world.walls.size)
        minimal += not removable(small.world, StillFails.of(small))
    return replace(row, minimal=minimal)


def by_passes(found: Found) -> Failure:
    """Return this program's shrinker."""
    return shrink(found.failure).failure


def by_hypothesis(found: Found) -> Failure:
    """Return Hypothesis's result for the layout's bytes, with the same exact judge."""
    still_fails = StillFails.of(found.failure)
    best = found.data

    @settings(
        database=InMemoryExampleDatabase(), phases=[Phase.reuse, Phase.shrink], deadline=None, derandomize=False,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(data=layouts())
    def arrives(data: bytes) -> None:
        nonlocal best
        if still_fails(decode_world(data)) is not None:
            best = data
            raise _Fails

    feed: Any = getattr(arrives, "hypothesis").fuzz_one_input  # noqa: B009 - given() adds it
    with contextlib.suppress(_Fails):
        feed(found.data)
    with contextlib.suppress(_Fails):
        arrives()
    # Hypothesis shrinks the bytes of the layout, so prove the result again.
    proved = certified(decode_world(best))
    small = (
        None
        if proved is None
        else failure_of(proved, found.scenario, steps=still_fails.proof_budget)
    )
    return found.failure if small is None else small


class _Fails(Exception):
    """The world fails as before."""


def tables(each: int, hypothesis: int) -> dict[str, Any]:
    """Return every case with every method, and all cases together."""
    ways: dict[str, Callable[[Found], Failure]] = {"passes": by_passes}
    if hypothesis:
        ways["hypothesis"] = by_hypothesis
    rows: list[dict[str, Any]] = []
    whole: dict[str, list[Row]] = {way: [] for way in ways}
    for case in CASES:
        found = failures_of(*case, each)
        for one in found[:1]:
            # Compiled before the clock starts.
            by_passes(one)
        for way, reduce in ways.items():
            row = measure(found if reduce is by_passes else found[:hypothesis], reduce)
            whole[way].append(row)
            rows.append({"case": " ".join(map(str, case)), "way": way, **row.summary()})
            click.echo(f"{rows[-1]}", err=True)
    for way, parts in whole.items():
        rows.append({"case": "all", "way": way, **_together(parts).summary()})
    return {"seed": _SEED, "rows": rows}


def _together(parts: list[Row]) -> Row:
    return Row(
        [time for part in parts for time in part.milliseconds],
        [count for part in parts for count in part.solid],
        [count for part in parts for count in part.cells],
        sum(part.minimal for part in parts),
    )


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--each", type=int, default=6, help="failures of each case at most")
    parser.add_argument(
        "--hypothesis", type=int, default=1, help="failures of each case that Hypothesis shrinks"
    )
    asked = parser.parse_args()
    made = tables(asked.each, asked.hypothesis)
    if asked.json:
        click.echo(json.dumps(made))
        return
    click.echo(
        "| case | by | failures | median ms | p95 ms | solid cells | cells | 1-minimal |\n"
        + "| --- " * 8
        + "|"
    )
    for row in made["rows"]:
        if row["failures"]:
            values = [
                row[name]
                for name in (
                    "failures",
                    "median_ms",
                    "p95_ms",
                    "median_solid_cells",
                    "median_cells",
                )
            ]
            share = f"{row['one_minimal']:.0%}"
            click.echo(
                "| "
                + " | ".join([row["case"], row["way"], *(f"{value:g}" for value in values), share])
                + " |"
            )


if __name__ == "__main__":
    main()
