"""Decide whether a car can get from the start to the target."""

from __future__ import annotations

from dataclasses import replace

from worldgen.reach.car.search import find_path, witness_of
from worldgen.reach.decision import REACHABLE, UNDECIDED, Decision
from worldgen.timeline import Timeline
from worldgen.world import World


def decide_car(
    world: World, body: Decision, *, margin: float = 0.0, certificate: bool = True
) -> Decision:
    """Return a witness for the world's car, or ``UNDECIDED``: nothing here proves ``BLOCKED``.

    In a world that changes, the path avoids everything that is ever blocked, so it holds whenever
    the car begins.

    Args:
        world: A world of one robot, a car.
        body: The decision about its body alone, as if that turned on the spot; not ``BLOCKED``.
        margin: s; see :func:`worldgen.reach.decide`.
        certificate: True to return the witness.
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
    alone = "its body alone can pass"
    if body.result != REACHABLE:
        alone = f"of its body alone: {body.reason}"
    ways = "forward and backward" if drive.reverse else "forward only"
    reason = (
        f"a car of turning radius {drive.turning_radius:g} m, {ways}: no path was found among "
        f"{path.searched} poses, and {alone}"
    )
    return Decision(UNDECIDED, None, reason)
