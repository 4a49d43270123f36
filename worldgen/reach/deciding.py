"""Reachability of one robot's target, or of those of several robots together."""

from __future__ import annotations

from collections.abc import Sequence

from worldgen.reach.decision import Decision, check_margin, check_radius
from worldgen.reach.joint.decide import decide_joint
from worldgen.reach.still import prove
from worldgen.world import World

__all__ = ["decide", "decide_many"]


def decide(
    world: World,
    *,
    radius: float | None = None,
    margin: float = 0.0,
    certificate: bool = True,
    cut: bool = True,
) -> Decision:
    """Decide whether a disc can get from the start to the target; all discs, if there are several.

    Args:
        world: The world; its own certificate is ignored.
        radius: Radius of the disc, m; the robot's, or each robot's, if omitted.
        margin: s. The witness of a world that changes also holds when the robot first waits at the
            start for any time up to this long, and then does everything so much later.
        certificate: Whether the proof is wanted, if the world is still. Without it, small worlds
            take a fraction of the time: that there is a path or a cut is shown all the same, but
            neither is made.
        cut: Whether the proof is wanted if it is a cut, too.

    Raises:
        InvalidParameter: If the radius is not a finite number above 0, or the margin is negative or
            not finite.
    """
    if not world.others:
        return prove.decide(world, radius=radius, margin=margin, certificate=certificate, cut=cut)
    if radius is not None:
        check_radius(radius, world.cell_size)
    check_margin(margin)
    return decide_joint(world, radius=radius, margin=margin, certificate=certificate, cut=cut)


def decide_many(
    worlds: Sequence[World], *, radius: float | None = None, certificate: bool = True
) -> list[Decision]:
    """Return what :func:`decide` returns for each of many worlds.

    Args:
        worlds: Any worlds.
        radius: Radius of the disc, m; each world's robot's if omitted.
        certificate: Whether the proofs of still worlds are wanted.

    Raises:
        InvalidParameter: If the radius is not a finite number above 0.
    """
    return [decide(world, radius=radius, certificate=certificate) for world in worlds]
