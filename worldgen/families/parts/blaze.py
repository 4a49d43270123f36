"""Spread fire over a ground: where it breaks out, and when each cell catches.

Also decide whether the fire leaves a path open, and hold it back from one if it does not.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from worldgen.families.parts.noise import smooth_noise
from worldgen.lattice import exact, in_cells, radius_in_cells
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import free_windows, shortest_path, window_at
from worldgen.support.arrays import Bools, Indices, Ints
from worldgen.world import World

# Cells around the robot's start that never burn, so that it can wait there.
FIREBREAK = 2
# Thickest wall, in cells, that fire can burn through.
THICKEST = 6
# Floor counts as the rim if it is at most this many cells farther from the border than the floor
# that is nearest to it.
RIM = 2
# Cells by which the robot may lag behind a square of its width that moves from cell to cell.
SLACK = 4

NEVER = 2**60  # ms
Times: TypeAlias = dict[int, int]  # flat cell: ms


@dataclass(frozen=True)
class Plan:
    """Describe the ground by flat cell indices.

    A window is a square of ``side`` cells that represents the robot; its index is its first cell.

    Args:
        walls: (height, width) bool; the rim is always solid, whatever the ground has there.
        side: Side of a window, which is the width of the narrowest passage, cells.
        flammable: (height * width,) bool, floor that can burn.
        start: Window at the start.
        goal: Window at the target.
        step: Time in which the robot moves by one cell, ms, rounded up.
    """

    walls: Bools
    side: int
    flammable: Bools
    start: int
    goal: int
    step: int

    @classmethod
    def of(cls, ground: World) -> Plan:
        """Create a plan of a ground."""
        # The rim is solid, so that every other cell has four neighbours.
        walls = ground.walls.copy()
        walls[[0, -1]] = walls[:, [0, -1]] = True
        radius = radius_in_cells(ground)
        side = max(1, math.ceil(2 * radius))
        x = ground.start.x / ground.cell_size
        y = ground.start.y / ground.cell_size

        # Keep the cells around the start from burning.
        reach = float(radius) + FIREBREAK
        dx, dy = (
            np.maximum(np.maximum(index - centre, centre - index - 1), 0.0)
            for index, centre in ((np.arange(ground.width), x), (np.arange(ground.height), y))
        )
        near = dx[np.newaxis, :] ** 2 + dy[:, np.newaxis] ** 2 < reach * reach
        start = _window(walls, side, ground.start.x, ground.start.y, ground)
        goal = _window(walls, side, ground.target.x, ground.target.y, ground)
        step = math.ceil(1000 * in_cells(ground.cell_size, ground.robot_speed))
        return cls(walls, side, (~walls & ~near).ravel(), start, goal, step)

    @property
    def stride(self) -> int:
        """Return the number of cells per row."""
        return int(self.walls.shape[1])

    def with_fuel(self, rng: RandomStream, share: float, grain: int) -> Plan:
        """Return a plan with fuel on only a share of the floor.

        Floor without fuel forms patches about ``grain`` cells wide.
        """
        if share == 1.0:
            return self
        floor = np.flatnonzero(self.flammable)
        heights = self.noise(rng, grain)[floor]
        kept = floor[np.argsort(heights, kind="stable")[len(floor) - round(share * len(floor)) :]]
        flammable = np.zeros_like(self.flammable)
        flammable[kept] = True
        return replace(self, flammable=flammable)

    def noise(self, rng: RandomStream, pitch: int) -> Ints:
        """Return smooth random heights of all cells, flat."""
        height, width = self.walls.shape
        return smooth_noise(rng, max(height, width), pitch)[:height, :width].ravel()

    def way(self, opened: Iterable[int] = (), shut: Iterable[int] = ()) -> list[int]:
        """Return the windows of a shortest path from start to target.

        Args:
            opened: Solid cells to treat as free.
            shut: Free cells to treat as solid.
        """
        walls = self.walls.copy()
        walls.ravel()[list(opened)] = False
        walls.ravel()[list(shut)] = True
        return shortest_path(free_windows(walls, self.side, self.side), self.start, self.goal)

    def kept(self, way: Iterable[int]) -> set[int]:
        """Return the cells of a path's windows, and of the windows around the target.

        The target may be between two windows, so the goal's window alone is not enough.
        """
        goal = self.goal
        round_target = (goal + 1, goal + self.stride, goal + self.stride + 1)
        return {cell for first in (*way, *round_target) for cell in self.window(first)}

    def burns(self, cell: int) -> bool:
        """Return True if the cell is floor that can burn."""
        return bool(self.flammable[cell])

    def neighbours(self, cell: int) -> tuple[int, int, int, int]:
        """Return a cell's four neighbours, counter-clockwise from +x.

        The cell must not be on the rim, whose flat neighbours may be in another row.
        """
        return cell + 1, cell + self.stride, cell - 1, cell - self.stride

    def window(self, first: int) -> list[int]:
        """Return the cells of the window at ``first`` that are inside the grid."""
        cells = [
            first + dy * self.stride + dx for dy in range(self.side) for dx in range(self.side)
        ]
        return [cell for cell in cells if cell < self.walls.size]


def _window(walls: Bools, side: int, x: float, y: float, ground: World) -> int:
    """Return a free window around a place, or next to it.

    Args:
        walls: (height, width) bool.
        side: Cells per side of the window.
        x: Metres from the left side.
        y: Metres from the lower side.
        ground: World that the place is in.
    """
    # Rounding may put the window one cell off if the place is not on a half cell, so the windows
    # next to it are candidates too.
    height = ground.height
    width = ground.width
    first = [
        min(max(window_at(round(2 * value / ground.cell_size), side), 0), most)
        for value, most in ((x, max(width - side, 0)), (y, max(height - side, 0)))
    ]
    near = [(first[0] + dx, first[1] + dy) for dx in (0, -1, 1) for dy in (0, -1, 1)]
    for ix, iy in near:
        inside = 0 <= ix <= width - side and 0 <= iy <= height - side
        if inside and not walls[iy : iy + side, ix : ix + side].any():
            return iy * width + ix
    return first[1] * width + first[0]


def delay(rng: RandomStream, mean: float, scatter: float = 0.5) -> int:
    """Draw a time in ms, at least 1.

    Args:
        rng: The only source of randomness.
        mean: Mean time, s.
        scatter: Largest difference from the mean, as a fraction of it.
    """
    return max(
        1, rng.between(round(1000 * (1 - scatter) * mean), round(1000 * (1 + scatter) * mean))
    )


def ignite(
    rng: RandomStream, plan: Plan, count: int, place: str, apart: float, scatter: float
) -> Times:
    """Draw the cells where fire breaks out, and the times.

    Args:
        rng: The only source of randomness.
        plan: The ground.
        count: Number of fires.
        place: ``way`` is the middle part of a shortest path, ``rim`` is near the border,
            ``anywhere`` is any floor that burns, and ``mixed`` puts the first fire on the path and
            the others anywhere.
        apart: Mean time between two fires, s.
        scatter: Largest difference from that mean, as a share of it.
    """
    way = plan.way()
    middle = way[len(way) // 3 : 1 + 3 * len(way) // 4]
    on_way = [cell for first in middle for cell in plan.window(first) if plan.flammable[cell]]
    anywhere = np.flatnonzero(plan.flammable)
    rim = _rim(plan, anywhere) if place == "rim" else anywhere
    embers: list[int] = []
    while len(embers) < count and len(anywhere):
        if on_way and (place == "way" or (place == "mixed" and not embers)):
            embers.append(rng.choice(on_way))
        else:
            embers.append(int(rim[rng.below(len(rim))]))
    return in_turn(rng.child("apart"), embers, apart, scatter)


def in_turn(rng: RandomStream, embers: list[int], apart: float, scatter: float) -> Times:
    """Draw when each fire breaks out: the first at time 0, every other some time after the last.

    Args:
        rng: The only source of randomness.
        embers: Cells of the fires, in order.
        apart: Mean time between two fires, s; with 0, all begin together.
        scatter: Largest difference from that mean, as a share of it.
    """
    times: Times = {}
    now = 0
    for cell in embers:
        times.setdefault(cell, now)
        if apart:
            now += delay(rng, apart, scatter)
    return times


def _rim(plan: Plan, cells: Indices) -> Indices:
    """Return the cells nearest to the border, or at most ``RIM`` cells farther from it."""
    iy, ix = np.divmod(cells, plan.stride)
    height, width = plan.walls.shape
    depth = np.minimum(np.minimum(ix, width - 1 - ix), np.minimum(iy, height - 1 - iy))
    return cells[depth <= int(depth.min()) + RIM] if len(cells) else cells


@dataclass(frozen=True)
class FireDelay:
    """Time that fire takes from one cell to the next.

    Args:
        mean: Mean delay, s.
        scatter: Largest difference of a delay from the mean, as a fraction of it.
        factors: Factors of the delay of fire that moves to +x, +y, -x and -y.
    """

    mean: float
    scatter: float = 0.5
    factors: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)


def burn_over(
    rng: RandomStream,
    plan: Plan,
    embers: Times,
    can_burn: Callable[[int], bool],
    pace: FireDelay,
    limit: int,
    held: Mapping[int, int] | None = None,
) -> Times:
    """Return when each cell catches, for the first ``limit`` cells that do.

    Each cell has one random delay, no matter which side the fire comes from. Wind makes the delay
    longer or shorter.

    Args:
        rng: The only source of randomness.
        plan: The ground.
        embers: Where and when fire breaks out, ms.
        can_burn: Returns True for a cell that fire can spread to.
        pace: Time that fire takes from cell to cell.
        limit: Limit on the cells that catch.
        held: Earliest times at which some cells may catch, ms.

    Source: Dijkstra, "A note on two problems in connexion with graphs", 1959; over random delays.
    """
    # The queue holds (time, cell); ties are broken by cell, so the order never depends on chance.
    held = held or {}
    burning: Times = {}
    best = {cell: max(time, held.get(cell, 0)) for cell, time in embers.items()}
    front = [(time, cell) for cell, time in best.items()]
    heapq.heapify(front)
    own: Times = {}
    while front and len(burning) < limit:
        time, cell = heapq.heappop(front)
        # An older, slower entry of a cell that caught in the meantime.
        if cell in burning:
            continue
        burning[cell] = time

        # Try to spread to each neighbour.
        for there, factor in zip(plan.neighbours(cell), pace.factors, strict=True):
            known = best.get(there, NEVER)
            if known <= time or not can_burn(there):
                continue
            # Draw a cell's delay only when fire first reaches it.
            if there not in own:
                own[there] = delay(rng, pace.mean, pace.scatter)
            takes = own[there] if factor == 1.0 else max(1, round(own[there] * factor))
            catches = max(time + takes, held.get(there, 0))
            if catches < known:
                best[there] = catches
                heapq.heappush(front, (catches, there))
    return burning


def weak_walls(rng: RandomStream, plan: Plan, floor: Times, count: int) -> set[int]:
    """Draw up to ``count`` separate slots through walls next to burning floor; return their cells.

    Args:
        rng: The only source of randomness.
        plan: The ground.
        floor: Times at which floor catches, ms.
        count: Limit on the slots to draw.
    """
    # List every possible slot, through vertical walls and, transposed, through horizontal ones.
    burnt = np.zeros(plan.walls.shape, dtype=np.bool_)
    burnt.ravel()[list(floor)] = True
    slots = [
        slot
        for thickness in range(1, THICKEST + 1)
        for slot in (
            *_slots(plan.walls, burnt, plan.side, thickness, (1, plan.stride)),
            *_slots(plan.walls.T, burnt.T, plan.side, thickness, (plan.stride, 1)),
        )
    ]

    # Take slots in random order, skipping those that touch one already taken.
    chosen: set[int] = set()
    taken: set[int] = set()
    left = count
    for k in np.argsort(rng.bits(len(slots)), kind="stable").tolist():
        if left == 0:
            break
        slot = slots[k]
        if taken.isdisjoint(slot):
            left -= 1
            chosen.update(slot)
            taken.update(slot, *(plan.neighbours(cell) for cell in slot))
    return chosen


def _slots(
    walls: Bools, burnt: Bools, side: int, thickness: int, strides: tuple[int, int]
) -> Iterator[list[int]]:
    """Yield the flat cells of every slot in +x that fire touches.

    A slot is a block of wall between two free squares; without it the robot could pass from one to
    the other.

    Args:
        walls: (rows, columns) bool.
        burnt: (rows, columns) bool.
        side: Side of the squares, and the slot's extent in y, cells.
        thickness: The slot's extent in x, cells.
        strides: Steps between flat cells in x and y.
    """
    reach = side + thickness
    columns = walls.shape[1] - reach
    if columns < 1:
        return

    # Find places with a free square, solid cells to its right, and fire at either end of these.
    free = free_windows(walls, side, side)
    solid = free_windows(~walls, thickness, side)[:, side:][:, :columns]
    touched = ~free_windows(burnt, 1, side)
    near = touched[:, side - 1 :][:, :columns] | touched[:, reach:]
    for y, x in np.argwhere(free[:, :columns] & solid & free[:, reach:] & near).tolist():
        first = (x + side) * strides[0] + y * strides[1]
        yield [
            first + i * strides[0] + j * strides[1] for i in range(thickness) for j in range(side)
        ]


def burn_walls(rng: RandomStream, plan: Plan, floor: Times, slots: set[int], mean: float) -> Times:
    """Return when the slots' cells catch fire from the floor next to them, and from each other."""
    embers = {
        cell: min(floor[there] for there in plan.neighbours(cell) if there in floor)
        + delay(rng, mean)
        for cell in sorted(slots)
        if any(there in floor for there in plan.neighbours(cell))
    }
    # Embers catch fire at their own time, even if the fire reaches them earlier.
    others = slots - embers.keys()
    return burn_over(rng, plan, embers, others.__contains__, FireDelay(mean), len(slots))


def leaves_a_way(plan: Plan, floor: Times, margin: float) -> bool:
    """Return True if a square of the robot's width, ``margin`` seconds late, can outrun the fire.

    Burning cells stay closed forever here, so arriving earlier is never worse, and a breadth-first
    search gives the exact answer.
    """
    # A window closes when the first of its cells catches.
    catches = np.full(plan.walls.shape, NEVER, np.int64)
    catches.ravel()[list(floor)] = list(floor.values())
    rows, columns = plan.walls.shape
    first = np.full(plan.walls.shape, NEVER, np.int64)
    inner = first[: rows - plan.side + 1, : columns - plan.side + 1]
    for dy in range(plan.side):
        for dx in range(plan.side):
            np.minimum(
                inner, catches[dy : dy + inner.shape[0], dx : dx + inner.shape[1]], out=inner
            )

    # Convert closing times to numbers of steps; -1 marks windows that are never free.
    late = math.ceil(1000 * exact(margin)) + SLACK * plan.step
    latest = np.where(
        free_windows(plan.walls, plan.side, plan.side), (first - late) // plan.step, -1
    ).ravel()
    number: list[int] = latest.tolist()

    # Search windows that are still free on arrival. At the goal, the cells around the target must
    # be free too.
    steps = {plan.start: 0}
    queue = deque([plan.start])
    while queue:
        cell = queue.popleft()
        if cell == plan.goal:
            return all(
                catches.flat[there] > late + steps[cell] * plan.step for there in plan.kept([cell])
            )
        for there in plan.neighbours(cell):
            if there not in steps and steps[cell] + 1 < number[there]:
                steps[there] = steps[cell] + 1
                queue.append(there)
    return False


def hold_back(plan: Plan, embers: Iterable[int], margin: float) -> Times:
    """Return the earliest times at which a path's cells may catch, so that the robot still passes.

    The path is a shortest one around the places where fire breaks out, or through them if there is
    no path around.

    Args:
        plan: The ground.
        embers: Cells where fire breaks out.
        margin: Seconds by which the robot may start late.

    Returns:
        Earliest time for each cell of the path, ms.
    """
    way = plan.way(shut=embers) or plan.way()
    late = math.ceil(1000 * exact(margin))
    held = dict.fromkeys(plan.kept([]), late + (len(way) + 2 * SLACK) * plan.step)
    for number, first in enumerate(way):
        for cell in plan.window(first):
            held[cell] = max(held.get(cell, 0), late + (number + 2 * SLACK) * plan.step)
    return held
