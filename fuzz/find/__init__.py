"""Find a world in which given controllers have given outcomes, or nearly so.

Contents:
    parse_targets, Wish: what is wanted.
    FindConfig, Find, Found: the search, unit by unit, and what it came to.
    draw: a world that it might look at first, to see whether there is one.
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
