"""Motion models: how a commanded motion becomes displacement.

Contents:
    Motion: What a motion model is.
    MOTIONS: All motion models, by name.
"""

from sim.motion.base import MOTIONS, Motion

__all__ = ["MOTIONS", "Motion"]
