"""Decide reachability of one robot's goals, or of the targets of several robots together.

A robot with waypoints is decided leg by leg: from pose to pose, each leg a world of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from worldgen.reach.decision import (
    BLOCKED,
    REACHABLE,
    UNDECIDED,
    Decision,
    check_margin,
    check_radius,
    unread_reason,
)
from worldgen.reach.single import prove
from worldgen.robot_overrides import describe_waypoint
from worldgen.timeline import CellState, Timeline
from worldgen.world import Cut, Pose, Witness, World


def decide(
    world: World,
    *,
    radius: float | None = None,
    margin: float = 0.0,
    certificate: bool = True,
    cut: bool = True,
) -> Decision:
    """Decide whether a disc, or each of several discs, can get from its start to its target.

    A robot with waypoints has to get to each of them first, in order.

    Args:
        world: The world; its own certificate is ignored. If something of its map was not read, it
            is ``UNDECIDED``.
        radius: Radius of the disc, m; the robot's, or each robot's, if omitted.
        margin: s. The witness of a world that changes also holds if the robot first waits at the
            start for any time up to this, and then does everything that much later.
        certificate: True to return the proof, if the world is static. Without it, small worlds take
            a fraction of the time: the existence of a path or a cut is still proved, but neither is
            constructed.
        cut: True to return the proof even if it is a cut.

    Raises:
        InvalidParameter: If the radius is not a finite number above 0, or the margin is negative or
            not finite.
    """
    if world.unread:
        return Decision(UNDECIDED, None, unread_reason(world.unread))
    if not world.is_fleet:

        def decide_leg(leg: World, certificate: bool, cut: bool) -> Decision:
            if radius is None and not leg.robots[0].is_round:
                return _decide_body(leg, margin=margin, certificate=certificate, cut=cut)
            return prove.decide(leg, radius=radius, margin=margin, certificate=certificate, cut=cut)

        robot = world.robots[0]
        if not robot.waypoints:
            return decide_leg(world, certificate, cut)
        may_return = radius is not None or not robot.drive.is_car
        return _Legs(world, decide_leg, may_return).decide(certificate, cut)
    if radius is not None:
        check_radius(radius, world.cell_size)
    check_margin(margin)
    if any(robot.waypoints for robot in world.robots):
        reason = "fleets with waypoints are not decided; ask about one robot at a time"
        return Decision(UNDECIDED, None, reason)
    if radius is None and any(not robot.is_disc or robot.drive.is_car for robot in world.robots):
        reason = "fleets with footprints or cars are not decided; ask about one robot at a time"
        return Decision(UNDECIDED, None, reason)
    from worldgen.reach.joint.decide import decide_joint

    return decide_joint(world, radius=radius, margin=margin, certificate=certificate, cut=cut)


def _decide_body(world: World, *, margin: float, certificate: bool, cut: bool) -> Decision:
    """Decide for a footprint or a car; what stops a body that turns on the spot stops a car."""
    check_margin(margin)
    robot = world.robots[0]
    if robot.is_disc:
        body = prove.decide(world, margin=margin, certificate=certificate, cut=cut)
    else:
        from worldgen.reach.body.prove import decide_body

        body = decide_body(world, margin=margin, certificate=certificate, cut=cut)
    if not robot.drive.is_car or body.result == BLOCKED:
        return body
    from worldgen.reach.car.decide import decide_car

    return decide_car(world, body, margin=margin, certificate=certificate, cut=cut)


class _Legs:
    """The legs of a robot with waypoints: from its start to its first goal, and so on.

    What turns on the spot and drives both ways can return on any path of a static world. So it gets
    to all of its goals in any order if it gets to each of them from its start, and a cut between its
    start and one of them stops it.

    Args:
        world: A world of one robot with waypoints.
        decide_leg: Decides a world of one robot without; its other arguments ask for a witness and
            for a cut.
        may_return: Whether it can return on its path.
    """

    def __init__(
        self, world: World, decide_leg: Callable[[World, bool, bool], Decision], may_return: bool
    ) -> None:
        self._world = world.bare
        self._decide_leg = decide_leg
        self._robot = world.robots[0]
        self._returns = may_return

    def decide(self, certificate: bool, cut: bool) -> Decision:
        """Return the decision, with its witness or its cut if requested."""
        if self._world.is_dynamic:
            return self._decide_changing(certificate, cut)
        # Existence needs no path where the robot can return.
        if self._returns and not certificate:
            found = [self._from_start(number, False) for number in range(self._count)]
            return min(found, key=lambda one: (BLOCKED, UNDECIDED, REACHABLE).index(one.result))
        path: Witness | None = None
        for number in range(self._count):
            leg = self._decide_leg(self._leg(number, path), True, cut)
            if not isinstance(leg.certificate, Witness):
                leg = self._again(number, path, leg, cut)
            if not isinstance(leg.certificate, Witness):
                return leg
            path = _joined(path, leg.certificate)
        return _reached(path, certificate)

    @property
    def _count(self) -> int:
        return len(self._robot.goals)

    def _leg(self, number: int, path: Witness | None) -> World:
        """Return the world in which a leg is the whole question; it begins where a path ends."""
        start = self._robot.start
        if path is not None:
            heading = start.heading if path.headings is None else float(path.headings[-1])
            start = Pose(float(path.x[-1]), float(path.y[-1]), heading)
        return replace(self._world.for_goal(number), start=start)

    def _from_start(self, number: int, proof: bool, cut: bool = False) -> Decision:
        """Decide whether a goal can be reached from the robot's start."""
        return self._named(number, self._decide_leg(self._leg(number, None), proof, cut))

    def _named(self, number: int, found: Decision) -> Decision:
        """Return a decision about a goal; if it cannot be reached, it names the goal."""
        if found.result == REACHABLE:
            return found
        proof = found.certificate
        if isinstance(proof, Cut) and number < self._count - 1:
            proof = replace(proof, waypoint=number + 1)
        return replace(found, certificate=proof, reason=f"{self._goal(number)}: {found.reason}")

    def _goal(self, number: int) -> str:
        return describe_waypoint(self._robot, number)

    def _first_blocked(self, first: int, cut: bool) -> Decision | None:
        """Return the first goal, from one on, that is cut off from the start; None if none is."""
        for number in range(first, self._count):
            found = self._from_start(number, True, cut)
            if found.result == BLOCKED:
                return found
        return None

    def _again(self, number: int, path: Witness | None, leg: Decision, cut: bool) -> Decision:
        """Decide a leg again that has no path from where the one before ends.

        Where a disc just fits, rounding may have closed the passage that led there. Another path
        returns to the start first.
        """
        found = self._named(number, leg)
        if path is not None:
            found = self._from_start(number, True, cut)
            out = found.certificate
            if self._returns and isinstance(out, Witness):
                return replace(found, certificate=_joined(_reversed(path), out))
        if found.result == BLOCKED:
            return found
        # A later goal may be cut off. What stops a car's body stops the car.
        blocked = self._first_blocked(number + 1, cut)
        if blocked is not None or found.result == UNDECIDED:
            return blocked or found
        reason = f"{self._goal(number)}, from where the path before it ends: {leg.reason}"
        return Decision(UNDECIDED, None, reason)

    def _decide_changing(self, certificate: bool, cut: bool) -> Decision:
        """Decide a world that changes: each leg as early as possible, or without what ever changes."""
        path: Witness | None = None
        for number in range(self._count):
            world = self._leg(number, path)
            if path is not None:
                world = _begun(world, path.duration)
            leg = self._decide_leg(world, True, cut)
            if not isinstance(leg.certificate, Witness):
                break
            path = _joined(path, leg.certificate)
        else:
            return _reached(path, certificate)
        if path is None:
            return self._named(number, leg)
        # A later goal may be cut off for good.
        blocked = self._first_blocked(number, cut)
        if blocked is not None:
            return blocked
        world = self._world
        still = replace(world, walls=world.walls | world.changing_cells, timeline=Timeline())
        untouched = _Legs(still, self._decide_leg, self._returns).decide(certificate, False)
        if untouched.result == REACHABLE:
            return untouched
        reason = f"{self._goal(number)}, from the earliest arrival at the one before: {leg.reason}"
        return Decision(UNDECIDED, None, reason)


def _begun(world: World, time: float) -> World:
    """Return a world as it is from a time on."""
    line = world.timeline
    past = line.count_until(time)
    cells = world.cells_at(time)
    burning = np.argwhere(cells == CellState.BURNING)
    times = np.concatenate([np.zeros(len(burning)), line.times[past:] - time])
    states = np.full(len(burning), int(CellState.BURNING), np.uint8)
    timeline = Timeline(
        times,
        np.concatenate([burning[:, 1], line.ix[past:]]),
        np.concatenate([burning[:, 0], line.iy[past:]]),
        np.concatenate([states, line.states[past:]]),
    )
    return replace(world, walls=cells == CellState.SOLID, timeline=timeline)


def _joined(path: Witness | None, leg: Witness) -> Witness:
    """Return a path with a leg behind it, which begins where the path ends."""
    if path is None:
        return leg
    columns = {
        name: np.concatenate([getattr(path, name), getattr(leg, name)[1:]]) for name in ("x", "y")
    }
    headings = None
    if path.headings is not None and leg.headings is not None:
        headings = np.concatenate([path.headings, leg.headings[1:]])
    times = np.concatenate([path.times, path.duration + leg.times[1:]])
    clearance = min(path.clearance, leg.clearance)
    return Witness(times, columns["x"], columns["y"], clearance, headings)


def _reversed(path: Witness) -> Witness:
    """Return the path from its end back to its start."""
    headings = None if path.headings is None else path.headings[::-1]
    times = path.duration - path.times[::-1]
    return Witness(times, path.x[::-1], path.y[::-1], path.clearance, headings)


def _reached(path: Witness | None, certificate: bool) -> Decision:
    if path is None or not certificate:
        return Decision(REACHABLE, None, "a path through all goals was found")
    reason = (
        f"a path of {path.length:.4g} m leads to all goals in order, with a clearance of "
        f"{path.clearance:.4g} m"
    )
    return Decision(REACHABLE, path, reason)
