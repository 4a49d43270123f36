"""Finds a world in which given controllers have given outcomes, exactly or as near as the budget allows.

Contents:
    parse_wishes, Wish: what is wanted.
    FindConfig, Find, Found: the search, unit by unit, and what it came to.
    draw: a world that it might look at first, to see whether there is one.
"""

from fuzz.find.search import Find, FindConfig, Found, draw
from fuzz.find.targets import Result, Wish, parse_wishes

__all__ = ["Find", "FindConfig", "Found", "Result", "Wish", "draw", "parse_wishes"]
