"""Compositions of the library's behaviours in plain Python: parts, arbiters, behaviours.

The memory is that of ``WgComposition``: the shared state (5 numbers), the part that acted, the
arbiter, the number of parts; then 8 numbers for each part; then the state of some arbiters; then
the parts' states.

Sources: the thesis on behaviour-based search and rescue robots that this program descends from
    (2005-2006), sections 3, 4 and 6; Rodney A. Brooks, "A robust layered control system for a
    mobile robot" (1986); Julio K. Rosenblatt, "DAMN: a distributed architecture for mobile
    navigation" (1997); Pattie Maes and Rodney A. Brooks, "Learning to coordinate behaviors" (1990).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers import _boundary as body
from tests.reference.sim.controllers._directions import bearing_of, steer, wrap
from tests.reference.sim.controllers.thesis import SNAP, TURN_STEP, turn_towards

Floats = npt.NDArray[np.float64]

BEHAVIOUR, COUNTER, TARGET, SPEED, OLD_SPEED, ACTED, ARBITER, COUNT = range(8)
HEAD = 8
PART = 8
PRIORITY, VOTE, LEARNING = 0, 1, 2
CONDITIONS = 4

_TURN = 2.0 * math.pi
_UNITS = layout.TURN / _TURN
_AHEAD = 60.0 * (math.pi / 180.0)
_ASIDE = 75.0 * (math.pi / 180.0)
_STRONGER = 1.02
_SPREAD = 0.5 * math.pi
_DIRECTIONS = 32


def _units(radians: float) -> int:
    return math.floor(radians * _UNITS + 0.5) % layout.TURN


class Behaviour:
    """The base of all behaviours; ``state`` is a view of the memory."""

    size = 0
    keeps_time = False
    restarts = False

    def __init__(self, options: Floats) -> None:
        self.options = options

    def trigger(self, seen: Floats, shared: Floats, state: Floats) -> bool:
        return True

    def watch(self, seen: Floats, shared: Floats, state: Floats) -> None:
        """Nothing."""

    def begin(self, seen: Floats, shared: Floats, state: Floats, command: Floats) -> None:
        """Nothing."""

    def action(self, seen: Floats, shared: Floats, state: Floats, command: Floats) -> bool:
        raise NotImplementedError


def _towards(seen: Floats, command: Floats, direction: float, speed: float) -> None:
    steer(seen, command, wrap(direction - seen[layout.OBS_HEADING]), speed)


class _OfTheThesis(Behaviour):
    keeps_time = True

    def turn_on(self, seen: Floats, shared: Floats, command: Floats) -> bool:
        heading = _units(seen[layout.OBS_HEADING])
        target = int(shared[TARGET])
        if heading == target:
            return True
        rest = turn_towards(heading, target)
        turn = rest if abs(rest) <= SNAP else (TURN_STEP if rest > 0 else -TURN_STEP)
        command[layout.CMD_TURN_RATE] = turn / _UNITS / seen[layout.OBS_TIME_STEP]
        return False

    def drive(self, seen: Floats, shared: Floats, command: Floats) -> None:
        command[layout.CMD_SPEED] = shared[SPEED] * seen[layout.OBS_TOP_SPEED]


class Collide(_OfTheThesis):
    restarts = True

    def trigger(self, seen, shared, state):
        return seen[layout.OBS_BUMP] != 0.0

    def begin(self, seen, shared, state, command):
        heading = _units(seen[layout.OBS_HEADING])
        shared[OLD_SPEED] = shared[SPEED]
        shared[SPEED] = 0.0
        if self.options[0] == 1.0:
            shared[TARGET] = (heading - layout.TURN // 4) % layout.TURN
        elif self.options[0] == 2.0:
            shared[TARGET] = (heading + layout.TURN // 4) % layout.TURN
        else:
            shared[TARGET] = math.floor(seen[layout.OBS_RANDOM] * layout.TURN)
            command[layout.CMD_DRAW] = 1.0

    def action(self, seen, shared, state, command):
        done = False
        if self.turn_on(seen, shared, command):
            done = shared[COUNTER] < 0.0
            if not done:
                shared[SPEED] = shared[OLD_SPEED]
                shared[COUNTER] -= 1.0
        self.drive(seen, shared, command)
        return done


class Seek(_OfTheThesis):
    def trigger(self, seen, shared, state):
        return seen[layout.OBS_BUMP] == 0.0

    def action(self, seen, shared, state, command):
        shared[SPEED] = 0.0
        shared[TARGET] = _units(seen[layout.OBS_SIGNAL_HEADING])
        done = self.turn_on(seen, shared, command)
        self.drive(seen, shared, command)
        return done


class Drive(_OfTheThesis):
    restarts = True

    def trigger(self, seen, shared, state):
        signal = _units(seen[layout.OBS_SIGNAL_HEADING])
        return seen[layout.OBS_BUMP] == 0.0 and int(shared[TARGET]) == signal

    def action(self, seen, shared, state, command):
        done = not (shared[COUNTER] >= 0.0 and seen[layout.OBS_BUMP] == 0.0)
        if not done:
            shared[SPEED] = 1.0
            shared[COUNTER] -= 1.0
        self.drive(seen, shared, command)
        return done


class Avoid(Behaviour):
    size = 1
    restarts = True

    def trigger(self, seen, shared, state):
        return seen[layout.OBS_BUMP] != 0.0

    def begin(self, seen, shared, state, command):
        away = self.options[0]
        if seen[layout.OBS_BUMP_BEARING] > 0.0:
            away = -away
        state[0] = wrap(body.touched(seen) + away)

    def action(self, seen, shared, state, command):
        _towards(seen, command, state[0], self.options[1] * seen[layout.OBS_TOP_SPEED])
        return False


class Follow(Behaviour):
    size = body.BODY_SIZE + 2
    FRESH = body.BODY_SIZE
    SIGNAL = body.BODY_SIZE + 1

    def trigger(self, seen, shared, state):
        turn = wrap(seen[layout.OBS_SIGNAL_HEADING] - body.touched(seen))
        return seen[layout.OBS_BUMP] != 0.0 and abs(turn) < 0.5 * math.pi

    def begin(self, seen, shared, state, command):
        state[body.HAND] = self.options[0]
        state[self.FRESH] = 1.0
        state[self.SIGNAL] = seen[layout.OBS_SIGNAL]
        body.begin_following(state, body.touched(seen))

    def action(self, seen, shared, state, command):
        done = False
        if state[self.FRESH] == 0.0:
            body.feel(seen, state)
            turn = wrap(seen[layout.OBS_SIGNAL_HEADING] - state[body.WALL])
            stronger = seen[layout.OBS_SIGNAL] > _STRONGER * state[self.SIGNAL]
            done = body.has_lost_it(state) or (abs(turn) > 0.5 * math.pi and stronger)
        state[self.FRESH] = 0.0
        body.follow(seen, state, command)
        return bool(done)


class Approach(Behaviour):
    def trigger(self, seen, shared, state):
        return seen[layout.OBS_SIGNAL] > 0.0

    def action(self, seen, shared, state, command):
        _towards(seen, command, seen[layout.OBS_SIGNAL_HEADING], seen[layout.OBS_TOP_SPEED])
        return False


class Escape(Behaviour):
    size = 4
    BEST, SINCE, SIDE, DIRECTION = range(4)

    def watch(self, seen, shared, state):
        if seen[layout.OBS_SIGNAL] > state[self.BEST]:
            state[self.BEST] = seen[layout.OBS_SIGNAL]
            state[self.SINCE] = 0.0
        else:
            state[self.SINCE] = min(state[self.SINCE] + 1.0, self.options[0])

    def trigger(self, seen, shared, state):
        return state[self.SINCE] >= self.options[0]

    def begin(self, seen, shared, state, command):
        state[self.SIDE] = -1.0 if state[self.SIDE] > 0.0 else 1.0
        state[self.BEST] = 0.0
        state[self.SINCE] = 0.0
        turn = state[self.SIDE] * self.options[1]
        state[self.DIRECTION] = wrap(seen[layout.OBS_SIGNAL_HEADING] + turn)

    def action(self, seen, shared, state, command):
        if seen[layout.OBS_BUMP] != 0.0:
            state[self.DIRECTION] = wrap(state[self.DIRECTION] + state[self.SIDE] * 0.5 * math.pi)
        _towards(seen, command, state[self.DIRECTION], seen[layout.OBS_TOP_SPEED])
        return False


class Home(Behaviour):
    def action(self, seen, shared, state, command):
        most = seen[layout.OBS_TARGET_DISTANCE] / seen[layout.OBS_TIME_STEP]
        speed = min(seen[layout.OBS_TOP_SPEED], most)
        _towards(seen, command, seen[layout.OBS_TARGET_HEADING], speed)
        return False


class Swerve(Behaviour):
    def nearest(self, seen):
        beams = seen[layout.OBS_SIZE :]
        nearest = seen[layout.OBS_RADIUS] + self.options[0]
        found = -1
        for beam, distance in enumerate(beams):
            if abs(wrap(bearing_of(beam, len(beams)))) <= _AHEAD and distance < nearest:
                nearest = distance
                found = beam
        return found

    def trigger(self, seen, shared, state):
        return self.nearest(seen) >= 0

    def action(self, seen, shared, state, command):
        beam = self.nearest(seen)
        turn = 0.0
        if beam >= 0:
            bearing = wrap(bearing_of(beam, len(seen) - layout.OBS_SIZE))
            turn = bearing + (-_ASIDE if bearing >= 0.0 else _ASIDE)
        steer(seen, command, turn, self.options[1] * seen[layout.OBS_TOP_SPEED])
        return False


class Wander(Behaviour):
    size = 2
    LEFT, DIRECTION = range(2)

    def action(self, seen, shared, state, command):
        if state[self.LEFT] <= 0.0 or seen[layout.OBS_BUMP] != 0.0:
            state[self.DIRECTION] = wrap(seen[layout.OBS_RANDOM] * _TURN)
            state[self.LEFT] = self.options[0]
            command[layout.CMD_DRAW] = 1.0
        state[self.LEFT] -= seen[layout.OBS_TOP_SPEED] * seen[layout.OBS_TIME_STEP]
        _towards(seen, command, state[self.DIRECTION], seen[layout.OBS_TOP_SPEED])
        return False


KINDS = (Collide, Seek, Drive, Avoid, Follow, Approach, Escape, Home, Swerve, Wander)
"""In the order of the core's list."""


class _Part:
    """A part of a composition, with views of its numbers in the memory."""

    def __init__(self, stored: Floats, state: Floats) -> None:
        self.does = KINDS[int(stored[0])](stored[4:8])
        self.priority = float(stored[1])
        self.duration = float(stored[2])
        self.interruptible = stored[3] != 0.0
        self.state = state

    def act(self, begins: bool, seen: Floats, shared: Floats, command: Floats) -> bool:
        if begins:
            shared[COUNTER] = self.duration
            self.does.begin(seen, shared, self.state, command)
        done = self.does.action(seen, shared, self.state, command)
        if not self.does.keeps_time:
            shared[COUNTER] -= 1.0
            done = done or shared[COUNTER] <= 0.0
        return bool(done)


def _by_priority(parts: list[_Part], seen: Floats, shared: Floats, command: Floats) -> int:
    active = int(shared[BEHAVIOUR])
    for part in parts:
        part.does.watch(seen, shared, part.state)
    chosen = active
    begins = False
    if active < 0 or parts[active].interruptible:
        # Return the first with the highest priority among those that apply and the one in charge.
        order = sorted(range(len(parts)), key=lambda k: -parts[k].priority)
        chosen = -1
        for k in order:
            asked = k != active or parts[k].does.restarts
            wants = asked and bool(parts[k].does.trigger(seen, shared, parts[k].state))
            if wants or k == active:
                chosen = k
                begins = wants
                break
    if chosen < 0:
        shared[BEHAVIOUR] = -1.0
        return -1
    shared[BEHAVIOUR] = chosen
    if parts[chosen].act(begins, seen, shared, command):
        shared[BEHAVIOUR] = -1.0
        shared[COUNTER] = 0.0
    return chosen


def _by_vote(
    parts: list[_Part], left: Floats, seen: Floats, shared: Floats, command: Floats
) -> int:
    for part in parts:
        part.does.watch(seen, shared, part.state)
    voters: list[tuple[int, Floats]] = []
    for k, part in enumerate(parts):
        acts = left[k] > 0.0
        begins = (not acts or part.does.restarts) and part.does.trigger(seen, shared, part.state)
        if acts or begins:
            own = np.zeros(layout.CMD_SIZE)
            shared[BEHAVIOUR] = k
            shared[COUNTER] = left[k]
            done = part.act(bool(begins), seen, shared, own)
            left[k] = 0.0 if done else max(shared[COUNTER], 1.0)
            voters.append((k, own))
    shared[COUNTER] = 0.0
    shared[BEHAVIOUR] = -1.0
    if not voters:
        return -1

    def votes(direction: float) -> list[float]:
        shares = []
        for k, own in voters:
            turn = wrap(own[layout.CMD_TURN_RATE] * seen[layout.OBS_TIME_STEP])
            share = max(0.0, 1.0 - abs(wrap(direction - turn)) / _SPREAD)
            shares.append(parts[k].priority * share)
        return shares

    best = 0.0
    most = -math.inf
    for d in range(_DIRECTIONS):
        away = bearing_of((d + 1) // 2, _DIRECTIONS)
        direction = wrap(-away if d % 2 == 0 else away)
        total = 0.0
        for share in votes(direction):
            total += share
        if total > most:
            most = total
            best = direction
    weights = votes(best)
    total = 0.0
    speed = 0.0
    for (_, own), weight in zip(voters, weights, strict=True):
        total += weight
        speed += weight * own[layout.CMD_SPEED]
        if own[layout.CMD_DRAW] != 0.0:
            command[layout.CMD_DRAW] = 1.0
    heaviest = weights.index(max(weights))
    winner, own = voters[heaviest]
    turn = wrap(own[layout.CMD_TURN_RATE] * seen[layout.OBS_TIME_STEP])
    near = abs(wrap(best - turn)) <= math.pi / _DIRECTIONS
    steer(seen, command, turn if near else best, speed / total if total > 0.0 else 0.0)
    return winner


_WHOLE = 65536


def _correlation(with_it: float, acted: float, acted_with: float) -> float:
    idle_with = max(0.0, with_it - acted_with)
    active_without = max(0.0, acted - acted_with)
    idle_without = max(0.0, _WHOLE - acted - idle_with)
    scale = (
        (idle_without + active_without)
        * (idle_without + idle_with)
        * (acted_with + idle_with)
        * (acted_with + active_without)
    )
    if scale <= 0.0:
        return 0.0
    return (acted_with * idle_without - active_without * idle_with) / math.sqrt(scale)


def _learned(
    parts: list[_Part], counts: Floats, memory: Floats, seen: Floats, command: Floats
) -> int:
    """``counts``: condition, recent condition, signal; then four numbers for all parts and for each
    part.
    """
    bump = seen[layout.OBS_BUMP] != 0.0
    good = seen[layout.OBS_SIGNAL] > counts[2] and not bump
    counts[1] = 32.0 if bump else max(0.0, counts[1] - 1.0)
    counts[2] = seen[layout.OBS_SIGNAL]
    tables = counts[3:].reshape(1 + len(parts), CONDITIONS, 4)
    last = int(memory[ACTED])
    if last >= 0:
        for k, table in enumerate(tables):
            row = table[int(counts[0])]
            acted = k in (0, 1 + last)
            row[0] = min(row[0] + acted, 48.0)
            for place, now in ((1, acted), (2, acted and good), (3, acted and bump)):
                row[place] += (_WHOLE * bool(now) - int(row[place])) // 128
    if memory[BEHAVIOUR] < 0.0:
        condition = (1 if bump else 0) + (2 if counts[1] > 0.0 else 0)
        counts[0] = condition
        _, _, goods, bads = tables[0, condition]
        for part, table in zip(parts, tables[1:], strict=True):
            trials, own_acted, own_good, own_bad = table[condition]
            part.priority = 2.0
            if trials >= 48.0:
                part.priority = _correlation(goods, own_acted, own_good)
                part.priority -= _correlation(bads, own_acted, own_bad)
    for part in parts:
        part.interruptible = False
    return _by_priority(parts, seen, memory[:HEAD], command)


def act(seen: Floats, memory: Floats, command: Floats) -> None:
    """One step of a composition."""
    count = int(memory[COUNT])
    at = HEAD + PART * count
    kept = at
    arbiter = memory[ARBITER]
    if arbiter == VOTE:
        at += count
    elif arbiter == LEARNING:
        at += 3 + 4 * CONDITIONS * (1 + count)
    counts = memory[kept:at]
    parts = []
    for k in range(count):
        stored = memory[HEAD + PART * k : HEAD + PART * (k + 1)]
        size = KINDS[int(stored[0])].size
        parts.append(_Part(stored, memory[at : at + size]))
        at += size
    if arbiter == VOTE:
        acted = _by_vote(parts, counts, seen, memory[:HEAD], command)
    elif arbiter == LEARNING:
        acted = _learned(parts, counts, memory, seen, command)
    else:
        acted = _by_priority(parts, seen, memory[:HEAD], command)
    memory[ACTED] = acted
