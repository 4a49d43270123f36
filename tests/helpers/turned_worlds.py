"""A world turned by quarters and mirrored, witness and all."""

from dataclasses import replace

import numpy as np

from fuzz.oracles import worlds
from worldgen.world import Pose, Target, Witness, World

__all__ = ["mirrored", "scaled", "turned"]


def mirrored(world: World) -> World:
    """Left and right swapped."""
    wide, proof = world.width * world.cell_size, world.certificate
    assert isinstance(proof, Witness)
    witness = replace(proof, x=np.array([_across(wide, x) for x in proof.x]))
    return replace(worlds.mirrored(world), certificate=witness)


def turned(world: World) -> World:
    """Turned by a quarter, counter-clockwise."""
    high, proof = world.height * world.cell_size, world.certificate
    assert isinstance(proof, Witness)
    witness = replace(proof, x=np.array([_across(high, y) for y in proof.y]), y=proof.x)
    return replace(worlds.turned(world), certificate=witness)


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
        certificate=Witness(
            times(proof.times), times(proof.x), times(proof.y), proof.clearance * by
        ),
    )
