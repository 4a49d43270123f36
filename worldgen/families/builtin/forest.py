"""Scatter round obstacles at random, with a minimum gap between any two."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Annotated, Literal, TypeAlias

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import CHOSEN, Arena, CellSize, RobotRadius, RobotSpeed, Size
from worldgen.families.parts.noise import smooth_noise
from worldgen.families.parts.open_ground import far_poses
from worldgen.families.parts.planting import disc_cells, plant
from worldgen.family import Bounds, check_at_least, check_between, family
from worldgen.lattice import exact
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import components, free_windows
from worldgen.support.arrays import Bools, Ints
from worldgen.world import World

Growth: TypeAlias = Literal["even", "thickets", "rows"]

MOST_GAP = 100.0  # widths of the robot
THICKEST = 64  # cells
# Share of the trees outside thickets that remain, as a fraction.
_IN_CLEARINGS = (1, 12)
# Range from which the largest diameter is drawn, cells.
_DRAWN_THICKEST = (2, 6)


@family("forest", version=1)
def forest(
    rng: RandomStream,
    *,
    size: Size = 30,
    growth: Growth = "even",
    thinnest: Annotated[int, Bounds(1, THICKEST, "cells")] = 1,
    thickest: Annotated[int, Bounds(1, THICKEST, "cells", chosen=CHOSEN)] = CHOSEN,
    gap: Annotated[float, Bounds(1.0, MOST_GAP, "widths of the robot")] = 1.2,
    density: Annotated[float, Bounds(0.0, 1.0, above=True)] = 1.0,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build a forest of round trunks, with the start on one side and the target on the other.

    There is a path between any two trunks, so a robot that goes around the trunks in its way
    arrives; one that turns by a fixed rule, or adds up repulsion from many sides, may not. No two
    trunks, and no trunk and the border, are closer than the gap, which is exact between their
    cells, so every target is reachable, whatever is drawn. A trunk of random thickness is tried at
    each cell, in random order, and kept if it respects the gap.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        growth: even: equally dense everywhere; thickets: dense stands with clearings between;
            rows: planted in rows, each offset from the next, and slightly out of line.
        thinnest: Diameter of the thinnest trunks, cells.
        thickest: Diameter of the thickest trunks, cells; if omitted, drawn.
        gap: Minimum gap between two trunks, and to the border, in widths of the robot.
        density: Fraction of the planted trunks that stay.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or not even one trunk fits.

    Source: Poisson-disc sampling; Bridson, "Fast Poisson disk sampling in arbitrary dimensions",
        SIGGRAPH
    2007, gives the same result as this cell-by-cell method: darts until none fits, Cook 1986.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    clear = 2 * arena.radius * exact(gap)
    free = _clear_of_border(arena, clear)
    thickest = _thickest(
        rng.child("thickest"), arena, int(free.any(axis=0).sum()), clear, thinnest, thickest
    )

    diameters = range(thinnest, thickest + 1)

    # Plant as many trunks as fit, then fell some of them. For the same seed, a lower density
    # therefore only removes trunks.
    places = _places(rng.child("places"), arena, growth, math.ceil(thickest + clear))
    kinds = (rng.child("kinds").bits(len(places)) % np.uint64(len(diameters))).astype(np.int64)
    stands = plant(free, places, kinds, diameters, clear)
    stands &= ~_felled(rng.child("felled"), arena, growth, density, places, stands)
    walls = _trunks(arena, places[stands], kinds[stands], diameters)
    begin = _widest(free_windows(walls, arena.narrowest, arena.narrowest))
    poses = far_poses(rng.child("poses"), walls, arena.narrowest, begin)

    return arena.world(walls, poses.start, poses.target, poses.quarter)


def _thickest(
    rng: RandomStream, arena: Arena, most: int, clear: Fraction, thinnest: int, thickest: int
) -> int:
    """Check the largest diameter, or draw it; it is at most ``most`` cells.

    Raises:
        InvalidParameter: If not even the thinnest trunk fits, or the requested diameter does not.
    """
    if most < thinnest:
        raise InvalidParameter(
            "no-room",
            "size={size} has no room for a trunk of {thinnest} cells and a gap of {clear:g} cells "
            "around it",
            "use a larger size, thinner trunks, or a smaller gap or robot_radius",
            size=arena.size,
            thinnest=thinnest,
            clear=float(clear),
        )
    if thickest == CHOSEN:
        return max(thinnest, min(most, rng.between(*_DRAWN_THICKEST)))
    check_at_least("thickest", thickest, thinnest, "cells")
    check_between("thickest", thickest, 1, min(most, THICKEST), "cells")
    return thickest


def _clear_of_border(arena: Arena, clear: Fraction) -> Bools:
    """Return the cells that are at least a gap away from the border."""
    margin = 1 + math.ceil(clear)
    free = np.zeros((arena.size, arena.size), dtype=np.bool_)
    free[margin : max(margin, arena.size - margin), margin : max(margin, arena.size - margin)] = (
        True
    )
    return free


def _places(rng: RandomStream, arena: Arena, growth: Growth, pitch: int) -> Ints:
    """Return the columns and rows of the places to try, in order.

    These are all cells in random order, or, for ``rows``, the places of a plantation, each slightly
    out of line.
    """
    if growth != "rows":
        order = np.argsort(rng.bits(arena.size * arena.size), kind="stable")
        return np.stack([order % arena.size, order // arena.size], axis=1)

    # Lay out the rows, every other one offset by half a pitch, and shift them all at random.
    shake = 1 + pitch // 4
    columns, rows = np.meshgrid(*[np.arange(pitch // 2, arena.size + pitch, pitch + shake - 1)] * 2)
    columns = (
        columns
        - (np.arange(len(columns)) % 2 * (pitch // 2))[:, np.newaxis]
        - rng.below(pitch // 2 + 1)
    )

    # Move each place a little, and drop those outside. Rows may also be columns.
    shaken = (rng.bits(2 * columns.size) % np.uint64(shake)).astype(np.int64).reshape(2, -1)
    places = np.stack(
        [columns.ravel() + shaken[0], rows.ravel() + shaken[1] - rng.below(pitch // 2 + 1)], axis=1
    )
    inside = ((places > 0) & (places < arena.size - 1)).all(axis=1)
    return np.asarray(places[inside] if not rng.below(2) else places[inside][:, ::-1])


def _felled(
    rng: RandomStream, arena: Arena, growth: Growth, density: float, places: Ints, stands: Bools
) -> Bools:
    """Draw the trunks to remove; the first one always stays, so that no forest is empty."""
    felled = rng.floats(len(places)) >= density
    if growth == "thickets":
        noise = smooth_noise(rng.child("clearings"), arena.size, max(4, arena.size // 5))
        clearing = noise < int(np.median(noise))
        spared = rng.floats(len(places)) * _IN_CLEARINGS[1] < _IN_CLEARINGS[0]
        felled |= clearing[places[:, 1], places[:, 0]] & ~spared
    felled[np.flatnonzero(stands)[:1]] = False
    return np.asarray(felled)


def _trunks(arena: Arena, places: Ints, kinds: Ints, diameters: range) -> Bools:
    walls = arena.solid()
    walls[1:-1, 1:-1] = False
    for kind, diameter in enumerate(diameters):
        cells = places[kinds == kind][:, np.newaxis, :] + disc_cells(diameter)[np.newaxis, :, :]
        walls[cells[..., 1], cells[..., 0]] = True
    return walls


def _widest(windows: Bools) -> int:
    """Return a place of the largest component, flat."""
    owner, count = components(windows)
    largest = int(np.bincount(owner[owner >= 0], minlength=count).argmax())
    return int(np.flatnonzero(owner == largest)[0])
