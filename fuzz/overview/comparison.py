"""Compare a campaign with earlier knowledge: what is new, what is fixed, what is still there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from fuzz.overview.causes import CauseTotals
from fuzz.overview.table import ChangesRow, ComparisonRow
from fuzz.cause import Cause
from worldgen.support.plain_text import counted


@dataclass(frozen=True)
class RegressionView:
    """What changed since an earlier campaign or a baseline.

    Args:
        against: ``baseline`` or ``last campaign``.
        new: Classes met now that were not known.
        still: Known classes that still fail.
        fixed: Known classes whose known failure no longer fails.
        new_causes: Causes met now that had no known failure.
        still_causes: Previously known causes that still occur.
        fixed_causes: Previously known causes that no longer occur.
    """

    against: str
    new: tuple[str, ...]
    still: tuple[str, ...]
    fixed: tuple[str, ...]
    new_causes: tuple[Cause, ...]
    still_causes: tuple[Cause, ...]
    fixed_causes: tuple[Cause, ...]

    def table(self) -> ComparisonRow:
        """Return the form of this record in JSON."""
        causes = (self.new_causes, self.still_causes, self.fixed_causes)
        return ComparisonRow(
            against=self.against,
            causes=ChangesRow(*([cause.value for cause in some] for some in causes)),
            classes=ChangesRow(list(self.new), list(self.still), list(self.fixed)),
            sentence=self.describe(),
        )

    def describe(self) -> str:
        """Return one sentence: ``against the baseline: 1 new cause (crashes), 2 fixed classes``."""
        parts = []
        for words, causes, classes in (
            ("new", self.new_causes, self.new),
            ("fixed", self.fixed_causes, self.fixed),
            ("still there", self.still_causes, self.still),
        ):
            names = f" ({', '.join(causes)})" if causes else ""
            count = f"{counted(len(causes), 'cause')}{names} and " if causes else ""
            parts.append(f"{words}: {count}{counted(len(classes), 'class', 'classes')}")
        return f"against the {self.against}, {'; '.join(parts)}"


def compare(
    against: str, now: Mapping[str, Cause], still: Mapping[str, Cause], fixed: Mapping[str, Cause]
) -> RegressionView:
    """Return what changed.

    Args:
        against: Name of the reference.
        now: The cause of current failures, by class.
        still: By class, the cause of known failures that still fail.
        fixed: By class, the cause of known failures that no longer fail.
    """
    known = still.keys() | fixed.keys()
    causes_before = {*still.values(), *fixed.values()}
    causes_now = {*now.values(), *still.values()}
    return RegressionView(
        against,
        new=tuple(sorted(now.keys() - known)),
        still=tuple(sorted(still)),
        fixed=tuple(sorted(fixed.keys() - still.keys() - now.keys())),
        new_causes=_sorted(causes_now - causes_before),
        still_causes=_sorted(causes_now & causes_before),
        # Without a run, the cause of an old failure that is fixed remains unknown.
        fixed_causes=_sorted(causes_before - causes_now - {Cause.UNKNOWN}),
    )


def with_states(causes: Iterable[CauseTotals], comparison: RegressionView) -> list[CauseTotals]:
    """Return causes, each marked as new or known; not those that only natural worlds show.

    An earlier campaign had other failures in its folder, not the natural worlds that it ran.
    """
    new = set(comparison.new_causes)
    still = set(comparison.still_causes)

    def state(cause: Cause) -> str:
        if cause in still:
            return "still"
        return "new" if cause in new else ""

    return [replace(one, state=state(one.cause)) for one in causes]


def _sorted(causes: Iterable[Cause]) -> tuple[Cause, ...]:
    order = list(Cause)
    return tuple(sorted(causes, key=order.index))
