"""``stepped``: the thesis's motion in steps of one pixel, a tenth of a cell, with its faults."""

from sim.motion.base import THESIS, Motion

__all__ = ["stepped"]

# One pixel, the model's own step: what it calls touching is up to half of that inside (its corner case).
stepped = Motion(
    "stepped", version=1, kernel=THESIS, code=0, overlap_tolerance=0.1,
    summary="the thesis's one-pixel stepping, faults included; runs the thesis's robots",
)  # fmt: skip
