"""Shrinking: make a failure's world as small as possible, and check that it is.

Contents:
    shrink: Runs every pass until none of them makes the failure simpler.
    Shrunk: The result of both.
    snippet: Writes a failure as a test module that contains its world.
    PASSES: The list of simplifications.
    ORDER: The measures that define "simpler".
    removable: Lists the parts that could still be removed; empty for a 1-minimal world.
"""

from fuzz.shrink.minimal import removable
from fuzz.shrink.passes import PASSES
from fuzz.shrink.run import Shrunk, shrink
from fuzz.shrink.snippet import snippet
from fuzz.simplicity import ORDER

__all__ = ["ORDER", "PASSES", "Shrunk", "removable", "shrink", "snippet"]
