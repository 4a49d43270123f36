"""Junctions: narrow arms that meet, and robots that have to pass each other there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias

from worldgen.errors import InvalidParameter
from worldgen.families.parts.fleets import Robots, fleet_world
from worldgen.families.parts.layout import (
    CHOSEN,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Size,
    Width,
)
from worldgen.family import family
from worldgen.random_streams import RandomStream
from worldgen.world import World

if TYPE_CHECKING:
    from worldgen.reach.joint.placing import Box

Shape: TypeAlias = Literal["X", "T"]


@family("junction", version=2)
def junction(
    rng: RandomStream,
    *,
    size: Size = 30,
    robots: Robots = 2,
    shape: Shape = "X",
    width: Width = CHOSEN,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build narrow corridors that meet at one place, where robots have to pass each other.

    Two robots cannot pass in an arm. One of them has to enter an arm that is not on its path, and
    let the other pass.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        robots: Number of robots; each starts in one arm and has its target in the arm straight
            ahead; for T, in the other arm of the bar.
        shape: X: four arms; T: three arms.
        width: Width of the arms, cells; if omitted, the narrowest that lets a robot through.
        cell_size: Side of a cell, m.
        robot_radius: Radius of a robot, m.
        robot_speed: Top speed of a robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or there is no room for the robots.

    Source: the simplest tree in which robots can swap; Kornhauser, Miller, Spirakis, "Coordinating
        pebble motion on graphs", FOCS 1984.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    width = arena.passage("width", width)
    least = 2 * arena.narrowest + width
    if arena.inside < least:
        raise InvalidParameter(
            "no-room",
            "width={width} leaves no room for arms in size={size} cells",
            "use a size of at least {least}, or a narrower width",
            width=width,
            size=size,
            least=least + 2,
        )

    # Choose where the arms meet, so that each arm is long enough for a robot.
    plan = rng.child("plan")
    low = 1 + arena.narrowest
    high = size - 1 - arena.narrowest - width
    x = plan.between(low, high)
    y = plan.between(low, high)
    walls = arena.solid()
    walls[y : y + width, 1:-1] = False
    top = size - 1 if shape == "X" else y + width
    walls[1:top, x : x + width] = False

    # Robots come from opposite arms and have to reach the other side; a T has only one such pair.
    west = (1, y, x - 1, y + width - 1)
    east = (x + width, y, size - 2, y + width - 1)
    south = (x, 1, x + width - 1, y - 1)
    north = (x, y + width, x + width - 1, size - 2)
    routes: list[tuple[Box, Box]] = [(west, east), (east, west)]
    if shape == "X":
        routes += [(south, north), (north, south)]
    boxes = [routes[number % len(routes)] for number in range(robots)]
    return fleet_world(arena, walls, rng, boxes, "junction")
