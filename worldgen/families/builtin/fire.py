"""Set another family's world on fire: cells burn, debris closes some, and walls burn open."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.blaze import (
    FIREBREAK,
    FireDelay,
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

# Factor by which a wall catches more slowly than the floor.
WALL_FACTOR = 5
DRAWN = "drawn"
# Cells between places of heavy fuel.
LOAD_PITCH = 6


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
    """Build a world of another family in which fire breaks out on the way to the target.

    What the robot knows at the start is no longer true later: paths burn, debris blocks them after
    the fire, and new ones open where walls burn through. The floor around the start never burns, so
    that the robot can wait.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        over: Family whose world burns, with its own parameters: maze, rooms,
            maze+algorithm=eller+passage=3. Choices that are not given are drawn.
        ignitions: Places where fire breaks out.
        ignite_at: Where: on the shortest path, anywhere, at the rim, or the first on the path and
            the others anywhere.
        ignite_cells: Cells where fire breaks out: drawn according to the two parameters above, or
            given, such as 12:5,20:7.
        apart: Mean time from one fire to the next, s; 0: all break out at time 0.
        spread: Mean time that fire takes to spread from one cell of floor to the next, s.
        scatter: Fraction by which times differ from their means.
        wind: Fraction by which fire is faster with the wind and slower against it.
        wind_to: Direction in which the wind blows: quarter turns counter-clockwise from +x; if
            omitted, drawn.
        fuel: Share of the floor that has fuel; the rest never burns.
        grain: Cells across a patch without fuel; 1: single cells.
        burn: Mean time that a cell burns, s.
        uneven: Fraction by which that mean differs from place to place.
        spread_cells: Limit on the cells of floor that burn.
        debris: Share of the burnt floor, except on one path to the target, that debris blocks when
            it has burnt out.
        clear: Mean time after which debris is cleared, s; 0: never.
        burn_through: Places where a wall burns away and opens a passage, if fire gets near that
            many.
        monotone: Nothing ever opens: everything that burns is blocked for good, and no wall burns
            through.
        margin: Delay, s, up to which the robot may start late and still arrive along its witness.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or no world fits ``over``.

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
            "clear={clear:g} s reopens what debris closed, and monotone lets nothing open",
            "leave one out",
            clear=clear,
        )

    # Build the ground, and let fire break out and spread over its floor.
    ground = lay_ground(rng.child("ground"), over, arena)
    plan = Plan.of(ground).with_fuel(rng.child("fuel"), fuel, grain)
    if ignite_cells != DRAWN:
        embers = in_turn(rng.child("apart"), _cells(ignite_cells, plan), apart, scatter)
    else:
        embers = ignite(rng.child("ignite"), plan, ignitions, ignite_at, apart, scatter)
    pace = FireDelay(spread, scatter, _wind_factors(rng.child("wind"), wind, wind_to))
    floor = _spread(rng, plan, embers, pace, spread_cells, margin if monotone else None)

    # Burn through some walls, and draw what debris closes. A monotone fire opens nothing, and
    # everything that it reaches stays closed.
    slots = weak_walls(rng.child("walls"), plan, floor, 0 if monotone else burn_through)
    walls = burn_walls(rng.child("wall-times"), plan, floor, slots, WALL_FACTOR * spread)
    closing = set(floor) if monotone else _debris(rng.child("debris"), plan, floor, walls, debris)
    lasts = _lasts(rng, plan, floor | walls, burn, uneven, scatter)
    return replace(
        ground, timeline=_timeline(rng.child("clear"), plan, floor | walls, lasts, closing, clear)
    )


def _cells(text: str, plan: Plan) -> list[int]:
    """Parse ``ix:iy,ix:iy`` to flat cells.

    Raises:
        InvalidParameter: If the text has another form, or a cell cannot burn.
    """
    height, width = plan.walls.shape
    cells = []
    for part in text.split(","):
        column, _, row = part.strip().partition(":")
        if not (column.isdecimal() and row.isdecimal()):
            raise InvalidParameter(
                "wrong-form",
                "ignite_cells={text!r}: {part!r} is not a cell",
                "write IX:IY,IX:IY, such as 12:5,20:7",
                text=text,
                part=part,
            )
        # Nine digits are enough for every grid; ``int`` is slow for longer numbers, or refuses
        # them.
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
                "use a cell of floor that can burn",
                cell=part.strip(),
                what=what,
            )
        cells.append(cell)
    return cells


def _wind_factors(
    rng: RandomStream, wind: float, wind_to: int
) -> tuple[float, float, float, float]:
    """Return the factors of the delay of fire that moves to +x, +y, -x and -y.

    Wind makes fire faster in its direction and slower against it.

    Args:
        rng: The only source of randomness.
        wind: Fraction by which the wind shortens and lengthens delays.
        wind_to: Direction of the wind, quarter turns, or ``CHOSEN``.
    """
    factors = [1.0, 1.0, 1.0, 1.0]
    if wind > 0.0:
        to = rng.below(4) if wind_to == CHOSEN else wind_to
        factors[to] = 1.0 - wind
        factors[(to + 2) % 4] = 1.0 + wind
    return factors[0], factors[1], factors[2], factors[3]


def _spread(
    rng: RandomStream, plan: Plan, embers: Times, pace: FireDelay, limit: int, race: float | None
) -> Times:
    """Return when each cell of floor catches, ms.

    Args:
        rng: The only source of randomness.
        plan: The ground.
        embers: Where and when fire breaks out, ms.
        pace: Time that fire takes from cell to cell.
        limit: Limit on the cells that catch.
        race: If nothing ever opens: seconds by which a robot may start late and must still get
            through. Otherwise ``None``.
    """

    def spread_over(held: Times | None) -> Times:
        return burn_over(rng.child("floor"), plan, embers, plan.burns, pace, limit, held)

    # Let the fire spread freely. If the robot cannot outrun it, run the same fire again and hold it
    # back along one path.
    floor = spread_over(None)
    if race is None or leaves_a_way(plan, floor, race):
        return floor
    return spread_over(hold_back(plan, embers, race))


def _debris(rng: RandomStream, plan: Plan, floor: Times, walls: Times, share: float) -> set[int]:
    """Draw the cells that debris closes.

    They are a share of the burnt floor, except on a shortest path through the cells that are open
    in the end.
    """
    kept = plan.kept(plan.way(walls))
    return {cell for cell in floor if cell not in kept and rng.random() < share}


def _lasts(
    rng: RandomStream, plan: Plan, burning: Times, mean: float, uneven: float, scatter: float
) -> list[int]:
    """Return how long each cell burns, ms.

    Args:
        rng: The only source of randomness.
        plan: The ground.
        burning: Cells that burn, in order.
        mean: Mean time, s.
        uneven: Fraction by which heavy fuel burns longer than the mean, and light fuel shorter.
        scatter: Largest difference of a cell from its mean, as a share of it.
    """
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
    """Return all changes, sorted by time and then by cell.

    Every cell burns and is then free, or, if debris closes it, solid until that is cleared.
    """
    # Compute the times at which each cell catches, burns out and is cleared, ms.
    shut = [cell for cell in burning if cell in closing] if clear > 0.0 else []
    cells = np.array([*burning, *burning, *shut], dtype=np.int64)
    caught = np.array([*burning.values()], dtype=np.int64)
    out = caught + np.array(lasts, dtype=np.int64)
    after = [CellState.SOLID if cell in closing else CellState.FREE for cell in burning]
    fell = dict(zip(burning, out.tolist(), strict=True))
    cleared = np.array([fell[cell] + delay(rng, clear) for cell in shut], dtype=np.int64)

    # Put the three kinds of events into one timeline.
    times = np.concatenate([caught, out, cleared])
    states = np.array(
        [CellState.BURNING] * len(burning) + after + [CellState.FREE] * len(shut), dtype=np.uint8
    )
    order = np.lexsort((cells, times))
    iy, ix = np.divmod(cells[order], plan.stride)
    return Timeline(times=times[order] / 1000.0, ix=ix, iy=iy, states=states[order])
