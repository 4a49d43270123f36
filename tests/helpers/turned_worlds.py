"""A world turned by quarters and mirrored, witness and all."""

import math
from dataclasses import replace

import numpy as np

from worldgen.timeline import Timeline
from worldgen.world import Pose, Target, Witness, World

__all__ = ["mirrored", "scaled", "turned"]


def mirrored(world: World) -> World:
    """Left and right swapped."""
    wide = world.width * world.cell_size
    line, proof = world.timeline, world.certificate
    assert isinstance(proof, Witness)
    return replace(
        world,
        walls=world.walls[:, ::-1],
        start=Pose(_across(wide, world.start.x), world.start.y, math.pi - world.start.heading),
        target=replace(world.target, x=_across(wide, world.target.x)),
        timeline=Timeline(line.times, world.width - 1 - line.ix, line.iy, line.states),
        certificate=replace(proof, x=np.array([_across(wide, x) for x in proof.x])),
    )


def turned(world: World) -> World:
    """Turned by a quarter, counter-clockwise."""
    high = world.height * world.cell_size
    line, proof = world.timeline, world.certificate
    assert isinstance(proof, Witness)
    return replace(
        world,
        walls=world.walls.T[:, ::-1],
        start=Pose(_across(high, world.start.y), world.start.x, world.start.heading + math.pi / 2),
        target=Target(_across(high, world.target.y), world.target.x, world.target.radius),
        timeline=Timeline(line.times, world.height - 1 - line.iy, line.ix, line.states),
        certificate=replace(proof, x=np.array([_across(high, y) for y in proof.y]), y=proof.x),
    )


def _across(side: float, value: float) -> float:
    return round(side - value, 12)


def scaled(world: World, by: float) -> World:
    """Every length times a number; times too, at the same speed."""
    proof, start, target = world.certificate, world.start, world.target
    assert isinstance(proof, Witness)

    def times(values):
        return np.round(np.asarray(values) * by, 12)

    return replace(
        world,
        cell_size=round(world.cell_size * by, 12),
        robot_radius=round(world.robot_radius * by, 12),
        start=Pose(float(times(start.x)), float(times(start.y)), start.heading),
        target=Target(*(float(times(value)) for value in (target.x, target.y, target.radius))),
        certificate=Witness(times(proof.times), times(proof.x), times(proof.y), proof.clearance * by),
    )
