"""The answer to a campaign: does it work, how bad is it, why, and what to do.

Contents:
    causes_of: Groups the failures of a campaign by cause.
    CauseTotals: A cause, and its occurrences.
    Cause: The causes.
    Severity: How bad a cause is.
    cause_of: The cause of one failure.
    Overview: The answer as data; ``overview.json`` in a campaign's hidden folder.
    read_overview: Reads that file.
"""

from fuzz.cause import Cause, Severity
from fuzz.overview.causes import CauseTotals, causes_of
from fuzz.overview.overview import Overview, read_overview
from fuzz.triage.diagnosis import cause_of

__all__ = ["Cause", "CauseTotals", "Overview", "Severity", "cause_of", "causes_of", "read_overview"]
