"""The controller contract: a compiled function on arrays, or a Python class.

Controllers that are programs are in :mod:`sim.controllers.programs`.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from sim._core import lib
from sim.controllers.core_act import CoreAct
from sim.controllers.memory_view import MemoryField, MemoryMap, check_fields
from sim.controllers.variants import Variants
from sim.kernels import layout
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Bools, Floats

if TYPE_CHECKING:
    from sim.controllers.behaviours.arbitration import Arbitration
    from sim.controllers.learning import Learning

Act: TypeAlias = Callable[[Floats, Floats, Floats], None]
Memory: TypeAlias = tuple[float, ...]

_PLAIN = RobotOptions()


class Neighbour(NamedTuple):
    """Another robot within the range of the sense, relative to the robot that senses it.

    Args:
        x: m, ahead of the robot.
        y: m, to its left.
        heading: rad, the neighbour's heading relative to the robot's.
        speed: m/s, of the neighbour along its heading.
        radius: m, of the neighbour.
        message: Numbers that the neighbour sent in the step before; empty if there is no channel.
    """

    x: float
    y: float
    heading: float
    speed: float
    radius: float
    message: tuple[float, ...] = ()


class Observation(NamedTuple):
    """A controller's input after each step.

    Angles are counter-clockwise in rad, and headings are relative to the world's +x.

    Args:
        bump: True if a wall or another robot stopped or bent the last move.
        bump_bearing: Direction of that contact relative to the robot's heading, rad.
        signal: Strength of the target's signal, 0 to 1.
        signal_heading: Heading to the neighbouring cell with the strongest signal, rad.
        heading: The robot's heading, rad.
        x: The robot's x, m.
        y: The robot's y, m.
        target_heading: Heading to the target, rad.
        target_distance: Distance to the target's centre, m.
        random: A random number in [0, 1); the same until the controller reports its use.
        time_step: Duration of a step, s.
        top_speed: The robot's speed limit, m/s.
        radius: The robot's radius, m.
        time: Time since the start, s; nan unless the controller declares this sense.
        odometry_x: x according to the wheels, m.
        odometry_y: y according to the wheels, m.
        odometry_heading: Heading according to the wheels, rad.
        beams: Distance to the nearest wall or robot along each range beam, m, counter-clockwise
            from straight ahead. Empty unless the controller's ``needs``, such as
            ``RobotOptions(beams=36)``, or an option such as ``+beams=36`` sets their number.
        neighbours: Other robots within range, the nearest first.
        goal_heading: Heading that the robot must have when it arrives, rad; nan if any will do.
        tilt: Speed at which the tilted floor carries the robot (the option ``drift``, in whole
            lattice units a step), m/s; 0 on a level floor.
        tilt_heading: World heading in which it does, rad; 0 on a level floor.
    """

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
    neighbours: tuple[Neighbour, ...] = ()
    goal_heading: float = math.nan
    tilt: float = 0.0
    tilt_heading: float = 0.0

    @classmethod
    def of(cls, array: Floats, tilt: float = 0.0, tilt_heading: float = 0.0) -> Observation:
        """Read the flat array, (OBS_SIZE + beams,), that the core fills for a robot of a fleet."""
        values: list[Any] = array.tolist()
        beams = tuple(values[layout.OBS_SIZE :])
        values[layout.OBS_SIZE :] = (beams, (), math.nan, tilt, tilt_heading)
        values[layout.OBS_BUMP] = values[layout.OBS_BUMP] != 0.0
        # The same as _make in half the time, which counts because it runs in every step.
        return tuple.__new__(cls, values)


NO_NEIGHBOURS: Floats = np.zeros((0, 0, layout.NEIGHBOUR_MESSAGE))
"""Neighbours of robots that do not sense other robots."""

NO_HEADING: Floats = np.zeros(0)
"""Goal headings, and tilts, of no robots."""


class Observations(NamedTuple):
    """Observations of many robots: the fields of an :class:`Observation`, of shape (n,) each."""

    bump: Bools
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
    """(n, beams) m, distance to the first wall along each range beam."""
    neighbours: Floats = NO_NEIGHBOURS
    """(n, most, 5 + message) the fields of each :class:`Neighbour`; nan if there is none."""
    goal_heading: Floats = NO_HEADING
    tilt: Floats = NO_HEADING
    tilt_heading: Floats = NO_HEADING

    @classmethod
    def of(cls, array: Floats) -> Observations:
        """Read the rows that the core fills, (n, OBS_SIZE + beams + OBS_TAIL)."""
        columns: list[Any] = [array[:, k] for k in range(layout.OBS_SIZE)]
        columns[layout.OBS_BUMP] = columns[layout.OBS_BUMP] != 0.0
        beams = array[:, layout.OBS_SIZE : -layout.OBS_TAIL]
        last = (layout.OBS_GOAL_HEADING, layout.OBS_TILT, layout.OBS_TILT_HEADING)
        return cls._make([*columns, beams, NO_NEIGHBOURS, *(array[:, at] for at in last)])


DEFAULT_SENSES = tuple(name for name in Observation._fields if name != "time")
"""The senses of a controller that does not declare any.

The clock is excluded: a controller that reads it never repeats a state, so no loop can be proved.
"""

_COMPILED_SENSES = tuple(
    name for name in DEFAULT_SENSES if name not in ("goal_heading", "tilt", "tilt_heading")
)
"""The same for a function of flat arrays, whose size would otherwise change."""


class Command(NamedTuple):
    """The output of a controller.

    Args:
        speed: m/s along the heading, negative for backwards; clamped to the robot's top speed.
        turn_rate: rad/s, counter-clockwise; takes effect before the next move. A step turns by at
            most half a turn either way, or by the run's ``turn_limit``: 7 rad in a step become pi,
            so wrap an angle before you divide it by ``time_step``.
        used_random: True if ``observation.random`` was used, so that the next one must be new.
        message: Finite numbers to send to the neighbours, as many as the run's ``message`` option
            says, or none to send zeros; ignored for a single robot.
    """

    speed: float = 0.0
    turn_rate: float = 0.0
    used_random: bool = False
    message: tuple[float, ...] = ()


class Commands(NamedTuple):
    """Commands for many robots.

    Each field of a :class:`Command` is an array of shape (n,), or one number for all robots.
    """

    speed: npt.ArrayLike = 0.0
    turn_rate: npt.ArrayLike = 0.0
    used_random: npt.ArrayLike = False
    message: npt.ArrayLike = ()


@dataclass(frozen=True)
class CompiledController:
    """A compiled controller: it runs millions of steps per second, and its loops can be proved.

    Args:
        name: Name in messages and files.
        act: A function of the core, or ``act(observation, memory, command)`` on flat float64 arrays
            (:mod:`sim.kernels.layout`), which numba compiles. It changes ``memory`` and ``command``
            in place and keeps all its state in ``memory``.
        memory: The numbers in the memory at reset.
        start_speed: Speed during the first step, before the first observation, m/s; limited to the
            robot's top speed.
        thesis_rule: 1, 2 or 3 if ``stepped`` runs the thesis's own robot in its place, else 0.
        randomised: True if it uses random numbers.
        senses: Names of the fields of :class:`Observation` that it reads; the others may be nan. By
            default it gets all but ``time``, ``goal_heading`` and tilt, and a step takes up to twice as
            long. A controller that reads ``time`` never repeats a state, so its loops cannot be
            proved.
        needs: Options of the robot that it requires, such as ``RobotOptions(beams=36)``. The
            settings of a run take precedence.
        slow: True if a step takes tens of microseconds, like one in Python; a campaign then does
            less work in each unit.
        memory_fields: Numbers of the memory that have a name, for pages that show a run.
        memory_map: Returns what the memory (m,) represents in the world, for pictures and pages; a
            run never calls it.
        memory_map_on: Indices of the numbers that the map depends on; empty means all of them.
        arbitration: How it arbitrates among behaviours, if it does; for traces and charts.
        learning: The part of its memory that it learns, if any, for ``worldgen train``.
        variants: Its own options, such as the size of its memory, if it has any.
        about: What it does, in one line, for ``worldgen controllers``.

    Raises:
        InvalidParameter: If a sense does not exist, ``needs`` is not a :class:`RobotOptions`, or
            the start speed is below 0 or nan.
    """

    name: str
    act: Act | CoreAct
    memory: Memory = ()
    start_speed: float = 0.0
    thesis_rule: int = 0
    randomised: bool = False
    senses: tuple[str, ...] = _COMPILED_SENSES
    needs: RobotOptions = _PLAIN
    slow: bool = False
    memory_fields: tuple[MemoryField, ...] = ()
    memory_map: Callable[[Floats], MemoryMap] | None = None
    memory_map_on: tuple[int, ...] = ()
    arbitration: Arbitration | None = None
    learning: Learning | None = None
    variants: Variants | None = None
    about: str = ""

    def __post_init__(self) -> None:
        check_declared(self.name, self.senses, self.needs)
        check_fields(self.name, self.memory_fields)
        speed: object = self.start_speed
        # Written so that nan also fails the comparison.
        if not isinstance(speed, int | float | np.number) or not speed >= 0.0:
            raise InvalidParameter(
                "out-of-range",
                "controller {name!r} has start_speed={speed!r}",
                "use m/s, 0 or more, or inf for the top speed",
                name=self.name,
                speed=speed,
            )


def check_declared(name: str, senses: object, needs: object) -> None:
    """Check that a controller declares only senses that exist and options of a robot.

    Raises:
        InvalidParameter: If it declares anything else.
    """
    if not isinstance(senses, tuple | list | set | frozenset):
        raise InvalidParameter(
            "wrong-declaration",
            "controller {name!r} has senses={senses!r}, which is not a tuple of names",
            "write a tuple such as ('bump', 'x')",
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
            "controller {name!r} has needs={needs!r}, which is not a RobotOptions",
            "write RobotOptions(beams=36)",
            name=name,
            needs=needs,
        )


class PythonController(Protocol):
    """A controller as a Python class.

    Make it a frozen dataclass and keep all its state in ``memory``, a tuple of numbers. Loops are
    proved only for a controller that does so; a controller that changes its own attributes gets at
    most ``stalled`` or ``timeout``.

    A controller that plans first defines ``reset(self, world)`` and receives the
    :class:`~worldgen.world.World`, without certificate and provenance. The optional attributes
    ``senses`` and ``needs`` declare what it reads and which robot it needs, as for a
    :class:`CompiledController`. The optional attributes ``memory_fields`` and ``memory_map_on`` and
    a method ``memory_map(self, memory)`` declare how its memory is shown.
    """

    def reset(self) -> Memory:
        """Return the memory at the start of an episode."""
        ...

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command for the next step, and the memory after it."""
        ...


@runtime_checkable
class VectorController(Protocol):
    """A controller as a Python class that acts for many robots at once, with NumPy.

    It runs millions of steps per second. Row i of everything belongs to robot i and must depend on
    nothing else. The number of robots varies, may be 1, and falls as robots arrive. A robot gets
    the same bits whether it runs alone or among others, as long as NumPy computes each row the same
    way; matrix products may not. Everything else is as for a :class:`PythonController`.
    """

    def reset(self) -> Memory:
        """Return the memory of each robot at the start of an episode, m numbers."""
        ...

    def act_many(self, observation: Observations, memory: Floats) -> tuple[Commands, Floats]:
        """Return the commands for the next step, and the memories after it.

        Args:
            observation: The robots' observations; must not be changed.
            memory: (n, m) the robots' memories; must not be changed.

        Returns:
            The commands, and the new memories, (n, m).
        """
        ...


Controller: TypeAlias = CompiledController | PythonController | VectorController

# Senses that the core computes only on request, because they cost time or room in a flat array.
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
    "neighbours": lib.WG_SENSE_NEIGHBOURS,
    "goal_heading": lib.WG_SENSE_GOAL_HEADING,
    "tilt": lib.WG_SENSE_TILT,
    "tilt_heading": lib.WG_SENSE_TILT,
}


def robot_for(controller: Controller, robot: RobotOptions) -> RobotOptions:
    """Return a run's robot, with the controller's needs wherever the run keeps the default."""
    needs: RobotOptions = getattr(controller, "needs", _PLAIN)
    return RobotOptions.of({**needs.changed(), **robot.changed()})


def wants_world(controller: Any) -> bool:
    """Return True if a class plans first: its ``reset`` takes the world as an argument."""
    try:
        parameters = inspect.signature(controller.reset).parameters.values()
    except (AttributeError, TypeError, ValueError):
        # The method is missing, or does not reveal its parameters.
        return False
    by_place = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return any(one.default is one.empty and one.kind in by_place for one in parameters)


def bits_of(sense: str) -> int:
    """Return the ``WG_SENSE_`` bit of a field of an observation; 0 if it is always available."""
    return _COSTLY_SENSES.get(sense, 0)


def senses_of(controller: Controller) -> int:
    """Return the ``WG_SENSE_`` bits of everything that a controller reads."""
    # The rows that a controller outside the core reads always end with the tilt and the goal's
    # heading.
    bits = 0 if isinstance(controller, CompiledController) else bits_of("tilt")
    for name in getattr(controller, "senses", DEFAULT_SENSES):
        bits |= bits_of(name)
    return bits
