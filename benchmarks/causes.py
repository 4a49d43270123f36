"""How well causes tell seeded faults apart.

``python -m benchmarks.causes`` runs a campaign, without shrinking, against each fault of
:mod:`benchmarks.faults` and takes every failure that shows the fault: with the verdict expected of it, in
a world in which the controller without the fault arrives. It counts their causes, and prints the
tables of ``docs/reference/verdicts.md`` row by row; with ``--json`` one object. It takes about six
minutes on two cores, and prints the same each time.

*Completeness* of a fault is the share of its failures in its most frequent cause. *Purity* of a
cause is the share of its failures that come from faults whose most frequent cause it is. A third
figure is the share of pairs of failures of two faults that have different causes. Each fault weighs
the same, however many failures were taken of it.

The rules for causes were written while looking at worlds of :data:`DESIGN`, half of the faults,
found with seed 1. No world of the other half was looked at, and none that the default seed finds.
The room that shows which controllers get around walls was chosen with all faults.
"""

from __future__ import annotations

import argparse
import json
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import combinations, islice
from pathlib import Path

import click

from benchmarks.faults import FAULTS
from benchmarks.finding import tells
from benchmarks.searchers import strategies
from fuzz.campaign import unit
from fuzz.facts.hazards import is_hazard
from fuzz.failure import Failure
from fuzz.triage import triage
from fuzz.triage.diagnosis import cause_of
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario

# The words of a round that takes seconds; the gate runs it.
TINY = ("--units", "1", "--faults", "bug2-stale-line", "--workers", "1")

DESIGN = tuple(sorted(FAULTS)[::2])
"""The faults whose worlds were looked at while the rules for causes were written."""

_EXAMPLES = 60
# Failures of a fault: after the unit with the hundredth, no further unit runs.
_MOST = 100
_UNITS = 12
_SEED = 2
_SHIPPED = Path("corpora/failures")


@dataclass(frozen=True)
class Sorted:
    """The failures that show one fault.

    Args:
        fault: Its name.
        failures: How many.
        signatures: How many different signatures they have.
        causes: How many have each cause, the most frequent first.
    """

    fault: str
    failures: int
    signatures: int
    causes: dict[str, int] = field(default_factory=dict)

    @property
    def main(self) -> str:
        """The most frequent cause; empty if there are no failures."""
        return next(iter(self.causes), "")

    @property
    def completeness(self) -> float:
        """Share of the failures that have the most frequent cause."""
        return self.causes[self.main] / self.failures if self.failures else 0.0


class _Everything(triage.Triage):
    """Triage that keeps every failure, and not only the simplest of each signature."""

    found: list[Failure]

    def _keep(self, failure: Failure | None) -> str:
        if failure is not None:
            _Everything.found.append(failure)
        return super()._keep(failure)


def sort_failures(fault: str, units: int = _UNITS, seed: int = _SEED) -> Sorted:
    """Search for failures that show a fault, and count their signatures and causes.

    Args:
        fault: Name of the fault.
        units: Maximum number of units of the campaign to run.
        seed: Seed of the campaign.
    """
    planted = FAULTS[fault]
    scenario = Scenario.parse(f"fuzz.faults:{fault.replace('-', '_')}{planted.variations}")
    config = CampaignConfig(
        scenario, seed=seed, examples=_EXAMPLES, time_steps=(scenario.run.time_step,)
    )
    # Units make their triage from the module's name, which is exchanged in this process alone.
    _Everything.found = []
    setattr(unit, "Triage", _Everything)  # noqa: B010 - the module does not export it
    showing: list[Failure] = []
    for _ in islice(strategies()(config), units):
        showing += [
            failure
            for failure in _Everything.found
            if failure.verdict == planted.expected and tells(planted, failure)
        ]
        _Everything.found.clear()
        if len(showing) >= _MOST:
            break
    causes = Counter(cause_of(failure).value for failure in showing)
    signatures = {failure.signature for failure in showing}
    return Sorted(fault, len(showing), len(signatures), dict(causes.most_common()))


def purity(rows: Sequence[Sorted]) -> dict[str, float]:
    """Return of each cause the share that comes from faults whose main cause it is."""
    share: dict[str, float] = {}
    own: dict[str, float] = {}
    for row in rows:
        for cause, count in row.causes.items():
            share[cause] = share.get(cause, 0.0) + count / row.failures
            own[cause] = own.get(cause, 0.0) + (count / row.failures if cause == row.main else 0.0)
    return {cause: own[cause] / share[cause] for cause in sorted(share)}


def apart(rows: Sequence[Sorted]) -> float:
    """Return the share of pairs of failures of two faults that have different causes.

    Fewer causes would make the other two figures better and this one worse.
    """
    pairs = list(combinations([row for row in rows if row.failures], 2))
    same = sum(
        one.causes[cause] * other.causes.get(cause, 0) / (one.failures * other.failures)
        for one, other in pairs
        for cause in one.causes
    )
    return 1.0 - same / max(1, len(pairs))


def _row(row: Sorted) -> str:
    others = ", ".join(f"{name} {count}" for name, count in list(row.causes.items())[1:])
    held = "" if row.fault in DESIGN else "yes"
    return (
        f"| `{row.fault}` | {held} | {row.failures} | {row.signatures} | {row.main} | "
        f"{_percent(row.completeness) if row.failures else '-'} | {others} |"
    )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _totals(rows: Sequence[Sorted]) -> Iterator[str]:
    """Yield the lines under the table of faults: totals, purity, and how many causes are shared."""
    known = [row for row in rows if row.failures]
    for name, own in (
        ("All", known),
        ("Held out", [row for row in known if row.fault not in DESIGN]),
    ):
        complete = sum(row.completeness >= 0.9 for row in own)
        mean = sum(row.completeness for row in own) / max(1, len(own))
        yield ""
        yield (
            f"{name}: {complete} of {len(own)} faults have 90 % or more in one cause; "
            f"mean {_percent(mean)}."
        )
    yield from (
        "",
        f"Pairs of failures of different faults with different causes: {_percent(apart(known))}.",
    )
    yield from ("", "| cause | main cause of | purity |", "| --- | ---: | ---: |")
    mains = Counter(row.main for row in known)
    for cause, value in purity(known).items():
        yield f"| {cause} | {mains[cause]} | {_percent(value)} |"


def _shipped() -> Iterator[str]:
    """Yield the table of the failures that ship, by controller."""
    yield from ("", "| controller | failures | causes |", "| --- | ---: | --- |")
    found: dict[str, Counter[str]] = {}
    for path in sorted(_SHIPPED.rglob("*.grid")):
        failure = Failure.read(path)
        if not is_hazard(failure):
            cause = cause_of(failure).value
            found.setdefault(path.relative_to(_SHIPPED).parts[0], Counter())[cause] += 1
    for name, causes in sorted(found.items()):
        counts = ", ".join(f"{cause} {count}" for cause, count in causes.most_common())
        yield f"| `{name}` | {causes.total()} | {counts} |"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--units", type=int, default=_UNITS, help=f"most units for each fault (default {_UNITS})"
    )
    parser.add_argument("--seed", type=int, default=_SEED, help=f"seed (default {_SEED})")
    parser.add_argument("--faults", default=",".join(FAULTS), help="names, with commas between")
    parser.add_argument(
        "--workers", type=int, default=os.cpu_count(), help="processes (default one per core)"
    )
    given = parser.parse_args()
    names = given.faults.split(",")

    # Rows come in the order of their names, each as soon as it and those before it are done.
    rows: list[Sorted] = []
    if not given.json:
        click.echo(
            "| fault | held out | failures | signatures | most frequent cause | share | others |"
        )
        click.echo("| --- | --- | ---: | ---: | --- | ---: | --- |")
    with ProcessPoolExecutor(given.workers) as pool:
        task = partial(sort_failures, units=given.units, seed=given.seed)
        for row in pool.map(task, names):
            rows.append(row)
            if not given.json:
                click.echo(_row(row))
    # The totals follow the rows.
    if given.json:
        click.echo(
            json.dumps(
                {
                    "rows": [asdict(row) for row in rows],
                    "purity": purity(rows),
                    "apart": apart(rows),
                }
            )
        )
        return
    for line in (*_totals(rows), *_shipped()):
        click.echo(line)


if __name__ == "__main__":
    main()
