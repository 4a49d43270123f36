"""Metamorphic oracles: in a world that corresponds to another one, the outcome corresponds too.

Each runs the controller once more where it ought to fare alike, and objects if the robot arrives in
one of the two runs and not in the other; with a number, also if one run takes more than that many
times the other's steps. ``wall`` asks for the very same run.

Source: Tsong Yueh Chen, Shing-Chi Cheung and Siu-Ming Yiu, "Metamorphic testing: a new approach for
    generating next
test cases", Hong Kong University of Science and Technology, 1998.
"""

from __future__ import annotations

import math
from typing import Any

from fuzz.oracles.added_walls import walled_where_unnoticed, with_a_block_beside_the_way
from fuzz.oracles.trial import Trial
from fuzz.oracles.worlds import mirrored, scaled, shifted, turned
from sim.options.run import MAX_STEPS
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.world import Value, World

__all__ = ["block", "finer", "mirror", "scale", "shift", "turn", "wall"]

_SHORTEST_STEP = 0.001  # s: what the simulator takes


def turn(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """The world turned by a quarter, counter-clockwise.

    Exact for who steers by angles to its heading or the target.
    """
    return _objection(trial, factor, turned(trial.world))


def shift(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Three more columns and five more rows of wall on the left and below.

    The same place, elsewhere.
    """
    return _objection(trial, factor, shifted(trial.world))


def scale(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Every length and the top speed doubled. Exact for who has no length of its own in metres."""
    return _objection(trial, factor, scaled(trial.world))


def mirror(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Left and right swapped, for who has no side of preference."""
    return _objection(trial, factor, mirrored(trial.world))


def finer(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Steps of half the duration, of which two count as one."""
    step = trial.options.time_step / 2
    steps = min(2 * trial.options.steps, MAX_STEPS)
    if step < _SHORTEST_STEP:
        raise InvalidParameter(
            "below-minimum",
            "oracle finer: half of time_step={time_step:g} s is below 0.001 s",
            "give a longer one",
            time_step=trial.options.time_step,
        )
    return _objection(trial, factor, trial.world, each=0.5, time_step=step, steps=steps)


def wall(trial: Trial) -> dict[str, Value] | None:
    """Walls where neither the witness passes nor the robot, in its run, could touch or sense them.

    The same run. What a controller does hangs on what it senses; who objects to this one has seen
    it look elsewhere.

    Returns:
        ``kind``; ``walls``: how many cells were added; ``verdicts`` and ``steps`` of both runs.
    """
    walled = walled_where_unnoticed(trial)
    if walled is None:
        return None
    here = trial.episode
    there = trial.again(walled)
    if (here.verdict, here.steps, here.trace_digest) == (
        there.verdict,
        there.steps,
        there.trace_digest,
    ):
        return None
    return {
        "kind": "otherwise" if here.verdict == there.verdict else f"then-{there.verdict}",
        "walls": walled.solid_cells - trial.world.solid_cells,
        "verdicts": [here.verdict, there.verdict],
        "steps": [here.steps, there.steps],
    }


def block(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """One cell of wall more, beside a wall and the robot's way, that the witness does not need.

    Perhaps another way.
    """
    blocked = with_a_block_beside_the_way(trial)
    return None if blocked is None else _objection(trial, factor, blocked)


def _objection(
    trial: Trial, factor: float, world: World, *, each: float = 1.0, **changes: Any
) -> dict[str, Value] | None:
    """The objection to a run whose counterpart fares otherwise.

    Args:
        trial: The run.
        factor: Greatest ratio of the two numbers of steps that is no failure, at least 1.
        world: Of the counterpart.
        each: Steps of the run that a step of the counterpart is worth.
        **changes: Options of the counterpart.
    """
    if factor < 1.0:
        raise InvalidParameter(
            "below-minimum",
            "a factor of {factor:g} is below 1, and equal runs have 1",
            "give 1 or more",
            factor=factor,
        )
    try:
        there = trial.again(world, **changes)
    except InvalidWorld:  # a start between two poses of the lattice was rounded into a wall
        return None
    here = trial.episode
    arrived = (here.verdict == Verdict.REACHED, there.verdict == Verdict.REACHED)
    slow = max(here.steps, there.steps * each)
    fast = min(here.steps, there.steps * each)
    if not any(arrived) or (all(arrived) and slow <= factor * max(fast, 1)):
        return None
    return {
        "kind": "slower" if all(arrived) else "only-here" if arrived[0] else "only-there",
        "verdicts": [here.verdict, there.verdict],
        "steps": [here.steps, there.steps],
    }
