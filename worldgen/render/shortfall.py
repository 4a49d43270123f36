"""How near a robot that repeats itself gets to its target, and what is straight between them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from worldgen.render.body_parts import solid_near
from worldgen.render.overlay import Trail
from worldgen.support.arrays import Bools, Floats
from worldgen.timeline import CellState
from worldgen.world import Witness, World

# Cells between two places on the straight line that are examined, and how deep the robot's disc
# must be in a cell to be stopped by it: it may slide along a wall that it touches.
_FINENESS = 1 / 16
_DEPTH = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Shortfall:
    """The place of a repeated path that is nearest to the target, and the straight way from there.

    Args:
        row: Index of the place in the trail.
        place: (2,) m.
        ahead: (2,) Direction of the target, a unit vector.
        end: (2,) m: where the robot's middle enters the target, or where a wall stops the robot.
        contact: (2,) m: where it touches that wall; ``None`` if nothing is in between.
    """

    row: int
    place: Floats
    ahead: Floats
    end: Floats
    contact: Floats | None

    @property
    def distance(self) -> float:
        """Length of the straight way, m."""
        return float(np.hypot(*(self.end - self.place)))


def shortfall_of(world: World, trail: Trail) -> Shortfall | None:
    """Return how near a single robot gets; ``None`` if it repeats nothing, or has other goals.

    Args:
        world: The world.
        trail: The robot's path in it.
    """
    robot = world.robots[0]
    if trail.repeats_from is None or trail.missed is not None or robot.waypoints or world.is_fleet:
        return None
    middle = np.array((robot.target.x, robot.target.y))
    away = np.hypot(*(trail.loop - middle).T)
    row = int(np.argmin(away))
    place = trail.loop[row]
    if float(away[row]) <= robot.target.radius:
        return None
    found = _straight(world, trail.repeats_from + row, place, middle)
    proof = world.certificate
    if found.contact is None or not isinstance(proof, Witness):
        return found
    # The middle of a target at a wall may be out of reach; the end of the witness is not.
    other = _straight(world, found.row, place, np.array((proof.x[-1], proof.y[-1])))
    return found if other.contact is not None else other


def _straight(world: World, row: int, place: Floats, aim: Floats) -> Shortfall:
    """Move the largest disc in the robot's body straight to a point of the target, up to a wall."""
    robot = world.robots[0]
    ahead = (aim - place) / float(np.hypot(*(aim - place)))
    middle = np.array((robot.target.x, robot.target.y))
    missing = _entry(place - middle, ahead, robot.target.radius)
    radius = (robot.radius if robot.is_disc else robot.inner_radius) / world.cell_size
    solid = _solid_at_last(world)
    for part in np.linspace(0.0, missing, 2 + math.ceil(missing / world.cell_size / _FINENESS)):
        middle = (place + part * ahead) / world.cell_size
        cells = solid_near(solid, np.array((middle - radius, middle + radius)))
        nearest = np.clip(middle, cells, cells + 1.0)
        depths = radius - np.hypot(*(nearest - middle).T)
        if len(depths) and depths.max() > _DEPTH:
            contact = nearest[int(np.argmax(depths))] * world.cell_size
            return Shortfall(row, place, ahead, place + part * ahead, contact)
    return Shortfall(row, place, ahead, place + missing * ahead, None)


def _entry(place: Floats, ahead: Floats, radius: float) -> float:
    """Return how far ahead a circle around the origin is entered, of a line that ends in it."""
    along = -float(place @ ahead)
    return along - math.sqrt(max(radius**2 - float(place @ place) + along**2, 0.0))


def _solid_at_last(world: World) -> Bools:
    """Return the cells that are solid after all changes."""
    solid = world.walls.copy()
    line = world.timeline
    # The last of a cell's events wins.
    solid[line.iy, line.ix] = line.states == CellState.SOLID
    return solid
