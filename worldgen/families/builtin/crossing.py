"""Crossings: two wide streets, and streams of robots that cross each other."""

from __future__ import annotations

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


@family("crossing", version=2)
def crossing(
    rng: RandomStream,
    *,
    size: Size = 30,
    robots: Robots = 4,
    street: Width = CHOSEN,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build two streets that cross, each wide enough for robots to pass each other.

    Robots come from all four sides at once, so that four can wait for each other in a circle.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        robots: Number of robots; they come from west, south, east and north in turn, and go
            straight ahead.
        street: Width of the streets, cells; if omitted, about a third of the square.
        cell_size: Side of a cell, m.
        robot_radius: Radius of a robot, m.
        robot_speed: Top speed of a robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or there is no room for the streets or
            robots.

    Source: circular wait at an intersection; Coffman, Elphick, Shoshani, "System deadlocks",
        Computing Surveys 1971.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    if street == CHOSEN:
        street = max(2 * arena.narrowest, arena.inside // 3)
    street = arena.passage("street", street)
    arm = arena.narrowest
    if arena.inside < street + 2 * arm:
        raise InvalidParameter(
            "no-room",
            "street={street} leaves no room for arms in size={size} cells",
            "use a size of at least {least}, or a narrower street",
            street=street,
            size=size,
            least=street + 2 * arm + 2,
        )

    # Where the streets cross; each arm is long enough for a robot.
    plan = rng.child("plan")
    x = plan.between(1 + arm, size - 1 - arm - street)
    y = plan.between(1 + arm, size - 1 - arm - street)
    walls = arena.solid()
    walls[y : y + street, 1:-1] = False
    walls[1:-1, x : x + street] = False

    # Each robot drives from one arm to the opposite one.
    west = (1, y, x - 1, y + street - 1)
    east = (x + street, y, size - 2, y + street - 1)
    south = (x, 1, x + street - 1, y - 1)
    north = (x, y + street, x + street - 1, size - 2)
    routes = [(west, east), (south, north), (east, west), (north, south)]
    boxes = [routes[number % 4] for number in range(robots)]
    return fleet_world(arena, walls, rng, boxes, "crossing")
