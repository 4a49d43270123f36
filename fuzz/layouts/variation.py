"""Quantities that a campaign varies besides the world: ``--vary sensor_noise=0,0.05,0.2``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from sim.options.run import TIME_STEP, switch_class
from sim.scenario import Scenario
from worldgen.body_room import layout_radius, usual_cell, with_chosen_waypoints
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.generation import generate
from worldgen.parameters.known_names import unknown_name
from worldgen.robot import DEFAULT_ROBOT_RADIUS
from worldgen.robot_overrides import RobotOverrides
from worldgen.world import DEFAULT_CELL_SIZE, Pose, Provenance, Robot, Target, Value, World

# Fields of a world.
_OF_THE_ROBOT = {"robot_radius": "m", "robot_speed": "m/s"}
_PREFIX = "robot_"
OVERRIDES = {_PREFIX + option.name: option for option in RobotOverrides.declared()}
"""Quantities of the robot's body, drive and goal: ``robot_footprint``, ``robot_arrival``, ..."""
WAYPOINTS = f"{_PREFIX}waypoints"
"""The quantity of goals before the target."""
OF_THE_ROBOT = frozenset({*_OF_THE_ROBOT, *OVERRIDES})
"""Quantities that :func:`with_robot` sets."""
# Cells around start and target that layouts leave free, in which a body must be able to turn.
_ROOM = 1.5
_USUAL_RADIUS = DEFAULT_ROBOT_RADIUS / DEFAULT_CELL_SIZE
MAP = "map"
"""Family in the provenance of a world that was made from a map which is not a foreign program's."""

_OPTION = "--vary"
_EXAMPLE = "write NAME=VALUE,VALUE,..., such as sensor_noise=0,0.05"


@dataclass(frozen=True)
class Variation:
    """One quantity and its values.

    Args:
        name: ``robot_radius`` (m), ``robot_speed`` (m/s), ``time_step`` (s), one of
            :data:`OVERRIDES`, an option of the motion model, or a field of the controller's class.
        values: Values, the simplest first.
    """

    name: str
    values: tuple[Value, ...]

    @classmethod
    def parse(cls, text: str, scenario: Scenario) -> Variation:
        """Read ``NAME=VALUE,VALUE,...``.

        Args:
            text: Text from the command line.
            scenario: Scenario whose motion model and controller decide which options exist.

        Raises:
            InvalidParameter: If the name is unknown, or a value is invalid or out of range.
        """
        name, equals, said = text.partition("=")
        name = name.strip().replace("-", "_")
        words = [word.strip() for word in said.split(",")]
        if not name or not equals or not all(words):
            raise InvalidParameter(
                "no-values",
                "{option} {text!r} names no values",
                _EXAMPLE,
                option=_OPTION,
                text=text,
            )
        _check_name(name, scenario)
        found = cls(name, tuple(_value(name, word, scenario) for word in words))
        for value in found.values:
            found._check(value, scenario)
        return found

    def _check(self, value: Value, scenario: Scenario) -> None:
        if self.name in _OF_THE_ROBOT:
            if not isinstance(value, float) or not 0.0 < value < 1e6:
                unit = _OF_THE_ROBOT[self.name]
                raise InvalidParameter(
                    "out-of-range",
                    "{option} {name}={value}: use {unit} above 0 and below a million",
                    option=_OPTION,
                    name=self.name,
                    value=value,
                    unit=unit,
                )
        elif self.name != "time_step" and self.name not in OVERRIDES:
            scenario.with_option(self.name, value)


def applied(
    values: Mapping[str, Value], world: World, scenario: Scenario
) -> tuple[World, Scenario]:
    """Return the world and the scenario with these values.

    Args:
        values: One value for each :class:`Variation`, by name.
        world: The world; it loses its certificate if its robot changes.
        scenario: The scenario to run in it.

    Raises:
        InvalidWorld: If the robot does not fit the world.
    """
    world = with_robot(world, values)
    for name, value in values.items():
        if name == "time_step":
            scenario = scenario.with_run(time_step=value)
        elif name not in OF_THE_ROBOT:
            scenario = scenario.with_option(name, value)
    return world, scenario


def with_robot(world: World, values: Mapping[str, Value]) -> World:
    """Return the world with the robot of these values.

    Args:
        world: The world; it loses what was true of another robot only, such as its certificate.
        values: As for :func:`applied`; those of the run are ignored.

    Raises:
        InvalidWorld: If the robot does not fit the world.
        InvalidParameter: If it has no room for as many waypoints.
    """
    robot = {name: value for name, value in values.items() if name in _OF_THE_ROBOT}
    if any(getattr(world, name) != value for name, value in robot.items()):
        parts: dict[str, Any] = {name.removeprefix("robot_"): robot[name] for name in robot}
        robots = tuple(replace(one, **parts) for one in world.robots)
        provenance = map_provenance(world)
        world = replace(world, robots=robots, certificate=None, provenance=provenance)
    overrides = overrides_in(values)
    if not overrides.chooses_waypoints:
        return overrides.applied_to(world)
    world = replace(overrides, waypoints=None).applied_to(world)
    return with_chosen_waypoints(world, overrides)


def overrides_in(values: Mapping[str, Value]) -> RobotOverrides:
    """Return the robot's body, drive and goal among some values."""
    given: dict[str, Any] = {
        option.name: values[name] for name, option in OVERRIDES.items() if name in values
    }
    return RobotOverrides(**given)


def quantities_of(overrides: RobotOverrides) -> dict[str, Value]:
    """Return overrides as values by the names of their quantities."""
    return {_PREFIX + name: value for name, value in overrides.given().items()}


def layout_disc(values: Mapping[str, Value]) -> tuple[float, float]:
    """Return the disc for which worlds of a robot with these values are laid out, and their cells.

    Args:
        values: As for :func:`applied`.

    Returns:
        The radius, and the side of a cell of a feature layout, m. The usual ones, if the robot is a
        disc that turns on the spot.
    """
    overrides = overrides_in(values)
    radius = values.get("robot_radius", DEFAULT_ROBOT_RADIUS)
    assert isinstance(radius, float)
    if not overrides.changes_body:
        return radius, DEFAULT_CELL_SIZE
    robot = overrides.applied_to_robot(Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 1.0), radius))
    radius = layout_radius(robot)
    return radius, max(usual_cell(radius), usual_cell(robot.radius * _USUAL_RADIUS / _ROOM))


def generated(family: str, seed: int, values: Mapping[str, Value]) -> World:
    """Return a family's world for a robot with these values, as far as the family has parameters.

    :func:`applied` gives it the rest.

    Args:
        family: Name of the family.
        seed: Seed of the world.
        values: As for :func:`applied`.

    Raises:
        GenerationFailed: If no layout is solvable for the robot.
        InvalidParameter: If the family cannot have such a robot.
    """
    found = FAMILIES.get(family)
    own = {one.name for one in found.all_parameters}
    robot = {one.name for one in found.robot_parameters}
    given = {name: value for name, value in values.items() if name in own}
    body = overrides_in(values).given()
    return generate(found, seed, **given, **{n: v for n, v in body.items() if n in robot})


def map_provenance(world: World) -> Provenance | None:
    """Return the provenance of the cells if they are a foreign map's, or a map's with changes.

    It is true for any robot and any start. It includes the map's origin, so that a failure can be
    located on the original map, and what was changed. A family's provenance describes the whole
    world.
    """
    made = world.provenance
    return made if made is not None and made.is_of_map else None


def changes_on_map(world: World) -> str:
    """Describe what was changed on a map; empty if nothing was.

    ``on the map: box of 0.5 x 0.3 m at (3.4, 2) m; window of 88 x 88 cells at (1.2, 0.4) m``
    """
    changed = () if world.provenance is None else world.provenance.changed
    return f"on the map: {'; '.join(changed)}" if changed else ""


def _value(name: str, word: str, scenario: Scenario) -> Value:
    if name == "time_step":
        seconds: float = TIME_STEP.parse(word, "run")
        return seconds
    if name in OVERRIDES:
        given: Value = OVERRIDES[name].parse(word, "robot")
        overrides_in({name: given})
        return given
    field = next((one for one in scenario.fields if one.name == name), None)
    if field is not None and name not in _OF_THE_ROBOT:
        value: Value = field.parse(word, scenario.controller)
        return value
    if name not in _OF_THE_ROBOT:
        return switch_class(scenario.run.motion).parse(name, word)[name]
    try:
        return float(word)
    except ValueError:
        raise InvalidParameter(
            "not-a-number",
            "{option} {name}={value}: that is not a number",
            _EXAMPLE,
            option=_OPTION,
            name=name,
            value=word,
        ) from None


def _check_name(name: str, scenario: Scenario) -> None:
    motion = scenario.run.motion
    fields = (one.name for one in scenario.fields)
    known = (*_OF_THE_ROBOT, *OVERRIDES, "time_step", *switch_class(motion).names(), *fields)
    if name not in known:
        problem = "{option} {name}: nothing with that name can be varied under {motion}"
        raise InvalidParameter.of(unknown_name(problem, name, known, option=_OPTION, motion=motion))
