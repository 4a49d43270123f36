"""Define behaviours: when they apply, what they then do, and how they compete with each other.

Source: Rodney A. Brooks, "A robust layered control system for a mobile robot", IEEE Journal of
    Robotics and Automation 2 (1986); the thesis on behaviour-based search and rescue robots that
    this program descends from (2005-2006), sections 3 and 6.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from sim.controllers.base import DEFAULT_SENSES, Command, Memory, Observation, check_declared
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter

UNTIL_DONE = math.inf
"""The duration of a behaviour that decides itself when it is done."""

Trigger: TypeAlias = Callable[[Observation, Memory], Any]
Action: TypeAlias = Callable[
    [Observation, Memory], tuple[Command, Memory] | tuple[Command, Memory, bool]
]


@dataclass(frozen=True)
class Behaviour:
    """A behaviour in Python, or one of the library's in C.

    A class or object with the same attributes and methods works too; ``trigger`` and ``action`` are
    then methods.

    Args:
        name: Name in messages, traces and charts.
        trigger: ``trigger(observation, memory)`` returns whether the behaviour applies; it is
            called while the behaviour is not active, and must not change anything.
        action: ``action(observation, memory)`` returns the command of one step and the memory after
            it, and as a third value True if the behaviour is done.
        duration: Number of steps that it acts once it has control; :data:`UNTIL_DONE` if it decides
            that itself.
        interruptible: True if a part of higher priority can take over before it is done.
        restarts: True if its own trigger restarts its duration while it acts, if it can be
            interrupted.
        memory: Its numbers at reset; only this behaviour reads and changes them.
        senses: The senses that it reads; by default all except the time.
        needs: Options of the robot that it requires.
        applies: When it applies, in words, for charts.
        does: What it does, in words.
        randomised: True if it uses random numbers.
        kind: Index of a behaviour in C: ``wg_behaviour_at``; -1 for one in Python.
        options: Dataclass of its tuning options, for a behaviour in C.
    """

    name: str
    trigger: Trigger | None = None
    action: Action | None = None
    duration: float = 1.0
    interruptible: bool = True
    restarts: bool = False
    memory: Memory = ()
    senses: tuple[str, ...] = DEFAULT_SENSES
    needs: RobotOptions = field(default_factory=RobotOptions)
    applies: str = ""
    does: str = ""
    randomised: bool = False
    kind: int = -1
    options: type | None = None

    def __post_init__(self) -> None:
        check_declared(self.name, self.senses, self.needs)
        if self.kind < 0 and not (callable(self.trigger) and callable(self.action)):
            raise InvalidParameter(
                "not-a-behaviour",
                "behaviour {name!r} has no trigger, or no action",
                "use trigger(observation, memory) and action(observation, memory)",
                name=self.name,
            )
        check_duration(self.name, self.duration)


def check_duration(name: str, duration: object) -> None:
    """Check that a duration is a number of steps.

    Raises:
        InvalidParameter: If it is anything else.
    """
    is_number = isinstance(duration, int | float) and not isinstance(duration, bool)
    if not is_number or not duration >= 0.0:  # type: ignore[operator]
        raise InvalidParameter(
            "out-of-range",
            "behaviour {name!r} has duration={duration!r}",
            "use steps, 0 or more, or UNTIL_DONE",
            name=name,
            duration=duration,
        )


@dataclass(frozen=True)
class Layer:
    """A behaviour in a composition.

    Args:
        behaviour: The behaviour.
        priority: The part with the highest priority acts, among those that apply; the first wins a
            tie. In a vote it is the part's weight. ``None``: earlier parts in the list have higher
            priority.
        duration: Steps, instead of the behaviour's own.
        interruptible: Instead of the behaviour's own.
        options: Values of the behaviour's options by name.
    """

    behaviour: Behaviour
    priority: float | None = None
    duration: float | None = None
    interruptible: bool | None = None
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def steps(self) -> float:
        """The effective duration."""
        return self.behaviour.duration if self.duration is None else self.duration

    @property
    def can_be_interrupted(self) -> bool:
        """True if a part of higher priority can take over before it is done."""
        own = self.behaviour.interruptible
        return own if self.interruptible is None else self.interruptible
