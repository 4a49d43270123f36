"""Turn what a robot senses into an environment's observations, and actions into commands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim import Command, Observation
from sim._core import ffi, lib
from sim.kernels import layout
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Floats, Ints
from worldgen.support.ccall import pointer, writable

__all__ = ["CHOICES", "DEFAULT_BEAMS", "SENSORS", "Interface"]

Singles = npt.NDArray[np.float32]

DEFAULT_BEAMS = 16
# Radians per second.
MOST_TURN_RATE = 1e6


class Sensor(NamedTuple):
    """A sensor of the environment.

    Args:
        code: Its number in the core.
        low: Smallest value of each of its numbers.
        high: Greatest value of each of its numbers.
        senses: The fields of the simulator's observation that it reads.
    """

    code: int
    low: tuple[float, ...]
    high: tuple[float, ...]
    senses: tuple[str, ...]


def _direction(code: int, *senses: str) -> Sensor:
    return Sensor(code, (-1.0, -1.0), (1.0, 1.0), (*senses, "heading"))


SENSORS: Mapping[str, Sensor] = {
    "bump": Sensor(lib.WG_SHOW_BUMP, (0.0,), (1.0,), ("bump",)),
    "bump_direction": _direction(lib.WG_SHOW_BUMP_DIRECTION, "bump", "bump_bearing"),
    "signal": Sensor(lib.WG_SHOW_SIGNAL, (0.0,), (1.0,), ("signal",)),
    "signal_direction": _direction(lib.WG_SHOW_SIGNAL_DIRECTION, "signal_heading"),
    "target_direction": _direction(lib.WG_SHOW_TARGET_DIRECTION, "target_heading"),
    "goal_direction": _direction(lib.WG_SHOW_GOAL_DIRECTION, "goal_heading"),
    "tilt": _direction(lib.WG_SHOW_TILT, "tilt", "tilt_heading"),
    "target_distance": Sensor(lib.WG_SHOW_TARGET_DISTANCE, (0.0,), (1.0,), ("target_distance",)),
    "heading": _direction(lib.WG_SHOW_HEADING),
    "position": Sensor(lib.WG_SHOW_POSITION, (0.0, 0.0), (1.0, 1.0), ("x", "y")),
    "odometry": Sensor(
        lib.WG_SHOW_ODOMETRY,
        (-1.0,) * 4,
        (1.0,) * 4,
        ("odometry_x", "odometry_y", "odometry_heading"),
    ),
    "beams": Sensor(lib.WG_SHOW_BEAMS, (0.0,), (1.0,), ("beams",)),
}
"""All sensors by name; ``beams`` has as many numbers as the robot has beams."""

CHOICES = ((0.0, 1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0))
"""The discrete actions, as fractions of the turn rate and of the top speed.

In order: ahead, ahead to the left, ahead to the right, left on the spot, right on the spot.
"""


@dataclass(frozen=True)
class Interface:
    """Sensors and actions of an environment.

    A controller with the same interface observes exactly what was observed in training.

    Args:
        sensors: Names from :data:`SENSORS`, in the order of their numbers in an observation.
        actions: ``continuous``, or ``discrete`` for the five in :data:`CHOICES`.
        turn_rate: Largest turn rate of an action, rad/s.
        reverse: Whether continuous actions may drive backwards.
        extent: Length that distances and positions are given as fractions of, m; larger ones are
            limited to it.
        robot: The robot's dynamics and sensors. If ``beams`` is among the sensors, it has 16 beams
            unless this says otherwise.

    Raises:
        InvalidParameter: If a name is unknown or a value is out of range.
    """

    sensors: tuple[str, ...] = ("target_direction", "target_distance", "bump", "beams")
    actions: str = "continuous"
    turn_rate: float = 2.0 * math.pi
    reverse: bool = False
    extent: float = 10.0
    robot: RobotOptions | Mapping[str, Any] = field(default_factory=RobotOptions)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sensors", _names(self.sensors))
        if self.actions not in ("continuous", "discrete"):
            raise InvalidParameter(
                "unknown-name",
                "actions={actions!r} is neither 'continuous' nor 'discrete'",
                "use one of them",
                actions=self.actions,
            )
        if not isinstance(self.reverse, bool):
            raise InvalidParameter(
                "wrong-type",
                "reverse={reverse!r} is neither True nor False",
                "use one of them",
                reverse=self.reverse,
            )
        if self.reverse and self.actions == "discrete":
            raise InvalidParameter(
                "conflict",
                "reverse=True needs continuous actions",
                "remove it, or actions='discrete'",
            )
        for name, most, unit in (("turn_rate", MOST_TURN_RATE, "rad/s"), ("extent", 1e6, "m")):
            object.__setattr__(self, name, positive(name, getattr(self, name), most, unit))
        object.__setattr__(self, "robot", self._robot())

    def _robot(self) -> RobotOptions:
        robot = self.robot
        if not isinstance(robot, RobotOptions):
            if not isinstance(robot, Mapping):
                raise InvalidParameter(
                    "wrong-type",
                    "robot={given} is not a RobotOptions",
                    "use some, or a dict: {{'slip': 0.1}}",
                    given=repr(robot),
                )
            robot = RobotOptions.of(robot)
        if "beams" in self.sensors and robot.beams == 0:
            return RobotOptions.of({**robot.changed(), "beams": DEFAULT_BEAMS})
        return robot

    @property
    def needs(self) -> RobotOptions:
        """The robot's options, as a controller declares them."""
        return self._robot()

    @property
    def senses(self) -> tuple[str, ...]:
        """Names of the senses that it reads, as a controller declares them."""
        found = dict.fromkeys(sense for name in self.sensors for sense in SENSORS[name].senses)
        return tuple(found)

    @property
    def codes(self) -> Ints:
        """(k,) int64, the sensors' numbers in the core."""
        return np.array([SENSORS[name].code for name in self.sensors], np.int64)

    @property
    def choices(self) -> Floats:
        """(m, 2) float64, the discrete actions; empty for continuous ones."""
        return np.array(CHOICES if self.actions == "discrete" else (), np.float64).reshape(-1, 2)

    def rules(self) -> Any:
        """Return a WgRules with the fields that this interface decides; the others are zero."""
        rules = ffi.new("WgRules *")
        rules.extent = self.extent
        rules.beam_range = self.needs.beam_range
        rules.turn_rate = self.turn_rate
        rules.slowest = -1.0 if self.reverse else 0.0
        return rules

    def bounds(self) -> dict[str, tuple[Singles, Singles]]:
        """Return the least and greatest values of each sensor's numbers."""
        found = {}
        for name in self.sensors:
            low, high = (np.array(numbers, np.float32) for numbers in SENSORS[name][1:3])
            if name == "beams":
                low = low.repeat(self.needs.beams)
                high = high.repeat(self.needs.beams)
            elif name == "signal":
                # Noise can raise a reading above 1.
                high += np.float32(self.needs.sensor_noise)
            found[name] = (low, high)
        return found

    def observe(self, observation: Observation) -> Singles:
        """Return (size,) float32, the environment's observation, made from a controller's."""
        # Fill the core's struct, whose numbers have the order of the observation's fields.
        numbers = np.array(observation[: layout.OBS_SIZE], np.float64)
        beams = np.array(observation.beams, np.float64)
        seen = ffi.new("WgObservation *")
        ffi.memmove(seen, pointer(ffi, numbers, np.float64), numbers.nbytes)
        seen.beams = pointer(ffi, beams, np.float64)
        seen.beam_count = len(beams)
        seen.goal_heading = observation.goal_heading
        seen.tilt = observation.tilt
        seen.tilt_heading = observation.tilt_heading
        out = np.empty(sum(len(low) for low, _ in self.bounds().values()), np.float32)
        codes = self.codes
        sensors = pointer(ffi, codes, np.int64)
        lib.wg_show(seen, sensors, len(codes), self.rules(), writable(ffi, out, np.float32))
        return out

    def command(self, action: Any, observation: Observation) -> Command:
        """Return an action as a command, for a robot with the observation's top speed."""
        turn, speed = (
            CHOICES[int(action)]
            if self.actions == "discrete"
            else (float(action[0]), float(action[1]))
        )
        turn = min(max(turn, -1.0), 1.0)
        speed = min(max(speed, -1.0 if self.reverse else 0.0), 1.0)
        return Command(speed * observation.top_speed, turn * self.turn_rate)


def positive(name: str, value: object, most: float, unit: str) -> float:
    """Return a positive number as a float.

    Raises:
        InvalidParameter: If it is not a number, not above 0, or above ``most``.
    """
    if (
        not isinstance(value, int | float | np.number)
        or isinstance(value, bool)
        or not 0.0 < value <= most
    ):
        raise InvalidParameter(
            "out-of-range",
            "{name}={value!r} is not a number of {unit} above 0 and at most {most:g}",
            "use one",
            name=name,
            value=value,
            unit=unit,
            most=most,
        )
    return float(value)


def _names(sensors: object) -> tuple[str, ...]:
    if isinstance(sensors, str) or not isinstance(sensors, tuple | list):
        raise InvalidParameter(
            "wrong-type",
            "sensors={sensors!r} is not a list of names",
            "write one: ('target_direction', 'bump')",
            sensors=sensors,
        )
    names = tuple(sensors)
    unknown = [name for name in names if name not in SENSORS]
    if unknown:
        raise InvalidParameter(
            "unknown-name",
            "no sensor is called {name!r}",
            "there are {known!l}",
            name=unknown[0],
            known=list(SENSORS),
        )
    if not names or len(set(names)) != len(names):
        raise InvalidParameter(
            "twice", "sensors={sensors!r}: use at least one, and each only once", sensors=sensors
        )
    return names
