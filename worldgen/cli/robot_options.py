"""Options that replace the robot of a world, its body, drive and goal: the same in every command."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from worldgen.cli.declared_options import declared_options
from worldgen.cli.output import note
from worldgen.robot_overrides import RobotOverrides, describe_start_in_target

if TYPE_CHECKING:
    from worldgen.world import World

F = TypeVar("F", bound=Callable[..., Any])

robot_options: Callable[[F], F] = declared_options(RobotOverrides.declared())
"""Add ``--footprint``, ``--drive``, ``--arrival`` and their companions to a command."""


def apply(world: World, options: RobotOverrides | Mapping[str, Any]) -> World:
    """Return the world with the robot that the options describe.

    A body that does not cover its axle, and a target that covers the start, are accepted, and
    mentioned on stderr.

    Args:
        world: The world.
        options: The overrides, or a command's values by name, which may include others.

    Raises:
        InvalidParameter: If a value is wrong, an option does not suit the robot, or the world has
            several robots.
        InvalidWorld: If no world can have such a robot.
    """
    overrides = options if isinstance(options, RobotOverrides) else RobotOverrides.of(options)
    note_axle(overrides)
    changed = overrides.applied_to(world)
    warn_of_start_in_target(overrides, changed)
    return changed


def note_axle(overrides: RobotOverrides) -> None:
    """Mention a body that does not cover the axle about which it turns."""
    if overrides.leaves_axle_outside:
        note(
            "note: the axle, (0, 0), is outside the footprint, so the robot turns about a point next "
            "to its body"
        )


def warn_of_start_in_target(overrides: RobotOverrides, world: World, where: str = "") -> None:
    """Warn of a radius of the target with which a world's robot arrives at once.

    Args:
        overrides: The options, of which only the target's radius matters.
        world: The world of these options.
        where: The file, if there can be several, with a colon and a space.
    """
    robot = world.robots[0]
    if overrides.target_radius is not None and robot.starts_in_target:
        note(f"warning: {where}{describe_start_in_target(robot)}")
