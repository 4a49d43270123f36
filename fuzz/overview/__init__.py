"""The answer to a campaign: does it work, how bad is it, why, and what to do.

Contents:
    CampaignResult: The answer as data; ``overview.json`` in a campaign's hidden folder.
    CauseResult: A cause, and its occurrences.
    NaturalResult: How often the robot arrives in natural worlds.
    read_overview: Reads that file.
    causes_of: Groups failures by cause.
    Cause: The causes.
    Severity: How bad a cause is.
    cause_of: The cause of one failure.
"""

from fuzz.cause import Cause, Severity
from fuzz.overview.causes import causes_of
from fuzz.overview.result import CampaignResult, CauseResult, NaturalResult, read_overview
from fuzz.triage.diagnosis import cause_of

__all__ = [
    "CampaignResult",
    "Cause",
    "CauseResult",
    "NaturalResult",
    "Severity",
    "cause_of",
    "causes_of",
    "read_overview",
]
