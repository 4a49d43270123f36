"""Campaigns with another goal than failures.

They find a world in which given controllers have given outcomes, or nearly so, and the values of a
number at which an outcome changes.

Contents:
    parse_targets, OutcomeTarget, Result: the outcomes, and how close a run comes.
    FindConfig, OutcomeSearch, NearestWorld: the search, unit by unit, and its result.
    draw: a world that the search might try first, to check that one exists.
    AxisScan, Stretch: every change of outcome between the values of a scan.
"""

from fuzz.find.scan import AxisScan, Stretch
from fuzz.find.search import FindConfig, NearestWorld, OutcomeSearch, draw
from fuzz.find.targets import OutcomeTarget, Result, parse_targets

__all__ = [
    "AxisScan",
    "FindConfig",
    "NearestWorld",
    "OutcomeSearch",
    "OutcomeTarget",
    "Result",
    "Stretch",
    "draw",
    "parse_targets",
]
