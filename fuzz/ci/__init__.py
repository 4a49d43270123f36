"""Failures for the programs that run tests for a team: JUnit, SARIF and a summary in Markdown.

Contents:
    Finding, State, Report: what a command found, and what it did for it.
    Outputs, NO_OUTPUTS: the files that a user asks for, checked before the work and written after
        it.
    junit, sarif, markdown: a report as text.
    place_of, repository: where in the repository a controller's source stands.

``docs/tutorials/ci.md`` is the description.
"""

from fuzz.ci.finding import CiFinding, Report, State
from fuzz.ci.junit import junit
from fuzz.ci.markdown import markdown
from fuzz.ci.outputs import NO_OUTPUTS, Outputs
from fuzz.ci.place import place_of, repository
from fuzz.ci.sarif import sarif

__all__ = [
    "NO_OUTPUTS", "CiFinding", "Outputs", "Report", "State", "junit", "markdown", "place_of", "repository", "sarif",
]  # fmt: skip
