"""Caves: a cellular automaton hollows out the rock, and tunnels join the separate hollows."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import CHOSEN, Arena, CellSize, RobotRadius, RobotSpeed, Size
from worldgen.families.parts.open_ground import covered, dig_from, easiest_joints, far_poses
from worldgen.family import Bounds, check_between, family
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import components, free_windows
from worldgen.support.arrays import Bools, Bytes
from worldgen.world import World

Shape: TypeAlias = Literal["caverns", "columns", "galleries"]

# Range from which the share of rock is drawn, percent.
_ROCK: dict[Shape, tuple[int, int]] = {
    "caverns": (47, 52),
    "columns": (38, 44),
    "galleries": (54, 58),
}
# The automaton stops changing long before this many rounds.
MOST_ROUNDS = 50
_ROUNDS = (3, 6)  # range from which the rounds are drawn
# Limit on the rounds that round off the corners of large cells: each costs as much as one of the
# automaton's.
_SMOOTHEST = 10
# Hollows with less than the area of a square of this many robot widths per side are filled in.
_HOLLOW = 2
# Limit on the rounds that it takes to dig a place; tunnels bend around hard places.
_HARDEST = 3
# Number of rounds in which columns grow in wide halls.
_OPENED_UP = 3


@family("cave", version=1)
def cave(
    rng: RandomStream,
    *,
    size: Size = 30,
    shape: Shape = "caverns",
    rock: Annotated[int, Bounds(30, 65, "percent", chosen=CHOSEN)] = CHOSEN,
    rounds: Annotated[int, Bounds(0, MOST_ROUNDS, chosen=CHOSEN)] = CHOSEN,
    grain: Annotated[int, Bounds(1, unit="cells", chosen=CHOSEN)] = CHOSEN,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build a cave of irregular halls and passages, with start and target at opposite ends.

    No wall is straight, and hollows of every size catch a robot that follows a signal or a wall.
    The robot can reach all free floor: separate hollows are joined by tunnels, and crannies too
    narrow for the robot are filled in.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        shape: caverns: halls and passages, with loops; columns: one wide hall full of pillars;
            galleries: small chambers, joined by long tunnels without loops.
        rock: Rock before the automaton's first round, in percent; more rock makes a narrower cave;
            if omitted, drawn to suit the shape.
        rounds: Rounds of the automaton; 0 leaves the rock as it was scattered; if omitted, drawn.
        grain: Cells per side of the automaton's own cells: larger ones make a wider cave; if
            omitted, chosen to suit the robot.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or the square is less than three robots wide.

    Source: Johnson, Yannakakis, Togelius, "Cellular automata for real-time generation of infinite
        cave
    levels", PCGames 2010; the rule of the columns from "Cellular Automata Method for Generating
    Random Cave-Like Levels", RogueBasin.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    check_between("grain", grain, CHOSEN, arena.inside, "cells")
    side = arena.narrowest
    if arena.inside < 3 * side:
        raise InvalidParameter(
            "no-room",
            "size={size} is too small for a cave, which needs {least} cells for a robot "
            "{robot_width} cells wide",
            "use a larger size or a smaller robot_radius",
            size=size,
            least=3 * side + 2,
            robot_width=side,
        )
    grain = max(1, side // 2) if grain == CHOSEN else grain
    rounds = rng.child("rounds").between(*_ROUNDS) if rounds == CHOSEN else rounds
    rock = rng.child("share").between(*_ROCK[shape]) if rock == CHOSEN else rock

    # Hollow out the rock, join the hollows, and keep only the floor that the robot can use.
    walls = _hollowed(rng.child("rock"), arena, rock, rounds, grain, pillars=shape == "columns")
    _dig_ends(rng.child("ends"), arena, walls)
    windows = _joined(rng.child("tunnels"), arena, walls)
    walls = ~covered(windows, side)
    poses = far_poses(rng.child("poses"), walls, side, int(np.flatnonzero(windows)[0]))

    return arena.world(walls, poses.start, poses.target, poses.quarter)


def _hollowed(
    rng: RandomStream, arena: Arena, rock: int, rounds: int, grain: int, *, pillars: bool
) -> Bools:
    """Scatter rock at random and smooth it: a cell becomes rock if most of its 3 x 3 square is.

    Args:
        rng: The only source of randomness.
        arena: The square.
        rock: Share of rock before smoothing, percent.
        rounds: Rounds of smoothing.
        grain: Side of the automaton's cells, in cells of the world.
        pillars: If True, columns grow in wide halls.
    """
    # Run the automaton on coarse cells. In wide halls, a cell with hardly any rock within two cells
    # becomes rock too, but not in the last round, which smooths the columns.
    side = -(-arena.inside // grain)
    walls = np.ones((side + 2, side + 2), dtype=np.bool_)
    walls[1:-1, 1:-1] = (rng.bits(side * side) % np.uint64(100) < rock).reshape(side, side)
    for done in range(rounds):
        near = _rock_within(walls, 1)
        grown = near >= 5
        if pillars and done < min(_OPENED_UP, rounds - 1):
            grown |= _rock_within(walls, 2) <= 2
        walls[1:-1, 1:-1] = grown

    # Enlarge the coarse cells to the world's.
    fine = np.ones((arena.size, arena.size), dtype=np.bool_)
    large = walls[1:-1, 1:-1].repeat(grain, axis=0).repeat(grain, axis=1)
    fine[1:-1, 1:-1] = large[: arena.inside, : arena.inside]

    # Round off the corners of large cells.
    for _ in range(min(grain, _SMOOTHEST) - 1):
        fine[1:-1, 1:-1] = _rock_within(fine, 1) >= 5
    return fine


def _rock_within(walls: Bools, reach: int) -> Bytes:
    """Count the rock in the square around each inner cell, including the cell itself.

    Everything outside the array counts as rock.
    """
    # Sum along rows and then along columns, which takes fewer additions than the whole square.
    padded = np.pad(walls, reach - 1, constant_values=True)
    rows, columns = (length - 2 * reach for length in padded.shape)
    lines = np.zeros((len(padded), columns), dtype=np.uint8)
    for k in range(2 * reach + 1):
        lines += padded[:, k : k + columns]
    counts = np.zeros((rows, columns), dtype=np.uint8)
    for k in range(2 * reach + 1):
        counts += lines[k : k + rows]
    return counts


def _dig_ends(rng: RandomStream, arena: Arena, walls: Bools) -> None:
    """Dig a chamber into each of two opposite corners, in place.

    The tunnels to these chambers make the cave span the square.
    """
    side = arena.narrowest
    spare = arena.inside - side
    flip = rng.below(2)
    for far in (0, 1):
        x, y = (rng.between(0, spare // 4) for _ in range(2))
        column = 1 + (spare - x if far else x)
        row = 1 + (spare - y if far ^ flip else y)
        walls[row : row + side, column : column + side] = False


def _joined(rng: RandomStream, arena: Arena, walls: Bools) -> Bools:
    """Fill small hollows and join the others by tunnels.

    Returns:
        (size, size) bool, True where the robot's window is free.
    """
    # Keep large hollows.
    side = arena.narrowest
    windows = free_windows(walls, side, side)
    owner, count = components(windows)
    sizes = np.bincount(owner[owner >= 0], minlength=count)
    kept = sizes >= min((_HOLLOW * side) ** 2, int(sizes.max()))
    free = np.flatnonzero(windows)

    # Keep the chambers in the corners too. The first and the last free window are always in these
    # chambers, or in a hollow that is connected to them.
    ends = [int(free[0]), int(free[-1])]
    for end in ends:
        kept[int(owner[end])] = True
    owner[~kept[owner] & (owner >= 0)] = -1

    # Dig tunnels through rock of random hardness, along the easiest paths.
    hard = np.zeros(walls.shape, dtype=np.uint8)
    inner = arena.inside - side + 1
    hard[1 : 1 + inner, 1 : 1 + inner] = (
        rng.bits(inner * inner) % np.uint64(_HARDEST) + 1
    ).reshape(inner, inner)
    dug = dig_from(owner, hard)
    windows = (owner >= 0).reshape(walls.shape)
    for one, other in easiest_joints(dug, arena.size, count):
        windows.reshape(-1)[dug.way_back(one) + dug.way_back(other)] = True
    return windows
