"""Grow mazes of chambers and walls that fill the square, or a shape inside it."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np

from worldgen.domain import MAX_SIDE
from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import (
    CHOSEN,
    SIZE,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Share,
    Wall,
    Width,
    spread_evenly,
)
from worldgen.families.parts.mazes import (
    FIT_ANY_SHAPE,
    ROCK,
    braid_ends,
    carve_rooms,
    cells_of,
    grow,
    pitch,
    shape_mask,
    ways_out,
)
from worldgen.family import Bounds, family
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools
from worldgen.world import World


@family("maze", version=1)
def maze(
    rng: RandomStream,
    *,
    size: Annotated[int, replace(SIZE, high=MAX_SIDE)] = 30,
    algorithm: Literal[
        "wilson",
        "aldous-broder",
        "backtracker",
        "hunt-and-kill",
        "kruskal",
        "prim",
        "growing-tree",
        "eller",
        "sidewinder",
        "binary-tree",
        "recursive-division",
    ] = "wilson",
    newest: Annotated[float, Bounds(0.0, 1.0, chosen=CHOSEN)] = float(CHOSEN),
    oldest: Annotated[float, Bounds(0.0, 1.0, chosen=CHOSEN)] = float(CHOSEN),
    mask: Literal["square", "disc", "ring", "cross", "diamond"] = "square",
    braid: Share = 0.0,
    rooms: Annotated[int, Bounds(0)] = 0,
    passage: Width = CHOSEN,
    wall: Wall = 1,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Make a maze with start and target in opposite corners.

    Dead ends and detours defeat a robot that only turns away from walls that it bumps into. A
    maze is a lattice of chambers, each a passage wide. Every chamber is reachable by construction;
    cells left over by the division into chambers widen some passages.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        algorithm: wilson, aldous-broder: every maze is equally likely; backtracker: long winding
            passages; kruskal, prim: a minimum spanning tree with random weights; for the others see
            the documentation.
        newest: Fraction of a growing tree's steps that continue from the newest chamber; if
            omitted, half.
        oldest: Fraction of the steps that continue from the oldest chamber; if omitted, none. The
            rest continue from any chamber.
        mask: Shape of the maze; the rest of the square is rock.
        braid: Fraction of the dead ends that get a second exit; 1 leaves no dead end.
        rooms: Number of open rectangular rooms, each of 2 x 2 chambers or more.
        passage: Width of the passages, cells; if omitted, the narrowest that lets the robot
            through.
        wall: Thickness of the walls, cells.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, has no effect with the algorithm, or does not
            fit.

    Source: each algorithm names its own, in worldgen/families/_mazes.
    """
    # Check the parameters, and find how many chambers fit.
    arena = Arena(size, cell_size, robot_radius, robot_speed, most=MAX_SIDE)
    passage = arena.passage("passage", passage)
    newest, oldest = _shares(algorithm, newest, oldest)
    side = (arena.inside + wall) // (passage + wall)
    if side < 2:
        raise InvalidParameter(
            "no-room",
            "passage={passage} and wall={wall} leave no 2 x 2 chambers in size={size} cells",
            "use a size of at least {least}, or narrower passages and walls",
            passage=passage,
            wall=wall,
            size=size,
            least=2 * passage + wall + 2,
        )
    # Grow the maze, then open rooms and dead ends.
    inside = _mask(mask, side, algorithm)

    links = grow(rng.child("tree"), inside, algorithm, newest=newest, oldest=oldest)
    if mask != "square":
        links[~inside] = ROCK
    carve_rooms(rng.child("rooms"), links, inside, rooms)
    braid_ends(rng.child("braid"), links, braid)

    # Widen some passages so that the maze fills the square exactly.
    spare = arena.inside - side * passage - (side - 1) * wall
    widths = [passage + extra for extra in spread_evenly(rng, spare, side)]
    heights = [passage + extra for extra in spread_evenly(rng, spare, side)]

    # Start and target are in opposite corners, or as near to them as the shape has chambers.
    corner = (rng.below(2) * (side - 1), rng.below(2) * (side - 1))
    start = _nearest(inside, corner)
    target = _nearest(inside, (side - 1 - corner[0], side - 1 - corner[1]))
    quarter = rng.choice(ways_out(links, *start))

    return arena.world(
        cells_of(links, pitch(widths, wall), pitch(heights, wall)),
        start=(_centre(widths, start[0], wall), _centre(heights, start[1], wall)),
        target=(_centre(widths, target[0], wall), _centre(heights, target[1], wall)),
        quarter=quarter,
    )


def _shares(algorithm: str, newest: float, oldest: float) -> tuple[float, float]:
    """Return the shares of a growing tree's steps, with defaults for omitted ones.

    Raises:
        InvalidParameter: If the sum exceeds 1, or a share is given for another algorithm.
    """
    given = {
        name: share for name, share in (("newest", newest), ("oldest", oldest)) if share != CHOSEN
    }
    for name, share in given.items():
        if algorithm != "growing-tree":
            raise InvalidParameter(
                "no-effect",
                "{name}={share:g} has no effect with algorithm={algorithm}",
                "omit it, or use growing-tree",
                name=name,
                share=share,
                algorithm=algorithm,
            )
    oldest = given.get("oldest", 0.0)
    newest = given.get("newest", min(0.5, 1.0 - oldest))
    if newest + oldest > 1.0:
        raise InvalidParameter(
            "above-maximum",
            "newest={newest:g} and oldest={oldest:g} add up to more than 1",
            "use at most 1 in total",
            newest=newest,
            oldest=oldest,
        )
    return newest, oldest


def _mask(shape: str, side: int, algorithm: str) -> Bools:
    """Return the mask of a shape, after checking that the algorithm can fill it.

    Raises:
        InvalidParameter: If there are too few chambers for the shape, or the algorithm needs a full
            square.
    """
    if shape != "square" and algorithm not in FIT_ANY_SHAPE:
        raise InvalidParameter(
            "conflict",
            "mask={shape} cannot be combined with algorithm={algorithm}, which fills whole rows",
            "use one of {known!l}, or mask=square",
            shape=shape,
            algorithm=algorithm,
            known=list(FIT_ANY_SHAPE),
        )
    return shape_mask(shape, side)


def _nearest(mask: Bools, corner: tuple[int, int]) -> tuple[int, int]:
    """Return the column and row of the chamber nearest to a corner.

    If there are several, this is the lowest one, and the leftmost of those.
    """
    column, row = corner
    if mask[row, column]:
        return corner
    rows, columns = np.nonzero(mask)
    first = int(np.argmin((columns - column) ** 2 + (rows - row) ** 2))
    return int(columns[first]), int(rows[first])


def _centre(widths: list[int], chamber: int, wall: int) -> int:
    """Return the middle of a chamber, in half cells."""
    return 2 * (1 + sum(widths[:chamber]) + chamber * wall) + widths[chamber]
