"""Check that two robots would have to change places in a passage too narrow for both.

This shares no code with the search. The theorem: two discs in a strip of height h, whose radii add
up to more than h / 2, are never at the same place along it, because they would be at most h - r - s
apart across it. So their order along the strip never changes, but the targets require the opposite
order.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from worldgen.reach.check.certificate import CheckReport
from worldgen.reach.decision import Swap
from worldgen.support.arrays import Bools
from worldgen.world import Robot, World


def check_swap(world: World, swap: Swap, *, radius: float | None = None) -> CheckReport:
    """Check the claim that two robots cannot both arrive, because they cannot pass each other.

    Args:
        world: The world.
        swap: The claim.
        radius: Radius of both robots, m; each one's own if omitted.
    """
    fault = _fault(world, swap, radius)
    if fault:
        return CheckReport(False, fault, 0.0)
    reason = (
        f"robots {swap.first} and {swap.second} would have to change places in a passage too "
        "narrow for both"
    )
    return CheckReport(True, reason, 0.0)


def _fault(world: World, swap: Swap, radius: float | None) -> str:
    """Return what is wrong with the claim; empty if it holds."""
    # Both robots must be in one room.
    if not 1 <= swap.first < swap.second <= len(world.robots):
        return f"there are no robots {swap.first} and {swap.second}"
    one = world.robots[swap.first - 1]
    other = world.robots[swap.second - 1]
    blocked = world.still_walls
    strip = _flooded(blocked, _cell_of(world, one))
    if not strip[_cell_of(world, other)]:
        return "the two robots are in different rooms"

    # The strip is the box around the room; its height is its extent across the axis.
    rows, columns = np.nonzero(strip)
    cells = rows if swap.axis == "x" else columns
    height = (int(cells.max()) - int(cells.min()) + 1) * _exact(world.cell_size)
    radii = sum(_exact(robot.radius if radius is None else radius) for robot in (one, other))
    if height >= 2 * radii:
        return f"the room is {float(height):.6g} m across, which lets the two robots pass"

    starts = [_along(robot.start, swap.axis) for robot in (one, other)]
    if starts[0] == starts[1]:
        return "the two robots start side by side"
    first, last = (one, other) if starts[0] < starts[1] else (other, one)
    nearest = _along(first.target, swap.axis) - _exact(first.target.radius)
    farthest = _along(last.target, swap.axis) + _exact(last.target.radius)
    if nearest < farthest:
        return "the targets do not reverse the order of the two robots"
    return ""


def _exact(value: float) -> Fraction:
    return Fraction(repr(float(value)))


def _along(place: object, axis: str) -> Fraction:
    return _exact(getattr(place, axis))


def _cell_of(world: World, robot: Robot) -> tuple[int, int]:
    size = _exact(world.cell_size)
    row = min(_exact(robot.start.y) // size, world.height - 1)
    column = min(_exact(robot.start.x) // size, world.width - 1)
    return int(row), int(column)


def _flooded(blocked: Bools, start: tuple[int, int]) -> Bools:
    """Return the cells connected to one by their sides, examining each only once."""
    # A ring of blocked cells around the grid, so that no step leaves the array.
    before = np.pad(~blocked, 1)
    stride = before.shape[1]
    free = bytearray(before.tobytes())
    begin = (start[0] + 1) * stride + start[1] + 1
    free[begin] = 0
    to_visit = [begin]
    while to_visit:
        cell = to_visit.pop()
        for beside in (cell - 1, cell + 1, cell - stride, cell + stride):
            if free[beside]:
                free[beside] = 0
                to_visit.append(beside)
    # The room consists of the cells that were free and no longer are, and of the start.
    after = np.frombuffer(bytes(free), np.bool_).reshape(before.shape)
    room = (before & ~after)[1:-1, 1:-1]
    room[start] = True
    return room
