"""Options that replace the robot of a world, its body, drive and goal: the same in every command."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from worldgen.cli.declared_options import declared_options
from worldgen.cli.output import note
from worldgen.robot_overrides import RobotOverrides

if TYPE_CHECKING:
    from worldgen.world import World

F = TypeVar("F", bound=Callable[..., Any])

robot_options: Callable[[F], F] = declared_options(RobotOverrides.declared())
"""Add ``--footprint``, ``--drive``, ``--arrival`` and their companions to a command."""


def apply(world: World, options: RobotOverrides | Mapping[str, Any]) -> World:
    """Return the world with the robot that the options describe.

    A body that does not cover its axle is accepted, and mentioned on stderr.

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
    return overrides.applied_to(world)


def note_axle(overrides: RobotOverrides) -> None:
    """Mention a body that does not cover the axle about which it turns."""
    if overrides.leaves_axle_outside:
        note(
            "note: the axle, (0, 0), is outside the footprint, so the robot turns about a point next "
            "to its body"
        )
