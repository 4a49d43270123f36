"""Measure a world."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from worldgen import reach
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.difficulty.metrics import METRICS, OF_DISCS, Metrics, rounded
from worldgen.difficulty.model import INPUTS, difficulty
from worldgen.difficulty.nodes import nodes_of
from worldgen.difficulty.path import WitnessPath, distance, witness_path_of
from worldgen.difficulty.pockets import pockets
from worldgen.lattice import UNIT
from worldgen.reach.still.disc import target_disc
from worldgen.timeline import CellState
from worldgen.world import Certificate, JointWitness, Witness, World

_BOTTLENECK = frozenset({"bottleneck", "bottleneck_radii"})
_POCKETS = frozenset({"concavity", "retreat"})


def measure(world: World, *, only: Collection[str] | None = None) -> Metrics:
    """Return how hard a world is, by every metric that is defined for it.

    Metrics along a path use the world's own witness; a world without a certificate is decided
    first. Equal worlds with equal witnesses have equal metrics, to the last digit, on every
    machine. In a world with several robots, the metrics are for the robot with the hardest task:
    each robot is measured alone, on its path in the joint witness.

    Args:
        world: Any world; in one that changes, the walls and obstacles of time 0 count.
        only: Names of the metrics to compute, which saves time; others may be missing from the
            result.
    """
    wanted = frozenset(METRICS if only is None else only)
    if "difficulty" in wanted:
        wanted |= frozenset(INPUTS)
    certificate = (
        world.certificate if world.certificate is not None else reach.decide(world).certificate
    )
    if world.is_fleet:
        return _hardest(world, certificate, only)
    # What a disc could do says little about a body or a car.
    robot = world.robots[0]
    if not robot.is_disc or robot.drive.is_car:
        wanted -= OF_DISCS
    solid = world.cells_at(0.0) != CellState.FREE
    found: dict[str, float] = {"solid": int(np.count_nonzero(solid)) / solid.size}
    if wanted & _BOTTLENECK:
        radius = bottleneck(world, solid)
        found |= {"bottleneck": radius, "bottleneck_radii": radius / world.robot_radius}
    if world.is_dynamic:
        changing = world.changing_cells
        found["changing"] = int(np.count_nonzero(changing)) / solid.size
    # Without a witness there is no path, and only the map itself can be measured.
    if isinstance(certificate, Witness) and len(certificate.times):
        way = witness_path_of(world, certificate)
        found |= _along(world, certificate, way)
        if not robot.is_disc:
            found["slack"] = certificate.clearance
        # Building the graph is the most expensive part, so skip it unless a metric needs it.
        if wanted & _POCKETS:
            depths = pockets(nodes_of(world, solid), way, target_disc(world))
            if depths is not None:
                found |= {
                    name: depth * world.cell_size / UNIT
                    for name, depth in zip(("concavity", "retreat"), depths, strict=True)
                }
        # The formula was fitted to static worlds and needs every one of its inputs.
        if "difficulty" in wanted and not world.is_dynamic and found.keys() >= set(INPUTS):
            found["difficulty"] = difficulty(found, world.robot_radius)
    return Metrics(
        **{
            name: value if isinstance(value, int) else rounded(value)
            for name, value in found.items()
        }
    )


def _hardest(
    world: World, certificate: Certificate | None, only: Collection[str] | None
) -> Metrics:
    """Return the metrics of the robot with the highest difficulty, or else the longest path."""
    paths = certificate.paths if isinstance(certificate, JointWitness) else ()
    measured: list[Metrics] = []
    for number in range(1, len(world.robots) + 1):
        alone = world.alone(number)
        if paths:
            alone = replace(alone, certificate=paths[number - 1])
        metrics = measure(alone, only=only)
        if paths and not world.is_dynamic:
            # Robots may wait for each other even if no cell changes.
            way = witness_path_of(alone, paths[number - 1])
            metrics = replace(metrics, waiting=rounded(way.waiting))
        measured.append(metrics)
    hardest = max(measured, key=lambda one: (one.difficulty or 0.0, one.length or 0.0))
    return replace(hardest, robots=len(world.robots))


def with_metrics(world: World) -> World:
    """Return the world with its metrics in its provenance.

    A world without provenance cannot store them and is returned unchanged.
    """
    if world.provenance is None:
        return world
    return replace(world, provenance=replace(world.provenance, metrics=measure(world).as_dict()))


def _along(world: World, certificate: Witness, way: WitnessPath) -> dict[str, float]:
    """Return the metrics along the witness."""
    length = way.length * world.cell_size / UNIT
    turns = way.turning
    found = {"length": length, "turns": turns, "duration": way.duration}
    if world.is_dynamic:
        found["waiting"] = way.waiting
        # This import loads shapely.
        margin = reach.witness_margin(world, certificate)
        if math.isfinite(margin):
            found["margin"] = margin
    # From goal to goal, if there are waypoints.
    places = world.robots[0].places
    straight = sum(distance(*one, *two) for one, two in itertools.pairwise(places))
    if straight > 0.0:
        found |= {"detour": length / straight, "turning": turns / straight}
    chord = distance(*(float(value) for value in (way.x[0], way.y[0], way.x[-1], way.y[-1])))
    if chord > 0.0:
        found["tortuosity"] = way.length / chord
    return found
