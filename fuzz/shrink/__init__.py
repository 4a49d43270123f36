"""Shrinking: makes a failure's world as small as it can be, and checks that it is.

Contents:
    shrink: runs every pass until none makes the world simpler.
    removable: what could still be taken away; empty for a 1-minimal world.
    PASSES: what "simpler" means, as a list.
"""

from fuzz.shrink.minimal import removable
from fuzz.shrink.order import PASSES
from fuzz.shrink.run import Shrunk, shrink

__all__ = ["PASSES", "Shrunk", "removable", "shrink"]
