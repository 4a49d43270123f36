"""Read body and goal from the parameters of Nav2: its costmaps and its goal checker.

Source: the parameters of nav2_costmap_2d (``footprint``, ``robot_radius``) and of nav2_controller's
SimpleGoalChecker and StoppedGoalChecker.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop.format import decimal
from worldgen.interop.format.foreign_map import ForeignRobot
from worldgen.interop.readers.places_text import kind_words, read_kind
from worldgen.interop.readers.yaml_table import YamlTable, read_yaml
from worldgen.robot import Arrival
from worldgen.world import Robot, Target

MAX_PARAMS_BYTES = 1 << 20
# Nav2's defaults, m, rad, m/s and rad/s.
_TOLERANCE = 0.25
_STOPPED = 0.25
_CHECKERS: Mapping[str, Arrival] = {"SimpleGoalChecker": "step", "StoppedGoalChecker": "stop"}


def read_nav2_params(text: bytes) -> ForeignRobot:
    """Return the robot of a file of parameters: its body, and what counts as arriving.

    The first ``footprint`` that is not empty counts, else the first ``robot_radius``, and the first
    goal checker. The target's radius is ``xy_goal_tolerance``.

    Raises:
        FormatError: If it is not YAML, or a value is wrong.
    """
    root = read_yaml(text, "parameters of Nav2 have `ros__parameters:` and similar keys")
    tables = list(_all_tables(root))
    robot = next((found for found in map(_body_of, tables) if found.footprint), None)
    robot = robot or next((found for found in map(_body_of, tables) if found.radius), None)
    goal = next((found for found in map(_goal_of, tables) if found is not None), None)
    # Parameters are no map: nothing in them can be an obstacle.
    root.pass_over()
    if robot is None and goal is None:
        raise FormatError(
            "missing-key",
            "no footprint, robot_radius or goal checker",
            "name a file of parameters of Nav2, with its costmaps or its controller server",
            line=1,
        )
    return (robot or ForeignRobot())._replace(goal=goal)


def _all_tables(table: YamlTable) -> Iterator[YamlTable]:
    yield table
    for key in table:
        try:
            inner = table.tables(key)
        except FormatError:
            continue
        for one in inner:
            yield from _all_tables(one)


def _body_of(table: YamlTable) -> ForeignRobot:
    if "footprint" in table and table.word("footprint").strip() not in ("[]", "[ ]"):
        words = {"footprint": table.word("footprint")}
        try:
            return read_kind(words)
        except InvalidParameter as error:
            raise FormatError.of(error.message, line=table.line_of("footprint")) from error
    if "robot_radius" in table:
        return ForeignRobot(radius=table.number("robot_radius"))
    return ForeignRobot()


def _goal_of(table: YamlTable) -> Target | None:
    if "plugin" not in table:
        return None
    # nav2_controller::SimpleGoalChecker, or nav2_controller/SimpleGoalChecker.
    arrival = _CHECKERS.get(table.word("plugin").replace("/", ":").split(":")[-1])
    if arrival is None:
        return None

    def value(key: str, default: float) -> float:
        return table.number(key) if key in table else default

    return Target(
        0.0, 0.0, value("xy_goal_tolerance", _TOLERANCE),
        heading_tolerance=value("yaw_goal_tolerance", _TOLERANCE), arrival=arrival,
        arrival_speed=value("trans_stopped_velocity", _STOPPED),
        arrival_turn_rate=value("rot_stopped_velocity", _STOPPED),
    )  # fmt: skip


def nav2_params(robot: Robot) -> str:
    """Return a robot's body and goal as parameters of Nav2: two costmaps and a goal checker."""
    body = f"robot_radius: {decimal(robot.radius)}"
    if not robot.is_disc:
        body = f'footprint: "{kind_words(robot)["footprint"]}"'
    target = robot.target
    values: dict[str, Any] = {"xy_goal_tolerance": target.radius}
    # A goal checker of Nav2 always has a heading; half a turn allows any.
    any_heading = target.heading is None
    values["yaw_goal_tolerance"] = 3.14159265 if any_heading else target.heading_tolerance
    plugin = "SimpleGoalChecker"
    if target.arrival == "stop":
        plugin = "StoppedGoalChecker"
        values["trans_stopped_velocity"] = target.arrival_speed
        values["rot_stopped_velocity"] = target.arrival_turn_rate
    lines = ["# Body and goal of a world made by worldgen; m, rad, s."]
    for costmap in ("local_costmap", "global_costmap"):
        lines += [f"{costmap}:", f"  {costmap}:", "    ros__parameters:", f"      {body}"]
    lines += [
        "controller_server:",
        "  ros__parameters:",
        '    goal_checker_plugins: ["goal_checker"]',
        "    goal_checker:",
        f'      plugin: "nav2_controller::{plugin}"',
        *(f"      {name}: {decimal(value)}" for name, value in values.items()),
    ]
    return "\n".join(lines) + "\n"
