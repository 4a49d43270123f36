"""Everything that can happen to a robot with chance.

All states that some draws lead to, and what follows each. A random controller draws one of a few
values (``coin``), and its poses are on a lattice (``lattice``), so the states that it can be in are
finite in number, often few enough to look at each. If the target can be reached from every one of
them, the robot arrives with probability one; if from none, it never arrives, whatever it draws;
else some draws are its end.

Source: John Kemeny and Laurie Snell, "Finite Markov chains", 1960, chapter 3: absorbing chains.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers import CompiledController, Controller, controller_of
from sim.controllers.base import robot_for
from sim.controllers.shared.guarded import ControllerDied, call
from sim.motion import MOTIONS
from sim.options.run import RunOptions
from sim.runners.core_calls import CoreEpisode, Driver
from sim.runners.lattice import LatticeRun
from sim.trace import Trace
from worldgen.errors import InvalidParameter
from worldgen.support.ccall import check, pointer, writable
from worldgen.world import World

__all__ = ["ARRIVED", "ENDED", "UNSEEN", "Outcomes", "explore", "states_of", "why_not_explored"]

ARRIVED = -1
ENDED = -2
"""What may follow a state instead of another one.

The target, or an end elsewhere, such as a command that is none, or a
crash."""

UNSEEN = -1
"""Of the next random number.

That the controller has not looked at it yet, so that any value is equally likely.
"""

_DRAWS = 4  # the word of a state that counts the draws
_NOT_DONE = -1  # an ending of a step that has not been made

Ints = npt.NDArray[np.int64]
Following: TypeAlias = tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class Outcomes:
    """States that some draws lead to, and what follows each.

    Args:
        coin: How many values a random number has.
        states: (n, k) complete states; the first is the start. The number of draws in them is 0.
        faces: (n,) which value the next random number has, from 0, or :data:`UNSEEN`.
        following: What may follow each state: the value that leads there, and the number of the
            state, :data:`ARRIVED` or :data:`ENDED`. Where the value makes no difference there is
            one entry, with :data:`UNSEEN`.
        ranks: (n,) fewest steps to the target, from 1; 0 where none lead there.
    """

    coin: int
    states: Ints
    faces: Ints
    following: tuple[Following, ...]
    ranks: tuple[int, ...]

    @property
    def chance(self) -> str:
        """``sure`` (with probability one the robot arrives), ``trap`` (it never does) or ``part``."""
        if not self.ranks[0]:
            return "trap"
        return "part" if any(map(self._is_lost, range(len(self.ranks)))) else "sure"

    def way_to_loss(self) -> tuple[tuple[int, ...], int]:
        """The fewest steps after which all is lost.

        The values drawn on the way there, and the number of steps.

        Raises:
            ValueError: If the robot arrives whatever it draws.
        """
        if not self.ranks[0]:
            return (), 0
        before: dict[int, tuple[int, int]] = {}
        queue = deque([0])
        while queue:
            number = queue.popleft()
            for face, after in self.following[number]:
                if after == ENDED or (after >= 0 and not self.ranks[after]):
                    return _drawn({**before, after: (number, face)}, after)
                if after > 0 and after not in before:
                    before[after] = (number, face)
                    queue.append(after)
        raise ValueError("nothing is ever lost")

    def _is_lost(self, number: int) -> bool:
        return not self.ranks[number] or any(after == ENDED for _, after in self.following[number])


def why_not_explored(controller: Controller, world: World, options: RunOptions) -> str:
    """Why not everything that can happen to a robot can be looked at.

    Empty if only its amount may stand against it.

    Args:
        controller: The controller.
        world: Where.
        options: Of the run.
    """
    if not isinstance(controller, CompiledController):
        return "only what a compiled controller may do can be looked at"
    if MOTIONS.get(options.motion).name != "swept":
        return "only the motion model swept has a lattice of poses on which no wall is ever entered"
    robot = robot_for(controller, options.robot)
    if world.is_dynamic:
        return "the world changes"
    if robot.random:
        return "the simulator draws random numbers of its own, for slip or a noisy sensor"
    if "time" in controller.senses:
        return "the controller reads the clock, so it never comes back to a state"
    if "random" in controller.senses and not robot.coin:
        return "a random number may be any below 1; give it few values with +coin=N"
    return ""


def explore(
    world: World, controller: str | Controller, options: RunOptions, *, most: int
) -> Outcomes | None:
    """Looks at every state that some draws lead to.

    Args:
        world: One that does not change.
        controller: The controller, or its name.
        options: ``swept``, with a robot whose ``coin`` and ``lattice`` make the states few.
        most: States.

    Returns:
        The states; ``None`` if there are more than ``most``.

    Raises:
        InvalidParameter: If :func:`why_not_explored` says so.
    """
    found = controller_of(controller)
    against = why_not_explored(found, world, options)
    if against or not isinstance(found, CompiledController):
        raise InvalidParameter(
            "not-explorable",
            "not everything that can happen can be looked at: {reason}",
            reason=against,
        )
    search = _Search(LatticeRun(world, found, options), found, most)
    return search.outcomes() if search.run() else None


def states_of(trace: Trace) -> Ints:
    """The states of a recording as :class:`Outcomes` has them.

    (n + 1, k), without the number of draws.
    """
    states = trace.states.view(np.int64).copy()
    states[:, _DRAWS] = 0
    return states


class _Search:
    """Breadth first, all states of one distance in one call of the core."""

    def __init__(self, run: LatticeRun, controller: CompiledController, most: int) -> None:
        self._run = run
        self._controller = controller
        self._most = most
        self.coin = max(run.options.robot.coin, 1)
        start = self._start()
        self._numbers: dict[tuple[bytes, int], int] = {(start.tobytes(), UNSEEN): 0}
        self._states = [start]
        self._faces = [UNSEEN]
        self._following: list[Following] = []

    def run(self) -> bool:
        """Looks at all states; False if there are too many."""
        while len(self._following) < len(self._states):
            first = len(self._following)
            states = np.array(self._states[first:])
            faces = np.array(self._faces[first:], np.int64)
            self._following.extend(self._entries(states, faces))
            if len(self._states) > self._most:
                return False
        return True

    def outcomes(self) -> Outcomes:
        following = tuple(self._following)
        faces = np.array(self._faces, np.int64)
        return Outcomes(self.coin, np.array(self._states), faces, following, _ranks(following))

    def _start(self) -> Ints:
        return self._episode().state_words()

    def _episode(self) -> CoreEpisode:
        run = self._run
        return CoreEpisode(
            run.arena(), run.settings, Driver(self._controller, self._controller.memory)
        )

    def _entries(self, states: Ints, faces: Ints) -> Iterator[Following]:
        """What follows each state, in order."""
        times = np.where(faces == UNSEEN, self.coin, 1)
        first = np.cumsum(times) - times
        each = np.repeat(faces, times)
        values = np.where(each == UNSEEN, np.arange(len(each)) - np.repeat(first, times), each)
        after, endings, drew = self._step(np.repeat(states, times, axis=0), values)
        for row, count in zip(first.tolist(), times.tolist(), strict=True):
            group = slice(row, row + count)
            yield self._entry(
                after[group], endings[group].tolist(), drew[group].tolist(), values[group].tolist()
            )

    def _entry(
        self, after: Ints, endings: list[int], drew: list[int], values: list[int]
    ) -> Following:
        """What follows one state, from what each value of the random number makes of it."""
        alike = len(set(endings)) == 1 and len(set(drew)) == 1 and bool((after == after[0]).all())
        if len(values) > 1 and alike:  # it was not looked at, or makes no difference
            return ((UNSEEN, self._number(after[0], endings[0], UNSEEN)),)
        faces = [UNSEEN if used else value for used, value in zip(drew, values, strict=True)]
        numbers = [self._number(*one) for one in zip(after, endings, faces, strict=True)]
        return tuple(zip(values if len(values) > 1 else (UNSEEN,), numbers, strict=True))

    def _number(self, state: Ints, ending: int, face: int) -> int:
        """The number of a state, a new one if it is new, or how the run ended."""
        if ending != lib.WG_LIMIT:
            return ARRIVED if ending == lib.WG_REACHED else ENDED
        key = (state.tobytes(), face)
        if key not in self._numbers:
            self._numbers[key] = len(self._states)
            self._states.append(state.copy())
            self._faces.append(face)
        return self._numbers[key]

    def _step(self, states: Ints, values: Ints) -> tuple[Ints, Ints, Ints]:
        """States after one step, how it ended, and whether the random number was used up."""
        count = len(states)
        episode = self._episode()
        if episode.guarded:
            return self._step_guarded(episode, states, values)
        after = np.empty_like(states)
        endings = np.zeros(count, np.int64)
        drew = np.zeros(count, np.int64)
        check(
            lib.wg_outcomes(
                episode.c,
                pointer(ffi, states, np.int64),
                pointer(ffi, values, np.int64),
                count,
                writable(ffi, after, np.int64),
                writable(ffi, endings, np.int64),
                writable(ffi, drew, np.int64),
            )
        )
        return after, endings, drew

    def _step_guarded(
        self, episode: CoreEpisode, states: Ints, values: Ints
    ) -> tuple[Ints, Ints, Ints]:
        """The same in another process.

        Where it ends, the state that it was at is one in which the controller fails.
        """
        memory = self._run.memory
        after = memory.own(states)
        drew = memory.zeros(len(states), np.int64)
        endings = memory.zeros(len(states), np.int64)
        endings[...] = _NOT_DONE
        arrays = (memory.own(states), memory.own(values), after, endings, drew)
        done = 0
        while done < len(states):
            objects = (episode.c, *(pointer(ffi, array[done:], np.int64) for array in arrays))
            report = ffi.addressof(episode.report)
            made = ffi.from_buffer(endings[done:])
            try:
                work = ffi.addressof(lib, "wg_call_outcomes")
                left = len(states) - done
                check(
                    call(
                        work, episode.guarded, objects, left, report=report, progress=(made,)
                    ).result
                )
                done = len(states)
            except ControllerDied:
                done += int((endings[done:] == _NOT_DONE).argmax())
                after[done] = states[done]
                after[done, _DRAWS] = 0
                endings[done] = lib.WG_CRASH
                done += 1
        return after, endings, drew


def _ranks(following: tuple[Following, ...]) -> tuple[int, ...]:
    """Fewest steps from each state to the target; 0 where none lead there."""
    before: list[list[int]] = [[] for _ in following]
    ranks = [0] * len(following)
    queue = deque[int]()
    for number, entry in enumerate(following):
        if any(after == ARRIVED for _, after in entry):
            ranks[number] = 1
            queue.append(number)
        for _, after in entry:
            if after >= 0:
                before[after].append(number)
    while queue:
        number = queue.popleft()
        for earlier in before[number]:
            if not ranks[earlier]:
                ranks[earlier] = ranks[number] + 1
                queue.append(earlier)
    return tuple(ranks)


def _drawn(before: dict[int, tuple[int, int]], number: int) -> tuple[tuple[int, ...], int]:
    """The values drawn on the way to a state, and its steps."""
    values = []
    steps = 0
    while number in before:
        number, face = before[number]
        steps += 1
        if face != UNSEEN:
            values.append(face)
    return tuple(reversed(values)), steps
