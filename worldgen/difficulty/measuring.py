"""Measures a world."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from worldgen.difficulty.metrics import Metrics, rounded
from worldgen.difficulty.way import Way, distance, way_of
from worldgen.lattice import UNIT
from worldgen.reach import decide
from worldgen.world import Witness, World

__all__ = ["measure", "with_metrics"]


def measure(world: World) -> Metrics:
    """How hard a world is, by every metric that has a meaning for it.

    What goes by a way goes by the world's own witness; a world without a certificate is decided first. Equal worlds
    with equal witnesses have equal metrics, to the last digit, on every machine.

    Args:
        world: Any; in one that changes, walls are those of time 0.
    """
    certificate = world.certificate if world.certificate is not None else decide(world).certificate
    found: dict[str, float] = {"solid": world.solid_cells / world.walls.size}
    if world.is_dynamic:
        line = world.timeline
        found["changing"] = len(np.unique(line.iy * world.width + line.ix)) / world.walls.size
    if isinstance(certificate, Witness) and len(certificate.times):
        found |= _along(world, way_of(world, certificate))
    return Metrics(**{name: value if isinstance(value, int) else rounded(value) for name, value in found.items()})


def with_metrics(world: World) -> World:
    """The world with its metrics in its provenance; one without provenance has no place for them and stays as it is."""
    if world.provenance is None:
        return world
    return replace(world, provenance=replace(world.provenance, metrics=measure(world).as_dict()))


def _along(world: World, way: Way) -> dict[str, float]:
    """What goes by the witness."""
    length, turns = way.length * world.cell_size / UNIT, way.turning
    found = {"length": length, "turns": turns, "duration": way.duration}
    if world.is_dynamic:
        found["waiting"] = way.waiting
    straight = distance(world.start.x, world.start.y, world.target.x, world.target.y)
    if straight > 0.0:
        found |= {"detour": length / straight, "turning": turns / straight}
    chord = distance(*(float(value) for value in (way.x[0], way.y[0], way.x[-1], way.y[-1])))
    if chord > 0.0:
        found["tortuosity"] = way.length / chord
    return found
