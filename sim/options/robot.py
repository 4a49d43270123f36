"""Options of the robot under the motion models on the pose lattice: its dynamics and its sensors.

All are off by default: the robot then turns and changes its speed at once, and senses without error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from sim.options.declared import Switches
from worldgen.errors import InvalidParameter

__all__ = ["MAX_BEAMS", "SIGNALS", "RobotOptions"]

MAX_BEAMS = 1000
SIGNALS = ("open", "weakened", "blocked")


@dataclass(frozen=True)
class RobotOptions(Switches):
    """How the robot moves and senses under ``swept`` and ``endpoint``; a failure stores what is not at its default.

    Args:
        turn_limit: Greatest rate of turning, rad/s; 0 means none.
        acceleration: Greatest gain of speed, m/s2; 0 means at once.
        friction: Greatest loss of speed, by brakes or on the floor, m/s2; 0 means at once.
        wall_friction: Share of a slide along a wall that friction takes, 0 to 1.
        slip: Largest share of a step's way that is lost on the floor, 0 to 1, another in each step.
        odometry_noise: Largest share by which a measured way or turn is wrong, 0 to 1, another in each step.
        sensor_cells: How many cells around its own the signal sensor looks at, 1 to 10; 1 sees eight.
        sensor_range: Distance from the target beyond which there is no signal, m; 0 means none.
        sensor_field: Angle that the signal sensor looks into, rad, about the heading; 0 means all round.
        sensor_noise: Largest share by which a strength is wrong, 0 to 1, another for each cell and step.
        signal: What walls do to the signal on its straight way from the target: nothing (``open``), halve it
            for each wall cell (``weakened``), or end it (``blocked``).
        smoke: Share of the signal that each cell of that way takes which lies in smoke, 0 to 1.
        smoke_reach: How many cells around each burning cell its smoke fills, 0 to 10, corners included.
        beams: Number of range beams, 0 to 1000.
        beam_range: Longest distance that a beam measures, m.
        beam_field: Angle between the first beam and the last, rad, about the heading; 0: evenly all round, the
            first ahead, the others counter-clockwise.
        beam_noise: Largest share by which a distance is wrong, 0 to 1, another for each beam and step.
        beam_dropout: Probability, 0 to 1, that a beam returns nothing.
        lattice: Poses are rounded after each step to 1/lattice of a cell, where the way there is clear; a power of 2
            from 2 to 1024, 0 means not.
        coin: How many values a random number of the controller has, 0, 1/coin and so on, equally likely; 0 means any
            number below 1. With few values, and a coarse lattice, all that can happen can be looked at.

    Raises:
        InvalidParameter: If a value is out of range.
    """

    turn_limit: float = 0.0
    acceleration: float = 0.0
    friction: float = 0.0
    wall_friction: float = 0.0
    slip: float = 0.0
    odometry_noise: float = 0.0
    sensor_cells: int = 1
    sensor_range: float = 0.0
    sensor_field: float = 0.0
    sensor_noise: float = 0.0
    signal: str = "open"
    smoke: float = 0.0
    smoke_reach: int = 2
    beams: int = 0
    beam_range: float = 5.0
    beam_field: float = 0.0
    beam_noise: float = 0.0
    beam_dropout: float = 0.0
    lattice: int = 0
    coin: int = 0

    RANGES: ClassVar[Mapping[str, tuple[float, float, str]]] = {
        "turn_limit": (0, 1e6, " rad/s"),
        "acceleration": (0, 1e6, " m/s2"),
        "friction": (0, 1e6, " m/s2"),
        "wall_friction": (0, 1, ""),
        "slip": (0, 1, ""),
        "odometry_noise": (0, 1, ""),
        "sensor_cells": (1, 10, " cells"),
        "sensor_range": (0, 1e6, " m"),
        "sensor_field": (0, 2 * math.pi, " rad"),
        "sensor_noise": (0, 1, ""),
        "smoke": (0, 1, ""),
        "smoke_reach": (0, 10, " cells"),
        "beams": (0, MAX_BEAMS, ""),
        "beam_range": (1e-6, 1e6, " m"),
        "beam_field": (0, 2 * math.pi, " rad"),
        "beam_noise": (0, 1, ""),
        "beam_dropout": (0, 1, ""),
        "lattice": (0, 1024, ""),
        "coin": (0, 65536, ""),
    }
    CHOICES: ClassVar[Mapping[str, tuple[str, ...]]] = {"signal": SIGNALS}
    GROUPS: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "Sensor": (
            "sensor_cells", "sensor_range", "sensor_field", "sensor_noise", "signal", "smoke", "smoke_reach",
        ),
        "Beams": ("beams", "beam_range", "beam_field", "beam_noise", "beam_dropout"),
        "Forces": ("turn_limit", "acceleration", "friction", "wall_friction", "slip", "odometry_noise"),
        "Lattice": ("lattice", "coin"),
    }  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lattice and (self.lattice == 1 or 1024 % self.lattice):
            raise InvalidParameter(
                "not-a-power-of-two",
                "lattice={lattice} does not divide 1024",
                "give a power of 2 from 2 to 1024",
                lattice=self.lattice,
            )

    @property
    def random(self) -> bool:
        """Whether the simulator itself draws random numbers, so that no state can come back."""
        shares = (self.slip, self.odometry_noise, self.sensor_noise, self.beam_noise, self.beam_dropout)
        return any(share > 0.0 for share in shares)

    @property
    def plain_sensor(self) -> bool:
        """Whether the signal sensor has no limits but the thesis's."""
        limits = (self.sensor_cells, self.sensor_range, self.sensor_field, self.sensor_noise, self.signal, self.smoke)
        return limits == (1, 0.0, 0.0, 0.0, "open", 0.0)
