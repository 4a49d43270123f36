"""The controller contract: a compiled function on arrays, or a class.

Programs: :mod:`sim.controllers.programs`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from sim._core import lib
from sim.controllers.core_act import CoreAct
from sim.controllers.memory_view import MemoryField, MemoryMap, check_fields
from sim.kernels import layout
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter

__all__ = [
    "Act",
    "Command",
    "Commands",
    "CompiledController",
    "Controller",
    "Memory",
    "Observation",
    "Observations",
    "PythonController",
    "VectorController",
    "bits_of",
    "check_declared",
    "robot_for",
    "senses_of",
    "wants_world",
]

Floats: TypeAlias = npt.NDArray[np.float64]
Act: TypeAlias = Callable[[Floats, Floats, Floats], None]
Memory: TypeAlias = tuple[float, ...]

_PLAIN = RobotOptions()


class Observation(NamedTuple):
    """What a controller sees after each step; units and frames as in ``worldgen_controller.h``."""

    bump: bool
    bump_bearing: float
    signal: float
    signal_heading: float
    heading: float
    x: float
    y: float
    target_heading: float
    target_distance: float
    random: float
    time_step: float
    top_speed: float
    radius: float
    time: float
    odometry_x: float
    odometry_y: float
    odometry_heading: float
    beams: tuple[float, ...]

    @classmethod
    def of(cls, array: Floats) -> Observation:
        """Read the flat array that the core fills."""
        values: list[Any] = array.tolist()
        values[layout.OBS_SIZE :] = (tuple(values[layout.OBS_SIZE :]),)
        values[layout.OBS_BUMP] = values[layout.OBS_BUMP] != 0.0
        return tuple.__new__(
            cls, values
        )  # as _make does, in half the time: this runs in every step


class Observations(NamedTuple):
    """What many robots see: an :class:`Observation` whose numbers are arrays of shape (n,)."""

    bump: npt.NDArray[np.bool_]
    bump_bearing: Floats
    signal: Floats
    signal_heading: Floats
    heading: Floats
    x: Floats
    y: Floats
    target_heading: Floats
    target_distance: Floats
    random: Floats
    time_step: Floats
    top_speed: Floats
    radius: Floats
    time: Floats
    odometry_x: Floats
    odometry_y: Floats
    odometry_heading: Floats
    beams: Floats
    """(n, beams)"""

    @classmethod
    def of(cls, array: Floats) -> Observations:
        """Read the rows that the core fills, (n, OBS_SIZE + beams)."""
        columns: list[Any] = [array[:, k] for k in range(layout.OBS_SIZE)]
        columns[layout.OBS_BUMP] = columns[layout.OBS_BUMP] != 0.0
        return cls._make([*columns, array[:, layout.OBS_SIZE :]])


DEFAULT_SENSES = tuple(name for name in Observation._fields if name != "time")
"""What a controller senses that does not say what it looks at.

All but the clock, which no loop can outlast.
"""


class Command(NamedTuple):
    """What a controller asks for.

    Args:
        speed: m/s along the heading, negative for backwards; clamped to the robot's top speed.
        turn_rate: rad/s, counter-clockwise; takes effect before the next move.
        used_random: Whether ``observation.random`` was used, so that the next one is fresh.
    """

    speed: float = 0.0
    turn_rate: float = 0.0
    used_random: bool = False


class Commands(NamedTuple):
    """What many robots are asked for.

    A :class:`Command` of arrays of shape (n,), or of numbers for all.
    """

    speed: npt.ArrayLike = 0.0
    turn_rate: npt.ArrayLike = 0.0
    used_random: npt.ArrayLike = False


@dataclass(frozen=True)
class CompiledController:
    """A controller that is compiled: millions of steps a second, and loops can be proved.

    Args:
        name: For messages and files.
        act: A function of the core; or ``act(observation, memory, command)`` on flat float64 arrays
            (:mod:`sim.kernels.layout`), which numba compiles: it changes ``memory`` and ``command``
            in place, and all its state is in ``memory``.
        memory: Memory at reset, numbers.
        start_speed: m/s during the first step, before anything has been seen; more than the robot's
            top speed is that speed.
        thesis_rule: 1, 2 or 3 if ``stepped`` runs the thesis's own robot in its place, else 0.
        randomised: Whether it uses random numbers.
        senses: Names of the fields of :class:`Observation` that it looks at; the others may be nan.
            Without names it gets all but ``time``, and a step takes up to twice as long. Who looks
            at ``time`` never comes back to a state, so no loop is proved.
        needs: Options of the robot without which it cannot work, such as
            ``RobotOptions(beams=36)``; a run that says otherwise has its way.
        slow: Whether a step takes tens of microseconds, as one in Python does; a campaign then does
            less in a unit.
        memory_fields: Numbers of the memory that have a name, for pages that show a run.
        memory_map: What the memory (m,) says about the world, also for pages; no run calls it.
        memory_map_on: Indices of the numbers that the map hangs on; without any it hangs on all.

    Raises:
        InvalidParameter: If there is no such sense, ``needs`` are no options, or the start speed is
            below 0 or nan.
    """

    name: str
    act: Act | CoreAct
    memory: Memory = ()
    start_speed: float = 0.0
    thesis_rule: int = 0
    randomised: bool = False
    senses: tuple[str, ...] = DEFAULT_SENSES
    needs: RobotOptions = _PLAIN
    slow: bool = False
    memory_fields: tuple[MemoryField, ...] = ()
    memory_map: Callable[[Floats], MemoryMap] | None = None
    memory_map_on: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_declared(self.name, self.senses, self.needs)
        check_fields(self.name, self.memory_fields)
        speed: object = self.start_speed
        if not isinstance(speed, int | float | np.number) or not speed >= 0.0:  # also true for nan
            raise InvalidParameter(
                "out-of-range",
                "controller {name!r} has start_speed={speed!r}",
                "give m/s, 0 or more, or inf for the top speed",
                name=self.name,
                speed=speed,
            )


def check_declared(name: str, senses: object, needs: object) -> None:
    """Refuses what a controller cannot declare.

    Names of senses that there are not, needs that are no options.

    Raises:
        InvalidParameter: If it does.
    """
    if not isinstance(senses, tuple | list | set | frozenset):
        raise InvalidParameter(
            "wrong-declaration",
            "controller {name!r} has senses={senses!r}, which is no tuple of names",
            "write one such as ('bump', 'x')",
            name=name,
            senses=senses,
        )
    unknown = [sense for sense in senses if sense not in Observation._fields]
    if unknown:
        raise InvalidParameter(
            "unknown-name",
            "controller {name!r} has a sense {sense!r}",
            "there are {known!l}",
            name=name,
            sense=unknown[0],
            known=list(Observation._fields),
        )
    if not isinstance(needs, RobotOptions):
        raise InvalidParameter(
            "wrong-declaration",
            "controller {name!r} has needs={needs!r}, which are no options",
            "write RobotOptions(beams=36)",
            name=name,
            needs=needs,
        )


class PythonController(Protocol):
    """A controller as a Python class.

    Make it a frozen dataclass and keep all its state in ``memory``. ``memory`` is a tuple of
    numbers. A loop is only proved for a controller that keeps to this; one that changes itself is
    at most ``stalled`` or ``timeout``. One that plans first writes ``reset(self, world)`` and gets
    the :class:`~worldgen.world.World`, without certificate and provenance. Attributes ``senses``
    and ``needs`` may say what it looks at and which robot it needs, as for a
    :class:`CompiledController`; so may ``memory_fields``, a method ``memory_map(self, memory)`` and
    ``memory_map_on`` how its memory is shown.
    """

    def reset(self) -> Memory:
        """Memory at the start of an episode."""
        ...

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Command for the next step, and the memory after it."""
        ...


@runtime_checkable
class VectorController(Protocol):
    """A controller as a Python class that acts for many robots at once, with NumPy.

    Millions of steps a second. Row i of everything belongs to robot i and must depend on nothing
    else. There may be any number of robots, also one, and there are fewer and fewer as they arrive.
    A run is to the bit the same alone and among others if NumPy works out each row likewise: a
        matrix product may not. All else is as for a :class:`PythonController`.
    """

    def reset(self) -> Memory:
        """Memory of each robot at the start of an episode, m numbers."""
        ...

    def act_many(self, observation: Observations, memory: Floats) -> tuple[Commands, Floats]:
        """Commands for the next step, and the memories after it.

        Args:
            observation: What they see; not to be changed.
            memory: (n, m), likewise.

        Returns:
            The commands, and the memories, (n, m).
        """
        ...


Controller: TypeAlias = CompiledController | PythonController | VectorController


_COSTLY_SENSES: dict[str, int] = {
    "bump_bearing": lib.WG_SENSE_BUMP_BEARING,
    "signal": lib.WG_SENSE_SIGNAL,
    "signal_heading": lib.WG_SENSE_SIGNAL_HEADING,
    "target_heading": lib.WG_SENSE_TARGET_HEADING,
    "target_distance": lib.WG_SENSE_TARGET_DISTANCE,
    "random": lib.WG_SENSE_RANDOM,
    "time": lib.WG_SENSE_TIME,
    "odometry_x": lib.WG_SENSE_ODOMETRY,
    "odometry_y": lib.WG_SENSE_ODOMETRY,
    "odometry_heading": lib.WG_SENSE_ODOMETRY,
    "beams": lib.WG_SENSE_BEAMS,
}


def robot_for(controller: Controller, robot: RobotOptions) -> RobotOptions:
    """A run's robot, with what the controller needs where the run leaves the default."""
    needs: RobotOptions = getattr(controller, "needs", _PLAIN)
    return RobotOptions.of({**needs.changed(), **robot.changed()})


def wants_world(controller: Any) -> bool:
    """Whether a class plans first: its ``reset`` takes an argument, the world."""
    try:
        parameters = inspect.signature(controller.reset).parameters.values()
    except (
        AttributeError,
        TypeError,
        ValueError,
    ):  # no such method, or one that does not say what it takes
        return False
    by_place = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return any(one.default is one.empty and one.kind in by_place for one in parameters)


def bits_of(sense: str) -> int:
    """Return the ``WG_SENSE_`` bit of a field of an observation; 0 for what is always there."""
    return _COSTLY_SENSES.get(sense, 0)


def senses_of(controller: Controller) -> int:
    """The ``SENSE_`` bits of what a controller looks at."""
    bits = 0
    for name in getattr(controller, "senses", DEFAULT_SENSES):
        bits |= bits_of(name)
    return bits
