"""Describe what a robot repeats in a sentence: its turns and the walls that it touches.

A cause names a behaviour; the moves show the decision behind it: to which side the robot turns
after which touch, and by how much.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fuzz.facts.contacts import WallBearings
from sim.clock.stopping import in_time
from sim.episode import Episode
from sim.episode.describe import describe_memory_drift, describe_missed_goal
from sim.evidence import BudgetEvidence, FaultEvidence, LoopEvidence
from sim.trace import Trace
from worldgen.support.arrays import Floats, Ints
from worldgen.support.plain_text import counted, in_degrees, rounded
from worldgen.world import World

# A longer list of moves is harder to read than a summary.
_MOST_MOVES = 8

# Degrees in one step: below the first the robot drives straight on,
# above the second it turns around.
_STRAIGHT = 2.0
_AROUND = 160.0
_NOTICED = 0.1  # degrees; a smaller total is no turn

# Share of a step's length that must lead against the heading for the robot to drive backwards: a
# wall may bend the step.
_BACKWARDS = 0.5

# Robot radii; a robot that moves less than this while turning is said to turn on the spot.
_ON_THE_SPOT = 0.5

# Robot radii; a circle with a smaller radius is a turn on the spot.
TIGHTEST_CIRCLE = 0.125

# Robot radii between two places that count as the same.
SAME_PLACE = 0.1

# Share of steps that touch a wall below which walls are not what holds the robot back.
RARELY = 0.02

# By how much the sides of the box around a circle may differ from its diameter, as a share of the
# radius, and what its steps turn in all from a whole turn, degrees.
_ROUND = 0.2
_ALIKE_CIRCLE = 20.0

# Degrees between the heading and a wall: up to the first, the wall is ahead; up to the second,
# ahead on one side; up to the third, on that side; beyond that, behind.
_AHEAD = 30.0
_HALF_AHEAD = 65.0
_BESIDE = 125.0

# Minimum share of a period's touches that must be on one side for that side to be named.
_MOSTLY = 0.8


# Without a proof, moves count as repeated if the same ones come again and again to the end: turns
# within this many degrees and lengths within this share of the longest step, for at least two
# repetitions and this many steps.
_ALIKE_TURN = 1.0
_ALIKE_LENGTH = 0.05
_FEWEST_ALIKE = 60

# Steps before the end of a run in which repetitions are looked for.
_MOST_SEARCHED = 6_000


class LastPart(NamedTuple):
    """The part of a run that shows why it does not end well.

    Args:
        first: The number of steps before it.
        last: Its last step.
        period: After how many steps its moves recur; 0 if they don't.
        is_proved: True if it is one period of a loop, so that it repeats endlessly.
    """

    first: int
    last: int
    period: int = 0
    is_proved: bool = False

    @property
    def words(self) -> str:
        """The part in words, such as ``its last 24 steps``."""
        count = self.last - self.first
        steps = f"{count:,} {'step' if count == 1 else 'steps'}"
        if self.is_proved:
            return f"one period of its loop, {steps}"
        if count == 1:
            return "its last step"
        return f"its last {steps}"


def last_part(episode: Episode) -> LastPart | None:
    """Return one period of a loop, the moves that recur at the end, or else the last steps.

    Those are the second half of a run without an end, and one step of a controller that fails.
    ``None`` without a recording of a single robot.
    """
    trace = episode.trace
    evidence = episode.evidence
    if trace is None or not trace.steps:
        return None
    if isinstance(evidence, LoopEvidence):
        last = evidence.entry + evidence.period
        return LastPart(evidence.entry, last, evidence.period, is_proved=True)
    if isinstance(evidence, FaultEvidence):
        return LastPart(episode.steps - 1, episode.steps)
    if isinstance(evidence, BudgetEvidence) and (period := _recurrence(trace)):
        # Without a proof, several repetitions show what also changes from one to the next.
        times = math.ceil(_FEWEST_ALIKE / period)
        return LastPart(trace.steps - times * period, trace.steps, period)
    # What ends a run, such as a fire, shows in its last steps; what wastes its time does not.
    late = trace.steps // 2 if isinstance(evidence, BudgetEvidence) else trace.steps - _FEWEST_ALIKE
    return LastPart(max(late, 0), trace.steps)


def _recurrence(trace: Trace) -> int:
    """Return after how many steps the moves at the end of a run recur; 0 if they don't."""
    # Look at the turn and the length of each step before the end.
    count = min(trace.steps, _MOST_SEARCHED)
    steps = np.arange(trace.steps - count, trace.steps)
    turns = _turns(trace, steps)
    lengths = np.hypot(np.diff(trace.x), np.diff(trace.y))[steps]
    far = _ALIKE_LENGTH * max(float(lengths.max()), 1e-9)

    # Find the shortest period after which they are alike.
    for period in range(1, count // 3 + 1):
        window = max(2 * period, _FEWEST_ALIKE)
        if window + period > count:
            break
        # Most periods are refuted by the last step.
        for size in (1, window):
            now = slice(count - size, count)
            before = slice(count - size - period, count - period)
            apart = turns[now] - turns[before]
            apart -= 360.0 * np.round(apart / 360.0)
            if np.abs(apart).max() > _ALIKE_TURN:
                break
            if np.abs(lengths[now] - lengths[before]).max() > far:
                break
        else:
            return period
    return 0


def lap_of(world: World, trace: Trace, period: int) -> int:
    """Return after how many steps a robot whose moves recur is back, having turned once; else 0.

    Only away from walls: what a robot does at walls, these decide.

    Args:
        world: World of the run.
        trace: The run's recording.
        period: Steps after which its moves recur, at the end of the run.
    """
    turns = _turns(trace, np.arange(trace.steps - period, trace.steps))
    turned = abs(float(turns.sum()))
    # What turns around within one period need not be on its way around anything.
    if not turned or turned >= 180.0:
        return 0
    # One of the steps about where the lap is complete ends nearest to where it began.
    around = 360.0 / turned * period
    steps = np.arange(1, trace.steps // 2 + 1)
    steps = steps[np.abs(steps - around) <= period / 2]
    if not len(steps):
        return 0
    apart = np.hypot(trace.x[-1] - trace.x[-1 - steps], trace.y[-1] - trace.y[-1 - steps])
    nearest = int(np.argmin(apart))
    lap = int(steps[nearest])
    is_back = apart[nearest] <= SAME_PLACE * world.robot_radius
    return lap if is_back and float(trace.bump[-lap:].mean()) < RARELY else 0


def _circle(world: World, trace: Trace, first: int, last: int) -> str:
    """Return how a range of steps drives a circle; empty if it drives none."""
    around = slice(first, last + 1)
    x = trace.x[around]
    y = trace.y[around]
    turned = float(_turns(trace, np.arange(first, last)).sum())
    dx, dy = np.diff(x), np.diff(y)
    radius = float(np.hypot(dx, dy).sum()) / math.tau
    # As wide and as high as a circle of that length.
    is_round = all(abs(float(np.ptp(along)) - 2.0 * radius) <= _ROUND * radius for along in (x, y))
    is_wide = radius >= TIGHTEST_CIRCLE * world.robot_radius
    touches = float(trace.bump[first + 1 : last + 1].mean())
    is_once = abs(abs(turned) - 360.0) <= _ALIKE_CIRCLE
    if touches >= RARELY or not (is_round and is_wide and is_once):
        return ""
    heading = trace.heading[first:last]
    backwards = float((dx * np.cos(heading) + dy * np.sin(heading)).sum()) < 0.0
    side = "left" if turned > 0.0 else "right"
    return f"{'backwards, ' if backwards else ''}with a radius of {rounded(radius, 2)} m, turning {side}"


@dataclass
class _Move:
    """Consecutive steps that turn to the same side, or not at all, and drive in one direction.

    Args:
        steps: Number of steps.
        turn: Total turn, degrees; left is positive.
        length: Path length, m.
        backwards: True if the robot drives backwards.
        pushes: True if a wall stops the robot altogether.
        begins_at: Direction, in words, of the wall that the robot has just begun to touch before it
            moves; empty if it touches none, or still the same one.
    """

    steps: int
    turn: float
    length: float
    backwards: bool
    pushes: bool
    begins_at: str = ""

    def goes_on(self, turn: float, length: float, backwards: bool) -> bool:
        """Return True if a step is part of this move; one in place may be part of any."""
        drives_alike = not length or not self.length or backwards == self.backwards
        return drives_alike and _side(turn) == _side(self.turn)


def describe_period(world: World, episode: Episode) -> str:
    """Return what the robot repeats: ``repeats 2 steps (0.03 s, 0 m): it turns ...``.

    Args:
        world: World of the run.
        episode: The run, recorded.

    Returns:
        The words, to follow ``it``; empty unless a single robot loops or runs out of time.

    Raises:
        OutOfTime: If there is no more time.
    """
    words = _of_last_part(world, episode)
    missed = describe_missed_goal(world, episode)
    return f"{words}; it {missed}" if words and missed else words


def _of_last_part(world: World, episode: Episode) -> str:
    part = last_part(episode)
    trace = episode.trace
    if part is None or trace is None:
        return ""
    if not isinstance(episode.evidence, LoopEvidence | BudgetEvidence):
        return ""
    last = part.last
    first = last - part.period if part.period else part.first
    length = float(np.hypot(np.diff(trace.x), np.diff(trace.y))[first:last].sum())
    seconds = rounded((last - first) * trace.time_step, 3)
    size = f"({seconds} s, {rounded(length, 2)} m)"
    steps = f"{counted(last - first, 'step')} {size}"
    again = f"the same {steps}" if last - first > 1 else f"the same step {size}"
    bearings = WallBearings(world, trace, at_once=reacts_at_once(trace))
    if not part.period:
        return (
            f"does not repeat itself; in its last {steps} {_summary(bearings, trace, first, last)}"
        )
    lap = part.period if part.is_proved else lap_of(world, trace, part.period)
    if lap and (circle := _circle(world, trace, last - lap, last)):
        same = "the same" if part.is_proved else "about the same"
        seconds = rounded(lap * trace.time_step, 3)
        return f"drives {same} circle again and again, {circle}, in {lap} steps ({seconds} s)"
    # A period may have more than 100,000 moves, so stop at the first that is too many.
    moves = list(itertools.islice(_moves(bearings, trace, first, last), _MOST_MOVES + 1))
    begin = f"repeats {steps}" if part.is_proved else f"ends by repeating about {again}"
    if len(moves) > _MOST_MOVES:
        return f"{begin}: {_summary(bearings, trace, first, last)}"
    # A touch is named where it begins, so one that never ends has no place.
    if trace.bump[first:last].all() and not any(move.begins_at for move in moves):
        begin += ", always touching a wall"
    drift = ""
    if isinstance(episode.evidence, BudgetEvidence) and episode.evidence.memory_drift:
        drift = f"; its pose repeats, and {describe_memory_drift(episode.evidence)}"
    return f"{begin}: {_in_order([_describe(move, world.robot_radius) for move in moves])}{drift}"


def _in_order(told: list[str]) -> str:
    """Return moves in their order, each repetition only once.

    Moves may recur while the controller's memory differs.
    """
    # The shortest part that gives the whole period if it is repeated.
    size = next(n for n in range(1, len(told) + 1) if told[:n] * (len(told) // n) == told)
    times = len(told) // size
    if size == 1 and times > 1:
        return f"{told[0]}, {times} times"
    parts = [(words, len(list(same))) for words, same in itertools.groupby(told[:size])]
    once = "; ".join(words if count == 1 else f"{words}, {count} times" for words, count in parts)
    return once if times == 1 else f"{once}; all of this {times} times"


def _moves(bearings: WallBearings, trace: Trace, first: int, last: int) -> Iterator[_Move]:
    """Yield the moves of a range of steps, each with the touch that comes before it."""
    move: _Move | None = None
    turns = _reactions(bearings, trace, first, last)
    # Join each step to the move before it, unless it turns or drives in another way.
    for step in in_time(range(first, last)):
        turn = float(turns[step - first])
        dx = float(trace.x[step + 1] - trace.x[step])
        dy = float(trace.y[step + 1] - trace.y[step])
        length = math.hypot(dx, dy)
        # The wheels drive along the heading that the robot had before it turned at the step's end.
        heading = float(trace.heading[step])
        backwards = dx * math.cos(heading) + dy * math.sin(heading) < -_BACKWARDS * length
        before = last - 1 if step == first else step - 1
        touches_anew = trace.bump[step] and not trace.bump[before]
        in_place = length == 0.0 and trace.bump[step]
        wall = _wall(bearings, step) if touches_anew or in_place else ""
        if move is not None and not wall and move.goes_on(turn, length, backwards):
            move.steps += 1
            move.turn += turn
            move.length += length
            move.backwards |= backwards
            continue
        if move is not None:
            yield move
        pushes = not length and bool(trace.bump[step + 1])
        move = _Move(1, turn, length, backwards, pushes, wall)
    if move is not None:
        yield move


def _describe(move: _Move, radius: float) -> str:
    touch = f"with a wall {move.begins_at}, it " if move.begins_at else "it "
    if _side(move.turn) == 0 and not move.length:
        return touch + ("pushes against it" if move.pushes else "stays there")
    if _side(move.turn) == 0:
        return (
            f"{touch}drives {rounded(move.length, 2)} m "
            f"{'backwards' if move.backwards else 'straight on'}"
        )
    side = "left" if move.turn > 0.0 else "right"
    amount = f"{in_degrees(abs(move.turn))} {side}"
    if move.steps == 1 and abs(move.turn) >= _AROUND:
        amount = "around"
    elif move.steps > 1:
        amount += f" in {move.steps} steps"
    if move.length < _ON_THE_SPOT * radius:
        return f"{touch}turns {amount}"
    drives = f"drives {rounded(move.length, 2)} m" + (" backwards" if move.backwards else "")
    return f"{touch}turns {amount} and {drives}"


def _summary(bearings: WallBearings, trace: Trace, first: int, last: int) -> str:
    """Return the moves of a long period in total: turns, touches and their side.

    A turn is a reaction to the touch before it, so turns after a touch are kept apart
    from the others.
    """
    steps = np.arange(first, last)
    turns = _reactions(bearings, trace, first, last)
    touches = trace.bump[first:last]
    if not touches.any():
        return f"it {_in_all(turns)}, and touches no wall"
    share = max(round(100 * int(touches.sum()) / (last - first)), 1)
    often = f"it touches a wall in {share} % of its steps{_sides(bearings, steps[touches])}"
    if touches.all():
        return f"{often}, and {_in_all(turns)}"
    at_walls = _in_all(turns[touches], "there")
    return f"{often}; it {at_walls}, and {_in_all(turns[~touches], 'in between')}"


def _in_all(turns: Floats, where: str = "in all") -> str:
    """Return how far some steps turn in total: ``turns 30 degrees left in all``."""
    sides = {"left": turns[turns > 0.0], "right": turns[turns < 0.0]}
    total = {side: float(np.abs(own).sum()) for side, own in sides.items()}
    parts = [
        f"{in_degrees(degrees)} {side}" for side, degrees in total.items() if degrees >= _NOTICED
    ]
    return f"turns {' and '.join(parts)} {where}" if parts else f"does not turn {where}"


def _sides(bearings: WallBearings, touched: Ints) -> str:
    """Return on which side the robot touches walls, if not only ahead: a wall follower has one."""
    degrees = np.degrees(bearings(touched))
    lefts = degrees[np.abs(degrees) > _AHEAD] > 0.0
    if not len(lefts):
        return ""
    left = int(lefts.sum())
    for side, count in (("left", left), ("right", len(lefts) - left)):
        if count >= _MOSTLY * len(lefts):
            return f", nearly always on its {side}"
    changes = int((lefts != np.roll(lefts, 1)).sum())
    return f", changing sides {changes} times"


def _wall(bearings: WallBearings, step: int) -> str:
    """Return where the wall that the robot touches after a step is."""
    degrees = math.degrees(bearings(np.array([step]))[0])
    side = "left" if degrees > 0.0 else "right"
    if abs(degrees) <= _AHEAD:
        return "ahead"
    if abs(degrees) <= _HALF_AHEAD:
        return f"ahead on its {side}"
    return f"on its {side}" if abs(degrees) <= _BESIDE else "behind"


def reacts_at_once(trace: Trace) -> bool:
    """Return True if touches mostly change the turn in their own step, not in the step after it.

    Both occur: a controller may look at the touch itself, or at a memory of it.
    """
    begins = 1 + np.flatnonzero(trace.bump[1:] & ~trace.bump[:-1])
    begins = begins[begins > 1]
    if not len(begins):
        return False
    change = _turns(trace, begins - 1) - _turns(trace, begins - 2)
    return bool((np.abs(change) >= _STRAIGHT).mean() > 0.5)


def _reactions(bearings: WallBearings, trace: Trace, first: int, last: int) -> Floats:
    """Return the turn with which the robot reacts to the state at the start of each step."""
    steps = np.arange(first, last)
    if bearings.at_once:
        # A period begins as it ends.
        steps = np.append(last - 1, steps[:-1])
    return _turns(trace, steps)


def _turns(trace: Trace, steps: Ints) -> Floats:
    """Return the turn between the states before and after each step, degrees; left is positive."""
    turns = trace.heading[steps + 1] - trace.heading[steps]
    found: Floats = np.degrees(turns - math.tau * np.round(turns / math.tau))
    return found


def _side(turn: float) -> int:
    return 0 if abs(turn) < _STRAIGHT else int(math.copysign(1, turn))
