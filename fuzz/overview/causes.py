"""Group the failures of a campaign by cause, the worst first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from msgspec import structs

from fuzz.cause import Cause, Severity
from fuzz.failure import Failure
from fuzz.overview.result import CauseResult
from fuzz.triage.diagnosis import cause_of

# Errors in any world, however unusual it is.
_ERRORS = (Severity.THROUGH_WALLS, Severity.THROUGH_ROBOTS, Severity.CONTROLLER_ERROR)


def causes_of(
    failures: Iterable[Failure], met: Mapping[tuple[str, str], int] | None = None
) -> list[CauseResult]:
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
        CauseResult.of(cause, sorted(own), dict((+verdicts[cause]).most_common()))
        for cause, own in groups.items()
    )


def in_order(causes: Iterable[CauseResult]) -> list[CauseResult]:
    """Sort causes: by severity, then by frequency in natural worlds, then in all worlds.

    Natural worlds come first because a search goes where failures are: its counts say more about
    the search than about the controller. So a cause that no natural world shows comes after those
    that some show, unless it is an error in any world.
    """
    order = list(Cause)

    def key(one: CauseResult) -> tuple[bool, Severity, int, int, int]:
        is_curious = one.natural == 0 and one.cause.severity not in _ERRORS
        place = order.index(one.cause)
        return is_curious, one.cause.severity, -(one.natural or 0), -one.met, place

    return sorted(causes, key=key)


def with_natural(causes: Iterable[CauseResult], natural: Mapping[str, int]) -> list[CauseResult]:
    """Return causes with their frequency in natural worlds, and those found only there."""
    found = {one.cause: one for one in causes}
    for cause in natural.keys() - found.keys():
        found[Cause(cause)] = CauseResult.of(Cause(cause))
    return in_order(
        structs.replace(one, natural=natural.get(one.cause, 0)) for one in found.values()
    )
