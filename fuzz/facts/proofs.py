"""Prove that a target is reachable or walled off, and check the proof stored in a file."""

from __future__ import annotations

import math
from dataclasses import replace

from sim.motion import MOTIONS
from worldgen.lattice import in_cells
from worldgen.reach import BLOCKED, REACHABLE, check_certificate, decide
from worldgen.world import Cut, Pose, World


def certified(world: World) -> World | None:
    """Return the world with a new witness, or ``None`` if its target is not provably reachable."""
    decision = decide(world, cut=False)
    return (
        replace(world, certificate=decision.certificate) if decision.result == REACHABLE else None
    )


def walled_off(world: World) -> World | None:
    """Return the world with a new cut around its target's cell.

    ``None`` if the target is not provably walled off. The thesis's robot arrives as soon as it
    enters the target's cell, so the cut separates the start from the whole cell. A target where
    the robot does not fit does not count as walled off: that is a slot, not a breach in the making.
    """
    # Does the robot fit at the target at all?
    at_target = replace(
        world, start=Pose(world.target.x, world.target.y, 0.0), certificate=None, failure=None
    )
    if decide(at_target, certificate=False).result != REACHABLE:
        return None
    decision = decide(_with_whole_cell(world))
    return replace(world, certificate=decision.certificate) if decision.result == BLOCKED else None


def _with_whole_cell(world: World) -> World:
    """Return the world with a target that covers both the target and its whole cell."""
    side = world.cell_size
    target = world.target
    x, y = (float((math.floor(in_cells(v, side)) + 0.5) * side) for v in (target.x, target.y))
    corner = side * math.sqrt(0.5) * (1 + 1e-9)
    needed = math.dist((x, y), (target.x, target.y)) + target.radius
    whole = replace(target, x=x, y=y, radius=max(corner, needed))
    return replace(world, target=whole, failure=None)


def certificate_fault(world: World, motion: str) -> str:
    """Return the reason that a world's certificate does not hold; empty if it does.

    Args:
        world: The world.
        motion: Name of the motion model that its robot is run with.
    """
    if world.certificate is None:
        return "the file has no witness that the target can be reached"
    is_cut = isinstance(world.certificate, Cut)
    report = check_certificate(world)
    if not report.valid:
        return f"the {'cut' if is_cut else 'witness'} does not hold: {report.reason}"

    # The thesis's robot arrives as soon as it enters the target's cell.
    if is_cut and not MOTIONS.get(motion).on_lattice:
        report = check_certificate(_with_whole_cell(world))
        if not report.valid:
            return f"the cut does not hold for the target's whole cell: {report.reason}"
    return ""
