"""Motion models: how a commanded motion becomes displacement, one file each.

Contents:
    Motion, MOTIONS: what a model is, and the registry that finds one by name.
"""

from sim.motion.base import MOTIONS, Motion

__all__ = ["MOTIONS", "Motion"]
