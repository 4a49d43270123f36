"""Fire over another family's world: cells burn, fall shut, and walls burn open."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.families._ground import lay_ground
from worldgen.families._layout import Arena
from worldgen.families._routes import free_windows, shortest_way, window_at
from worldgen.family import check_between, family
from worldgen.random_streams import RandomStream
from worldgen.timeline import CellState, Timeline
from worldgen.world import World

__all__ = ["fire"]

FIREBREAK = 2  # cells round the robot at its start that never burn: there it can wait
THICKEST = 6  # cells of wall that fire eats through
WALL_FACTOR = 5  # a wall catches so many times slower than the floor

Times: TypeAlias = dict[int, int]  # flat cell: ms


@family("fire", version=1)
def fire(
    rng: RandomStream,
    *,
    size: int = 30,
    over: Literal["maze", "corridor", "trap"] = "maze",
    ignitions: int = 2,
    spread: float = 0.15,
    burn: float = 2.0,
    spread_cells: int = 300,
    debris: float = 0.2,
    burn_through: int = 3,
    cell_size: float = 0.1,
    robot_radius: float = 0.07,
    robot_speed: float = 2.0,
) -> World:
    """A maze, corridor or trap in which fire breaks out on the way to the target.

    What is true when the robot sets out is not true when it arrives: ways burn, fall shut behind the fire,
    and open where walls burn through. The floor round the start never burns, so that the robot can wait.

    Args:
        rng: The only source of chance; equal state, equal world.
        size: Cells a side, the solid border included; 10 to 2000.
        over: Family whose world burns; its shape is drawn.
        ignitions: Places where fire breaks out at time 0, the first on the shortest way to the target.
        spread: Mean time that fire takes from one cell of floor to the next, s.
        burn: Mean time that a cell burns, s.
        spread_cells: Cells of floor that burn at most.
        debris: Share of the burnt floor, off one way to the target, that falls shut when it is burnt out.
        burn_through: Places where a wall burns away and opens a passage, if fire gets near so many.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range.

    Source: fire spreads as in first-passage percolation: Hammersley and Welsh, "First-passage percolation,
    subadditive processes, stochastic networks, and generalized renewal theory", 1965.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    check_between("ignitions", ignitions, 1, 100)
    check_between("spread", spread, 0.01, 60.0, "s")
    check_between("burn", burn, 0.01, 600.0, "s")
    check_between("spread_cells", spread_cells, 1, 100_000, "cells")
    check_between("debris", debris, 0.0, 1.0)
    check_between("burn_through", burn_through, 0, 1000)

    ground = lay_ground(rng.child("ground"), over, arena)
    plan = _Plan.of(arena, ground)
    embers = _ignite(rng.child("ignite"), plan, ignitions)
    floor = _burn(rng.child("floor"), plan, embers, plan.burns, spread, spread_cells)
    slots = _weak_walls(rng.child("walls"), plan, floor, burn_through)
    walls = _burn_walls(rng.child("wall-times"), plan, floor, slots, WALL_FACTOR * spread)
    closing = _debris(rng.child("debris"), plan, floor, walls, debris)
    timeline = _timeline(rng.child("burn"), size, floor | walls, closing, burn)

    return World(
        walls=ground.walls,
        start=ground.start,
        target=ground.target,
        cell_size=cell_size,
        robot_radius=robot_radius,
        robot_speed=robot_speed,
        timeline=timeline,
    )


@dataclass(frozen=True)
class _Plan:
    """The ground as flat cells.

    Args:
        walls: (size, size) bool.
        side: Cells of the narrowest passage, and of the square that stands for the robot.
        flammable: Cells of floor that can burn.
        start: Window at the start.
        goal: Window at the target.
    """

    walls: npt.NDArray[np.bool_]
    side: int
    flammable: npt.NDArray[np.bool_]
    start: int
    goal: int

    @classmethod
    def of(cls, arena: Arena, ground: World) -> _Plan:
        """Takes a ground apart."""
        start, goal = (
            tuple(window_at(round(2 * value / arena.cell_size), arena.narrowest) for value in (point.x, point.y))
            for point in (ground.start, ground.target)
        )
        x, y = ground.start.x / arena.cell_size, ground.start.y / arena.cell_size
        reach = float(arena.radius) + FIREBREAK
        index = np.arange(arena.size)
        dx = np.maximum(np.maximum(index - x, x - index - 1), 0.0)
        dy = np.maximum(np.maximum(index - y, y - index - 1), 0.0)
        near = dx[np.newaxis, :] ** 2 + dy[:, np.newaxis] ** 2 < reach * reach
        return cls(
            walls=ground.walls,
            side=arena.narrowest,
            flammable=(~ground.walls & ~near).ravel(),
            start=start[1] * arena.size + start[0],
            goal=goal[1] * arena.size + goal[0],
        )

    @property
    def stride(self) -> int:
        """Cells a row."""
        return int(self.walls.shape[1])

    def way(self, opened: Iterable[int] = ()) -> list[int]:
        """Windows of a shortest way from start to target, some cells opened."""
        walls = self.walls.copy()
        walls.ravel()[list(opened)] = False
        return shortest_way(free_windows(walls, self.side, self.side), self.start, self.goal)

    def burns(self, cell: int) -> bool:
        """Whether the cell is floor that can burn."""
        return bool(self.flammable[cell])

    def neighbours(self, cell: int) -> tuple[int, int, int, int]:
        """The four cells beside a cell that is not on the rim."""
        return cell + 1, cell + self.stride, cell - 1, cell - self.stride

    def window(self, first: int) -> list[int]:
        """Cells of the window at ``first``."""
        return [first + dy * self.stride + dx for dy in range(self.side) for dx in range(self.side)]


def _ignite(rng: RandomStream, plan: _Plan, ignitions: int) -> Times:
    """Cells that burn at time 0: the first in the middle part of the shortest way, the others anywhere."""
    way = plan.way()
    middle = way[len(way) // 3 : 1 + 3 * len(way) // 4]
    on_way = [cell for first in middle for cell in plan.window(first) if plan.flammable[cell]]
    anywhere = np.flatnonzero(plan.flammable)
    embers = [rng.choice(on_way)] if on_way else []
    while len(embers) < ignitions and len(anywhere):
        embers.append(int(anywhere[rng.below(len(anywhere))]))
    return dict.fromkeys(embers, 0)


def _delay(rng: RandomStream, mean: float) -> int:
    """A time in ms between half and one and a half of the mean, in s; at least 1."""
    return max(1, rng.between(round(500 * mean), round(1500 * mean)))


def _burn(
    rng: RandomStream, plan: _Plan, embers: Times, can_burn: Callable[[int], bool], mean: float, limit: int
) -> Times:
    """When each cell catches, for the earliest ``limit`` of them: Dijkstra's algorithm over random delays.

    A cell's delay is its own, whatever side the fire comes from; so the first neighbour to burn decides.
    """
    burning: Times = {}
    front = [(time, cell) for cell, time in embers.items()]
    heapq.heapify(front)
    caught = set(embers)
    while front and len(burning) < limit:
        time, cell = heapq.heappop(front)
        burning[cell] = time
        for there in plan.neighbours(cell):
            if there not in caught and can_burn(there):
                caught.add(there)
                heapq.heappush(front, (time + _delay(rng, mean), there))
    return burning


def _weak_walls(rng: RandomStream, plan: _Plan, floor: Times, count: int) -> set[int]:
    """Cells of up to ``count`` slots through walls that burning floor touches, apart from each other."""
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
    walls: npt.NDArray[np.bool_],
    burnt: npt.NDArray[np.bool_],
    side: int,
    thickness: int,
    strides: tuple[int, int],
) -> Iterator[list[int]]:
    """Flat cells of every slot, in +x, whose removal joins a free square to another and that fire touches.

    Args:
        walls: (rows, columns) bool.
        burnt: (rows, columns) bool.
        side: Cells of the squares, and of the slot in y.
        thickness: Cells of the slot in x.
        strides: Step between flat cells in x and y.
    """
    reach = side + thickness
    columns = walls.shape[1] - reach
    if columns < 1:
        return
    free = free_windows(walls, side, side)
    solid = free_windows(~walls, thickness, side)[:, side:][:, :columns]
    touched = ~free_windows(burnt, 1, side)
    near = touched[:, side - 1 :][:, :columns] | touched[:, reach:]
    for y, x in np.argwhere(free[:, :columns] & solid & free[:, reach:] & near).tolist():
        first = (x + side) * strides[0] + y * strides[1]
        yield [first + i * strides[0] + j * strides[1] for i in range(thickness) for j in range(side)]


def _burn_walls(rng: RandomStream, plan: _Plan, floor: Times, slots: set[int], mean: float) -> Times:
    """When the cells of the slots catch from the floor beside them, and from each other."""
    embers = {
        cell: min(floor[there] for there in plan.neighbours(cell) if there in floor) + _delay(rng, mean)
        for cell in sorted(slots)
        if any(there in floor for there in plan.neighbours(cell))
    }
    return _burn(rng, plan, embers, slots.__contains__, mean, len(slots))


def _debris(rng: RandomStream, plan: _Plan, floor: Times, walls: Times, share: float) -> set[int]:
    """Cells that fall shut: a share of the burnt floor off a shortest way over what is open in the end."""
    goal = plan.goal
    round_target = (goal + 1, goal + plan.stride, goal + plan.stride + 1)  # it may lie between two windows
    kept = {cell for first in (*plan.way(walls), *round_target) for cell in plan.window(first)}
    return {cell for cell in floor if cell not in kept and rng.random() < share}


def _timeline(rng: RandomStream, size: int, burning: Times, closing: set[int], mean: float) -> Timeline:
    """Every cell burns, then is free, or solid if it falls shut; in order of time, then of place."""
    cells = np.array([*burning, *burning], dtype=np.int64)
    caught = np.array([*burning.values()], dtype=np.int64)
    out = caught + np.array([_delay(rng, mean) for _ in burning], dtype=np.int64)
    after = [CellState.SOLID if cell in closing else CellState.FREE for cell in burning]
    times = np.concatenate([caught, out])
    states = np.array([CellState.BURNING] * len(burning) + after, dtype=np.uint8)
    order = np.lexsort((cells, times))
    iy, ix = np.divmod(cells[order], size)
    return Timeline(times=times[order] / 1000.0, ix=ix, iy=iy, states=states[order])
