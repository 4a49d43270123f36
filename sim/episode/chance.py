"""Explore everything that can happen to a robot whose controller draws random numbers.

A random controller draws one of a few values (``coin``), and its poses are on a lattice
(``lattice``), so it can be in a finite number of states, often few enough to visit them all. If the
target can be reached from every one of them, the robot arrives with probability one. If it can be
reached from none, the robot never arrives, whatever it draws. Otherwise some draws trap it.

Source: John Kemeny and Laurie Snell, "Finite Markov chains", 1960, chapter 3: absorbing chains.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from sim._core import ffi, lib
from sim.controllers.base import CompiledController, Controller, robot_for, senses_of
from sim.controllers.catalogue import controller_of
from sim.controllers.noise import is_noisy
from sim.controllers.shared.guarded import ControllerDied
from sim.motion import MOTIONS
from sim.options.run import TARGET, RunOptions
from sim.runners.lattice import LatticeRun
from sim.trace import Trace
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, pointer
from worldgen.world import World

ARRIVED = -1
"""Follows a state from which the robot arrives, in place of another state."""

ENDED = -2
"""Follows a state in which the run ends without arrival, as in a crash or an invalid command."""

UNSEEN = -1
"""Marks a random number that the controller has not read, so every value is equally likely."""

# Index of the word of a state that counts the draws.
_DRAWS = 4

# The ending of a step that has not been simulated yet.
_NOT_DONE = -1

Following: TypeAlias = tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class Outcomes:
    """The states that some draws lead to, and the successors of each.

    Args:
        coin: Number of values that a random number can take.
        states: (n, k) complete states, the start first. Their number of draws is set to 0.
        faces: (n,) the value that the next random number will take, from 0, or :data:`UNSEEN`.
        following: The successors of each state: pairs of the value that leads there and the number
            of the next state, :data:`ARRIVED` or :data:`ENDED`. If the value makes no difference,
            there is one pair, with :data:`UNSEEN`.
        ranks: (n,) fewest steps to the target, from 1; 0 if it cannot be reached.
    """

    coin: int
    states: Ints
    faces: Ints
    following: tuple[Following, ...]
    ranks: tuple[int, ...]

    @property
    def chance(self) -> str:
        """``sure`` if the robot arrives with probability one, ``trap`` if never, else ``part``."""
        if not self.ranks[0]:
            return "trap"
        return "part" if any(map(self._is_lost, range(len(self.ranks)))) else "sure"

    def way_to_loss(self) -> tuple[tuple[int, ...], int]:
        """Return the shortest path to a state from which the robot can no longer arrive.

        Returns:
            The values drawn along that path, and its number of steps.

        Raises:
            ValueError: If the robot arrives whatever it draws.
        """
        if not self.ranks[0]:
            return (), 0

        # Breadth first from the start, so the first lost state found is a nearest one.
        before: dict[int, tuple[int, int]] = {}
        queue = deque([0])
        while queue:
            number = queue.popleft()
            for face, after in self.following[number]:
                if after == ENDED or (after >= 0 and not self.ranks[after]):
                    return _drawn({**before, after: (number, face)}, after)
                # State 0 is the start, which is already in the queue.
                if after > 0 and after not in before:
                    before[after] = (number, face)
                    queue.append(after)
        raise ValueError("no sequence of draws makes the target unreachable")

    def _is_lost(self, number: int) -> bool:
        return not self.ranks[number] or any(after == ENDED for _, after in self.following[number])


def why_not_explored(controller: Controller, world: World, options: RunOptions) -> str:
    """Return why a run's states cannot all be explored, however few; empty if they can.

    Args:
        controller: The controller.
        world: The world that it drives in.
        options: Options of the run.
    """
    # Check the controller and the motion model first.
    if not isinstance(controller, CompiledController):
        return "only compiled controllers can be explored"
    if MOTIONS.get(options.motion).name != "swept":
        return "only the motion model swept has a lattice of poses on which no wall is ever entered"
    robot = robot_for(controller, options.robot)
    # Then check everything that makes a state's future depend on more than the state.
    if world.is_dynamic:
        return "the world changes"
    if options.task != TARGET:
        return "the cells left to cover depend on everything that happened before"
    if robot.pushes:
        return "pushes at fixed times make the future depend on the time, not only on the state"
    if robot.moved and senses_of(controller) & lib.WG_SENSE_ODOMETRY:
        return "the controller reads odometry, which disturbances falsify"
    if is_noisy(controller, options):
        # Last, check the sources of randomness, which must be few and the controller's own.
        return "the simulator draws its own random numbers, for slip or a noisy sensor"
    if "time" in controller.senses:
        return "the controller reads the clock, so it never returns to a state"
    if "random" in controller.senses and not robot.coin:
        return "a random number may be any number below 1; limit it to a few values with +coin=N"
    return ""


def explore(
    world: World, controller: str | Controller, options: RunOptions, *, most: int
) -> Outcomes | None:
    """Visit every state that some sequence of draws leads to.

    Args:
        world: A world that does not change.
        controller: The controller, or its name.
        options: ``swept``, with a robot whose ``coin`` and ``lattice`` keep the states few.
        most: The largest number of states to visit.

    Returns:
        The states; ``None`` if there are more than ``most``.

    Raises:
        InvalidParameter: If :func:`why_not_explored` returns a reason.
    """
    found = controller_of(controller)
    against = why_not_explored(found, world, options)
    if against or not isinstance(found, CompiledController):
        raise InvalidParameter(
            "not-explorable", "not every outcome can be explored: {reason}", reason=against
        )
    search = _Search(LatticeRun(world, found, options), found, most)
    return search.outcomes() if search.run() else None


def states_of(trace: Trace) -> Ints:
    """Return the states of a recording in the form that :class:`Outcomes` uses.

    Returns:
        (n + 1, k) states, with their number of draws set to 0.
    """
    states = trace.states.view(np.int64).copy()
    states[:, _DRAWS] = 0
    return states


class _Search:
    """A breadth-first search that steps all states of one depth in one call of the core."""

    def __init__(self, run: LatticeRun, controller: CompiledController, most: int) -> None:
        self._run = run
        self._controller = controller
        self._most = most
        self.coin = max(run.options.robot.coin, 1)
        start = run.episode(controller).state_words()
        self._numbers: dict[tuple[bytes, int], int] = {(start.tobytes(), UNSEEN): 0}
        self._states = [start]
        self._faces = [UNSEEN]
        self._following: list[Following] = []

    def run(self) -> bool:
        """Visit all states; return False if there are too many."""
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

    def _entries(self, states: Ints, faces: Ints) -> Iterator[Following]:
        """Yield the successors of each state, in order."""
        # A state whose random number is unread is stepped once for each value; others once.
        times = np.where(faces == UNSEEN, self.coin, 1)
        first = np.cumsum(times) - times
        each = np.repeat(faces, times)
        values = np.where(each == UNSEEN, np.arange(len(each)) - np.repeat(first, times), each)
        after, endings, drew = self._step(np.repeat(states, times, axis=0), values)

        # Gather the rows that belong to one state.
        for row, count in zip(first.tolist(), times.tolist(), strict=True):
            group = slice(row, row + count)
            yield self._entry(
                after[group], endings[group].tolist(), drew[group].tolist(), values[group].tolist()
            )

    def _entry(
        self, after: Ints, endings: list[int], drew: list[int], values: list[int]
    ) -> Following:
        """Return the successors of one state, given where each value of the random number leads."""
        alike = len(set(endings)) == 1 and len(set(drew)) == 1 and bool((after == after[0]).all())
        # The controller did not read the number, or its value makes no difference.
        if len(values) > 1 and alike:
            return ((UNSEEN, self._number(after[0], endings[0], UNSEEN)),)
        faces = [UNSEEN if used else value for used, value in zip(drew, values, strict=True)]
        numbers = [self._number(*one) for one in zip(after, endings, faces, strict=True)]
        return tuple(zip(values if len(values) > 1 else (UNSEEN,), numbers, strict=True))

    def _number(self, state: Ints, ending: int, face: int) -> int:
        """Return the number of a state, adding it if it is new, or how the run ended."""
        if ending != lib.WG_LIMIT:
            return ARRIVED if ending == lib.WG_REACHED else ENDED
        key = (state.tobytes(), face)
        if key not in self._numbers:
            self._numbers[key] = len(self._states)
            self._states.append(state.copy())
            self._faces.append(face)
        return self._numbers[key]

    def _step(self, states: Ints, values: Ints) -> tuple[Ints, Ints, Ints]:
        """Return the states after one step, the endings, and whether the random number was used."""
        # Move all arrays to memory that the core can use, in this process or in another.
        episode = self._run.episode(self._controller)
        memory = self._run.memory
        after = memory.zeros(states.shape, np.int64)
        drew = memory.zeros(len(states), np.int64)
        endings = memory.zeros(len(states), np.int64)
        endings[...] = _NOT_DONE
        arrays = (memory.own(states), memory.own(values), after, endings, drew)
        # If another process dies, the controller failed in the first state without an ending:
        # record a crash for it, and resume after it.
        done = 0
        while done < len(states):
            objects = (episode.c, *(pointer(ffi, array[done:], np.int64) for array in arrays))
            made = ffi.from_buffer(endings[done:])
            try:
                check(episode.call("wg_call_outcomes", objects, len(states) - done, (made,)))
                done = len(states)
            except ControllerDied:
                done += int((endings[done:] == _NOT_DONE).argmax())
                after[done] = states[done]
                after[done, _DRAWS] = 0
                endings[done] = lib.WG_CRASH
                done += 1
        return after, endings, drew


def _ranks(following: tuple[Following, ...]) -> tuple[int, ...]:
    """Return the fewest steps from each state to the target; 0 where no path leads there."""
    # Reverse the graph, and begin with the states one step from the target.
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

    # Search breadth first from the target, backwards.
    while queue:
        number = queue.popleft()
        for earlier in before[number]:
            if not ranks[earlier]:
                ranks[earlier] = ranks[number] + 1
                queue.append(earlier)
    return tuple(ranks)


def _drawn(before: dict[int, tuple[int, int]], number: int) -> tuple[tuple[int, ...], int]:
    """Return the values drawn on the path to a state, and the steps of that path."""
    values = []
    steps = 0
    while number in before:
        number, face = before[number]
        steps += 1
        if face != UNSEEN:
            values.append(face)
    return tuple(reversed(values)), steps
