"""The library's behaviours. They are written in C, in ``sim/core/behaviours``.

Each has a dataclass of its tuning options, in the order in which the C code reads them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from sim._core import ffi, lib
from sim.controllers.behaviours.arbitration import ALWAYS
from sim.controllers.behaviours.base import UNTIL_DONE, Behaviour
from sim.kernels.layout import place
from sim.options.robot import RobotOptions
from worldgen.parameters.bounds import Bounds

TURNS = {"right": 1.0, "left": 2.0, "random": 3.0}
"""Words for the turn of ``collide``, with the thesis's numbers for its rules."""

TURN_WORDS = {
    "right": "turn right by a quarter",
    "left": "turn left by a quarter",
    "random": "turn to a random heading",
}
"""The same turns as parts of a sentence."""

HANDS = {"left": 1.0, "right": -1.0}
"""Words for the side on which ``follow`` keeps its wall."""

IDLE = {
    place("WgShared", "behaviour"): -1.0,
    place("WgShared", "target"): -1.0,
    place("WgShared", "speed"): 1.0,
    place("WgShared", "old_speed"): 1.0,
}
"""What the arbiter's memory holds at reset: no behaviour in control, no target, the top speed."""

_STEER = ("heading", "time_step", "top_speed")


def _kind(name: str) -> int:
    """Return the index of a behaviour of the C core."""
    for index in range(int(lib.wg_behaviour_count())):
        if ffi.string(lib.wg_behaviour_at(index).name) == name.encode():
            return index
    raise LookupError(f"the core has no behaviour {name!r}")


@dataclass(frozen=True)
class CollideOptions:
    """How ``collide`` turns.

    Args:
        turn: The direction of its quarter turn; ``random`` picks any heading.
    """

    turn: Literal["right", "left", "random"] = "right"


@dataclass(frozen=True)
class AvoidOptions:
    """How ``avoid`` turns away.

    Args:
        angle: Angle between the direction of the wall and the direction of driving away.
        speed: Share of the top speed.
    """

    angle: Annotated[float, Bounds(0, math.pi, "rad")] = 2.0
    speed: Annotated[float, Bounds(0, 1)] = 1.0


@dataclass(frozen=True)
class FollowOptions:
    """How ``follow`` keeps its wall.

    Args:
        hand: Side on which it keeps the wall.
    """

    hand: Literal["left", "right"] = "left"


@dataclass(frozen=True)
class WanderOptions:
    """How ``wander`` drives about.

    Args:
        leg: Length of a leg.
    """

    leg: Annotated[float, Bounds(0.001, 1000, "m")] = 0.5


@dataclass(frozen=True)
class SwerveOptions:
    """When ``swerve`` turns away.

    Args:
        gap: Distance between robot and wall below which it applies.
        speed: Share of the top speed.
    """

    gap: Annotated[float, Bounds(0, 10, "m")] = 0.03
    speed: Annotated[float, Bounds(0, 1)] = 0.5


@dataclass(frozen=True)
class EscapeOptions:
    """When ``escape`` applies, and where it goes.

    Args:
        patience: Steps without a stronger signal after which it applies.
        angle: Angle between the signal and the direction of driving away, alternately to the left
            and to the right.
    """

    patience: Annotated[int, Bounds(1, 1_000_000)] = 200
    angle: Annotated[float, Bounds(0, math.pi, "rad")] = 2.0


def _behaviour(name: str, **fields: Any) -> Behaviour:
    return Behaviour(name, kind=_kind(name), **fields)


collide = _behaviour(
    "collide",
    duration=5.0,
    interruptible=False,
    restarts=True,
    senses=("bump", *_STEER, "random"),
    applies="the robot touches a wall",
    does="stop, `turn`, and drive on for `duration` steps at the previous speed",
    options=CollideOptions,
)
seek = _behaviour(
    "seek",
    duration=0.0,
    interruptible=False,
    senses=("bump", "signal_heading", *_STEER),
    applies="the robot touches nothing",
    does="turn on the spot until it points to the signal",
)
drive = _behaviour(
    "drive",
    duration=2.0,
    interruptible=False,
    restarts=True,
    senses=("bump", "signal_heading", *_STEER),
    applies="the robot touches nothing and has turned to the signal",
    does="drive straight on for `duration` steps",
)
avoid = _behaviour(
    "avoid",
    duration=12.0,
    restarts=True,
    senses=("bump", "bump_bearing", *_STEER),
    applies="the robot touches a wall",
    does="turn away from it, and drive for `duration` steps",
    options=AvoidOptions,
)
follow = _behaviour(
    "follow",
    duration=UNTIL_DONE,
    senses=("bump", "bump_bearing", "signal", "signal_heading", "x", "y", "radius", *_STEER),
    applies="the robot touches a wall in the direction of the signal",
    does="follow it until the signal is stronger than where the wall was met, and in a direction "
    "away from it",
    options=FollowOptions,
)
approach = _behaviour(
    "approach",
    senses=("signal", "signal_heading", *_STEER),
    applies="a signal is received",
    does="drive to where it is strongest",
)
escape = _behaviour(
    "escape",
    duration=40.0,
    senses=("bump", "signal", "signal_heading", *_STEER),
    applies="the signal has not got stronger for `patience` steps",
    does="drive at an angle from it for `duration` steps",
    options=EscapeOptions,
)
home = _behaviour(
    "home",
    senses=("target_heading", "target_distance", *_STEER),
    applies=ALWAYS,
    does="drive straight to the target, whose position it knows",
)
swerve = _behaviour(
    "swerve",
    senses=("beams", "radius", *_STEER),
    needs=RobotOptions(beams=24, beam_range=2.0),
    applies="a range beam ahead sees a wall nearer than `gap`",
    does="turn until the wall is to the side, and slow down",
    options=SwerveOptions,
)
wander = _behaviour(
    "wander",
    senses=("bump", *_STEER, "random"),
    applies=ALWAYS,
    does="drive legs of `leg` m in random directions; a wall ends a leg",
    options=WanderOptions,
    randomised=True,
)
