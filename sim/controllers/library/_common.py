"""Declarations that controllers of the library share: their senses, and a user's own numbers.

``sim/core/controllers/shared/boundary.h`` describes those that follow a wall by touch. The memory
of each of them begins with the fields of ``WgWallBody``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct
from sim.kernels.layout import place

HAND = place("WgWallBody", "hand")

TO_TARGET = ("heading", "target_heading", "target_distance", "time_step", "top_speed", "radius")
"""Senses of a controller that drives to the target."""

LOCATED = (*TO_TARGET, "x", "y")
"""Senses of one that also knows its position."""

BY_TOUCH = ("bump", "bump_bearing", *LOCATED)
"""Senses of one that also follows walls."""


def tuned_controller(controller: CompiledController, tuned: Any, name: str) -> CompiledController:
    """Return a controller with a user's numbers.

    Args:
        controller: The one with the default numbers, which the core holds.
        tuned: The numbers, a NamedTuple that has those as its defaults.
        name: Name in messages and files.
    """
    if tuned == type(tuned)():
        return replace(controller, name=name)
    act = CoreAct(f"{controller.name}-tuned")
    return replace(controller, name=name, act=act, memory=(*controller.memory, *map(float, tuned)))
