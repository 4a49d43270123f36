"""Options of the thesis's simulator.

They cover the settings of the thesis's program, and work that its author left to be done. The
defaults reproduce the program as it was. ``docs/notes/thesis.md`` gives the origin of each
option.
"""

from __future__ import annotations

import math
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from sim.options.declared import OptionSet
from sim.options.robot import Signal
from worldgen.errors import InvalidParameter
from worldgen.parameters import Group
from worldgen.parameters.bounds import Bounds

Arbiter = Literal["A0", "A1", "A2", "A3", "A4", "A5", "A6", "interruptible"]
ARBITERS: tuple[Arbiter, ...] = typing.get_args(Arbiter)
REPAIRS = ("repair_slide", "repair_back_off", "repair_corner")


@dataclass(frozen=True)
class ThesisOptions(OptionSet):
    """Options of the motion model ``stepped`` and of the thesis's robot.

    A failure stores the options that differ from their defaults. Angles are in rad.

    Args:
        sensor_range: Reach of the signal sensor, px, 36 to 1000; 36 sees the eight cells around.
        noise: Whether the noise filter has changed the signal near walls.
        collide_ticks: Counter of the collide behaviour, 0 to 1000; it drives one tick more.
        drive_ticks: Counter of the drive behaviour, 0 to 1000; it drives one tick more.
        turn_angle: Angle by which the collide behaviour turns; the random rule draws its own.
        arbiter: Reading of the arbiter, which the thesis's listing lacks: ``A0`` to ``A6``; or
            ``interruptible``, which decides in every tick and lets a new collision restart the
            escape.
        repair_slide: Slide along a wall only if the disc is then clear of every wall.
        repair_back_off: Stay at a wall instead of backing off without looking.
        repair_corner: Stop where only the corner of a cell is touched.
        keep_going: Whether walls that the robot enters, or that land on it, neither end the run nor
            decide its verdict, as in the original program.
        acceleration: Greatest gain of speed, m/s2; 0 means instantly. Like all forces it acts on
            the speed, while moves are whole pixels, a tenth of a cell: a robot that moves at most
            one pixel per tick does not move at all.
        friction: Loss of speed once the wheels have stopped, m/s2; 0 means instantly.
        wall_friction: Fraction of a slide along a wall that is lost to friction, 0 to 1.
        slip: Largest fraction of a tick's move that is lost on the floor, 0 to 1, drawn again in
            each tick.
        sensor_field: Angle that the sensor covers, centred on the heading; 0 means all directions.
        sensor_noise: Largest fraction by which a reading is wrong, 0 to 1, drawn for each cell and
            tick.
        signal: What walls do to the signal on its straight path from the target: nothing, as in the
            thesis (``open``), halve it for each wall cell (``weakened``), or block it
            (``blocked``).
        map_scale: Side of a cell of the robot's own map, in cells of the world, 1 to 100.
        draws: Numbers in [0, 1) that the random rule uses before those of the seed.

    Raises:
        InvalidParameter: If a value is out of range.
    """

    sensor_range: Annotated[int, Bounds(36, 1000, "px"), Group("Sensor")] = 36
    noise: Annotated[bool, Group("Sensor")] = False
    collide_ticks: Annotated[int, Bounds(0, 1000, "ticks"), Group("Behaviours")] = 5
    drive_ticks: Annotated[int, Bounds(0, 1000, "ticks"), Group("Behaviours")] = 2
    turn_angle: Annotated[float, Bounds(0, math.pi, "rad"), Group("Behaviours")] = math.pi / 2
    arbiter: Annotated[Arbiter, Group("Behaviours")] = "A0"
    repair_slide: Annotated[bool, Group("Faults")] = False
    repair_back_off: Annotated[bool, Group("Faults")] = False
    repair_corner: Annotated[bool, Group("Faults")] = False
    keep_going: Annotated[bool, Group("Faults")] = False
    acceleration: Annotated[float, Bounds(0, 1e6, "m/s2"), Group("Forces")] = 0.0
    friction: Annotated[float, Bounds(0, 1e6, "m/s2"), Group("Forces")] = 0.0
    wall_friction: Annotated[float, Bounds(0, 1), Group("Forces")] = 0.0
    slip: Annotated[float, Bounds(0, 1), Group("Forces")] = 0.0
    sensor_field: Annotated[float, Bounds(0, 2 * math.pi, "rad"), Group("Sensor")] = 0.0
    sensor_noise: Annotated[float, Bounds(0, 1), Group("Sensor")] = 0.0
    signal: Annotated[Signal, Group("Sensor")] = "open"
    map_scale: Annotated[int, Bounds(1, 100, "cells"), Group("Sensor")] = 1
    draws: Annotated[tuple[float, ...], Group("Behaviours")] = ()

    OWNER: ClassVar[str] = "thesis"
    TOGETHER: ClassVar[Mapping[str, tuple[str, ...]]] = {"repaired": REPAIRS}

    def __post_init__(self) -> None:
        super().__post_init__()
        if not all(0.0 <= draw < 1.0 for draw in self.draws):
            raise InvalidParameter(
                "out-of-range",
                "draws contain a number outside [0, 1)",
                "use numbers from 0 up to, but not including, 1",
            )

    @property
    def repaired(self) -> bool:
        """True if all three faults of the motion are repaired, so that no wall is ever cut."""
        return self.repair_slide and self.repair_back_off and self.repair_corner

    @property
    def sensor_cells(self) -> int:
        """Reach of the sensor in cells, rounded as in the listing: 36 px gives 1, 50 px gives 2."""
        return int((self.sensor_range - 36) / 10) + 1

    @property
    def random(self) -> bool:
        """True if the simulator itself draws random numbers, so that no state can recur."""
        return self.slip > 0.0 or self.sensor_noise > 0.0
