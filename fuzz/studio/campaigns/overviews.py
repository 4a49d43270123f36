"""Read from campaigns' overviews how bad failures are, and what their examples depend on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from fuzz.cause import Cause
from fuzz.overview.causes import in_order
from fuzz.overview.result import CampaignResult, CauseResult, read_overview
from worldgen.errors import WorldgenError


def ranks(causes: Iterable[str], folders: Iterable[Path]) -> dict[str, int]:
    """Return the place of each cause, the worst first, in the order of the report.

    Args:
        causes: The cause of each failure by name; an empty one is an unknown cause.
        folders: Folders of failures. Those of campaigns know how often a cause occurs in natural
            worlds.
    """
    met = Counter(cause or Cause.UNKNOWN.value for cause in causes)
    natural: Counter[str] = Counter()
    for folder in folders:
        overview = _overview_in(folder)
        for row in () if overview is None else overview.causes:
            natural[row.cause.value] += row.natural or 0
    totals = (
        CauseResult.of(Cause(cause), (), {cause: count}, natural[cause])
        for cause, count in met.items()
    )
    order = {one.cause.value: rank for rank, one in enumerate(in_order(totals))}
    return order | {"": order.get(Cause.UNKNOWN.value, 0)}


def example_in(file: Path) -> CauseResult | None:
    """Return the cause whose example a file is, according to the campaign in its folder."""
    overview = _overview_in(file.parent)
    if overview is None:
        return None
    return next((row for row in overview.causes if row.file == file.name), None)


def _overview_in(folder: Path) -> CampaignResult | None:
    """Return a campaign's overview; ``None`` if its file is missing or cannot be read.

    The pictures are worth showing without it.
    """
    try:
        return read_overview(folder)
    except WorldgenError:
        return None
