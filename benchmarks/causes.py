"""How well causes tell seeded faults apart.

``python -m benchmarks.causes`` runs a campaign, without shrinking, against each fault of
:mod:`fuzz.faults` and takes every failure that shows the fault: with the verdict expected of it, in a
world in which the controller without the fault arrives. It counts their causes, and prints the table
of ``docs/reference/verdicts.md``; with ``--json`` one object.

*Completeness* of a fault is the share of its failures in its most frequent cause. *Purity* of a cause
is the share of its failures that come from faults whose most frequent cause it is. Each fault weighs
the same, however many failures were taken of it.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field

import click

from benchmarks.finding import tells
from benchmarks.searchers import strategies
from fuzz.campaign import unit
from fuzz.campaign.config import CampaignConfig
from fuzz.failure import Failure
from fuzz.faults import FAULTS
from fuzz.triage import triage
from fuzz.triage.diagnosis import cause_of
from sim.scenario import Scenario

__all__ = ["Sorted", "purity", "sort_failures"]

_EXAMPLES = 60
_MOST = 150  # failures of a fault
_SECONDS = 20.0  # CPU seconds for a fault
_SEED = 1


@dataclass(frozen=True)
class Sorted:
    """The failures that show one fault.

    Args:
        fault: Its name.
        failures: How many.
        classes: In how many classes they are.
        causes: How many have each cause, the most frequent first.
    """

    fault: str
    failures: int
    classes: int
    causes: dict[str, int] = field(default_factory=dict)

    @property
    def main(self) -> str:
        """The most frequent cause; empty without failures."""
        return next(iter(self.causes), "")

    @property
    def completeness(self) -> float:
        """Share of the failures that have the most frequent cause."""
        return self.causes[self.main] / self.failures if self.failures else 0.0


class _Everything(triage.Triage):
    """Triage that keeps every failure, and not only the simplest of each class."""

    found: list[Failure]

    def _keep(self, failure: Failure | None) -> str:
        if failure is not None:
            _Everything.found.append(failure)
        return super()._keep(failure)


def sort_failures(fault: str, seconds: float = _SECONDS) -> Sorted:
    """Search for failures that show a fault, and count their classes and causes."""
    planted = FAULTS[fault]
    scenario = Scenario.parse(f"fuzz.faults:{fault.replace('-', '_')}{planted.variations}")
    config = CampaignConfig(
        scenario, seed=_SEED, examples=_EXAMPLES, time_steps=(scenario.run.time_step,)
    )
    showing: list[Failure] = []
    begun = time.process_time()
    for _ in strategies()(config):
        showing += [
            failure
            for failure in _Everything.found
            if failure.verdict == planted.expected and tells(planted, failure)
        ]
        _Everything.found.clear()
        if len(showing) >= _MOST or time.process_time() - begun >= seconds:
            break
    causes = Counter(cause_of(failure).value for failure in showing)
    kinds = {failure.bucket for failure in showing}
    return Sorted(fault, len(showing), len(kinds), dict(causes.most_common()))


def purity(rows: Sequence[Sorted]) -> dict[str, float]:
    """Return of each cause the share that comes from faults whose main cause it is."""
    share: dict[str, float] = {}
    own: dict[str, float] = {}
    for row in rows:
        for cause, count in row.causes.items():
            share[cause] = share.get(cause, 0.0) + count / row.failures
            own[cause] = own.get(cause, 0.0) + (count / row.failures if cause == row.main else 0.0)
    return {cause: own[cause] / share[cause] for cause in sorted(share)}


def _table(rows: Sequence[Sorted]) -> str:
    lines = [
        "| fault | failures | classes | most frequent cause | share | others |",
        "| --- | ---: | ---: | --- | ---: | --- |",
    ]
    for row in rows:
        others = ", ".join(f"{name} {count}" for name, count in list(row.causes.items())[1:])
        lines.append(
            f"| `{row.fault}` | {row.failures} | {row.classes} | {row.main} | "
            f"{row.completeness:.0%} | {others} |"
        )
    known = [row for row in rows if row.failures]
    complete = sum(row.completeness >= 0.9 for row in known)
    mean = sum(row.completeness for row in known) / max(1, len(known))
    lines.append("")
    lines.append(
        f"{complete} of {len(known)} faults have 90 % or more in one cause; mean {mean:.0%}."
    )
    lines.append("")
    lines += ["| cause | purity |", "| --- | ---: |"]
    lines += [f"| {cause} | {value:.0%} |" for cause, value in purity(known).items()]
    return "\n".join(lines)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--seconds", type=float, default=_SECONDS, help="CPU seconds for each fault (default 20)"
    )
    parser.add_argument("--faults", default=",".join(FAULTS), help="names, with commas between")
    given = parser.parse_args()

    # Units make their triage from the module's name, which is exchanged in this process alone.
    _Everything.found = []
    unit.Triage = _Everything  # type: ignore[misc]
    rows = [sort_failures(fault, given.seconds) for fault in given.faults.split(",")]
    found = {"rows": [asdict(row) for row in rows], "purity": purity(rows)}
    click.echo(json.dumps(found) if given.json else _table(rows))


if __name__ == "__main__":
    main()
