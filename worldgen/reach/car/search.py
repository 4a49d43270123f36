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
    lattice_to_metres,
    lattice_units,
    metres_to_lattice,
)
from worldgen.reach.body.core_calls import Body, BodyPose
from worldgen.reach.body.prove import goal_headings
from worldgen.reach.car.guide import guides
from worldgen.reach.car.stretches import leg_of
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.lattice_graph import clear_from
from worldgen.reach.still.path import make_witness, ticks_per_second, travel_ticks
from worldgen.reach.still.walls import ExactPoint, Walls, described_disc, described_walls
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, kept, pointer
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
        poses: (n, 3) int64, x and y in lu, heading in 1/65536 turn; empty if none was found. From
            pose to pose, the car turns by half of what its heading changes, rounded towards zero,
            drives straight, and turns by the rest.
        searched: Poses that the search expanded, and curves that were tried.
    """

    poses: Ints
    searched: int


def find_path(world: World, efforts: Sequence[Effort] = EFFORTS) -> CarPath:
    """Search for a path of the world's robot, which must be a car.

    First a quick search for one without many manoeuvres; then, if the car may reverse, along paths
    of the body alone; then finer searches.

    Args:
        world: The world; what changes in it later is ignored.
        efforts: How finely to search, each tried if the one before finds nothing.
    """
    walls = described_walls(world.walls)
    searched = 0
    for effort in efforts:
        query = _query(world, effort)
        if query is None:
            break
        check(lib.wg_car_search(walls, query))
        searched += query.expanded
        if query.count:
            return CarPath(_taken(query), searched)
        if effort == efforts[0] and query.reverse:
            for guide in guides(world):
                query.most = _MOST_CURVES
                check(lib.wg_car_follow(walls, query, pointer(ffi, guide, np.int64), len(guide)))
                searched += query.expanded
                if query.count:
                    return CarPath(_taken(query), searched)
    return CarPath(np.zeros((0, 3), np.int64), searched)


def _taken(query: Any) -> Ints:
    """Return the poses in an answer, and free them there."""
    poses = np.frombuffer(ffi.buffer(query.poses, 24 * query.count), np.int64).reshape(-1, 3).copy()
    lib.wg_car_free(query)
    return poses


def _query(world: World, effort: Effort) -> Any:
    """Return the question in the form that C reads; None if no heading is the target's."""
    robot = world.robots[0]
    size = world.cell_size
    headings = goal_headings(robot.target)
    if headings is None:
        return None
    query = ffi.new("WgCarQuery *")
    inner = in_cells(robot.radius, size)
    if robot.is_disc:
        query.disc = query.around = described_disc(inner)[0]
        query.start_x, query.start_y = (
            float(lattice_units(value, size)) for value in (robot.start.x, robot.start.y)
        )
    else:
        body = Body(world.walls, robot.footprint, size)
        query = kept(ffi, query, body)
        query.body = body.described
        outer = math.isqrt(body.outer_sq - 1) + 1
        query.around = (outer, body.outer_sq, float(body.outer_sq))
        inner = max(body.inner, 0 * inner) / UNIT
        query.disc = described_disc(inner)[0]
        query.start_x, query.start_y = (
            float(metres_to_lattice(value, size)) for value in (robot.start.x, robot.start.y)
        )
    query.turning_radius = float(in_cells(robot.drive.turning_radius, size) * UNIT)
    query.reverse = robot.drive.reverse
    query.start_heading = heading_to_lattice(robot.start.heading)
    query.target_x, query.target_y, query.target_radius = map(float, target_disc(world))
    query.from_heading, query.headings = headings
    query.clear_from = max(1, clear_from(inner, 4))
    query.bin = max(2.0, max(UNIT, float(inner) * UNIT) / effort.bins)
    query.heading_bins = effort.headings
    query.most = effort.most
    return query


def witness_of(world: World, poses: Ints) -> Witness | None:
    """Return the witness of a path; None if rounding its ends to the lattice made it one."""
    robot = world.robots[0]
    rows = [BodyPose(*row) for row in poses.tolist()]
    if not target_disc(world).holds((rows[-1].x, rows[-1].y)):
        return None
    witness = _disc_witness(world, rows) if robot.is_disc else _body_witness(world, rows)
    if witness is None:
        return None
    headings = np.array([heading_from_lattice(pose.heading) for pose in rows])
    return _with_steering(replace(witness, headings=headings), poses, robot.drive.steering_rate)


def _disc_witness(world: World, poses: list[BodyPose]) -> Witness | None:
    """Return the witness of a disc's path, without headings; it begins exactly at the start."""
    size = world.cell_size
    walls = Walls(world.walls, in_cells(world.robot_radius, size))
    points: list[ExactPoint] = [(pose.x, pose.y) for pose in poses]
    points[0] = (lattice_units(world.start.x, size), lattice_units(world.start.y, size))
    if not walls.is_clear(points[0], points[min(1, len(points) - 1)]):
        return None
    return make_witness(walls, points, size, world.robot_speed)


def _body_witness(world: World, poses: list[BodyPose]) -> Witness:
    """Return the witness of a footprint's path, without headings."""
    size = world.cell_size
    body = Body(world.walls, world.robots[0].footprint, size)
    ticks = ticks_per_second(size, world.robot_speed)
    times = [0]
    every = [poses[0]]
    for p, q in itertools.pairwise(poses):
        leg = travel_ticks((p.x, p.y), (q.x, q.y), size, world.robot_speed, ticks)
        times.append(times[-1] + leg)
        turn = leg_of(p, q).turn
        along = (p.heading + int(turn / 2)) % TURN
        every += [p._replace(heading=along), q._replace(heading=along), q]
    every = [pose for k, pose in enumerate(every) if k == 0 or pose != every[k - 1]]
    clearance = body.clearance(every) * size / UNIT * (1.0 - 1e-12)
    return Witness(
        np.array([time / ticks for time in times]),
        np.array([lattice_to_metres(pose.x, size) for pose in poses]),
        np.array([lattice_to_metres(pose.y, size) for pose in poses]),
        # Rounded down.
        max(0.0, math.nextafter(clearance, 0.0)),
    )


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
