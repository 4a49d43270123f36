"""Compare a campaign with earlier knowledge: what is new, what is fixed, what is still there."""

from __future__ import annotations

from collections.abc import Iterable, Set

from msgspec import structs

from fuzz.overview.result import CampaignComparison, CauseResult
from worldgen.support.plain_text import counted


def compare(
    against: str, now: Set[str], still: Set[str], fixed: Set[str], fall: str = ""
) -> CampaignComparison:
    """Return what changed.

    Its sentence is like ``against the baseline, new: 1 cause (crashes); fixed: none``.

    Args:
        against: Name of the reference.
        now: Groups of the current failures.
        still: Groups of the known failures that still fail.
        fixed: Groups of the known failures that no longer fail.
        fall: That the robot arrives in fewer natural worlds than before; empty unless it does.
    """
    new = sorted(now - still - fixed)
    gone = sorted(fixed - still - now)
    there = sorted(still)
    parts = []
    for words, groups in (("new", new), ("fixed", gone), ("still there", there)):
        names = f" ({', '.join(groups)})" if groups else ""
        parts.append(f"{words}: {counted(len(groups), 'cause')}{names}")
    if fall:
        parts.append(fall)
    return CampaignComparison(
        against=against,
        causes={"new": new, "still": there, "fixed": gone},
        sentence=f"against the {against}, {'; '.join(parts)}",
    )


def with_states(causes: Iterable[CauseResult], comparison: CampaignComparison) -> list[CauseResult]:
    """Return causes, each marked as new or known if it has failures to compare."""

    def state(one: CauseResult) -> str:
        if set(one.groups) & set(comparison.causes["new"]):
            return "new"
        return "still" if set(one.groups) & set(comparison.causes["still"]) else ""

    return [structs.replace(one, state=state(one)) for one in causes]
