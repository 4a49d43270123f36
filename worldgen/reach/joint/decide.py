"""Decide whether all robots of a world can reach their targets, with a proof if one is found."""

from __future__ import annotations

from dataclasses import replace

from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.reach.joint.plan import find_plan
from worldgen.reach.joint.question import joint_question
from worldgen.reach.joint.swap import find_swap
from worldgen.reach.joint.witness import make_joint_witness
from worldgen.reach.single.prove import decide
from worldgen.world import Cut, World

_FINER = 4  # nodes per cell side if half cells have no plan
_MOST_FINE = 40_000  # largest world, in cells, to search on the finer graph too


def decide_joint(
    world: World,
    *,
    radius: float | None = None,
    margin: float = 0.0,
    certificate: bool = True,
    cut: bool = True,
) -> Decision:
    """Decide whether all robots of a world can reach their targets together.

    A joint witness proves that they can. The opposite is proved by a cut for one of them, or by two
    robots that would have to change places in a passage too narrow for both. If all joint moves
    over a graph were searched without success, the reason states this, but it proves nothing about
    the plane.

    Args:
        world: A world of several robots; its own certificate is ignored.
        radius: Radius of every robot, m; each one's own if None.
        margin: Seconds by which all robots may start late, in a world that changes.
        certificate: True to return the proof.
        cut: True to return the proof even if it is a cut. Otherwise, no proof that there is no
            witness is searched for, and the search for a witness is short.
    """
    # Search half cells first, then finer ones, which take longer but find tighter plans.
    exhausted = 0
    for k in (2, _FINER) if cut else (2,):
        if k > 2 and world.walls.size > _MOST_FINE:
            break
        question = joint_question(world, k=k, radius=radius, margin=margin)
        if question is None:
            continue
        plan = find_plan(question, thorough=cut)
        if plan.nodes is not None:
            witness = make_joint_witness(question, plan.nodes)
            if witness is not None:
                reason = (
                    f"joint paths with a total length of {witness.length:.4g} m; the last robot "
                    f"arrives after {witness.duration:.4g} s"
                )
                return Decision(REACHABLE, witness if certificate else None, reason)
        elif plan.is_exhausted and question.spans is None:
            exhausted = k
        # Before searching the finer graph, look for a proof that there is nothing to find.
        if k == 2 and cut:
            blocked = _proved_impossible(world, radius, certificate)
            if blocked is not None:
                return blocked
    blocked = _proved_impossible(world, radius, certificate) if cut and not exhausted else None
    return blocked or Decision(UNDECIDED, None, _undecided_reason(exhausted))


def _undecided_reason(exhausted: int) -> str:
    if not exhausted:
        return "no joint plan was found, but it is not proved that none exists"
    return (
        f"all joint moves on the grid of 1/{exhausted} cells were searched, from the nodes chosen "
        f"for the starts and with robots that stay where they arrive, but none brings every robot "
        f"to its target; this is a statement about the grid, not a proof for the plane"
    )


def _proved_impossible(world: World, radius: float | None, wants_cut: bool) -> Decision | None:
    """Return the decision if one robot cannot arrive even alone, or if two have to swap."""
    for number in range(1, len(world.robots) + 1):
        alone = decide(world.alone(number), radius=radius, certificate=wants_cut, cut=wants_cut)
        if alone.result == BLOCKED:
            proof = alone.certificate
            if isinstance(proof, Cut):
                proof = replace(proof, robot=number)
            return Decision(BLOCKED, proof, f"robot {number}: {alone.reason}")
    swap = find_swap(world, radius)
    if swap is None:
        return None
    reason = (
        f"robots {swap.first} and {swap.second} would have to change places in a passage too "
        "narrow for both"
    )
    return Decision(BLOCKED, None, reason, swap=swap)
