"""The answer of a campaign, as data: written next to its summary, for reports and the studio."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.campaign.store import MEMORY, OVERVIEW_FILE
from fuzz.failure import Failure
from fuzz.overview.causes import CauseTotals
from fuzz.overview.comparison import RegressionView
from fuzz.overview.natural import NaturalRuns
from fuzz.overview.table import OverviewTable
from worldgen.files.json_file import JsonFile

_FILE = JsonFile(
    OverviewTable,
    version=2,
    code="invalid-overview",
    problem="not an overview of a campaign: {reason}",
    remedy="run the campaign again, or delete the file if you don't need the overview",
)


@dataclass(frozen=True)
class Overview:
    """The answer: does it work, how bad is it, and why.

    Args:
        causes: The causes, the worst first.
        natural: The results in natural worlds; ``None`` if none were run.
        comparison: Changes since an earlier campaign; ``None`` if it is the first.
        files: By the stem of its file, each failure that the campaign shows.
    """

    causes: tuple[CauseTotals, ...]
    natural: NaturalRuns | None = None
    comparison: RegressionView | None = None
    files: Mapping[str, Failure] = field(default_factory=dict)

    def table(self) -> OverviewTable:
        """Return the form of the answer in JSON."""
        return OverviewTable(
            causes=[one.table() for one in self.causes],
            natural=None if self.natural is None else self.natural.table(),
            comparison=None if self.comparison is None else self.comparison.table(),
        )


def write_overview(overview: Overview, folder: Path) -> None:
    """Write an overview into a campaign's folder.

    Raises:
        OutputError: If it cannot be written.
    """
    _FILE.write(folder / MEMORY / OVERVIEW_FILE, overview.table())


def read_overview(folder: Path) -> OverviewTable | None:
    """Return the overview in a campaign's folder, or ``None`` if it has no such file.

    The form is checked, so that pages can rely on it whatever the file's origin.

    Raises:
        FormatError: If the file cannot be read, or is not an overview of version 2.
    """
    return _FILE.find(folder / MEMORY / OVERVIEW_FILE)
