"""Motion models: how a commanded motion becomes displacement.

Contents:
    Motion, MOTIONS: what a model is, and all of them by name.
"""

from sim.motion.base import MOTIONS, Motion

__all__ = ["MOTIONS", "Motion"]
