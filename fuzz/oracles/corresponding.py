"""Metamorphic oracles: in a world that corresponds to another one, the outcome corresponds too.

Each runs the controller once more in a related world where it should do equally well. It reports a
violation if the robot arrives in only one of the two runs or, given a number, if one run takes
more than that many times the other's steps. ``wall`` requires exactly the same run.

Source: Tsong Yueh Chen, Shing-Chi Cheung and Siu-Ming Yiu, "Metamorphic testing: a new approach for
    generating next test cases", Hong Kong University of Science and Technology, 1998.
"""

from __future__ import annotations

import math
from typing import Any

from fuzz.oracles.added_walls import walled_where_unnoticed, with_a_block_near_the_path
from fuzz.oracles.trial import Trial
from fuzz.oracles.worlds import mirrored, scaled, shifted, turned
from sim.options.run import MAX_STEPS
from sim.verdict import ARRIVALS
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.world import Value, World

_SHORTEST_STEP = 0.001  # s: the simulator's minimum


def turn(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Compare with the world turned counter-clockwise by a quarter turn.

    The run should be equivalent for a controller that steers relative to its heading or the target.
    """
    return _objection(trial, factor, turned(trial.world))


def shift(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Compare with the world moved by three more wall columns on the left and five rows below."""
    return _objection(trial, factor, shifted(trial.world))


def scale(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Compare with the world in which every length and the top speed are doubled.

    The run should be equivalent for a controller without built-in lengths in metres.
    """
    return _objection(trial, factor, scaled(trial.world))


def mirror(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Compare with the mirrored world, for a controller that prefers neither left nor right."""
    return _objection(trial, factor, mirrored(trial.world))


def finer(trial: Trial, factor: float = math.inf) -> dict[str, Value] | None:
    """Compare with a run whose steps are half as long; two of them count as one."""
    step = trial.options.time_step / 2
    steps = min(2 * trial.options.steps, MAX_STEPS)
    if step < _SHORTEST_STEP:
        raise InvalidParameter(
            "below-minimum",
            "oracle finer: half of time_step={time_step:g} s is below 0.001 s",
            "choose a longer time step",
            time_step=trial.options.time_step,
        )
    return _objection(trial, factor, trial.world, each=0.5, time_step=step, steps=steps)


def wall(trial: Trial) -> dict[str, Value] | None:
    """Compare with the world that has walls wherever the robot could neither touch nor sense them.

    The run must stay exactly the same. A controller acts on its senses, so one that acts
    differently here gets information from elsewhere.

    Returns:
        ``kind``; ``walls``: number of cells added; ``verdicts`` and ``steps`` of both runs.
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
    """Compare with the world that has one more wall cell, next to a wall and near the robot's path.

    The witness does not need that cell, so the robot should still arrive, perhaps by another path.
    """
    blocked = with_a_block_near_the_path(trial)
    return None if blocked is None else _objection(trial, factor, blocked)


def _objection(
    trial: Trial, factor: float, world: World, *, each: float = 1.0, **changes: Any
) -> dict[str, Value] | None:
    """Return what differs if the two runs do not correspond, else ``None``.

    Args:
        trial: The run.
        factor: Largest acceptable ratio between the two step counts, at least 1.
        world: World of the other run.
        each: Number of steps of this run that one step of the other run counts for.
        **changes: Options of the other run that differ.
    """
    if factor < 1.0:
        raise InvalidParameter(
            "below-minimum",
            "a factor of {factor:g} is below 1, but even equal runs have a factor of 1",
            "choose 1 or more",
            factor=factor,
        )
    try:
        there = trial.again(world, **changes)
    except InvalidWorld:
        # A start between two poses of the lattice was rounded into a wall.
        return None
    here = trial.episode
    arrived = (here.verdict in ARRIVALS, there.verdict in ARRIVALS)
    slow = max(here.steps, there.steps * each)
    fast = min(here.steps, there.steps * each)
    if not any(arrived) or (all(arrived) and slow <= factor * max(fast, 1)):
        return None
    return {
        "kind": "slower" if all(arrived) else "only-here" if arrived[0] else "only-there",
        "verdicts": [here.verdict, there.verdict],
        "steps": [here.steps, there.steps],
    }
