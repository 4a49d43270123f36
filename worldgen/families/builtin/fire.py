"""Fire over another family's world: cells burn, fall shut, and walls burn open."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.blaze import (
    FIREBREAK,
    Plan,
    Times,
    burn_over,
    burn_walls,
    delay,
    hold_back,
    ignite,
    in_turn,
    leaves_a_way,
    weak_walls,
)
from worldgen.families.parts.ground import lay_ground
from worldgen.families.parts.layout import (
    CHOSEN,
    Arena,
    CellSize,
    Margin,
    RobotRadius,
    RobotSpeed,
    Share,
    Size,
    without_effect,
)
from worldgen.family import Bounds, family
from worldgen.random_streams import RandomStream
from worldgen.timeline import CellState, Timeline
from worldgen.world import World

__all__ = ["fire"]

WALL_FACTOR = 5  # a wall catches so many times slower than the floor
DRAWN = "drawn"
LOAD_PITCH = 6  # cells from one place of heavy fuel to the next


@family("fire", version=1, changes=True)
def fire(
    rng: RandomStream,
    *,
    size: Size = 30,
    over: str = "maze",
    ignitions: Annotated[int, Bounds(1, 100)] = 2,
    ignite_at: Literal["mixed", "way", "anywhere", "rim"] = "mixed",
    ignite_cells: str = DRAWN,
    apart: Annotated[float, Bounds(0.0, 600.0, "s")] = 0.0,
    spread: Annotated[float, Bounds(0.01, 60.0, "s")] = 0.15,
    scatter: Annotated[float, Bounds(0.0, 0.9)] = 0.5,
    wind: Annotated[float, Bounds(0.0, 0.9)] = 0.0,
    wind_to: Annotated[int, Bounds(0, 3, "quarter turns", chosen=CHOSEN)] = CHOSEN,
    fuel: Share = 1.0,
    grain: Annotated[int, Bounds(1, 1000, "cells")] = 3,
    burn: Annotated[float, Bounds(0.01, 600.0, "s")] = 2.0,
    uneven: Annotated[float, Bounds(0.0, 0.9)] = 0.0,
    spread_cells: Annotated[int, Bounds(1, 100_000, "cells")] = 300,
    debris: Share = 0.2,
    clear: Annotated[float, Bounds(0.0, 600.0, "s")] = 0.0,
    burn_through: Annotated[int, Bounds(0, 1000)] = 3,
    monotone: bool = False,
    margin: Margin = 0.0,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """A world of another family in which fire breaks out on the way to the target.

    What is true when the robot sets out is not true when it arrives: ways burn, fall shut behind
    the fire, and open where walls burn through. The floor round the start never burns, so that the
    robot can wait.

    Args:
        rng: The only source of chance; equal state, equal world.
        size: Cells a side, the solid border included.
        over: Family whose world burns, with its own parameters: maze, rooms,
            maze+algorithm=eller+passage=3. Words that are not given are drawn.
        ignitions: Places where fire breaks out.
        ignite_at: Where: on the shortest way, anywhere, at the rim, or the first on the way and the
            others anywhere.
        ignite_cells: Cells where fire breaks out: drawn as the two above say, or given, such as
            12:5,20:7.
        apart: Mean time from one fire to the next, s; 0: all break out at time 0.
        spread: Mean time that fire takes from one cell of floor to the next, s.
        scatter: Share by which times differ from their means.
        wind: Share by which fire goes faster with the wind and slower against it.
        wind_to: Where the wind blows to: quarter turns counter-clockwise from +x; if omitted,
            drawn.
        fuel: Share of the floor that has fuel; the rest never burns.
        grain: Cells across a patch without fuel; 1: single cells.
        burn: Mean time that a cell burns, s.
        uneven: Share by which that mean differs from place to place.
        spread_cells: Cells of floor that burn at most.
        debris: Share of the burnt floor, off one way to the target, that falls shut when it is
            burnt out.
        clear: Mean time after which debris is cleared, s; 0: never.
        burn_through: Places where a wall burns away and opens a passage, if fire gets near so many.
        monotone: Nothing ever opens: all that burns falls shut for good, and no wall burns through.
        margin: The robot may set out on its witness up to this much later and still arrive, s.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or there is no such ground.

    Source: fire spreads as in first-passage percolation: Hammersley and Welsh, "First-passage
        percolation,
    subadditive processes, stochastic networks, and generalized renewal theory", 1965.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    if wind == 0.0:
        without_effect("wind_to", wind_to, "wind=0")
    if monotone and clear > 0.0:
        raise InvalidParameter(
            "conflict",
            "clear={clear:g} s opens what fell shut, and monotone lets nothing open",
            "leave one out",
            clear=clear,
        )

    ground = lay_ground(rng.child("ground"), over, arena)
    plan = Plan.of(ground).with_fuel(rng.child("fuel"), fuel, grain)
    if ignite_cells != DRAWN:
        embers = in_turn(rng.child("apart"), _cells(ignite_cells, plan), apart, scatter)
    else:
        embers = ignite(rng.child("ignite"), plan, ignitions, ignite_at, apart, scatter)
    floor = _spread(
        rng,
        plan,
        embers,
        spread,
        scatter,
        wind,
        wind_to,
        spread_cells,
        margin if monotone else None,
    )
    slots = weak_walls(rng.child("walls"), plan, floor, 0 if monotone else burn_through)
    walls = burn_walls(rng.child("wall-times"), plan, floor, slots, WALL_FACTOR * spread)
    closing = set(floor) if monotone else _debris(rng.child("debris"), plan, floor, walls, debris)
    lasts = _lasts(rng, plan, floor | walls, burn, uneven, scatter)
    return replace(
        ground, timeline=_timeline(rng.child("clear"), plan, floor | walls, lasts, closing, clear)
    )


def _cells(text: str, plan: Plan) -> list[int]:
    """Flat cells of ``ix:iy,ix:iy``."""
    height, width = plan.walls.shape
    cells = []
    for part in text.split(","):
        column, _, row = part.strip().partition(":")
        if not (column.isdecimal() and row.isdecimal()):
            raise InvalidParameter(
                "wrong-form",
                "ignite_cells={text!r}: {part!r} is no cell",
                "write IX:IY,IX:IY, such as 12:5,20:7",
                text=text,
                part=part,
            )
        ix = int(column[:9])
        iy = int(row[:9])
        if not (ix < width and iy < height):
            raise InvalidParameter(
                "outside-grid",
                "ignite_cells: cell {cell} is outside the {width} x {height} cells",
                cell=part.strip(),
                width=width,
                height=height,
            )
        cell = iy * width + ix
        if not plan.flammable[cell]:
            what = (
                "a wall"
                if plan.walls[iy, ix]
                else f"within {FIREBREAK} cells of the robot, or without fuel"
            )
            raise InvalidParameter(
                "cannot-burn",
                "ignite_cells: cell {cell} is {what}",
                "give one of floor that can burn",
                cell=part.strip(),
                what=what,
            )
        cells.append(cell)
    return cells


def _spread(
    rng: RandomStream,
    plan: Plan,
    embers: Times,
    spread: float,
    scatter: float,
    wind: float,
    wind_to: int,
    limit: int,
    race: float | None,
) -> Times:
    """When each cell of floor catches.

    ``race`` is the margin of a robot that must get by, if nothing ever opens.
    """
    factors = [1.0, 1.0, 1.0, 1.0]
    if wind > 0.0:
        to = rng.child("wind").below(4) if wind_to == CHOSEN else wind_to
        factors[to] = 1.0 - wind
        factors[(to + 2) % 4] = 1.0 + wind
    given = (factors[0], factors[1], factors[2], factors[3])

    def spread_over(held: Times | None) -> Times:
        stream = rng.child("floor")
        return burn_over(
            stream,
            plan,
            embers,
            plan.burns,
            spread,
            limit,
            scatter=scatter,
            factors=given,
            held=held,
        )

    floor = spread_over(None)
    if race is None or leaves_a_way(plan, floor, race):
        return floor
    return spread_over(hold_back(plan, embers, race))


def _debris(rng: RandomStream, plan: Plan, floor: Times, walls: Times, share: float) -> set[int]:
    """Cells that fall shut: a share of the burnt floor off a shortest way over what is open in the end."""
    kept = plan.kept(plan.way(walls))
    return {cell for cell in floor if cell not in kept and rng.random() < share}


def _lasts(
    rng: RandomStream, plan: Plan, burning: Times, mean: float, uneven: float, scatter: float
) -> list[int]:
    """How long each cell burns, ms."""
    stream = rng.child("burn")
    if uneven == 0.0:
        return [delay(stream, mean, scatter) for _ in burning]
    heights = plan.noise(rng.child("load"), LOAD_PITCH)
    low = int(heights.min())
    high = int(heights.max())
    spare = max(1, high - low)
    means = (
        mean * (1.0 + uneven * (2 * (int(heights[cell]) - low) / spare - 1.0)) for cell in burning
    )
    return [delay(stream, each, scatter) for each in means]


def _timeline(
    rng: RandomStream, plan: Plan, burning: Times, lasts: list[int], closing: set[int], clear: float
) -> Timeline:
    """Every cell burns, then is free, or solid if it falls shut, until that is cleared.

    By time, then by place.
    """
    shut = [cell for cell in burning if cell in closing] if clear > 0.0 else []
    cells = np.array([*burning, *burning, *shut], dtype=np.int64)
    caught = np.array([*burning.values()], dtype=np.int64)
    out = caught + np.array(lasts, dtype=np.int64)
    after = [CellState.SOLID if cell in closing else CellState.FREE for cell in burning]
    fell = dict(zip(burning, out.tolist(), strict=True))
    cleared = np.array([fell[cell] + delay(rng, clear) for cell in shut], dtype=np.int64)
    times = np.concatenate([caught, out, cleared])
    states = np.array(
        [CellState.BURNING] * len(burning) + after + [CellState.FREE] * len(shut), dtype=np.uint8
    )
    order = np.lexsort((cells, times))
    iy, ix = np.divmod(cells[order], plan.stride)
    return Timeline(times=times[order] / 1000.0, ix=ix, iy=iy, states=states[order])
