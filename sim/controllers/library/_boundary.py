"""What controllers that follow a wall by touch have in common.

How they do it says ``sim/core/controllers/boundary.h``. The memory of each begins with the fields
of ``WgWallBody``.
"""

from __future__ import annotations

from sim.controllers.core_act import place

__all__ = ["HAND", "SENSES", "WALL", "X", "Y"]

X = place("WgWallBody", "x")
Y = place("WgWallBody", "y")
HAND = place("WgWallBody", "hand")
WALL = place("WgWallBody", "wall")

SENSES = (
    "bump", "bump_bearing", "heading", "x", "y", "target_heading", "target_distance", "time_step", "top_speed",
    "radius",
)  # fmt: skip
"""What a controller looks at that drives to the target and follows walls."""
