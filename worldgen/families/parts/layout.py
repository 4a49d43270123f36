"""Steps that every family shares: the checked arena, passages that fit the robot, spreading spare cells."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter
from worldgen.family import Bounds
from worldgen.lattice import TURN, UNIT, exact, heading_from_lattice, in_cells, lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.support.frozen import freeze
from worldgen.timeline import Timeline
from worldgen.world import Pose, Target, World

__all__ = [
    "CHOSEN",
    "MAX_SIZE",
    "MIN_SIZE",
    "SIZE",
    "STEPS",
    "Arena",
    "CellSize",
    "Margin",
    "RobotRadius",
    "RobotSpeed",
    "Share",
    "Size",
    "Wall",
    "Width",
    "spread_evenly",
    "spread_unevenly",
    "without_effect",
]

# cells a side
MIN_SIZE = 10
MAX_SIZE = 2000
CHOSEN = -1  # how files write ``None``, which has the family choose
STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))  # (dx, dy) of a heading in quarter turns

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
    """A square of cells inside a solid ring, and the robot that must get through it.

    Args:
        size: Cells a side, the ring of one cell included.
        cell_size: m.
        robot_radius: m.
        robot_speed: m/s.
        most: Cells a side at most.

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
                "give at most {most:g} m, or a larger size",
                robot_radius=self.robot_radius,
                size=self.size,
                cell_size=self.cell_size,
                most=float(room),
            )

    @property
    def inside(self) -> int:
        """Cells a side within the ring."""
        return self.size - 2

    @property
    def radius(self) -> Fraction:
        """The robot's radius in cells, exactly."""
        return in_cells(self.robot_radius, self.cell_size)

    @property
    def narrowest(self) -> int:
        """Width, in cells, of the narrowest passage that lets the robot through."""
        return max(1, math.ceil(2 * self.radius))

    def passage(self, name: str, width: int) -> int:
        """A passage's width in cells; -1 stands for the narrowest.

        Raises:
            InvalidParameter: If the robot does not fit through.
        """
        if width == CHOSEN:
            return self.narrowest
        if width < self.narrowest:
            raise InvalidParameter(
                "narrower-than-robot",
                "{name}={width} is narrower than the robot, {robot_width:g} cells wide",
                "give at least {narrowest}, or leave it out for the narrowest",
                name=name,
                width=width,
                robot_width=float(2 * self.radius),
                narrowest=self.narrowest,
            )
        return width

    def solid(self) -> npt.NDArray[np.bool_]:
        """(size, size) bool, all solid."""
        return np.ones((self.size, self.size), dtype=np.bool_)

    def spot(self, rng: RandomStream, low: int, high: int) -> int:
        """A coordinate, in half cells, at which the robot is clear of walls below ``low`` and from ``high`` on.

        There is one whenever ``high - low`` is at least :attr:`narrowest`.
        """
        return rng.between(math.ceil(2 * (low + self.radius)), math.floor(2 * (high - self.radius)))

    def metres(self, halves: int) -> float:
        """Half cells to m, with the shortest decimal."""
        return lattice_to_metres(halves * _HALF, self.cell_size)

    def world(
        self,
        walls: npt.NDArray[np.bool_],
        start: tuple[int, int],
        target: tuple[int, int],
        quarter: int,
        timeline: Timeline | None = None,
    ) -> World:
        """The world, without proof: start and target in half cells, the heading in quarter turns.

        The walls are handed over: nobody may write to them any more.
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
    """0, for a number that a setting makes void.

    Raises:
        InvalidParameter: If it was given all the same.
    """
    if value != CHOSEN:
        raise InvalidParameter(
            "no-effect",
            "{name}={value} has no effect with {setting}",
            "leave it out, or change {setting}",
            name=name,
            value=value,
            setting=setting,
        )
    return 0


def spread_evenly(rng: RandomStream, spare: int, slots: int) -> list[int]:
    """Spare cells over slots, no slot more than one ahead of another, which ones by chance."""
    each, rest = divmod(spare, slots)
    shares = [each + 1] * rest + [each] * (slots - rest)
    rng.shuffle(shares)
    return shares


def spread_unevenly(rng: RandomStream, spare: int, slots: int) -> list[int]:
    """Spare cells over slots as random cuts of a line fall: some slots get much, some nothing."""
    cuts = [0, *sorted(rng.between(0, spare) for _ in range(slots - 1)), spare]
    return [high - low for low, high in pairwise(cuts)]
