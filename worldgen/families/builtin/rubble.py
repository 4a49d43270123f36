"""Collapse an office plan, and bury a survivor in a pocket under debris."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.doors import hang_doors
from worldgen.families.parts.floor_plan import Sizes, Style, divide, fit_sizes, joined
from worldgen.families.parts.layout import (
    CHOSEN,
    STEPS,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Share,
    Size,
    Wall,
    Width,
)
from worldgen.families.parts.noise import smooth_noise
from worldgen.families.parts.open_ground import FAR, dig_from
from worldgen.family import Bounds, check_between, family
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import free_windows, steps_from
from worldgen.support.arrays import Bools, Ints
from worldgen.world import World

Collapse: TypeAlias = Literal["quake", "blast", "wing"]

# Probability of a door where none is needed to join all rooms.
_SHARED = 0.25
# Weight of debris next to fallen walls; elsewhere it is 2.
_NEAR_WALLS = 3
# Share of the walls in the ruined part that are down.
_BREACHED = 0.6
# Cost of a window with debris, in free windows, when choosing the path to clear.
_DIGGING = 6


@family("rubble", version=1)
def rubble(
    rng: RandomStream,
    *,
    size: Size = 30,
    collapse: Collapse = "quake",
    damage: Share = 0.5,
    debris: Share = 0.35,
    room: Width = CHOSEN,
    wall: Wall = 1,
    pocket: Annotated[int, Bounds(0, unit="cells", chosen=CHOSEN)] = CHOSEN,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build a collapsed building in which the robot looks for a survivor in a pocket.

    The robot enters where the building still stands. Walls are down in the ruined part, so there
    are paths that the plan does not show; debris lies where they stood and blocks paths that the
    plan does show. The survivor, the target, is in a pocket that debris encloses except for one
    entrance.

    The path to it is cleared from the start, over as little debris as possible and never through a
    wall that still stands: every world can be solved, whatever collapses.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        collapse: quake: ruined in patches all over; blast: ruined around one place; wing: ruined on
            one side.
        damage: Fraction of the building that is ruined.
        debris: Fraction of the ruined floor that debris covers; it is thickest where walls fell.
        room: Minimum inner side of a room, cells; if omitted, drawn.
        wall: Thickness of the walls, cells.
        pocket: Free cells around the survivor, inside the debris; if omitted, drawn.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or two rooms do not fit.

    Source: the rescue robot of the thesis that this program descends from; voids left in a
        collapse, as in
    Murphy, "Disaster Robotics", 2014.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    check_between("pocket", pocket, CHOSEN, arena.inside, "cells")
    side = arena.narrowest
    pocket = rng.child("pocket").between(0, side) if pocket == CHOSEN else pocket

    # Draw a building, and let a part of it collapse. The border always stands.
    building = _building(rng.child("building"), arena, room, wall)
    ruined = _ruined(rng.child("ruined"), arena, collapse, damage)
    standing = building & ~(ruined & _fallen(rng.child("fallen"), arena))
    standing[[0, -1], :] = standing[:, [0, -1]] = True

    # Add debris, bury the survivor, and clear one path to the pocket.
    ends = _ends(rng.child("ends"), building, standing, ruined, side)
    heaps = _heaps(rng.child("debris"), building, ruined, debris) & ~standing
    _bury(heaps, ends, pocket, side)
    heaps &= ~standing
    _clear(heaps, standing, ends, side)
    walls = standing | heaps

    windows = free_windows(walls, side, side)
    ways = [way for way, (dx, dy) in enumerate(STEPS) if windows.flat[ends.start + dx + dy * size]]
    return arena.world(
        walls, ends.middle(ends.start), ends.middle(ends.target), rng.choice(ways or [0, 1, 2, 3])
    )


@dataclass(frozen=True)
class _Ends:
    """Hold the windows of the robot's start and of the survivor.

    Args:
        start: Flat place of the start's window.
        target: Flat place of the survivor's window.
        stride: Cells per row.
        side: Cells per side of a window.
    """

    start: int
    target: int
    stride: int
    side: int

    def middle(self, place: int) -> tuple[int, int]:
        """Return a window's middle in half cells."""
        return 2 * (place % self.stride) + self.side, 2 * (place // self.stride) + self.side


def _building(rng: RandomStream, arena: Arena, room: int, wall: int) -> Bools:
    """Return the walls before the collapse, with doors open, of a random plan that fits.

    Raises:
        InvalidParameter: If no plan fits.
    """
    styles: list[Style] = ["wings", "spine", "suite"]
    rng.shuffle(styles)
    width = arena.narrowest
    # Two times out of three, try the plan without corridors last.
    for style in sorted(styles, key=lambda style: style == "suite" and rng.below(3) > 0):
        asked = Sizes(room, 0 if style == "suite" else width, width, wall)
        try:
            sizes = fit_sizes(rng.child("sizes"), arena, style, asked, spacious=2 * width)
        except InvalidParameter as refusal:
            problem = refusal
            if style == "suite":
                break
            continue
        floor = divide(rng.child("floor"), arena, style, sizes)
        return hang_doors(rng.child("doors"), floor, joined(floor, sizes), sizes, _SHARED).walls
    raise problem


def _largest(scores: Ints, within: Bools, share: float) -> Bools:
    """Return a share of the cells in ``within``: those with the largest scores, including ties."""
    inside = scores[within]
    count = round(share * len(inside))
    if count == 0:
        return np.zeros_like(within)
    limit = np.partition(inside, len(inside) - count)[len(inside) - count]
    return np.asarray(within & (scores >= limit))


def _ruined(rng: RandomStream, arena: Arena, collapse: Collapse, damage: float) -> Bools:
    """Return the part of the building that is ruined, with a ragged edge.

    Noise gives the edge its shape. A blast adds the distance from a point, and the collapse of a
    wing adds the distance along a direction. All are scaled to whole numbers of the same size.
    """
    size = arena.size
    pitch = max(4, arena.size // 6)
    noise = smooth_noise(rng, size, pitch)
    highest = 1024 * pitch * pitch
    x = np.arange(size)[np.newaxis, :]
    y = np.arange(size)[:, np.newaxis]
    if collapse == "blast":
        cx = rng.between(1, size - 2)
        cy = rng.between(1, size - 2)
        noise = noise * size**2 - 8 * highest * ((x - cx) ** 2 + (y - cy) ** 2)
    elif collapse == "wing":
        a = rng.between(1, 8) * (2 * rng.below(2) - 1)
        b = rng.between(0, 8) * (2 * rng.below(2) - 1)
        if rng.below(2):
            a, b = b, a
        noise = noise * size * (abs(a) + abs(b)) + 4 * highest * (a * x + b * y)

    # The border never falls.
    inside = np.zeros((size, size), dtype=np.bool_)
    inside[1:-1, 1:-1] = True
    return _largest(noise, inside, damage)


def _fallen(rng: RandomStream, arena: Arena) -> Bools:
    """Return where walls in the ruined part are down.

    Smooth noise gives stretches wide enough for the robot, with stumps between them.
    """
    everywhere = np.ones((arena.size, arena.size), dtype=np.bool_)
    return _largest(smooth_noise(rng, arena.size, arena.narrowest + 1), everywhere, _BREACHED)


def _ends(rng: RandomStream, building: Bools, standing: Bools, ruined: Bools, side: int) -> _Ends:
    """Draw a survivor in the ruined part, and a start far away from it.

    The start is where the building still stands, if such a place is far enough away. Both places
    were open before the collapse. Those are all connected, and fallen walls only add connections.
    """
    # Draw the survivor.
    open_before = free_windows(building, side, side)
    buried = np.flatnonzero(open_before & ruined)
    if not len(buried):
        buried = np.flatnonzero(open_before)
    target = int(buried[rng.below(len(buried))])

    # Draw the start among the farthest places.
    steps, order = steps_from(free_windows(standing, side, side), target)
    order = order[open_before.ravel()[order]]
    far = order[np.searchsorted(steps[order], int(steps[order[-1]]) * FAR[0] // FAR[1]) :]
    safe = far[~ruined.ravel()[far]]
    return _Ends(
        int(rng.choice((safe if len(safe) else far).tolist())), target, len(standing), side
    )


def _heaps(rng: RandomStream, building: Bools, ruined: Bools, share: float) -> Bools:
    """Scatter debris in heaps over a share of the ruined floor, mostly where walls stood."""
    # Sums of 3 x 3 random numbers vary smoothly enough to form heaps.
    size = len(building)
    strewn = (rng.bits(size * size) % np.uint64(1 << 20)).astype(np.int64).reshape(size, size)
    near_walls = ~free_windows(np.pad(building, 1, constant_values=True), 3, 3)[:size, :size]
    heaped = np.pad(strewn, 1, mode="edge")
    heaped = heaped[:, :-2] + heaped[:, 1:-1] + heaped[:, 2:]
    heaped = heaped[:-2] + heaped[1:-1] + heaped[2:]
    return _largest(np.where(near_walls, _NEAR_WALLS, 2) * heaped, ruined, share)


def _bury(heaps: Bools, ends: _Ends, pocket: int, side: int) -> None:
    """Enclose the survivor's pocket in debris, in place."""
    row, column = divmod(ends.target, ends.stride)
    shell = pocket + max(1, side // 2)
    for reach, solid in ((shell, True), (pocket, False)):
        rows = slice(max(1, row - reach), min(len(heaps) - 1, row + side + reach))
        columns = slice(max(1, column - reach), min(len(heaps) - 1, column + side + reach))
        heaps[rows, columns] = solid


def _clear(heaps: Bools, standing: Bools, ends: _Ends, side: int) -> None:
    """Clear the path from start to survivor that goes through the least debris, in place."""
    passable = free_windows(standing, side, side)
    free = free_windows(standing | heaps, side, side)
    hard = np.where(free, 1, np.where(passable, _DIGGING, 0)).astype(np.uint8)
    owner = np.full(hard.size, -1, dtype=np.int32)
    owner[ends.target] = 0
    for place in dig_from(owner, hard).way_back(ends.start):
        row, column = divmod(place, ends.stride)
        heaps[row : row + side, column : column + side] = False
