"""Find a world in which given controllers have given outcomes, or nearly so.

Contents:
    parse_targets, OutcomeTarget, Result: the outcomes, and how close a run comes.
    FindConfig, OutcomeSearch, NearestWorld: the search, unit by unit, and its result.
    draw: a world that the search might try first, to check that one exists.
"""

from fuzz.find.search import FindConfig, NearestWorld, OutcomeSearch, draw
from fuzz.find.targets import OutcomeTarget, Result, parse_targets

__all__ = [
    "FindConfig",
    "NearestWorld",
    "OutcomeSearch",
    "OutcomeTarget",
    "Result",
    "draw",
    "parse_targets",
]
