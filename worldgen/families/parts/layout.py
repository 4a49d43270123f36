"""Steps that every family shares: check the arena, fit passages, distribute spare cells."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Annotated, TypeAlias

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.family import Bounds
from worldgen.lattice import TURN, UNIT, exact, heading_from_lattice, in_cells, lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools
from worldgen.support.frozen import freeze
from worldgen.timeline import Timeline
from worldgen.world import Pose, Target, World

# Limits on the cells per side.
MIN_SIZE = 10
MAX_SIZE = 2000
# Files write ``None`` as this number; it makes the family choose a value.
CHOSEN = -1
# (dx, dy) of a heading in quarter turns.
STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))

SIZE = Bounds(MIN_SIZE, MAX_SIZE, "cells")
_CELL_SIZE = Bounds(0.001, 1000.0, "m")
_RADIUS = Bounds(0.0, unit="m", above=True)
_SPEED = Bounds(0.001, 1000.0, "m/s")

Size: TypeAlias = Annotated[int, SIZE]
CellSize: TypeAlias = Annotated[float, _CELL_SIZE]
RobotRadius: TypeAlias = Annotated[float, _RADIUS]
RobotSpeed: TypeAlias = Annotated[float, _SPEED]
Share: TypeAlias = Annotated[float, Bounds(0.0, 1.0)]
Width: TypeAlias = Annotated[int, Bounds(1, unit="cells", chosen=CHOSEN)]
Wall: TypeAlias = Annotated[int, Bounds(1, unit="cells")]
Margin: TypeAlias = Annotated[float, Bounds(0.0, 3600.0, "s")]

_HALF = UNIT // 2


@dataclass(frozen=True)
class Arena:
    """Hold a checked square of cells inside a solid ring, and the robot that must cross it.

    Args:
        size: Cells per side, including the ring of one cell.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.
        most: Limit on the cells per side.

    Raises:
        InvalidParameter: If a number is out of range, or the robot does not fit between the walls.
    """

    size: int
    cell_size: float
    robot_radius: float
    robot_speed: float
    most: int = MAX_SIZE

    def __post_init__(self) -> None:
        replace(SIZE, high=self.most).check("size", self.size)
        _CELL_SIZE.check("cell_size", self.cell_size)
        _RADIUS.check("robot_radius", self.robot_radius)
        _SPEED.check("robot_speed", self.robot_speed)
        room = exact(self.cell_size) * self.inside / 2
        if exact(self.robot_radius) > room:
            raise InvalidParameter(
                "no-room",
                "robot_radius={robot_radius:g} m does not fit between the walls of "
                "size={size} cells of {cell_size:g} m",
                "use at most {most:g} m, or a larger size",
                robot_radius=self.robot_radius,
                size=self.size,
                cell_size=self.cell_size,
                most=float(room),
            )

    @property
    def inside(self) -> int:
        """Return the cells per side inside the ring."""
        return self.size - 2

    @property
    def radius(self) -> Fraction:
        """Return the robot's exact radius in cells."""
        return in_cells(self.robot_radius, self.cell_size)

    @property
    def narrowest(self) -> int:
        """Return the width, in cells, of the narrowest passage that the robot fits through."""
        return max(1, math.ceil(2 * self.radius))

    def passage(self, name: str, width: int) -> int:
        """Check a passage's width, and return it in cells; -1 means the narrowest.

        Args:
            name: Name of the parameter, for the error message.
            width: The requested width, cells, or ``CHOSEN``.

        Raises:
            InvalidParameter: If the robot does not fit through.
        """
        if width == CHOSEN:
            return self.narrowest
        if width < self.narrowest:
            raise InvalidParameter(
                "narrower-than-robot",
                "{name}={width} is narrower than the robot, {robot_width:g} cells wide",
                "use at least {narrowest}, or omit it for the narrowest",
                name=name,
                width=width,
                robot_width=float(2 * self.radius),
                narrowest=self.narrowest,
            )
        return width

    def solid(self) -> Bools:
        """Return a (size, size) bool array that is all solid."""
        return np.ones((self.size, self.size), dtype=np.bool_)

    def spot(self, rng: RandomStream, low: int, high: int) -> int:
        """Draw a coordinate, in half cells, at which the robot is clear of the walls around it.

        There is one whenever ``high - low`` is at least :attr:`narrowest`.

        Args:
            rng: The only source of randomness.
            low: First free cell.
            high: First cell of the wall beyond.
        """
        return rng.between(math.ceil(2 * (low + self.radius)), math.floor(2 * (high - self.radius)))

    def metres(self, halves: int) -> float:
        """Convert half cells to metres, as the float with the shortest decimal."""
        return lattice_to_metres(halves * _HALF, self.cell_size)

    def world(
        self,
        walls: Bools,
        start: tuple[int, int],
        target: tuple[int, int],
        quarter: int,
        timeline: Timeline | None = None,
    ) -> World:
        """Build the world, without a proof.

        Args:
            walls: (size, size) bool. The world takes over the array and makes it read-only.
            start: Start in half cells.
            target: Target in half cells.
            quarter: Heading in quarter turns.
            timeline: Changes of cells, if any.
        """
        heading = heading_from_lattice(quarter * TURN // 4)
        return World(
            walls=freeze(walls),
            start=Pose(self.metres(start[0]), self.metres(start[1]), heading),
            target=Target(self.metres(target[0]), self.metres(target[1]), self.metres(1)),
            cell_size=self.cell_size,
            robot_radius=self.robot_radius,
            robot_speed=self.robot_speed,
            timeline=timeline or Timeline(),
        )


def without_effect(name: str, value: int, setting: str) -> int:
    """Return 0 for a parameter that another setting disables.

    Args:
        name: Name of the parameter.
        value: Its value; ``CHOSEN`` unless the user gave one.
        setting: The setting that disables it, as ``name=value``.

    Raises:
        InvalidParameter: If the user gave a value, which would be ignored silently.
    """
    if value != CHOSEN:
        raise InvalidParameter(
            "no-effect",
            "{name}={value} has no effect with {setting}",
            "omit it, or change {setting}",
            name=name,
            value=value,
            setting=setting,
        )
    return 0


def spread_evenly(rng: RandomStream, spare: int, slots: int) -> list[int]:
    """Distribute spare cells over slots as evenly as possible, and the remainder at random."""
    each, rest = divmod(spare, slots)
    shares = [each + 1] * rest + [each] * (slots - rest)
    rng.shuffle(shares)
    return shares


def spread_unevenly(rng: RandomStream, spare: int, slots: int) -> list[int]:
    """Distribute spare cells over slots by random cuts; some slots get many, others none."""
    cuts = [0, *sorted(rng.between(0, spare) for _ in range(slots - 1)), spare]
    return [high - low for low, high in pairwise(cuts)]
