"""How fire goes over a ground: where it breaks out, when each cell catches.

It ways it has to leave open.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.families.parts.noise import smooth_noise
from worldgen.lattice import exact, in_cells, radius_in_cells
from worldgen.random_streams import RandomStream
from worldgen.support.grid_search import free_windows, shortest_path, window_at
from worldgen.world import World

__all__ = [
    "FIREBREAK",
    "NEVER",
    "Plan",
    "Times",
    "burn_over",
    "burn_walls",
    "delay",
    "hold_back",
    "ignite",
    "in_turn",
    "leaves_a_way",
    "weak_walls",
]

FIREBREAK = 2  # cells round the robot at its start that never burn: there it can wait
THICKEST = 6  # cells of wall that fire eats through
# Cells farther from the border than the floor nearest to it, up to which floor counts as the rim.
RIM = 2
SLACK = 4  # cells that the robot may be behind a square as wide as it that goes from cell to cell

NEVER = 2**60  # ms
Times: TypeAlias = dict[int, int]  # flat cell: ms


@dataclass(frozen=True)
class Plan:
    """The ground as flat cells.

    Args:
        walls: (height, width) bool; the rim counts as solid, whatever the ground says.
        side: Cells of the narrowest passage, and of the square that stands for the robot.
        flammable: Cells of floor that can burn.
        start: Window at the start.
        goal: Window at the target.
        step: ms in which the robot goes one cell, rounded up.
    """

    walls: npt.NDArray[np.bool_]
    side: int
    flammable: npt.NDArray[np.bool_]
    start: int
    goal: int
    step: int

    @classmethod
    def of(cls, ground: World) -> Plan:
        """Takes a ground apart."""
        walls = ground.walls.copy()
        walls[[0, -1]] = walls[:, [0, -1]] = True
        radius = radius_in_cells(ground)
        side = max(1, math.ceil(2 * radius))
        x = ground.start.x / ground.cell_size
        y = ground.start.y / ground.cell_size
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
        """Cells a row."""
        return int(self.walls.shape[1])

    def with_fuel(self, rng: RandomStream, share: float, grain: int) -> Plan:
        """The plan with fuel on a share of the floor alone, the rest in patches of ``grain`` cells or so."""
        if share == 1.0:
            return self
        floor = np.flatnonzero(self.flammable)
        heights = self.noise(rng, grain)[floor]
        kept = floor[np.argsort(heights, kind="stable")[len(floor) - round(share * len(floor)) :]]
        flammable = np.zeros_like(self.flammable)
        flammable[kept] = True
        return replace(self, flammable=flammable)

    def noise(self, rng: RandomStream, pitch: int) -> npt.NDArray[np.int64]:
        """Smooth heights of all cells, flat."""
        height, width = self.walls.shape
        return smooth_noise(rng, max(height, width), pitch)[:height, :width].ravel()

    def way(self, opened: Iterable[int] = (), shut: Iterable[int] = ()) -> list[int]:
        """Windows of a shortest way from start to target, some cells opened, some shut."""
        walls = self.walls.copy()
        walls.ravel()[list(opened)] = False
        walls.ravel()[list(shut)] = True
        return shortest_path(free_windows(walls, self.side, self.side), self.start, self.goal)

    def kept(self, way: Iterable[int]) -> set[int]:
        """Cells of the windows of a way, and of those round the target.

        It may lie between two.
        """
        goal = self.goal
        round_target = (goal + 1, goal + self.stride, goal + self.stride + 1)
        return {cell for first in (*way, *round_target) for cell in self.window(first)}

    def burns(self, cell: int) -> bool:
        """Whether the cell is floor that can burn."""
        return bool(self.flammable[cell])

    def neighbours(self, cell: int) -> tuple[int, int, int, int]:
        """The four cells beside a cell that is not on the rim, by quarter turns from +x."""
        return cell + 1, cell + self.stride, cell - 1, cell - self.stride

    def window(self, first: int) -> list[int]:
        """Cells of the window at ``first`` that lie in the grid."""
        cells = [
            first + dy * self.stride + dx for dy in range(self.side) for dx in range(self.side)
        ]
        return [cell for cell in cells if cell < self.walls.size]


def _window(walls: npt.NDArray[np.bool_], side: int, x: float, y: float, ground: World) -> int:
    """The free window nearest to a place in m: the one round it, where start and target stand on halves of cells."""
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
    """A time in ms that differs from the mean, in s, by up to ``scatter`` of it; at least 1."""
    return max(
        1, rng.between(round(1000 * (1 - scatter) * mean), round(1000 * (1 + scatter) * mean))
    )


def ignite(
    rng: RandomStream, plan: Plan, count: int, place: str, apart: float, scatter: float
) -> Times:
    """Cells where fire breaks out, and when, as the word ``place`` has it.

    Args:
        rng: The only source of chance.
        plan: The ground.
        count: How many.
        place: ``way``: in the middle part of the shortest way; ``rim``: near the border;
            ``anywhere``; ``mixed``: the first on the way, the others anywhere.
        apart: Mean time from one to the next, s.
        scatter: Share by which that differs.
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
    """When each of some fires breaks out: the first at time 0, each other a while after the one before."""
    times: Times = {}
    now = 0
    for cell in embers:
        times.setdefault(cell, now)
        if apart:
            now += delay(rng, apart, scatter)
    return times


def _rim(plan: Plan, cells: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
    """Those of the cells that are nearest to the border, or hardly farther."""
    iy, ix = np.divmod(cells, plan.stride)
    height, width = plan.walls.shape
    depth = np.minimum(np.minimum(ix, width - 1 - ix), np.minimum(iy, height - 1 - iy))
    return cells[depth <= int(depth.min()) + RIM] if len(cells) else cells


def burn_over(
    rng: RandomStream,
    plan: Plan,
    embers: Times,
    can_burn: Callable[[int], bool],
    mean: float,
    limit: int,
    *,
    scatter: float = 0.5,
    factors: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0),
    held: Mapping[int, int] | None = None,
    settled: bool = False,
) -> Times:
    """When each cell catches, for the earliest ``limit`` of them: Dijkstra's algorithm over random delays.

    A cell's delay is its own, whatever side the fire comes from; wind makes it longer or shorter.

    Args:
        rng: The only source of chance.
        plan: The ground.
        embers: Where and when fire breaks out, ms.
        can_burn: Whether a cell can.
        mean: Of the delays, s.
        limit: Cells at most.
        scatter: Share by which delays differ from the mean.
        factors: Of the delay of fire that goes to +x, +y, -x, -y.
        held: Cells that catch no earlier than at some time, ms.
        settled: Whether embers catch at their own time, even if fire gets there earlier.
    """
    held = held or {}
    burning: Times = {}
    best = {cell: max(time, held.get(cell, 0)) for cell, time in embers.items()}
    front = [(time, cell) for cell, time in best.items()]
    heapq.heapify(front)
    own: Times = {}
    while front and len(burning) < limit:
        time, cell = heapq.heappop(front)
        if cell in burning:
            continue
        burning[cell] = time
        for there, factor in zip(plan.neighbours(cell), factors, strict=True):
            known = best.get(there, NEVER)
            if known <= time or (settled and there in embers) or not can_burn(there):
                continue
            if there not in own:
                own[there] = delay(rng, mean, scatter)
            takes = own[there] if factor == 1.0 else max(1, round(own[there] * factor))
            catches = max(time + takes, held.get(there, 0))
            if catches < known:
                best[there] = catches
                heapq.heappush(front, (catches, there))
    return burning


def weak_walls(rng: RandomStream, plan: Plan, floor: Times, count: int) -> set[int]:
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
        yield [
            first + i * strides[0] + j * strides[1] for i in range(thickness) for j in range(side)
        ]


def burn_walls(rng: RandomStream, plan: Plan, floor: Times, slots: set[int], mean: float) -> Times:
    """When the cells of the slots catch from the floor beside them, and from each other."""
    embers = {
        cell: min(floor[there] for there in plan.neighbours(cell) if there in floor)
        + delay(rng, mean)
        for cell in sorted(slots)
        if any(there in floor for there in plan.neighbours(cell))
    }
    return burn_over(rng, plan, embers, slots.__contains__, mean, len(slots), settled=True)


def leaves_a_way(plan: Plan, floor: Times, margin: float) -> bool:
    """Whether a square as wide as the robot, ``margin`` seconds late, gets to the target ahead of the fire.

    What burns stays shut for ever here, so to be earlier is never worse, and a breadth-first search
    decides.
    """
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
    late = math.ceil(1000 * exact(margin)) + SLACK * plan.step
    latest = np.where(
        free_windows(plan.walls, plan.side, plan.side), (first - late) // plan.step, -1
    ).ravel()
    number: list[int] = latest.tolist()  # of steps after which the window is still free
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
    """When, at the earliest, the cells of one way may catch if a robot ``margin`` seconds late is to get by.

    It is the shortest way round the places where fire breaks out, or through them if there is none
    round.
    """
    way = plan.way(shut=embers) or plan.way()
    late = math.ceil(1000 * exact(margin))
    held = dict.fromkeys(plan.kept([]), late + (len(way) + 2 * SLACK) * plan.step)
    for number, first in enumerate(way):
        for cell in plan.window(first):
            held[cell] = max(held.get(cell, 0), late + (number + 2 * SLACK) * plan.step)
    return held
