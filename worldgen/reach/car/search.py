"""Search for a path that a car can drive, with its proof."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import (
    TURN,
    UNIT,
    heading_from_lattice,
    heading_to_lattice,
    in_cells,
    lattice_units,
)
from worldgen.reach.car.guide import guides
from worldgen.reach.car.stretches import leg_of
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.lattice_graph import clear_from
from worldgen.reach.still.path import make_witness, ticks_per_second
from worldgen.reach.still.walls import ExactPoint, Walls, described_disc
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, pointer
from worldgen.world import Witness, World


class Effort(NamedTuple):
    """How finely to search.

    Args:
        bins: Bins of places per cell, along each axis, or per radius of the body if that is larger.
        headings: Bins of headings.
        most: Limit on the poses searched.
    """

    bins: float
    headings: int
    most: int


# Each is tried if the one before finds nothing.
EFFORTS = (Effort(1, 48, 2_000), Effort(2, 72, 20_000), Effort(4, 144, 100_000))
# Limit on the curves that are tried along one path.
_MOST_CURVES = 50_000


class CarPath(NamedTuple):
    """Poses along a car's path.

    Args:
        poses: (n, 3) int64, x and y in lu, heading in 1/65536 turn; empty if none was found.
        searched: Poses that the search expanded, and curves that were tried.
    """

    poses: Ints
    searched: int


def find_path(world: World, efforts: Sequence[Effort] = EFFORTS) -> CarPath:
    """Search for a path of the world's robot, which must be a car with a disc as its body.

    First a quick search for one without many manoeuvres; then, if the car may reverse, along paths
    of the body alone; then finer searches.

    Args:
        world: The world; what changes in it later is ignored.
        efforts: How finely to search, each tried if the one before finds nothing.
    """
    walls = Walls(world.walls, in_cells(world.robot_radius, world.cell_size))
    searched = 0
    for effort in efforts:
        query = _query(world, walls, effort)
        check(lib.wg_car_search(walls.described, query))
        searched += query.expanded
        if query.count:
            return CarPath(_taken(query), searched)
        if effort == EFFORTS[0] and query.reverse:
            for guide in guides(world):
                query.most = _MOST_CURVES
                poses = pointer(ffi, guide, np.int64)
                check(lib.wg_car_follow(walls.described, query, poses, len(guide)))
                searched += query.expanded
                if query.count:
                    return CarPath(_taken(query), searched)
    return CarPath(np.zeros((0, 3), np.int64), searched)


def _taken(query: Any) -> Ints:
    """Return the poses in an answer, and free them there."""
    poses = np.frombuffer(ffi.buffer(query.poses, 24 * query.count), np.int64).reshape(-1, 3).copy()
    lib.wg_car_free(query)
    return poses


def _query(world: World, walls: Walls, effort: Effort) -> Any:
    """Return the question in the form that C reads."""
    robot = world.robots[0]
    size = world.cell_size
    target = robot.target
    query = ffi.new("WgCarQuery *")
    query.disc = described_disc(walls.radius)[0]
    query.turning_radius = float(in_cells(robot.drive.turning_radius, size) * UNIT)
    query.reverse = robot.drive.reverse
    query.start_x, query.start_y = (
        float(lattice_units(value, size)) for value in (robot.start.x, robot.start.y)
    )
    query.start_heading = heading_to_lattice(robot.start.heading)
    disc = target_disc(world)
    query.target_x, query.target_y, query.target_radius = map(float, disc)
    if target.heading is not None:
        query.has_heading = 1
        query.target_heading = heading_to_lattice(target.heading)
        # Rounded down, and less by the rounding of the heading itself.
        query.tolerance = max(0, math.floor(target.heading_tolerance * TURN / math.tau) - 1)
    query.clear_from = max(1, clear_from(walls.radius, 4))
    query.bin = max(2.0, max(UNIT, float(walls.radius) * UNIT) / effort.bins)
    query.headings = effort.headings
    query.most = effort.most
    return query


def witness_of(world: World, poses: Ints) -> Witness | None:
    """Return the witness of a path; None if rounding its start to the lattice made it clear."""
    robot = world.robots[0]
    size = world.cell_size
    walls = Walls(world.walls, in_cells(robot.radius, size))
    points: list[ExactPoint] = [(x, y) for x, y, _ in poses.tolist()]
    points[0] = (lattice_units(robot.start.x, size), lattice_units(robot.start.y, size))
    if not walls.is_clear(points[0], points[min(1, len(points) - 1)]):
        return None
    if not target_disc(world).holds(points[-1]):
        return None
    witness = make_witness(walls, points, size, robot.speed)
    headings = np.array([heading_from_lattice(units) for units in poses[:, 2].tolist()])
    return _with_steering(replace(witness, headings=headings), poses, robot.drive.steering_rate)


def _with_steering(witness: Witness, poses: Ints, rate: float) -> Witness:
    """Return a witness that waits wherever the steering changes, if that takes time."""
    if not rate:
        return witness
    ticks = ticks_per_second(1.0, 1.0)
    rows: list[tuple[float, int]] = [(0.0, 0)]
    late = 0.0
    before = 0
    for index, steer in enumerate(_steering(poses)):
        if steer != before:
            late += math.ceil(abs(steer - before) / rate * ticks) / ticks
            rows.append((witness.times[index] + late, index))
        rows.append((witness.times[index + 1] + late, index + 1))
        before = steer
    times, kept = (np.array(values) for values in zip(*rows, strict=True))
    headings = None if witness.headings is None else witness.headings[kept]
    return Witness(times, witness.x[kept], witness.y[kept], witness.clearance, headings)


def _steering(poses: Ints) -> Iterator[int]:
    """Yield the steering of each leg: 1 left, 0 straight, -1 right."""
    for before, after in itertools.pairwise(poses.tolist()):
        leg = leg_of(before, after)
        yield leg.gear * ((leg.turn > 0) - (leg.turn < 0))
