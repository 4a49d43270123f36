"""Group the failures of a campaign by cause, the worst first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from fuzz.cause import Cause, Diagnosis, Severity
from fuzz.failure import Failure
from fuzz.overview.counterfactual import Counterfactuals
from fuzz.overview.table import CauseRow
from fuzz.triage.diagnosis import cause_of, diagnosis_of
from fuzz.triage.run_facts import RunFacts

# Errors in any world, however unusual it is.
_ERRORS = (Severity.THROUGH_WALLS, Severity.THROUGH_ROBOTS, Severity.CONTROLLER_ERROR)


@dataclass(frozen=True)
class CauseTotals:
    """A cause, and its occurrences in a campaign.

    Args:
        cause: The cause.
        groups: Names under which its failures are filed: its own or, if errors have different
            reasons, theirs.
        verdicts: Number of examined failures by verdict.
        natural: Number of natural worlds in which it occurred; ``None`` if none were tried.
        file: File of the world to look at, relative to the campaign's folder; empty if there is
            none.
        failure: The failure in ``file``.
        original: The failure that ``failure`` was shrunk from, if only natural worlds have it.
        smallest: File of the simplest world; empty if there is none.
        files: All its files, the clearest first.
        shown: What the run in ``file`` shows; empty if not tried.
        why: The single changes after which the robot of ``file`` arrives; ``None`` if not tried.
        fault: The controller's error in ``file``, and its place: ``mine.py:6: KeyError: 'left'``;
            empty if the controller raised none.
        state: ``new`` or ``still`` compared with the known failures; empty if there were none.
    """

    cause: Cause
    groups: tuple[str, ...]
    verdicts: Mapping[str, int] = field(default_factory=dict)
    natural: int | None = None
    file: str = ""
    failure: Failure | None = None
    original: Failure | None = None
    smallest: str = ""
    files: tuple[str, ...] = ()
    shown: RunFacts = field(default_factory=RunFacts)
    why: Counterfactuals | None = None
    fault: str = ""
    state: str = ""

    @cached_property
    def diagnosis(self) -> Diagnosis:
        """The cause with the circumstance of the world to look at."""
        return Diagnosis(self.cause) if self.failure is None else diagnosis_of(self.failure)

    @property
    def sentence(self) -> str:
        """What goes wrong, in one sentence."""
        return self.diagnosis.sentence(None if self.failure is None else self.failure.world)

    @property
    def met(self) -> int:
        """Number of examined failures of this cause."""
        return sum(self.verdicts.values())

    @property
    def is_met(self) -> bool:
        """True if a world of the search or a natural one shows it, and not only a shrunk one."""
        return self.met > 0 or bool(self.natural)

    def table(self) -> CauseRow:
        """Return the form of this record in JSON; ``docs/reference/verdicts.md`` describes it."""
        return CauseRow(
            cause=self.cause.value,
            sentence=self.sentence,
            advice=self.diagnosis.advice,
            severity=self.cause.severity.word,
            state=self.state,
            met=self.met,
            verdicts=dict(self.verdicts),
            natural=self.natural,
            groups=list(self.groups),
            files=list(self.files),
            file=self.file,
            smallest=self.smallest,
            fault=self.fault,
            **self.shown.table(),
            why="" if self.why is None else self.why.describe(),
            changes=[] if self.why is None else [vars(change) for change in self.why.changes],
        )


def causes_of(
    failures: Iterable[Failure], met: Mapping[tuple[str, str], int] | None = None
) -> list[CauseTotals]:
    """Group failures by cause, the worst and most frequent first.

    Args:
        failures: Any failures. Those whose record names no cause, because an older version wrote
            it, are run.
        met: By group and verdict, the number of failures that a campaign has examined. If omitted,
            the failures are counted.
    """
    groups: dict[Cause, set[str]] = {}
    found: Counter[tuple[str, str]] = Counter()
    for failure in failures:
        groups.setdefault(cause_of(failure), set()).add(failure.group)
        found[failure.group, failure.verdict] += 1
    counts = found if met is None else met
    verdicts: dict[Cause, Counter[str]] = {}
    for cause, own in groups.items():
        verdicts[cause] = Counter()
        for (group, verdict), count in counts.items():
            if group in own:
                verdicts[cause][verdict] += count
    return in_order(
        CauseTotals(cause, tuple(sorted(own)), dict((+verdicts[cause]).most_common()))
        for cause, own in groups.items()
    )


def in_order(causes: Iterable[CauseTotals]) -> list[CauseTotals]:
    """Sort causes: by severity, then by frequency in natural worlds, then in all worlds.

    Natural worlds come first because a search goes where failures are: its counts say more about
    the search than about the controller. So a cause that no natural world shows comes after those
    that some show, unless it is an error in any world.
    """
    order = list(Cause)

    def key(one: CauseTotals) -> tuple[bool, Severity, int, int, int]:
        is_curious = one.natural == 0 and one.cause.severity not in _ERRORS
        place = order.index(one.cause)
        return is_curious, one.cause.severity, -(one.natural or 0), -one.met, place

    return sorted(causes, key=key)


def with_natural(causes: Iterable[CauseTotals], natural: Mapping[Cause, int]) -> list[CauseTotals]:
    """Return causes with their frequency in natural worlds, and those found only there."""
    found = {one.cause: one for one in causes}
    for cause in natural.keys() - found.keys():
        found[cause] = CauseTotals(cause, ())
    return in_order(replace(one, natural=natural.get(one.cause, 0)) for one in found.values())
