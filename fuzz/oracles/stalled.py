"""``stalled``: no proof of a loop, but the second half of the budget brought no new cell."""

from __future__ import annotations

from collections.abc import Mapping

from fuzz.oracles._plain import first_new_cell_of_second_half
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import Value, World

__all__ = ["object_to_stalled"]


def object_to_stalled(world: World, trace: Trace, evidence: Mapping[str, Value], motion: Motion) -> str:
    """Objects if a state of the second half lies in a cell that no state of the first half has seen."""
    fresh = first_new_cell_of_second_half(world, trace)
    return f"cell {fresh} is entered for the first time in the second half" if fresh else ""
