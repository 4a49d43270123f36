"""Report failures to CI services: JUnit, SARIF and a summary in Markdown.

Contents:
    CiFinding, FindingState, Report: The results of a command.
    Outputs, NO_OUTPUTS: The report files that a user requests, checked before the work starts and
        written after it.
    junit, sarif, markdown: Convert a report to text.
    place_of, repository: Locate a controller's source in the repository.

``docs/tutorials/ci.md`` describes these reports for users.
"""

from fuzz.ci.finding import CiFinding, FindingState, Report
from fuzz.ci.junit import junit
from fuzz.ci.markdown import markdown
from fuzz.ci.outputs import NO_OUTPUTS, Outputs
from fuzz.ci.place import place_of, repository
from fuzz.ci.sarif import sarif

__all__ = [
    "NO_OUTPUTS",
    "CiFinding",
    "FindingState",
    "Outputs",
    "Report",
    "junit",
    "markdown",
    "place_of",
    "repository",
    "sarif",
]
