"""What the user of a campaign fixed: the robot and the run that every failure must keep.

A campaign has one constraint. Its strategies draw within it, its natural worlds meet it, and its
failures carry it in their records, so that shrinking keeps it whoever shrinks them later.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from fuzz.layouts.variation import OVERRIDES, WAYPOINTS, overrides_in
from fuzz.simplicity import Case
from sim.options.run import switch_class
from worldgen.errors import WorldgenError
from worldgen.world import Robot, Value

FIXED = "fixed"
"""Name of the detail of a failure's record that holds its constraint."""

_OF_A_ROBOT: dict[str, Callable[[Robot], float]] = {
    "robot_radius": lambda robot: robot.radius,
    "robot_speed": lambda robot: robot.speed,
    "robot_target_radius": lambda robot: robot.target.radius,
}


@dataclass(frozen=True)
class Constraint:
    """The values that some quantities may have; all others are free.

    Args:
        allowed: The quantities in order of their names, each with its values. A quantity is
            ``time_step`` (s), ``robot_radius`` (m), ``robot_speed`` (m/s), one of the
            robot's body, drive or goal (``OVERRIDES`` in :mod:`fuzz.layouts.variation`), an option of
            the motion model or a field of the controller's class. Those of robots hold for each
            robot of a world.
    """

    allowed: tuple[tuple[str, tuple[Value, ...]], ...] = ()

    @classmethod
    def of(cls, allowed: Mapping[str, Collection[Value]]) -> Constraint:
        """Return the constraint that allows these values, each listed once."""
        return cls(
            tuple((name, _once_each(values)) for name, values in sorted(allowed.items()) if values)
        )

    @classmethod
    def recorded(cls, details: Mapping[str, Value]) -> Constraint:
        """Return the constraint in a failure's record.

        Records may come from anywhere, so malformed parts are skipped.
        """
        table = details.get(FIXED)
        if not isinstance(table, dict):
            return cls()
        return cls.of({name: values for name, values in table.items() if isinstance(values, list)})

    def details(self) -> dict[str, Any]:
        """Return what a failure's record stores; empty if nothing is fixed."""
        table = {name: list(values) for name, values in self.allowed}
        return {FIXED: table} if table else {}

    def fixes(self, name: str) -> bool:
        """Return True if a quantity has only certain values."""
        return any(name == one for one, _ in self.allowed)

    def allows(self, case: Case) -> bool:
        """Return True if a world and the run in it have allowed values only."""
        return not self.violated_by(case)

    def violated_by(self, case: Case) -> tuple[str, ...]:
        """Return the quantities of which a world or the run in it has another value."""
        return tuple(name for name, values in self.allowed if not _is_one_of(case, name, values))


def _once_each(values: Collection[Value]) -> tuple[Value, ...]:
    # Options that are lists cannot be hashed, so no set or dictionary can do this.
    kept: list[Value] = []
    for value in values:
        if value not in kept:
            kept.append(value)
    return tuple(kept)


def _is_one_of(case: Case, name: str, values: Collection[Value]) -> bool:
    """Return True if a quantity of a case, if it has that, has one of these values."""
    if name in _OF_A_ROBOT or name not in OVERRIDES:
        return all(value in values for value in _values(case, name))
    return all(any(_has(robot, name, value) for value in values) for robot in case.world.robots)


def _has(robot: Robot, name: str, value: Value) -> bool:
    """Return True if an option changes nothing about a robot, so that it has this value already.

    Of waypoints, it may have fewer.
    """
    # A record may come from anywhere.
    try:
        # Waypoints are places, which move with the walls, and the number of them only has a limit.
        if name == WAYPOINTS:
            return len(robot.waypoints) <= overrides_in({name: value}).waypoint_count
        return overrides_in({name: value}).applied_to_robot(robot) == robot
    except WorldgenError:
        return False


def _values(case: Case, name: str) -> list[Any]:
    """Return the values of a quantity, one for each robot; empty if the case does not have it."""
    if name in _OF_A_ROBOT:
        return [*map(_OF_A_ROBOT[name], case.world.robots)]
    run = case.scenario.run
    if name == "time_step":
        return [run.time_step]
    options = getattr(run, switch_class(run.motion).OWNER)
    if name not in options.names():
        own = [one for one in case.scenario.fields if one.name == name]
        return [case.scenario.value_of(one) for one in own]
    value = getattr(options, name)
    return [[*value] if isinstance(value, tuple) else value]
