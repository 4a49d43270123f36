"""Turn cells and marks into a world, and prove that it can be solved."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from worldgen.compose.marks import START, TARGET, Mark, Marks, pose_of, target_of
from worldgen.errors import GenerationFailed, InvalidWorld
from worldgen.interop.place import place
from worldgen.lattice import in_cells
from worldgen.reach import REACHABLE, decide
from worldgen.support.arrays import Bools
from worldgen.timeline import Timeline
from worldgen.world import Pose, Robot, Target, Witness, World

USUAL_ROBOT = Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 1.0))
"""A disc that turns on the spot and has to touch its target."""


def kind_of(robot: Robot) -> Robot | None:
    """Return a robot without what a piece's marks and numbers say; ``None`` for the usual one."""
    place = USUAL_ROBOT.target
    goal = replace(robot.target, x=place.x, y=place.y, radius=place.radius, heading=None)
    kind = replace(
        robot,
        start=USUAL_ROBOT.start,
        target=goal,
        radius=USUAL_ROBOT.radius,
        speed=USUAL_ROBOT.speed,
    )
    return None if kind == USUAL_ROBOT else kind


def usual(value: float | None, otherwise: float) -> float:
    """Return the value, or the default if it is ``None``."""
    return otherwise if value is None else value


def world_of(
    walls: Bools, marks: Marks, timeline: Timeline, robot: Robot, cell_size: float, seed: int
) -> World:
    """Build a world without proving it.

    A start or a target that is not marked is placed far from the other one.

    Args:
        walls: (height, width) bool, True is solid.
        marks: Named places; only ``start`` and ``target`` are used.
        timeline: Changes of cells.
        robot: The robot; the marks replace its start, and its target's place.
        cell_size: Side of a cell, m.
        seed: Seed of the search for places that are far apart.

    Raises:
        InvalidWorld: If there is no room for the robot.
    """
    ends = [marks.get(name) for name in (START, TARGET)]
    if None in ends:
        points = [None if mark is None else _metres(mark, cell_size) for mark in ends]
        placed = place(walls, cell_size, robot.radius, seed, start=points[0], target=points[1])
        found = [_mark(placed.start, cell_size), _mark(placed.target, cell_size)]
        ends = [mark or other for mark, other in zip(ends, found, strict=True)]
    start, target = (mark or Mark(Fraction(0), Fraction(0)) for mark in ends)
    placed_robot = replace(
        robot,
        start=pose_of(start, target, cell_size),
        target=target_of(target, cell_size, robot.target),
    )
    return World(walls, cell_size=cell_size, timeline=timeline, robots=[placed_robot])


def _metres(mark: Mark, cell_size: float) -> tuple[float, float]:
    pose = pose_of(mark, mark, cell_size)
    return pose.x, pose.y


def _mark(point: tuple[float, float], cell_size: float) -> Mark:
    return Mark(in_cells(point[0], cell_size), in_cells(point[1], cell_size))


def witness_path_of(world: World) -> Witness:
    """Find a path from start to target through a world as it is at time 0.

    Raises:
        InvalidWorld: If there is no path.
    """
    decision = decide(replace(world, timeline=Timeline()))
    if not isinstance(decision.certificate, Witness):
        raise InvalidWorld(
            "not-reachable",
            "at='way', but the host has no path from start to target: {reason}",
            "put the piece elsewhere",
            reason=decision.reason,
        )
    return decision.certificate


def proved(world: World, margin: float = 0.0) -> World:
    """Return the world with a witness that the robot may start up to ``margin`` seconds late.

    Raises:
        GenerationFailed: If there is no witness; the error carries the reason.
    """
    decision = decide(world, margin=margin)
    if decision.result != REACHABLE:
        raise GenerationFailed(
            "not-reachable",
            "the composed world is {result}: {reason}",
            "move a piece, start or target, or make the robot smaller",
            result=decision.result,
            reason=decision.reason,
        )
    return replace(world, certificate=decision.certificate)
