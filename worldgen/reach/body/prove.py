"""Decide whether a body can get from the start to the target, with a proof either way.

Two discs about the axle decide most worlds: what stops the one that the body holds stops the body,
and where the one that holds the body gets, the body gets with its heading kept. Between them, boxes
of poses are searched (``worldgen/core/body/decide.c``).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from worldgen._core import lib
from worldgen.lattice import (
    TURN,
    UNIT,
    heading_from_lattice,
    heading_to_lattice,
    lattice_to_metres,
    metres_to_lattice,
)
from worldgen.reach.body.core_calls import ALL_HEADINGS, Body, BodyAnswer, BodyPose, Headings
from worldgen.reach.body.in_time import timed_witness
from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.reach.single import prove
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.path import ticks_per_second, travel_ticks
from worldgen.robot import Corner
from worldgen.support.arrays import Floats, Ints
from worldgen.timeline import Timeline
from worldgen.world import Cut, Target, Witness, World

MOST_BOXES = 200_000
"""Limit on the boxes of poses of one search; this many take about 100 MB."""

# Smaller footprints that are tried for a cut: enough for a hundredth of the footprint.
_SMALLER_TRIED = 8
_MOST_BOXES_SMALLER = 20_000

_NOT_ASKED = "a path was found; its witness was not requested"
_CUT_NOT_ASKED = "the target is cut off; the cut was not requested"


def decide_body(
    world: World, *, margin: float = 0.0, certificate: bool = True, cut: bool = True
) -> Decision:
    """Return True if the robot's body can get from the start to the target.

    In a world that changes, a path avoids every cell that is ever solid or burning, or it is that of the
    disc that holds the body, or it is timed (:mod:`worldgen.reach.body.in_time`). Only cells that are
    always solid count for a cut.

    Args:
        world: A world of one robot with a footprint; its own certificate is ignored.
        margin: As in :func:`worldgen.reach.decide`.
        certificate: True to return the proof.
        cut: True to return the proof even if it is a cut.
    """
    if not world.is_dynamic:
        return _Question(world, certificate, cut).answer()
    still = replace(world.bare, timeline=Timeline())
    untouched = _Question(
        replace(still, walls=world.walls | world.changing_cells), certificate, cut
    ).answer()
    if untouched.result == REACHABLE:
        return untouched
    around = _disc_of(world, outer=True)
    timed = prove.decide(world, radius=around, margin=margin, certificate=certificate, cut=False)
    proof = timed.certificate
    if timed.result == REACHABLE and isinstance(proof, Witness):
        return _with_heading(world, timed, proof)
    always = _Question(replace(still, walls=world.still_walls), certificate, cut).answer()
    if always.result == BLOCKED:
        return always
    witness = timed_witness(world, margin, _path_in)
    if witness is not None:
        reason = (
            f"a path of {witness.length:.4g} m in {witness.duration:.4g} s is clear at its times"
        )
        return Decision(REACHABLE, witness if certificate else None, reason)
    reason = (
        "no path avoids every cell that changes, none in time lets the disc around the footprint "
        "through, the footprint's own paths at some moments are not clear in time, and the cells "
        "that never open leave no cut"
    )
    return Decision(UNDECIDED, None, reason)


def _path_in(world: World) -> Witness | None:
    """Return a path of the body in a world that does not change; None if none is found."""
    proof = _Question(world, certificate=True, cut=False).answer().certificate
    return proof if isinstance(proof, Witness) else None


def also_for_smaller(world: World, decision: Decision) -> Decision:
    """Return the answer with a cut of poses that also stops smaller footprints, if one is found.

    A cut need not stop anything but the body itself. What stops a smaller footprint inside stops the
    body, too; so a few of those are tried, with a limit on the work.

    Args:
        world: A world that does not change.
        decision: The answer for its robot.
    """
    cut = decision.certificate
    if not isinstance(cut, Cut) or cut.boxes is None:
        return decision
    question = _Question(world, certificate=True, cut=True)
    size = world.cell_size / UNIT
    corners = question.body.corners.astype(np.float64)
    stopped = 0.0
    passes = float(np.hypot(*corners.T).max())
    for _ in range(_SMALLER_TRIED):
        inward = 0.5 * (stopped + passes)
        inside = _shrunk(corners, inward)
        rows = (
            None if inside is None else question.rows_for([(x * size, y * size) for x, y in inside])
        )
        if rows is None:
            passes = inward
            continue
        stopped = inward
        # Its corners are rounded to the lattice, at most by this.
        clearance = max(0.0, inward - 1.0) * size * (1.0 - 1e-9)
        cut = replace(cut, boxes=rows, clearance=clearance)
    return replace(decision, certificate=cut)


def _shrunk(corners: Floats, inward: float) -> list[tuple[float, float]] | None:
    """Return a polygon whose sides have moved inward; None if one of them would be gone."""
    found = []
    count = len(corners)
    along = [corners[(k + 1) % count] - corners[k] for k in range(count)]
    along = [side / math.hypot(*side) for side in along]
    for k in range(count):
        before = along[k - 1]
        after = along[k]
        # Both sides move to their left; the corner moves along the line between them.
        turn = float(before[0] * after[1] - before[1] * after[0])
        shift = (after - before) * inward / turn
        found.append((float(corners[k][0] + shift[0]), float(corners[k][1] + shift[1])))
    for k, (x, y) in enumerate(found):
        ahead = found[(k + 1) % count]
        if (ahead[0] - x) * along[k][0] + (ahead[1] - y) * along[k][1] < 2.0:
            return None
    return found


def _disc_of(world: World, *, outer: bool) -> float:
    """Return the radius, m, of the disc that holds the body, or of one in it: 0 if it has none."""
    body = Body(world.walls, world.robots[0].footprint, world.cell_size)
    return body.disc(outer=outer)


def _with_heading(world: World, decision: Decision, path: Witness) -> Decision:
    """Return a disc's path as the body's, which keeps its heading and turns at the end."""
    start = heading_to_lattice(world.start.heading)
    headings = goal_headings(world.target)
    if headings is None:
        return Decision(UNDECIDED, None, _NO_HEADING)
    units = np.full(len(path.times), start)
    turned = _into(start, headings)
    arrays = [path.times, path.x, path.y, units]
    for end in _turn_to(start, turned):
        arrays = [np.append(values, values[-1]) for values in arrays]
        arrays[3][-1] = end
    times, x, y, units = arrays
    radians = np.array([heading_from_lattice(int(unit)) for unit in units])
    clearance = max(0.0, path.clearance - _disc_of(world, outer=True))
    return replace(decision, certificate=Witness(times, x, y, clearance, radians))


_NO_HEADING = (
    "no heading of 1/65536 turn is within the tolerance of the target's; use a larger tolerance"
)


def goal_headings(target: Target) -> Headings | None:
    """Return the headings of the lattice that count as the target's; None if there are none."""
    if target.heading is None or target.heading_tolerance >= math.pi:
        return ALL_HEADINGS
    unit = 2.0 * math.pi / TURN
    # The nearest one is off by half a unit at most; as many on both sides as are certainly inside.
    middle = heading_to_lattice(target.heading)
    # A difference from a huge heading would be rounded.
    wanted = math.remainder(target.heading, 2.0 * math.pi)
    off = math.remainder(middle * unit - wanted, 2.0 * math.pi)
    # A safe margin for what the floats lose.
    reach = target.heading_tolerance * (1.0 - 1e-12) + 1e-12
    below = math.floor((reach + off) / unit)
    above = math.floor((reach - off) / unit)
    if below + above < 0:
        return None
    return Headings((middle - below) % TURN, min(below + above, TURN - 1))


def _into(heading: int, headings: Headings) -> int:
    """Return the nearest of some headings."""
    ahead = (heading - headings.first) % TURN
    if ahead <= headings.following:
        return heading
    last = (headings.first + headings.following) % TURN
    back = (heading - last) % TURN
    return last if back <= TURN - ahead else headings.first


def _turn_to(start: int, end: int) -> list[int]:
    """Return the headings at which the turns from one heading to another end; half a turn has two."""
    if start == end:
        return []
    return [(start + TURN // 4) % TURN, end] if (end - start) % TURN == TURN // 2 else [end]


class _Question:
    """A static world, and what is asked about it.

    Args:
        world: The world.
        certificate: True if the proof is wanted.
        cut: True if a cut is wanted, too.
    """

    def __init__(self, world: World, certificate: bool, cut: bool) -> None:
        self.world = world
        self.certificate = certificate
        self.cut = certificate and cut
        robot = world.robots[0]
        self.body = Body(world.walls, robot.footprint, world.cell_size)
        self.start = BodyPose(
            metres_to_lattice(world.start.x, world.cell_size),
            metres_to_lattice(world.start.y, world.cell_size),
            heading_to_lattice(world.start.heading),
        )

    def answer(self) -> Decision:
        """Return the decision."""
        headings = goal_headings(self.world.target)
        if headings is None:
            return Decision(UNDECIDED, None, _NO_HEADING)
        if not self.body.is_clear(self.start):
            return self._covered()
        inside = _disc_of(self.world, outer=False)
        if inside > 0.0:
            held = prove.decide(
                self.world, radius=inside, certificate=self.certificate, cut=self.cut
            )
            if held.result == BLOCKED:
                return held
        found = self._by_disc(headings)
        if found is not None:
            return found
        answer = self.body.search(
            self.start,
            target_disc(self.world),
            headings,
            most_boxes=MOST_BOXES,
            proof=self.certificate,
        )
        return self._decision(answer)

    def rows_for(self, footprint: Sequence[Corner]) -> Ints | None:
        """Return the rows of a cut for another footprint; None if none is found soon."""
        headings = goal_headings(self.world.target)
        if headings is None:
            return None
        body = Body(self.world.walls, tuple(footprint), self.world.cell_size)
        if not body.is_clear(self.start):
            return _cut_of_start(self.start)
        disc = target_disc(self.world)
        answer = body.search(self.start, disc, headings, most_boxes=_MOST_BOXES_SMALLER, proof=True)
        return answer.rows if answer.outcome == lib.WG_BODY_STOPPED else None

    def _by_disc(self, headings: Headings) -> Decision | None:
        """Return the path of the disc that holds the body, if it has one."""
        around = _disc_of(self.world, outer=True)
        decision = prove.decide(self.world, radius=around, certificate=self.certificate, cut=False)
        if decision.result != REACHABLE:
            return None
        proof = decision.certificate
        if not isinstance(proof, Witness):
            return decision
        # The start is the lattice's, and the other corners of a path usually are.
        size = self.world.cell_size
        poses = [
            BodyPose(metres_to_lattice(x, size), metres_to_lattice(y, size), self.start.heading)
            for x, y in zip(proof.x.tolist(), proof.y.tolist(), strict=True)
        ]
        poses = [pose for k, pose in enumerate(poses) if k == 0 or pose != poses[k - 1]]
        for end in _turn_to(self.start.heading, _into(self.start.heading, headings)):
            poses.append(poses[-1]._replace(heading=end))
        disc = target_disc(self.world)
        clear = disc.holds((poses[-1].x, poses[-1].y)) and all(
            self.body.may_move(p, q.x, q.y)
            if p.heading == q.heading
            else self.body.may_turn(p, (q.heading - p.heading + TURN // 2) % TURN - TURN // 2)
            for p, q in itertools.pairwise(poses)
        )
        if not clear:
            return None
        return self._reached(poses, self.body.clearance(poses))

    def _decision(self, answer: BodyAnswer) -> Decision:
        if answer.outcome == lib.WG_BODY_REACHED:
            if not self.certificate:
                return Decision(REACHABLE, None, _NOT_ASKED)
            poses = list(map(BodyPose._make, answer.rows.tolist()))
            return self._reached(poses, answer.clearance)
        if answer.outcome == lib.WG_BODY_STOPPED:
            if not self.cut:
                return Decision(BLOCKED, None, _CUT_NOT_ASKED)
            reason = (
                f"{len(answer.rows)} runs of poses in which the body overlaps a wall separate the "
                f"start from the target"
            )
            return Decision(BLOCKED, _cut_of(answer.rows), reason)
        side, turn = answer.finest
        reason = (
            f"{answer.boxes} boxes of poses, down to {side}/1024 of a cell and {turn}/65536 of a "
            f"turn, neither connect the start with the target nor separate them; the body fits "
            f"too closely"
        )
        return Decision(UNDECIDED, None, reason)

    def _covered(self) -> Decision:
        if not self.cut:
            return Decision(BLOCKED, None, _CUT_NOT_ASKED)
        rows = _cut_of_start(self.start)
        return Decision(BLOCKED, _cut_of(rows), "the body overlaps a wall at the start")

    def _reached(self, poses: Sequence[BodyPose], clearance: float) -> Decision:
        size = self.world.cell_size
        speed = self.world.robot_speed
        ticks = ticks_per_second(size, speed)
        times = [0]
        # A turn takes no time, as in the simulator.
        for p, q in itertools.pairwise(poses):
            times.append(times[-1] + travel_ticks((p.x, p.y), (q.x, q.y), size, speed, ticks))
        witness = Witness(
            np.array([time / ticks for time in times]),
            np.array([lattice_to_metres(pose.x, size) for pose in poses]),
            np.array([lattice_to_metres(pose.y, size) for pose in poses]),
            # Rounded down.
            max(0.0, math.nextafter(clearance * size / UNIT * (1.0 - 1e-12), 0.0)),
            np.array([heading_from_lattice(pose.heading) for pose in poses]),
        )
        reason = (
            f"a path of {witness.length:.4g} m leaves the footprint {witness.clearance:.4g} m to "
            f"spare"
        )
        return Decision(REACHABLE, witness, reason)


def _cut_of_start(start: BodyPose) -> Ints:
    return np.array([[start.heading, 0, 0, start.y, start.x, start.x]], np.int64)


def _cut_of(rows: Ints) -> Cut:
    return Cut(np.zeros((0, 2), np.int64), 0.0, boxes=rows)
