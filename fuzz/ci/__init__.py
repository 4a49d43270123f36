"""Report failures to CI services: JUnit, SARIF and a summary in Markdown.

Contents (each name is imported on first use):
    CiFinding, FindingState, Report: The results of a command.
    Outputs, NO_OUTPUTS: The report files that a user requests, checked before the work starts and
        written after it.
    place_of, repository: Locate a controller's source in the repository.

The modules ``junit``, ``sarif`` and ``markdown`` convert a report to text.
``docs/reference/ci.md`` describes these reports for users.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from fuzz.ci.finding import CiFinding, FindingState, Report
    from fuzz.ci.outputs import NO_OUTPUTS, Outputs
    from fuzz.ci.place import place_of, repository

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "finding": ("CiFinding", "FindingState", "Report"),
        "outputs": ("NO_OUTPUTS", "Outputs"),
        "place": ("place_of", "repository"),
    },
)

__all__ = ["NO_OUTPUTS", "CiFinding", "FindingState", "Outputs", "Report", "place_of", "repository"]
