"""Measure how well failures are found.

It compares, on the seeded faults, each strategy, the whole plan, and what one would do without
them. ``python -m benchmarks.finding`` gives every searcher (:mod:`benchmarks.searchers`) the same
number of simulated steps against each fault of :mod:`benchmarks.faults`, shrinks what it finds, and
prints the tables of ``docs/explanation/search.md``; ``--json`` prints one object. With ``--out
DIR`` each cell of the table is a file: existing ones are not computed again, and several processes
can work on the same table. ``--quick`` takes minutes, ``--full`` a day.

A fault counts as found by a failure with the verdict expected of it, confirmed by replay, in a
world in which the controller without the fault arrives.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from statistics import median
from typing import Any

import click
import numpy as np

from benchmarks.faults import FAULTS, Fault
from benchmarks.finding_tables import summary, tables
from benchmarks.searchers import SEARCHERS, strategies
from fuzz.cause import CAUSE
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.shrink import shrink
from fuzz.triage.diagnosis import cause_of
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import UnitResult
from sim.episode import simulate
from sim.evidence import evidence_table
from sim.options.run import step_budget
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.errors import WorldgenError
from worldgen.files.grid import write_world
from worldgen.world import World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--quick", "--fault", "bug2-stale-line", "--searcher", "native", "--part", "faults")

# Worlds of a unit, so that it is known which world it was.
EXAMPLES = 1
# Strategies that do not ask oracles about runs that arrive.
_FAILURES_ALONE = ("native", "archive", "boundary")
# Wall seconds; slow controllers may not be done by then.
_SHRINK_SECONDS = 60.0
# Units without a world, after which a searcher has nothing left to try.
_IDLE = 100
# Seed of the units done before the clock starts, so that kernels are compiled.
_OTHER_SEED = 1 << 40
# From docs/reference/library.md: those that arrive in every static world.
COMPLETE = ("bug1", "bug2", "mapper")
# Oracles that hold for controllers that arrive.
ORACLES = ("repeat", "turn", "shift", "scale", "mirror", "finer", "wall", "block")


@dataclass(frozen=True)
class Limits:
    """The limits of a search without a find.

    Args:
        steps: Steps simulated in screening.
        seconds: CPU seconds of one core.
    """

    steps: int
    seconds: float


SIZES = {
    "quick": (Limits(200_000, 10.0), (1,)),
    "": (Limits(1_000_000, 20.0), (1, 2, 3)),
    "full": (Limits(10_000_000, 600.0), (1, 2, 3, 4, 5)),
}
"""Limits and seeds of a table."""


@dataclass(frozen=True)
class Row:
    """One search for one fault.

    Args:
        fault: Name of the fault.
        searcher: Name of the searcher.
        seed: Seed of the search.
        limits: Limits of the search.
        found: Whether a failure distinguishes the fault from the controller without it.
        worlds: Worlds simulated until that failure, or in total.
        steps: Steps simulated until that failure, or in total.
        seconds: CPU seconds until that failure, or in total.
        wall_seconds: Wall seconds.
        kind: Class of that failure, shrunk.
        solid_cells: Solid cells of its world as found, and shrunk.
        cells: Cells of its world as found, and shrunk.
        shrink_seconds: CPU seconds of shrinking.
        one_minimal: Whether the shrinker reports it as 1-minimal.
        removable: Solid cells of the shrunk world that an independent check could remove, one at a
            time.
        shrunk_tells: Whether the controller without the fault also arrives in the shrunk world.
    """

    fault: str
    searcher: str
    seed: int
    limits: Limits
    found: bool
    worlds: int
    steps: int
    seconds: float
    wall_seconds: float
    kind: str = ""
    solid_cells: tuple[int, int] = (0, 0)
    cells: tuple[int, int] = (0, 0)
    shrink_seconds: float = 0.0
    one_minimal: bool = False
    removable: int = 0
    shrunk_tells: bool = False


def controller_name(fault: Fault) -> str:
    """Return the name under which a command takes the fault, with the options of its run."""
    return f"fuzz.faults:{fault.name.replace('-', '_')}{fault.variations}"


def tells(fault: Fault, failure: Failure) -> bool:
    """Return True if the controller without the fault arrives in the world of a failure."""
    if fault.base is None:
        return False
    return simulate(failure.world, fault.base, failure.options).verdict == Verdict.REACHED


def look_for(fault: Fault, searcher: str, seed: int, limits: Limits) -> tuple[Row, Failure | None]:
    """Do one search for one fault; return the failure that reveals it, shrunk."""
    scenario = Scenario.parse(controller_name(fault))
    config = CampaignConfig(
        scenario, seed=seed, time_steps=(scenario.run.time_step,), examples=EXAMPLES
    )
    # Compile everything before the clock starts.
    _compile(searcher)
    # Compiles the fault.
    next(SEARCHERS["features"](replace(config, seed=seed + _OTHER_SEED, examples=4)))
    # Search until a failure reveals the fault or a limit is reached.
    cpu = time.process_time()
    wall = time.monotonic()
    worlds = 0
    steps = 0
    found = None
    for result in _units(searcher, config):
        worlds = worlds + result.worlds
        steps = steps + result.steps
        found = next((one for one in result.failures.values() if shows(fault, one)), None)
        spent = time.process_time() - cpu
        if found or steps >= limits.steps or spent >= limits.seconds:
            break
    spent = time.process_time() - cpu
    waited = time.monotonic() - wall
    row = Row(
        fault.name,
        searcher,
        seed,
        limits,
        found is not None,
        worlds,
        steps,
        round(spent, 3),
        round(waited, 3),
    )
    return (row, None) if found is None else _shrunk(row, fault, found)


@functools.cache
def _compile(searcher: str) -> None:
    """Do a unit against a fast controller.

    No kernel is then compiled while the clock runs.
    """
    next(SEARCHERS[searcher](CampaignConfig(Scenario("turn-right"), seed=_OTHER_SEED, examples=4)))


def _units(searcher: str, config: CampaignConfig) -> Iterator[UnitResult]:
    """Yield the results of a search, as long as it has worlds to try."""
    idle = 0
    for result in SEARCHERS[searcher](config):
        idle = 0 if result.worlds else idle + 1
        if idle == _IDLE:
            return
        yield result


def shows(fault: Fault, failure: Failure) -> bool:
    """Return True if a failure shows the fault, and recurs."""
    return failure.verdict == fault.expected and tells(fault, failure) and replay(failure).confirmed


def _shrunk(row: Row, fault: Fault, found: Failure) -> tuple[Row, Failure]:
    """Return the row and the world of a find after shrinking, or as found if that fails."""
    begun = time.process_time()
    try:
        small = shrink(found, seconds=_SHRINK_SECONDS).failure
    except WorldgenError:
        return replace(
            row, solid_cells=(found.world.solid_cells,) * 2, cells=(found.world.walls.size,) * 2
        ), found
    spent = time.process_time() - begun
    details = small.record.details
    row = replace(
        row,
        kind=str(details.get(CAUSE, "")),
        solid_cells=(found.world.solid_cells, small.world.solid_cells),
        cells=(found.world.walls.size, small.world.walls.size),
        shrink_seconds=round(spent, 4),
        one_minimal=bool(details.get("one_minimal")),
        removable=removable_cells(small),
        shrunk_tells=shows(fault, small),
    )
    return row, small


def removable_cells(failure: Failure) -> int:
    """Return how many of a failure's solid cells can be removed one at a time, by brute force.

    It shares no code with the shrinker.
    """
    found = 0
    for iy, ix in np.argwhere(failure.world.walls):
        walls = failure.world.walls.copy()
        walls[iy, ix] = False
        found += _fails_likewise(
            failure, replace(failure.world, walls=walls, certificate=None, provenance=None)
        )
    return found


def _fails_likewise(failure: Failure, candidate: World) -> bool:
    """Return True if a reachable world fails in the way that shrinking preserved."""
    record = failure.record
    options = failure.options
    proved = certified(candidate)
    if proved is None:
        return False
    if record.verdict in (Verdict.STALLED, Verdict.TIMEOUT):
        # The smaller world may need more steps than the first one's budget.
        options = replace(options, steps=step_budget(proved, options))
    # Compare more than the verdict, or a shrunk failure may be another one.
    episode = simulate(proved, record.controller, options)
    manner = "kind" if record.verdict == Verdict.STALLED else "cause"
    evidence = evidence_table(episode.evidence)
    if episode.verdict != record.verdict or evidence.get(manner) != record.evidence.get(manner):
        return False
    other = failure_of(proved, failure.scenario, steps=options.steps)
    return other is not None and cause_of(other) == cause_of(failure)


@dataclass(frozen=True)
class Alarm:
    """The results of one searcher against a controller that is known to arrive.

    Any failure is a false alarm.

    Args:
        controller: Name of the controller.
        searcher: Name of the searcher.
        worlds: Worlds simulated.
        asked: Those of them that the oracles judged, too.
        failures: Failures found, by cause.
    """

    controller: str
    searcher: str
    worlds: int
    asked: int
    failures: dict[str, int]


def alarms(controller: str, searcher: str, worlds: int, folder: Path | None = None) -> Alarm:
    """Search for failures of a correct controller; keep what is found in a folder."""
    met = Counter[str]()
    looked = []
    # Runs without oracles are cheap, so they have most of the worlds.
    for oracles, most in (
        ((), worlds),
        (ORACLES, 0 if searcher in _FAILURES_ALONE else worlds // 10),
    ):
        config = CampaignConfig(
            Scenario(controller), seed=1 + len(oracles), examples=EXAMPLES, oracles=oracles
        )
        looked.append(0)
        for result in _units(searcher, config) if most else ():
            for (cause, _), count in result.met.items():
                met[cause] += count
            looked[-1] += result.worlds
            for failure in result.failures.values() if folder else ():
                name = f"{controller}-{searcher}-{failure.signature}.grid"
                failure.write(folder / name, force=True)
            if looked[-1] >= most:
                break
    return Alarm(controller, searcher, sum(looked), looked[1], dict(met))


def floors() -> dict[str, float]:
    """Return median CPU seconds to the first proved loop of ``turn-right``.

    Speeds are measured by :mod:`benchmarks.native`.
    """
    seconds = []
    for seed in range(10):
        config = CampaignConfig(Scenario("turn-right"), seed=seed, examples=EXAMPLES)
        begun = time.process_time()
        next(
            result
            for result in strategies()(config)
            if any(failure.verdict == Verdict.LOOP for failure in result.failures.values())
        )
        seconds.append(time.process_time() - begun)
    # The first one also compiles.
    return {"first_loop_seconds": round(median(seconds[1:]), 4)}


# --- a table in files
# ---------------------------------------------------------------------------------------------


def _once(
    file: Path | None, key: dict[str, Any], work: Callable[[], dict[str, Any]]
) -> dict[str, Any]:
    """Return the work's result from its file if the key matches; otherwise do and keep the work."""
    if file is not None and file.exists():
        known: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if known["key"] == key:
            return dict(known["result"])
    result = work()
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        draft = file.with_suffix(f".{os.getpid()}")
        draft.write_text(json.dumps({"key": key, "result": result}), encoding="utf-8")
        draft.replace(file)
    return result


def _rows(
    given: argparse.Namespace, limits: Limits, seeds: Sequence[int]
) -> Iterator[dict[str, Any]]:
    """Yield every cell of the table.

    Everything about one fault comes together, because its kernels are compiled once per process.
    """
    for name, seed, searcher in product(given.fault or FAULTS, seeds, given.searcher or SEARCHERS):
        file = given.out / "rows" / f"{searcher}.{name}.{seed}.json" if given.out else None

        def work(name: str = name, seed: int = seed, searcher: str = searcher) -> dict[str, Any]:
            row, world = look_for(FAULTS[name], searcher, seed, limits)
            if given.out and world:
                write_world(
                    world, given.out / "rows" / f"{searcher}.{name}.{seed}.grid", force=True
                )
            click.echo(_in_words(row), err=True)
            return asdict(row)

        yield _once(file, asdict(limits), work)


def _in_words(row: Row) -> str:
    what = (
        f"{row.kind}, {row.solid_cells[0]} -> {row.solid_cells[1]} solid cells"
        if row.found
        else "not found"
    )
    return (
        f"{row.fault:<40} {row.searcher:<9} {row.seed} {row.worlds:>7} worlds "
        f"{row.seconds:>7.2f} s  {what}"
    )


def main() -> None:
    """Print the tables."""
    # Parse the options.
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "--quick",
        action="store_const",
        const="quick",
        dest="size",
        default="",
        help="one seed, minutes",
    )
    size.add_argument(
        "--full", action="store_const", const="full", dest="size", help="five seeds, a day"
    )
    parser.add_argument(
        "--fault", action="append", choices=sorted(FAULTS), help="only this one; may be repeated"
    )
    parser.add_argument(
        "--searcher",
        action="append",
        choices=sorted(SEARCHERS),
        help="only this one; may be repeated",
    )
    parser.add_argument("--seed", action="append", type=int, help="only this one; may be repeated")
    parser.add_argument(
        "--part",
        action="append",
        choices=("faults", "alarms", "floors"),
        help="only this part; may be repeated",
    )
    parser.add_argument(
        "--alarm-worlds", type=int, default=2000, help="for each complete controller and searcher"
    )
    parser.add_argument(
        "--out", type=Path, help="folder that keeps every cell of the table, and the worlds"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    parts = given.part or ("faults", "alarms", "floors")
    limits, seeds = SIZES[given.size]
    if given.out:
        (given.out / "rows").mkdir(parents=True, exist_ok=True)
    # Compute the tables, or take them from the files of earlier runs.
    rows = list(_rows(given, limits, given.seed or seeds)) if "faults" in parts else []
    alarmed = [
        _once(
            given.out / "alarms" / f"{controller}.{searcher}.json" if given.out else None,
            {"worlds": given.alarm_worlds},
            lambda c=controller, s=searcher: asdict(alarms(c, s, given.alarm_worlds, given.out)),
        )
        for controller, searcher in product(COMPLETE, given.searcher or SEARCHERS)
        if "alarms" in parts and searcher != "plan"
    ]
    measured = floors() if "floors" in parts else {}
    # Print them.
    if given.json:
        told = {
            "limits": asdict(limits),
            "searchers": summary(rows),
            "alarms": alarmed,
            "floors": measured,
        }
        click.echo(json.dumps({**told, "rows": rows}))
        return
    click.echo(tables(rows) if rows else "", nl=bool(rows))
    for entry in alarmed:
        click.echo(
            f"{entry['controller']} {entry['searcher']}: {entry['worlds']} worlds, "
            f"{entry['failures'] or 'none'}"
        )
    for name, value in measured.items():
        click.echo(f"{name}: {value}")


if __name__ == "__main__":
    main()
