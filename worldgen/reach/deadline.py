"""Decide whether the disc reaches the target by a deadline, and how long it may wait first."""

from __future__ import annotations

import math
from dataclasses import replace

from worldgen.lattice import UNIT, exact, in_cells
from worldgen.reach import deciding
from worldgen.reach.decision import BLOCKED, UNDECIDED, Decision, check_deadline, check_radius
from worldgen.reach.single.prove import decide
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.path import travel_ticks
from worldgen.reach.still.walls import ExactPoint
from worldgen.reach.timed.confine import confine
from worldgen.reach.timed.earliest import TimedPath, make_timed_witness
from worldgen.reach.timed.latest import find_latest_start
from worldgen.reach.timed.spans import MARGIN, ChangingWalls, Spans
from worldgen.world import JointWitness, Witness, World

# Departures that are tried for one piece of a path.
_TRIES = 40
# Tiles per cell side that confine the robot.
_TILES = (4, 8)
# Tiles per cell side if those are too many.
_COARSE = (2, 1)
_MOST_TILES = 4_000_000
# Nodes per cell side of the graphs searched for the latest start, as for witnesses.
_NODES = (2, 4, 8, 16)
_MOST_NODES = 4_000_000


def decide_in_time(
    world: World, deadline: float | None = None, *, radius: float | None = None
) -> Decision:
    """Return True if a disc can get from the start to the target by a deadline, or at all.

    In addition to :func:`decide`, it confines the robot. This can prove the target unreachable
    although no wall is permanent: because the robot is shut in, burns, or has too far to go.

    Args:
        world: The world; its own certificate is ignored.
        deadline: Time from the beginning, s, at which the robot must be in the target; None for any
            time.
        radius: Radius of the disc, m; the robot's if omitted.

    Returns:
        ``REACHABLE`` with a witness that arrives in time; ``BLOCKED`` with a cut of the world
        :func:`until` the deadline, or with a confinement; or ``UNDECIDED``.

    Raises:
        InvalidParameter: If the radius or the deadline isn't a finite number above 0.
    """
    check_deadline(deadline)
    robot = world.robots[0]
    if world.is_fleet or robot.waypoints or (radius is None and not robot.is_round):
        return _all_in_time(world, deadline, radius)
    radius = world.robot_radius if radius is None else radius
    check_radius(radius, world.cell_size)
    ahead = world if deadline is None else until(world, deadline)
    arrivals = []
    # With fewer obstacles, another path is found, whose straight lines may take longer, so both
    # worlds are tried.
    for tried in (ahead,) if ahead is world else (ahead, world):
        decision = decide(tried, radius=radius)
        if not isinstance(decision.certificate, Witness):
            break
        witness = decision.certificate
        if deadline is not None and witness.duration > deadline and ahead.is_dynamic:
            witness = retime(
                ahead,
                ChangingWalls(ahead, Spans(ahead), in_cells(radius, world.cell_size)),
                witness,
            )
        if deadline is None or witness.duration <= deadline:
            return replace(decision, certificate=witness)
        arrivals.append(witness.duration)
    if decision.result == BLOCKED and not arrivals:
        return decision
    late = f"the earliest path found takes {min(arrivals):.6g} s" if arrivals else ""
    return _confined(ahead, radius, deadline, late or decision.reason)


def _confined(world: World, radius: float, deadline: float | None, why: str) -> Decision:
    """Return ``BLOCKED`` with a confinement, or ``UNDECIDED`` for the reason ``why``."""
    earliest = 0.0
    fine, coarse = (
        [k for k in sides if k * k * world.walls.size <= _MOST_TILES] for sides in (_TILES, _COARSE)
    )
    for k in fine or coarse[:1]:
        reach = confine(world, in_cells(radius, world.cell_size), k, deadline)
        if reach is None:
            break
        if reach.proof is not None:
            within = "" if deadline is None else f" within {deadline:g} s"
            reason = f"wherever the robot goes{within}, it does not get to the target"
            return Decision(BLOCKED, None, reason, reach.proof)
        earliest = max(earliest, reach.earliest)
    if earliest > 0.0:
        why = f"{why}, but a path of {earliest:.6g} s is not excluded"
    return Decision(UNDECIDED, None, why)


def until(world: World, deadline: float) -> World:
    """Return the world without its changes after a deadline.

    They do not affect a robot that must arrive by then.
    """
    kept = world.timeline.until(deadline)
    if len(kept) == len(world.timeline):
        return world
    return replace(world, timeline=kept, certificate=None)


def _all_in_time(world: World, deadline: float | None, radius: float | None) -> Decision:
    """Decide for several robots, or a body: a witness that is too late leaves the question open."""
    decision = deciding.decide(world, radius=radius)
    proof = decision.certificate
    if deadline is None or not isinstance(proof, Witness | JointWitness):
        return decision
    if proof.duration <= deadline:
        return decision
    found = "joint paths found take" if world.is_fleet else "path found takes"
    who = "all robots" if world.is_fleet else "it"
    reason = f"the {found} {proof.duration:.6g} s; whether {who} can be faster is undecided"
    return Decision(UNDECIDED, None, reason)


def latest_start(
    world: World, deadline: float | None = None, *, radius: float | None = None
) -> float | None:
    """Return the longest wait at the start, s, after which some path still arrives in time.

    It is exact for the paths of the graph that is searched for witnesses; a path off that graph may
    allow more.

    Args:
        world: The world.
        deadline: Time, s, by which the robot must arrive; None for any time.
        radius: Radius of the disc, m; the robot's if omitted.

    Returns:
        Infinite if it may wait forever; None if no graph that is tried has a path.

    Raises:
        InvalidParameter: If the radius or the deadline isn't a finite number above 0.
    """
    radius = world.robot_radius if radius is None else radius
    check_radius(radius, world.cell_size)
    check_deadline(deadline)
    start: ExactPoint = (
        in_cells(world.start.x, world.cell_size) * UNIT,
        in_cells(world.start.y, world.cell_size) * UNIT,
    )
    walls = ChangingWalls(world, Spans(world), in_cells(radius, world.cell_size))
    for k in _NODES:
        if k > 2 and k * k * world.walls.size > _MOST_NODES:
            break
        found = find_latest_start(world, walls, k, start, target_disc(world), deadline)
        if found is not None:
            return found if deadline is None else min(found, math.nextafter(deadline, 0.0))
    return None


def retime(world: World, walls: ChangingWalls, witness: Witness) -> Witness:
    """Return the same path, with each piece driven at full speed and as soon as it is clear.

    It arrives no later: its straight lines take less time than the steps they replaced. If the
    robot arrives at a point earlier than before, it is safe there until the old time, so the rest
    can still be driven as before.

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
