"""Apply the thesis's world shifter to another family's world: mirrored cells change places."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.ground import lay_ground
from worldgen.families.parts.layout import (
    Arena,
    CellSize,
    Margin,
    RobotRadius,
    RobotSpeed,
    Share,
    Size,
)
from worldgen.family import Bounds, family
from worldgen.lattice import exact, in_cells
from worldgen.random_streams import RandomStream
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import World


@family("shift", version=1, changes=True)
def shift(
    rng: RandomStream,
    *,
    size: Size = 30,
    over: str = "trap",
    interval: Annotated[float, Bounds(0.01, 60.0, "s")] = 0.5,
    chance: Share = 0.1,
    speedup: Annotated[float, Bounds(1.0, 100.0)] = 1.0,
    duration: Annotated[float, Bounds(0.0, 600.0, "s")] = 60.0,
    margin: Margin = 0.0,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build a world of another family in which cells change places over time.

    This follows the thesis's world shifter. Repeatedly, with some probability, a random cell of the
    whole square is swapped with its mirror image in the diagonal from the upper left to the lower
    right: a wall moves from one side of it to the other. Swapping two equal cells changes nothing.
    The thesis's program also moves the target and every cell's signal. Here only walls move, no
    cell that the target overlaps is swapped, and the first draw comes after one interval, not
    immediately.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        over: Family whose world moves, with its own parameters: trap, rooms, trap+shape=U+depth=9.
            Choices that are not given are drawn.
        interval: Time between two draws, s.
        chance: Fraction of the draws that swap two cells.
        speedup: Factor by which the rate of draws and ``chance`` (at most 1) are larger at
            ``duration`` than at the start; both rise linearly in between.
        duration: Time after which nothing changes, s.
        margin: Delay, s, up to which the robot may start late and still arrive along its witness.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range.

    Source: the thesis's listing, ``simGuiExp.worldShifter``, called every 500 ms, one chance in
        ten.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)

    ground = lay_ground(rng.child("ground"), over, arena)
    if ground.width != ground.height:
        raise InvalidParameter(
            "not-square",
            "over={over}: {width} x {height} cells have no mirror image",
            "use a square ground",
            over=over,
            width=ground.width,
            height=ground.height,
        )
    pace = _Pace(interval, chance, duration, speedup)
    return replace(ground, timeline=_swaps(rng.child("swaps"), ground, pace))


def shifted(
    world: World,
    seed: int,
    *,
    interval: float = 0.5,
    chance: float = 0.1,
    duration: float = 600.0,
    speedup: float = 1.0,
) -> World:
    """Build a world in which cells change places over time, as in :func:`shift`.

    The result has no certificate, even if the given world had one.

    Args:
        world: A square world without changes.
        seed: Seed of the swaps.
        interval: Time between two draws, s.
        chance: Share of the draws that swap two cells.
        duration: Time after which nothing changes, s.
        speedup: As for :func:`shift`.

    Raises:
        InvalidParameter: If the world is not square or already changes, or if no swap happens.
    """
    if world.width != world.height:
        raise InvalidParameter(
            "not-square",
            "{width} x {height} cells have no mirror image; only in a square world can walls "
            "change places",
            width=world.width,
            height=world.height,
        )
    if world.is_dynamic:
        raise InvalidParameter(
            "world-changes",
            "the world already changes",
            "clear its changes, or use a world that does not change",
        )
    pace = _Pace(interval, chance, duration, speedup)
    swaps = _swaps(RandomStream(seed).child("swaps"), world, pace)
    if len(swaps) == 0:
        raise InvalidParameter(
            "no-room",
            "no wall has a free mirror image in {duration:g} s",
            "draw walls off the diagonal, or use another seed",
            duration=duration,
        )
    return replace(world.bare, timeline=swaps)


@dataclass(frozen=True)
class _Pace:
    """The times of the draws, and the share of them that swap.

    Args:
        interval: Time between two draws at the start, s.
        chance: Share of the draws that swap, at the start.
        duration: Time of the last draw, s.
        speedup: Rate and share at the end, as multiples of those at the start.
    """

    interval: float
    chance: float
    duration: float
    speedup: float

    @property
    def draws(self) -> int:
        """Return the number of draws: the rate's integral over the duration."""
        mean = (1 + exact(self.speedup)) / 2
        return math.floor(mean * exact(self.duration) / exact(self.interval))

    def time(self, draw: int) -> float:
        """Return the time, s, of a draw counted from 1: when the rate's integral reaches it."""
        gain = self.speedup - 1.0
        if gain == 0.0:
            return float(draw * exact(self.interval))
        rounds = draw * self.interval / self.duration
        root = math.sqrt(1.0 + 2.0 * gain * rounds)
        return round(min(self.duration * (root - 1.0) / gain, self.duration), 6)

    def share(self, time: float) -> float:
        """Return the share of draws that swap at a time."""
        if self.speedup == 1.0:
            return self.chance
        return min(1.0, self.chance * (1.0 + (self.speedup - 1.0) * time / self.duration))


def _swaps(rng: RandomStream, ground: World, pace: _Pace) -> Timeline:
    """Draw the swaps, and return two changes for each swap of a wall and a free cell."""
    walls = ground.walls.copy()
    last = ground.height - 1
    kept = _target_cells(ground)
    events: list[Event] = []
    for draw in range(1, pace.draws + 1):
        time = pace.time(draw)
        if rng.random() >= pace.share(time):
            continue
        # Count the row from the top, as the thesis does.
        column = rng.below(ground.width)
        row = rng.below(ground.height)
        here = (last - row, column)
        there = (last - column, row)
        # Swapping equal cells changes nothing, and the target must stay free.
        if walls[here] == walls[there] or here in kept or there in kept:
            continue
        walls[here], walls[there] = walls[there], walls[here]
        for iy, ix in sorted((here, there)):
            events.append(Event(time, ix, iy, CellState.SOLID if walls[iy, ix] else CellState.FREE))
    return Timeline.of(events)


def _target_cells(ground: World) -> set[tuple[int, int]]:
    """Return the cells, as (row, column), that overlap the inside of the target's disc."""
    x, y, radius = (
        float(in_cells(value, ground.cell_size))
        for value in (ground.target.x, ground.target.y, ground.target.radius)
    )
    index = np.arange(ground.width)
    dx = np.maximum(np.maximum(index - x, x - index - 1), 0.0)
    dy = np.maximum(np.maximum(index - y, y - index - 1), 0.0)
    rows, columns = np.nonzero(dx[np.newaxis, :] ** 2 + dy[:, np.newaxis] ** 2 < radius * radius)
    return set(zip(rows.tolist(), columns.tolist(), strict=True))
