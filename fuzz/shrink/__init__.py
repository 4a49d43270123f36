"""Shrinking: makes a failure's world as small as it can be, and checks that it is.

Contents:
    shrink: runs every pass until none makes the failure simpler.
    shrink_class: the simplest result over several failures.
    Shrunk: what they return.
    snippet: a failure as a test module that carries its world.
    KEEP: what a shrunk failure can keep of the one that it came from.
    PASSES: the ways to get simpler, as a list.
    ORDER: what "simpler" means, as a list.
    removable: what could still be taken away; empty for a 1-minimal world.
"""

from fuzz.shrink.minimal import removable
from fuzz.shrink.passes import PASSES
from fuzz.shrink.run import KEEP, Shrunk, shrink, shrink_class
from fuzz.shrink.snippet import snippet
from fuzz.simplicity import ORDER

__all__ = ["KEEP", "ORDER", "PASSES", "Shrunk", "removable", "shrink", "shrink_class", "snippet"]
