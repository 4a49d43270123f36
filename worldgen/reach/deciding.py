"""Decide reachability of one robot's target, or of the targets of several robots together."""

from __future__ import annotations

from worldgen.reach.decision import (
    BLOCKED,
    UNDECIDED,
    Decision,
    check_margin,
    check_radius,
    unread_reason,
)
from worldgen.reach.single import prove
from worldgen.world import World


def decide(
    world: World,
    *,
    radius: float | None = None,
    margin: float = 0.0,
    certificate: bool = True,
    cut: bool = True,
) -> Decision:
    """Decide whether a disc, or each of several discs, can get from its start to its target.

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
        robot = world.robots[0]
        if radius is None and not (robot.is_disc and not robot.drive.is_car):
            return _decide_body(world, margin=margin, certificate=certificate, cut=cut)
        return prove.decide(world, radius=radius, margin=margin, certificate=certificate, cut=cut)
    if radius is not None:
        check_radius(radius, world.cell_size)
    check_margin(margin)
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
