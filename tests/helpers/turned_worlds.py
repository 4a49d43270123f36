"""Rotate a world by quarter turns or mirror it, with its witness."""

from dataclasses import replace

import numpy as np

from fuzz.oracles import worlds
from worldgen.world import JointWitness, Pose, Robot, Target, Witness, World


def mirrored(world: World) -> World:
    """Left and right swapped."""
    wide = world.width * world.cell_size

    def mirror(path: Witness) -> Witness:
        return replace(path, x=np.array([_across(wide, x) for x in path.x]))

    return replace(worlds.mirrored(world), certificate=_each(world, mirror))


def turned(world: World) -> World:
    """Rotated by a quarter turn, counter-clockwise."""
    high = world.height * world.cell_size

    def turn(path: Witness) -> Witness:
        return replace(path, x=np.array([_across(high, y) for y in path.y]), y=path.x)

    return replace(worlds.turned(world), certificate=_each(world, turn))


def _each(world, change):
    """The certificate with every path changed."""
    proof = world.certificate
    if isinstance(proof, JointWitness):
        return JointWitness(tuple(map(change, proof.paths)))
    assert isinstance(proof, Witness)
    return change(proof)


def _across(side: float, value: float) -> float:
    return round(side - value, 12)


def scaled(world: World, by: float) -> World:
    """Multiply every length by a number; times too, at the same speed."""

    def times(values):
        return np.round(np.asarray(values) * by, 12)

    def scale(path: Witness) -> Witness:
        return Witness(times(path.times), times(path.x), times(path.y), path.clearance * by)

    def larger(robot: Robot) -> Robot:
        start, target = robot.start, robot.target
        return Robot(
            Pose(float(times(start.x)), float(times(start.y)), start.heading),
            Target(*(float(times(value)) for value in (target.x, target.y, target.radius))),
            round(robot.radius * by, 12),
            robot.speed,
        )

    return replace(
        world,
        cell_size=round(world.cell_size * by, 12),
        robots=tuple(map(larger, world.robots)),
        certificate=_each(world, scale),
    )
