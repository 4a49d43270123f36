"""Compare a campaign with earlier knowledge: what is new, what is fixed, what is still there."""

from __future__ import annotations

from collections.abc import Iterable, Set
from dataclasses import dataclass, replace

from fuzz.overview.causes import CauseTotals
from fuzz.overview.table import ChangesRow, ComparisonRow
from worldgen.support.plain_text import counted


@dataclass(frozen=True)
class RegressionView:
    """What changed since an earlier campaign or a baseline.

    Failures are compared by group: by cause, or by the reason of an error.

    Args:
        against: ``baseline`` or ``last campaign``.
        new: Groups met now that were not known.
        still: Known groups that still fail.
        fixed: Known groups whose known failures no longer fail.
        fall: That the robot arrives in fewer natural worlds than before; empty unless it does.
    """

    against: str
    new: tuple[str, ...]
    still: tuple[str, ...]
    fixed: tuple[str, ...]
    fall: str = ""

    def table(self) -> ComparisonRow:
        """Return the form of this record in JSON."""
        return ComparisonRow(
            against=self.against,
            causes=ChangesRow(list(self.new), list(self.still), list(self.fixed)),
            sentence=self.describe(),
        )

    def describe(self) -> str:
        """Return one sentence: ``against the baseline, new: 1 cause (crashes); fixed: none``."""
        parts = []
        for words, groups in (
            ("new", self.new),
            ("fixed", self.fixed),
            ("still there", self.still),
        ):
            names = f" ({', '.join(groups)})" if groups else ""
            parts.append(f"{words}: {counted(len(groups), 'cause')}{names}")
        if self.fall:
            parts.append(self.fall)
        return f"against the {self.against}, {'; '.join(parts)}"


def compare(
    against: str, now: Set[str], still: Set[str], fixed: Set[str], fall: str = ""
) -> RegressionView:
    """Return what changed.

    Args:
        against: Name of the reference.
        now: Groups of the current failures.
        still: Groups of the known failures that still fail.
        fixed: Groups of the known failures that no longer fail.
        fall: See :class:`RegressionView`.
    """
    return RegressionView(
        against,
        new=tuple(sorted(now - still - fixed)),
        still=tuple(sorted(still)),
        fixed=tuple(sorted(fixed - still - now)),
        fall=fall,
    )


def with_states(causes: Iterable[CauseTotals], comparison: RegressionView) -> list[CauseTotals]:
    """Return causes, each marked as new or known if it has failures to compare."""

    def state(one: CauseTotals) -> str:
        if set(one.groups) & set(comparison.new):
            return "new"
        return "still" if set(one.groups) & set(comparison.still) else ""

    return [replace(one, state=state(one)) for one in causes]
