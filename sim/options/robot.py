"""Options of the robot under the motion models on the pose lattice: its dynamics and its sensors.

All are off by default: the robot then turns and changes its speed instantly, and senses without
error.
"""

from __future__ import annotations

import math
import typing
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from sim.options.declared import OptionSet
from worldgen.errors import InvalidParameter
from worldgen.parameters import Group
from worldgen.parameters.bounds import Bounds

MAX_BEAMS = 1000
MAX_NEIGHBOURS = 64
MAX_MESSAGE = 8
MOST_PUSHES = 1000
_MOVES = "Disturbances"
Signal = Literal["open", "weakened", "blocked"]
SIGNALS: tuple[Signal, ...] = typing.get_args(Signal)
# Options that are lists: the number of values in each entry, and their meaning.
_LISTS = (
    ("pushes", 4, "time, dx, dy, turn"),
    ("push_places", 5, "x, y, dx, dy, turn"),
    ("decoys", 3, "x, y, strength"),
)


@dataclass(frozen=True)
class RobotOptions(OptionSet):
    """How the robot moves and senses under ``swept`` and ``endpoint``.

    A failure stores those that differ from their defaults. Angles are in rad.

    Args:
        turn_limit: Greatest turn rate; 0 means no limit.
        acceleration: Greatest gain of speed, m/s2; 0 means no limit.
        friction: Greatest loss of speed, by brakes or floor friction, m/s2; 0 means no limit.
        wall_friction: Share of a slide along a wall that is lost to friction, 0 to 1.
        slip: Largest share of a step's path that is lost to slip, 0 to 1, drawn for each step.
        odometry_noise: Largest share by which a measured distance or turn is wrong, 0 to 1, drawn
            for each step.
        sensor_cells: Reach of the signal sensor, cells around its own, 1 to 10; 1 sees eight cells.
        sensor_range: Distance from the target beyond which there is no signal, m; 0 means no limit.
        sensor_field: Field of view of the signal sensor, centred on the heading;
            0 means all around.
        sensor_noise: Largest share by which a signal strength is wrong, 0 to 1, drawn for each cell
            and step.
        signal: Effect of walls on the signal's straight line from the target: none (``open``),
            halve it for each wall cell (``weakened``), or block it (``blocked``).
        smoke: Share of the signal that each cell in smoke on that line absorbs, 0 to 1.
        smoke_reach: Number of cells that smoke fills around each burning cell, 0 to 10, corners
            included.
        beams: Number of range beams, 0 to 1000.
        beam_range: Longest distance that a beam measures, m.
        beam_field: Angle between the first and the last beam, centred on the heading; 0 spreads
            them evenly over a full turn, the first ahead, the others counter-clockwise.
        beam_noise: Largest share by which a distance is wrong, 0 to 1, drawn for each beam and
            step.
        beam_dropout: Probability, 0 to 1, that a beam returns nothing.
        drift: Speed at which a tilted floor carries the robot, m/s.
        drift_heading: Direction of the drift, counter-clockwise from the x axis.
        pushes: Pushes at given times, four numbers each: time (s), displacement along x and y (m),
            turn (rad, counter-clockwise). Each happens at the end of its step; walls stop it.
        push_places: Cells that push the robot, five numbers each: a point in the cell (m), then
            displacement and turn as for ``pushes``. A step that ends with the centre in the cell
            ends with that push.
        decoys: Additional sources of the signal, three numbers each: place (m), and strength as a
            multiple of the target's.
        neighbour_range: Distance between centres within which the robot senses other robots, m; 0
            means that it senses none.
        neighbours: How many other robots it senses at most, the nearest first, 1 to 64.
        message: How many numbers each robot may send to the robots that sense it, 0 to 8; they
            arrive in the next step.

    Raises:
        InvalidParameter: If a value is out of range.
    """

    turn_limit: Annotated[float, Bounds(0, 1e6, "rad/s"), Group("Forces")] = 0.0
    acceleration: Annotated[float, Bounds(0, 1e6, "m/s2"), Group("Forces")] = 0.0
    friction: Annotated[float, Bounds(0, 1e6, "m/s2"), Group("Forces")] = 0.0
    wall_friction: Annotated[float, Bounds(0, 1), Group("Forces")] = 0.0
    slip: Annotated[float, Bounds(0, 1), Group("Forces")] = 0.0
    odometry_noise: Annotated[float, Bounds(0, 1), Group("Forces")] = 0.0
    sensor_cells: Annotated[int, Bounds(1, 10, "cells"), Group("Sensor")] = 1
    sensor_range: Annotated[float, Bounds(0, 1e6, "m"), Group("Sensor")] = 0.0
    sensor_field: Annotated[float, Bounds(0, 2 * math.pi, "rad"), Group("Sensor")] = 0.0
    sensor_noise: Annotated[float, Bounds(0, 1), Group("Sensor")] = 0.0
    signal: Annotated[Signal, Group("Sensor")] = "open"
    smoke: Annotated[float, Bounds(0, 1), Group("Sensor")] = 0.0
    smoke_reach: Annotated[int, Bounds(0, 10, "cells"), Group("Sensor")] = 2
    beams: Annotated[int, Bounds(0, MAX_BEAMS), Group("Beams")] = 0
    beam_range: Annotated[float, Bounds(1e-6, 1e6, "m"), Group("Beams")] = 5.0
    beam_field: Annotated[float, Bounds(0, 2 * math.pi, "rad"), Group("Beams")] = 0.0
    beam_noise: Annotated[float, Bounds(0, 1), Group("Beams")] = 0.0
    beam_dropout: Annotated[float, Bounds(0, 1), Group("Beams")] = 0.0
    drift: Annotated[float, Bounds(0, 1e6, "m/s"), Group(_MOVES)] = 0.0
    drift_heading: Annotated[float, Bounds(-2 * math.pi, 2 * math.pi, "rad"), Group(_MOVES)] = 0.0
    pushes: Annotated[tuple[float, ...], Group(_MOVES)] = ()
    push_places: Annotated[tuple[float, ...], Group(_MOVES)] = ()
    decoys: Annotated[tuple[float, ...], Group("Sensor")] = ()
    neighbour_range: Annotated[float, Bounds(0, 1e6, "m"), Group("Neighbours")] = 0.0
    neighbours: Annotated[int, Bounds(1, MAX_NEIGHBOURS), Group("Neighbours")] = 8
    message: Annotated[int, Bounds(0, MAX_MESSAGE), Group("Neighbours")] = 0

    OWNER: ClassVar[str] = "robot"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, size, each in _LISTS:
            self._check_list(name, size, each)
        if any(time < 0.0 for time in self.pushes[::4]):
            raise InvalidParameter(
                "below-minimum",
                "{name}: time {value:g} s is below {low:g} s",
                "use the time after the start",
                name="pushes",
                value=min(self.pushes[::4]),
                low=0,
            )
        if any(strength < 0.0 for strength in self.decoys[2::3]):
            raise InvalidParameter(
                "below-minimum",
                "{name}: strength {value:g} is below {low:g}",
                "express its strength as a multiple of the target's signal",
                name="decoys",
                value=min(self.decoys[2::3]),
                low=0,
            )

    def _check_list(self, name: str, size: int, each: str) -> None:
        numbers = getattr(self, name)
        if len(numbers) % size:
            raise InvalidParameter(
                "wrong-length",
                "{name} has {count} numbers, but each entry needs {size}: {each}",
                "write {name}={example}",
                name=name,
                count=len(numbers),
                size=size,
                each=each,
                example=":".join(["1"] * size),
            )
        if len(numbers) > MOST_PUSHES * size:
            raise InvalidParameter(
                "too-many",
                "{name} has {count} entries, and at most {most} are allowed",
                "leave some out",
                name=name,
                count=len(numbers) // size,
                most=MOST_PUSHES,
            )

    @property
    def moved(self) -> bool:
        """True if something moves the robot in addition to its wheels."""
        return self.drift > 0.0 or bool(self.pushes) or bool(self.push_places)

    @property
    def plain_sensor(self) -> bool:
        """True if the signal sensor has no limits beyond the thesis's."""
        sensor = ("sensor_cells", "sensor_range", "sensor_field", "sensor_noise")
        names = (*sensor, "signal", "smoke", "decoys")
        return all(getattr(self, name) == getattr(RobotOptions, name) for name in names)
