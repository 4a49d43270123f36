"""Axes of a boundary search: radius, speed, time step, start heading, depth of a trap, and fields.

The values of an axis are numbered, so doubling steps and bisection are integer arithmetic. They end
at neighbouring values that a person would write, with three significant digits or whole numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal

from fuzz.layouts.variation import map_provenance
from sim.scenario import Scenario
from worldgen.generation import generate
from worldgen.parameters import find_parameter
from worldgen.world import Witness, World

# Three-digit numbers from 100 to 999.
_DECADE = 900
_TRAP = "trap"
# The largest whole number that a float64 holds exactly.
_MOST_WHOLE = 2**53


@dataclass(frozen=True)
class Subject:
    """A scenario with one number that varies.

    Args:
        world: The world.
        scenario: The scenario to run in it.
    """

    world: World
    scenario: Scenario


@dataclass(frozen=True)
class Axis:
    """A number of a scenario that can vary.

    Args:
        name: Name on the command line.
        unit: Unit of its values.
        low: Index of the smallest value.
        high: Index of the largest value.
        value: Returns the value of an index.
        index: Returns the index nearest to a subject's own value; ``None`` if the subject has no
            such number.
        at: Returns the subject with another value, or raises if it cannot be made.
        quantity: Name by which a campaign's constraint may fix the number; empty if none can.
        is_whole: Whether its values are whole numbers.
    """

    name: str
    unit: str
    low: int
    high: int
    value: Callable[[int], float]
    index: Callable[[Subject], int | None]
    at: Callable[[Subject, float], Subject]
    quantity: str = ""
    is_whole: bool = False


def three_digits(index: int) -> float:
    """Return the number of three significant digits with this index; they ascend with the index."""
    exponent, mantissa = divmod(index, _DECADE)
    return float(f"{mantissa + 100}e{exponent - 2}")


def index_of(value: float) -> int:
    """Return the index of the number with three significant digits nearest to a positive number."""
    exact = Decimal(repr(value))
    exponent = exact.adjusted()
    return exponent * _DECADE + round(exact.scaleb(2 - exponent)) - 100


def _radius(subject: Subject) -> int | None:
    """Return the index of the radius; None for a robot with a footprint, which has none to vary."""
    robot = subject.world.robots[0]
    return index_of(robot.radius) if robot.is_disc else None


def _with_radius(subject: Subject, value: float) -> Subject:
    """Return the robot with another radius.

    It keeps the witness if that has enough clearance.
    """
    world = subject.world
    made = map_provenance(world)
    changed = replace(world, robot_radius=value, provenance=made, failure=None)
    return replace(subject, world=changed)


def _with_speed(subject: Subject, value: float) -> Subject:
    """Return the robot with another speed.

    The witness is slowed down or sped up accordingly, unless the world changes over time.
    """
    world = subject.world
    witness = subject.world.certificate
    if isinstance(witness, Witness):
        times = witness.times * (world.robot_speed / value)
        witness = None if world.is_dynamic else replace(witness, times=times)
    made = map_provenance(world)
    changed = replace(world, robot_speed=value, certificate=witness, provenance=made, failure=None)
    return replace(subject, world=changed)


def _with_time_step(subject: Subject, value: float) -> Subject:
    return replace(subject, scenario=subject.scenario.with_run(time_step=value))


def _with_heading(subject: Subject, value: float) -> Subject:
    world = subject.world
    start = replace(world.start, heading=math.radians(value))
    changed = replace(world, start=start, provenance=map_provenance(world), failure=None)
    return replace(subject, world=changed)


def _depth(subject: Subject) -> int | None:
    made = subject.world.provenance
    if made is None or made.family != _TRAP:
        return None
    depth = made.params["depth"]
    return depth if isinstance(depth, int) and depth > 0 else 1


def _with_depth(subject: Subject, value: float) -> Subject:
    """Return the trap of the same seed with arms of another length and all else unchanged."""
    made = subject.world.provenance
    params = {} if made is None else dict(made.params)
    seed = 0 if made is None else made.seed
    return replace(subject, world=generate(_TRAP, seed, **{**params, "depth": int(value)}))


AXES = {
    axis.name: axis
    for axis in (
        Axis("radius", "m", index_of(1e-4), index_of(1e3), three_digits,
             _radius, _with_radius, "robot_radius"),
        Axis("speed", "m/s", index_of(1e-3), index_of(1e4), three_digits,
             lambda subject: index_of(subject.world.robot_speed), _with_speed, "robot_speed"),
        Axis("time-step", "s", index_of(1e-3), index_of(1e1), three_digits,
             lambda subject: index_of(subject.scenario.run.time_step), _with_time_step, "time_step"),
        Axis("heading", "degrees", -179, 180, float,
             lambda subject: round(math.degrees(math.remainder(subject.world.start.heading, math.tau))), _with_heading),
        Axis("depth", "cells", 1, 100, float, _depth, _with_depth),
    )
}  # fmt: skip
"""The axes, by their names on the command line."""


def axis_of_field(scenario: Scenario, name: str) -> Axis:
    """Return the axis of a number among the fields of a scenario's controller.

    Values keep the sign of the scenario's own one; around zero, they are hundredths.

    Raises:
        InvalidParameter: If its controller has no such field, or the field is not a number.
    """
    numbers = [one for one in scenario.fields if one.kind in (int, float)]
    names = {one.name for one in numbers}
    others = [one for one in AXES if one not in names]
    field = find_parameter(name, numbers, scenario.controller, also=others)
    own = scenario.value_of(field)
    assert isinstance(own, int | float)

    def with_field(subject: Subject, value: float) -> Subject:
        changed = subject.scenario.with_option(name, field.kind(value))
        return replace(subject, scenario=changed)

    def with_index(index_of_own: int, low: int, high: int, value: Callable[[int], float]) -> Axis:
        return Axis(name, "", low, high, value, lambda _: index_of_own, with_field, name)

    if field.kind is int:
        whole = with_index(int(own), -_MOST_WHOLE, _MOST_WHOLE, float)
        return replace(whole, is_whole=True)
    if own == 0.0:
        return with_index(0, -_MOST_WHOLE, _MOST_WHOLE, lambda index: index / 100)
    low, high = index_of(1e-9), index_of(1e9)
    if own > 0.0:
        return with_index(index_of(own), low, high, three_digits)
    # Indices ascend with the values.
    return with_index(-index_of(-own), -high, -low, lambda index: -three_digits(-index))
