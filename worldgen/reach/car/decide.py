"""Decide whether a car can get from the start to the target."""

from __future__ import annotations

from dataclasses import replace

from worldgen.reach.body.in_time import timed_witness
from worldgen.reach.car.confine import confine_car
from worldgen.reach.car.search import EFFORTS, find_path, witness_of
from worldgen.reach.check.car_confinement import check_car_confinement
from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.timeline import Timeline
from worldgen.world import Witness, World


def decide_car(
    world: World, body: Decision, *, margin: float = 0.0, certificate: bool = True, cut: bool = True
) -> Decision:
    """Return a witness for the world's car, a proof that it cannot arrive, or ``UNDECIDED``.

    In a world that changes, the path avoids everything that is ever blocked, or it is timed: the car
    waits on it where changes are in its way.

    Args:
        world: A world of one robot, a car.
        body: The decision about its body alone, as if that turned on the spot; not ``BLOCKED``.
        margin: s; see :func:`worldgen.reach.decide`.
        certificate: True to return the witness.
        cut: True to look for a proof that it cannot arrive, which only a car that never reverses
            may have.
    """
    drive = world.robots[0].drive
    still = world
    if world.is_dynamic:
        from worldgen.reach.timed.spans import Spans  # noqa: PLC0415 - few worlds change

        ever = Spans(world, margin).ever
        still = replace(world, walls=ever, timeline=Timeline(), certificate=None)
    path = find_path(still)
    if len(path.poses):
        witness = witness_of(still, path.poses)
        if witness is not None:
            room = f"is clear for discs of up to {witness.clearance:.4g} m"
            if not world.robots[0].is_disc:
                room = f"leaves the footprint {witness.clearance:.4g} m to spare"
            reason = f"a car's path of {witness.length:.4g} m {room}"
            return Decision(REACHABLE, witness if certificate else None, reason)
    if world.is_dynamic:
        witness = timed_witness(world, margin, _path_in)
        if witness is not None:
            reason = (
                f"a car's path of {witness.length:.4g} m in {witness.duration:.4g} s is clear at its "
                "times"
            )
            return Decision(REACHABLE, witness if certificate else None, reason)
    boxes = ""
    if cut and not drive.reverse:
        always = replace(world.bare, walls=world.still_walls, timeline=Timeline())
        confined = confine_car(always)
        # What confines a car is found with rounded numbers and many bounds, so it is not claimed unchecked.
        if confined.proof is not None and check_car_confinement(always, confined.proof).valid:
            reason = (
                f"a car that turns on circles of {drive.turning_radius:g} m and never reverses "
                f"cannot leave {confined.proof.count:,} boxes of poses"
            )
            return Decision(BLOCKED, None, reason, confined.proof)
        if confined.side is not None:
            boxes = (
                f", boxes of poses down to {confined.side:.2g} m and 1/{confined.headings} turn "
                "do not confine it"
            )
    alone = "its body alone can pass"
    if body.result != REACHABLE:
        alone = f"of its body alone: {body.reason}"
    ways = "forward and backward" if drive.reverse else "forward only"
    reason = (
        f"a car of turning radius {drive.turning_radius:g} m, {ways}: no path was found among "
        f"{path.searched} poses{boxes}, and {alone}"
    )
    return Decision(UNDECIDED, None, reason)


def _path_in(world: World) -> Witness | None:
    """Return a car's path in a world that does not change; None if none is found quickly."""
    poses = find_path(world, EFFORTS[:2]).poses
    return witness_of(world, poses) if len(poses) else None
