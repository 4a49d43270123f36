"""Describe one period of a robot's loop in a sentence: its turns and the walls that it touches.

A cause names a behaviour; the moves show the decision behind it: to which side the robot turns
after which touch, and by how much.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fuzz.triage.contacts import bearing_of_wall
from sim.episode import Episode
from sim.evidence import LoopEvidence
from sim.trace import Trace
from worldgen.support.plain_text import counted
from worldgen.world import World

__all__ = ["describe_period"]

# A longer list of moves is harder to read than a summary.
_MOST_MOVES = 8

# Degrees in one step: below the first the robot drives straight on,
# above the second it turns around.
_STRAIGHT = 2.0
_AROUND = 160.0

# Robot radii; a robot that moves less than this while turning is said to turn on the spot.
_ON_THE_SPOT = 0.5

# Degrees between the heading and a wall: up to the first, the wall is ahead; up to the second,
# ahead on one side; up to the third, on that side; beyond that, behind.
_AHEAD = 30.0
_HALF_AHEAD = 65.0
_BESIDE = 125.0

# Minimum share of a period's touches that must be on one side for that side to be named.
_MOSTLY = 0.8


@dataclass
class _Move:
    """Consecutive steps that turn to the same side, or not at all.

    Args:
        steps: Number of steps.
        turn: Total turn, degrees; left is positive.
        length: Path length, m.
        begins_at: Direction, in words, of the wall that the robot has just begun to touch before it
            moves; empty if it touches none, or still the same one.
    """

    steps: int
    turn: float
    length: float
    begins_at: str = ""


def describe_period(world: World, episode: Episode) -> str:
    """Return what the robot repeats: ``repeats 2 steps (0.03 s, 0 m): it turns ...``.

    Args:
        world: World of the run.
        episode: The run, recorded.

    Returns:
        The words, to follow ``it``; empty unless the run is a loop of a single robot.
    """
    loop = episode.evidence
    trace = episode.trace
    if not isinstance(loop, LoopEvidence) or trace is None:
        return ""
    first = loop.entry
    last = first + loop.period
    length = float(np.hypot(np.diff(trace.x), np.diff(trace.y))[first:last].sum())
    duration = f"{loop.period * trace.time_step:.3g} s, {length:.2g} m"
    moves = list(_moves(world, trace, first, last))
    begin = f"repeats {counted(loop.period, 'step')} ({duration}): "
    if len(moves) <= _MOST_MOVES:
        told = [_describe(move, world.robot_radius) for move in moves]
        # Moves may recur while the controller's memory differs.
        parts = [(words, len(list(same))) for words, same in itertools.groupby(told)]
        return begin + "; ".join(
            words if count == 1 else f"{words}, {count} times" for words, count in parts
        )
    return begin + _summary(world, trace, first, last)


def _moves(world: World, trace: Trace, first: int, last: int) -> Iterator[_Move]:
    """Yield the moves of a range of steps, each with the touch that comes before it."""
    move: _Move | None = None
    for step in range(first, last):
        turn = _turn(trace, step)
        length = math.hypot(trace.x[step + 1] - trace.x[step], trace.y[step + 1] - trace.y[step])
        # The controller senses a touch after the step, and reacts to it in the next one.
        before = last - 1 if step == first else step - 1
        touches_anew = trace.bump[step] and not trace.bump[before]
        in_place = length == 0.0 and trace.bump[step]
        wall = _wall(world, trace, step) if touches_anew or in_place else ""
        if move is not None and not wall and _side(turn) == _side(move.turn):
            move.steps += 1
            move.turn += turn
            move.length += length
            continue
        if move is not None:
            yield move
        move = _Move(1, turn, length, wall)
    if move is not None:
        yield move


def _describe(move: _Move, radius: float) -> str:
    touch = f"with a wall {move.begins_at}, it " if move.begins_at else "it "
    if _side(move.turn) == 0:
        return touch + (f"drives {move.length:.2g} m straight on" if move.length else "stays there")
    side = "left" if move.turn > 0.0 else "right"
    amount = f"{abs(move.turn):.0f} degrees {side}"
    if move.steps == 1 and abs(move.turn) >= _AROUND:
        amount = "around"
    elif move.steps > 1:
        amount += f" in {move.steps} steps"
    if move.length < _ON_THE_SPOT * radius:
        return f"{touch}turns {amount}"
    return f"{touch}turns {amount} and drives {move.length:.2g} m"


def _summary(world: World, trace: Trace, first: int, last: int) -> str:
    """Return the moves of a long period in total: turns, touches and their side.

    A turn is a reaction to the touch before it, so turns after a touch are kept apart
    from the others.
    """
    at_walls = [_turn(trace, step) for step in range(first, last) if trace.bump[step]]
    between = [_turn(trace, step) for step in range(first, last) if not trace.bump[step]]
    if not at_walls:
        return f"it turns {_in_all(between)} in all, and touches no wall"
    touched = [step for step in range(first, last) if trace.bump[step]]
    share = max(round(100 * len(touched) / (last - first)), 1)
    often = f"it touches a wall in {share} % of its steps{_sides(world, trace, touched)}"
    if not between:
        return f"{often}, and turns {_in_all(at_walls)} in all"
    return f"{often}; it turns {_in_all(at_walls)} there, and {_in_all(between)} in between"


def _in_all(turns: Sequence[float]) -> str:
    left = sum(turn for turn in turns if turn > 0.0)
    right = -sum(turn for turn in turns if turn < 0.0)
    return f"{left:.0f} degrees left and {right:.0f} degrees right"


def _sides(world: World, trace: Trace, touched: Sequence[int]) -> str:
    """Return on which side the robot touches walls, if not only ahead: a wall follower has one."""
    bearings = (math.degrees(bearing_of_wall(world, trace, step)) for step in touched)
    lefts = [bearing > 0.0 for bearing in bearings if abs(bearing) > _AHEAD]
    if not lefts:
        return ""
    for side, count in (("left", sum(lefts)), ("right", len(lefts) - sum(lefts))):
        if count >= _MOSTLY * len(lefts):
            return f", nearly always on its {side}"
    changes = sum(one != before for one, before in zip(lefts, [lefts[-1], *lefts], strict=False))
    return f", which changes between its left and its right {changes} times"


def _wall(world: World, trace: Trace, step: int) -> str:
    """Return the direction of the wall that the robot touches after a step."""
    degrees = math.degrees(bearing_of_wall(world, trace, step))
    side = "left" if degrees > 0.0 else "right"
    if abs(degrees) <= _AHEAD:
        return "ahead"
    if abs(degrees) <= _HALF_AHEAD:
        return f"ahead on its {side}"
    return f"on its {side}" if abs(degrees) <= _BESIDE else "behind"


def _turn(trace: Trace, step: int) -> float:
    """Return the turn between the states before and after a step, degrees; left is positive."""
    return math.degrees(
        math.remainder(float(trace.heading[step + 1] - trace.heading[step]), math.tau)
    )


def _side(turn: float) -> int:
    return 0 if abs(turn) < _STRAIGHT else int(math.copysign(1, turn))
