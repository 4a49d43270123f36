"""Drive a timed path as early as possible.

Its straight lines take less time than the steps they replaced.
"""

from __future__ import annotations

from worldgen.lattice import UNIT, exact
from worldgen.reach.still.path import travel_ticks
from worldgen.reach.still.walls import ExactPoint
from worldgen.reach.timed.earliest import TimedPath, make_timed_witness
from worldgen.reach.timed.spans import MARGIN, ChangingWalls
from worldgen.world import Witness, World

__all__ = ["retime"]

# Departures tried for one piece.
_TRIES = 40


def retime(world: World, walls: ChangingWalls, witness: Witness) -> Witness:
    """Return the same path, with each piece driven at full speed and as soon as it is clear.

    It arrives no later. If the robot arrives at a point earlier than before, it is safe there until
    the old time, so the rest can still be driven as before.

    Args:
        world: The world, for speed and size.
        walls: Its changes and the radius.
        witness: A witness that the prover found.
    """
    scale = UNIT / exact(world.cell_size)
    points: list[ExactPoint] = [
        (exact(x) * scale, exact(y) * scale)
        for x, y in zip(witness.x.tolist(), witness.y.tolist(), strict=True)
    ]
    times = [round(exact(time) * walls.spans.ticks) for time in witness.times.tolist()]
    made = TimedPath(points[:1], times[:1])
    for i in range(len(points) - 1):
        p = points[i]
        q = points[i + 1]
        if p == q:
            continue
        now = made.times[-1]
        takes = travel_ticks(p, q, world.cell_size, world.robot_speed, walls.spans.ticks)
        leave = _departure(walls, (p, q), now, takes, times[i + 1])
        arrive = times[i + 1] if leave is None else leave + takes
        leave = max(now, times[i]) if leave is None else leave
        for point, time in ((p, leave), (q, arrive)):
            if time > made.times[-1]:
                made.points.append(point)
                made.times.append(time)
    return make_timed_witness(world, walls, made)


def _departure(
    walls: ChangingWalls, piece: tuple[ExactPoint, ExactPoint], now: int, takes: int, by: int
) -> int | None:
    """Return the first tick at which a piece can begin and end safely before ``by``, or None."""
    p, q = piece
    ends = sorted({end for _, end in walls.spans_near(p, q) if now < end and end + takes < by})
    for leave in [now, *(end + MARGIN for end in ends[:_TRIES])]:
        arrive = leave + takes
        if (
            arrive < by
            and walls.is_clear(p, p, now, leave)
            and walls.is_clear(p, q, leave - MARGIN, arrive + MARGIN)
            and walls.is_clear(q, q, arrive, by)
        ):
            return leave
    return None
