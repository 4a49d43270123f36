"""Common parts of controllers that follow a wall by touch.

``sim/core/controllers/shared/boundary.h`` describes how they do it. The memory of each of them begins with
the fields of ``WgWallBody``.
"""

from __future__ import annotations

from sim.controllers.core_act import place

__all__ = ["HAND", "SENSES", "WALL", "X", "Y"]

X = place("WgWallBody", "x")
Y = place("WgWallBody", "y")
HAND = place("WgWallBody", "hand")
WALL = place("WgWallBody", "wall")

SENSES = (
    "bump",
    "bump_bearing",
    "heading",
    "x",
    "y",
    "target_heading",
    "target_distance",
    "time_step",
    "top_speed",
    "radius",
)
"""Senses of a controller that drives to the target and follows walls."""
