"""Compose behaviours in Python: the core's arbiter calls them."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sim._core import ffi, lib
from sim.controllers.base import Command, Memory, Observation
from sim.controllers.behaviours.arbitration import Arbitration
from sim.controllers.behaviours.base import Behaviour
from sim.controllers.contract import no_command, no_memory
from sim.controllers.memory_view import MemoryField
from sim.kernels.layout import OBS_SIZE
from sim.options.robot import RobotOptions
from worldgen.support.ccall import kept

# The C type of a trigger and of an action.
_CALL = dict(ffi.typeof("WgBehaviour").fields)["trigger"].type


@dataclass(frozen=True)
class ComposedController:
    """A controller composed of behaviours, some of which are in Python.

    Args:
        name: Name in messages.
        memory: At reset; its layout is that of a compiled composition.
        others: The behaviours in Python, in the order of their parts.
        senses: Everything that a part reads.
        needs: Options of the robot that a part requires.
        memory_fields: See :class:`~sim.controllers.base.CompiledController`.
        arbitration: The same.
    """

    name: str
    memory: Memory
    others: tuple[Behaviour, ...]
    senses: tuple[str, ...]
    needs: RobotOptions
    memory_fields: tuple[MemoryField, ...]
    arbitration: Arbitration

    @property
    def made_of(self) -> tuple[object, ...]:
        """Objects whose classes may keep state outside the memory."""
        functions = (one for part in self.others for one in (part.trigger, part.action))
        return tuple(getattr(one, "__self__", one) for one in functions)

    def reset(self) -> Memory:
        """Return the memory at the start of an episode."""
        return self.memory

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Let the arbiter choose a part, and return its command and the memory after it."""
        # The core works on a copy of the memory, and calls back for the parts in Python.
        numbers = np.array(memory, np.float64)
        calls = _calls_of(self.others)
        calls.now.observation = observation
        calls.now.error = None
        beams = ffi.new("double[]", observation.beams) if observation.beams else ffi.NULL
        plain: Any = observation[:OBS_SIZE]
        seen = ffi.new("WgObservation *", (*map(float, plain), beams, len(observation.beams)))
        seen.goal_heading = observation.goal_heading
        seen.tilt = observation.tilt
        seen.tilt_heading = observation.tilt_heading
        command = ffi.new("WgCommand *")
        into = ffi.from_buffer("double[]", numbers, require_writable=True)
        lib.wg_compose(calls.behaviours, seen, into, command)
        # An exception cannot pass through the core, so it is raised here.
        if calls.now.error is not None:
            raise calls.now.error
        used = command.used_random != 0.0
        return Command(command.speed, command.turn_rate, used), tuple(numbers.tolist())


class _Now:
    """The current step, and the first exception in it."""

    observation: Observation
    error: BaseException | None = None


class _Calls(NamedTuple):
    """The behaviours as the core calls them.

    Args:
        behaviours: WgBehaviour[].
        now: State that the calls share.
    """

    behaviours: Any
    now: _Now


@functools.lru_cache(maxsize=64)
def _calls_of(others: tuple[Behaviour, ...]) -> _Calls:
    now = _Now()
    behaviours = ffi.new("WgBehaviour[]", len(others))
    held: list[Any] = []
    for into, one in zip(behaviours, others, strict=True):
        name = ffi.new("char[]", one.name.encode())
        trigger = ffi.callback(_CALL, _trigger(one, now))
        action = ffi.callback(_CALL, _action(one, now))
        into.name = name
        into.trigger = trigger
        into.action = action
        into.restarts = int(one.restarts)
        into.state_size = len(one.memory)
        held += [name, trigger, action]
    # The structs only have the addresses of names and callbacks.
    return _Calls(kept(ffi, behaviours, *held), now)


def _trigger(behaviour: Behaviour, now: _Now) -> Callable[[Any], int]:
    trigger: Any = behaviour.trigger
    size = len(behaviour.memory)

    def call(situation: Any) -> int:
        if now.error is not None:
            return 0
        try:
            own = tuple(situation.state[k] for k in range(size))
            return int(bool(trigger(now.observation, own)))
        except BaseException as error:  # noqa: BLE001 - raised again where the controller acts
            now.error = error
            return 0

    return call


def _action(behaviour: Behaviour, now: _Now) -> Callable[[Any], int]:
    action: Any = behaviour.action
    size = len(behaviour.memory)

    def call(situation: Any) -> int:
        if now.error is not None:
            return 1
        try:
            own = tuple(situation.state[k] for k in range(size))
            answer = action(now.observation, own)
            command, memory, done = _taken_apart(answer, size)
        except BaseException as error:  # noqa: BLE001 - as above
            now.error = error
            return 1
        for k, number in enumerate(memory):
            situation.state[k] = number
        situation.command.speed = command.speed
        situation.command.turn_rate = command.turn_rate
        situation.command.used_random = float(command.used_random)
        return int(done)

    return call


def _taken_apart(answer: Any, size: int) -> tuple[Command, Memory, bool]:
    """Return the command, the memory and whether the behaviour is done, as the core takes them.

    Raises:
        ContractBroken: If the answer is something else.
    """
    if not isinstance(answer, tuple) or len(answer) not in (2, 3) or hasattr(answer, "_fields"):
        raise no_memory(answer, "action")
    command, memory, *done = answer
    if not isinstance(memory, tuple) or len(memory) != size:
        raise no_memory(answer, "action")
    if not isinstance(command, tuple) or len(command) < 2:
        raise no_memory(answer, "action")
    try:
        numbers = tuple(float(number) for number in memory)
    except (TypeError, ValueError):
        raise no_memory(answer, "action") from None
    try:
        used_random = len(command) > 2 and bool(command[2])
        taken = Command(float(command[0]), float(command[1]), used_random)
    except (TypeError, ValueError):
        raise no_command(answer, "action") from None
    return taken, numbers, bool(done and done[0])
