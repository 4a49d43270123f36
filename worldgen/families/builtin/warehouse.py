"""Warehouses: rows of shelves with narrow aisles between them, and robots on errands."""

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
    Wall,
    Width,
)
from worldgen.family import check_between, family
from worldgen.random_streams import RandomStream
from worldgen.world import World

# Shelf lengths that are drawn if the user gives none, in aisle widths.
SHELF_ASPECTS = (2, 5)


@family("warehouse", version=2)
def warehouse(
    rng: RandomStream,
    *,
    size: Size = 30,
    robots: Robots = 4,
    aisle: Width = CHOSEN,
    shelf_length: Width = CHOSEN,
    shelf_depth: Wall = 2,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build rows of shelves with aisles for one robot, in which robots go from place to place.

    Each aisle is open at both ends, so a robot can make way, but only by driving along its whole
    length.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        robots: Number of robots, with starts and targets anywhere in the aisles.
        aisle: Width of the aisles, cells; if omitted, the narrowest that lets a robot through.
        shelf_length: Length of a shelf, cells; if omitted, drawn.
        shelf_depth: Depth of a shelf, cells.
        cell_size: Side of a cell, m.
        robot_radius: Radius of a robot, m.
        robot_speed: Top speed of a robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or there is no room for a shelf or for the
            robots.

    Source: the warehouse maps of multi-agent path finding; Stern et al., "Multi-Agent Pathfinding:
        Definitions, Variants, and Benchmarks", SoCS 2019.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    aisle = arena.passage("aisle", aisle)
    plan = rng.child("plan")
    most = arena.inside - 2 * aisle
    if most < max(1, shelf_depth):
        raise InvalidParameter(
            "no-room",
            "aisle={aisle} and shelf_depth={depth} leave no room for a shelf in size={size} cells",
            "use a size of at least {least}, or narrower aisles",
            aisle=aisle,
            depth=shelf_depth,
            size=size,
            least=2 * aisle + shelf_depth + 2,
        )
    # If no length was given, shelves are a few times as long as an aisle is wide.
    if shelf_length == CHOSEN:
        low, high = (min(most, aspect * aisle) for aspect in SHELF_ASPECTS)
        shelf_length = plan.between(low, high)
    check_between("shelf_length", shelf_length, 1, most, "cells")

    # Place as many shelves as fit; the remaining space widens the aisle along one side.
    walls = arena.solid()
    walls[1:-1, 1:-1] = False
    columns = (arena.inside - aisle) // (shelf_length + aisle)
    rows = (arena.inside - aisle) // (shelf_depth + aisle)
    left = 1 + aisle + plan.between(0, arena.inside - aisle - columns * (shelf_length + aisle))
    low = 1 + aisle + plan.between(0, arena.inside - aisle - rows * (shelf_depth + aisle))
    for row in range(rows):
        y = low + row * (shelf_depth + aisle)
        for column in range(columns):
            x = left + column * (shelf_length + aisle)
            walls[y : y + shelf_depth, x : x + shelf_length] = True

    everywhere = (1, 1, size - 2, size - 2)
    return fleet_world(arena, walls, rng, [(everywhere, everywhere)] * robots, "warehouse")
