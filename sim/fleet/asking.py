"""Let controllers outside the core act for the robots of a fleet."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from sim._core import lib
from sim.clock.controller_time import timed
from sim.clock.stopping import breakable, check_time
from sim.controllers.base import Controller, Memory, Observation
from sim.controllers.contract import ContractBroken
from sim.controllers.controller_error import ControllerError
from sim.controllers.vector import Asker
from sim.fleet.core_calls import CoreFleet
from sim.kernels import layout
from sim.options.robot import RobotOptions
from sim.runners.controller_host import ControllerHost, Faults, host_of
from sim.runners.core_calls import Workspace
from sim.runners.python_act import settled
from sim.verdict import Verdict
from worldgen.support.arrays import Floats
from worldgen.support.plain_text import counted

# Steps between two checks of the clock.
_CHECKED_EVERY = 16


def own_hosts(controllers: Sequence[Controller | ControllerHost]) -> list[ControllerHost]:
    """Give each robot its own controller, so that robots share nothing; return their hosts.

    A controller that acts for all of its robots in one call, or has no state, is shared.
    """
    taken: dict[int, ControllerHost] = {}
    own: list[ControllerHost] = []
    for controller in controllers:
        first = taken.get(id(controller))
        own.append(host_of(controller) if first is None else first.another())
        taken.setdefault(id(controller), own[-1])
    return own


def run_with_hosts(
    fleet: CoreFleet,
    hosts: Sequence[ControllerHost],
    memories: Sequence[Memory],
    channels: Sequence[int],
) -> dict[int, ControllerError]:
    """Run a fleet to its end, and let the controllers that are not in the core act.

    Args:
        fleet: The fleet.
        hosts: (n,) the host of each robot's controller.
        memories: (n,) their memories at reset.
        channels: (n,) how many numbers each robot may send.

    Returns:
        What controllers did wrong in the last step, by the index of their robot.

    Raises:
        OutOfTime: If there is no more time.
    """
    askers = _askers(fleet, hosts, memories, channels)
    for number in itertools.count():
        state = fleet.run(_CHECKED_EVERY)
        if state == lib.WG_OVER:
            break
        if number % _CHECKED_EVERY == 0:
            check_time()
        faults = _ask(fleet, askers) if state == lib.WG_ACTS else {}
        if faults:
            # Whichever robots fail in one step, the first of them is named.
            fleet.fail(min(faults))
            return faults
    return {}


def _askers(
    fleet: CoreFleet,
    hosts: Sequence[ControllerHost],
    memories: Sequence[Memory],
    channels: Sequence[int],
) -> list[_One | _Many]:
    """Return an object that calls each robot's own controller, and each vector controller."""
    askers: list[_One | _Many] = []
    # Vector controllers act for all their robots together.
    many: dict[int, list[int]] = {}
    for number, host in enumerate(hosts):
        if host.acts_for_many:
            many.setdefault(id(host), []).append(number)
        elif not host.in_core:
            channel = _Channel(host.controller, channels[number])
            askers.append(_One(fleet, number, host, memories[number], channel))
    for numbers in many.values():
        shared = hosts[numbers[0]]
        channel = _Channel(shared.controller, channels[numbers[0]])
        askers.append(_Many(fleet, shared, numbers, channel))
    return askers


def _ask(fleet: CoreFleet, askers: Sequence[_One | _Many]) -> dict[int, ControllerError]:
    """Let all controllers act whose robots wait, and return their faults."""
    faults: dict[int, ControllerError] = {}
    for asker in askers:
        waiting = [number for number in asker.numbers if fleet.members[number].c.waits]
        try:
            if waiting:
                with asker.faults:
                    asker.ask(waiting)
        except ControllerError as fault:
            faults[waiting[0]] = fault
    return faults


def message_not_finite() -> ControllerError:
    """Return the fault of a controller that sends nan or infinity."""
    return ControllerError(
        Verdict.INVALID_COMMAND,
        "the message has a number that is not finite",
        {"rule": "message-is-not-finite"},
    )


class _Channel:
    """The lengths that a controller's messages may have.

    A message has as many numbers as the run's ``message`` option, or as the controller's own
    ``needs`` if that option is larger. Without numbers, zeros are sent.

    Args:
        controller: The controller.
        size: The run's option.
    """

    def __init__(self, controller: Any, size: int) -> None:
        needs = getattr(controller, "needs", None)
        own = needs.message if isinstance(needs, RobotOptions) else size
        self._size = size
        self._allowed = {0, size, min(own, size)}

    def check(self, count: int, message: object) -> None:
        """Check the length of a message.

        Raises:
            ContractBroken: If it has another length.
        """
        if count not in self._allowed:
            raise ContractBroken(
                "message-has-another-length",
                f"the message has {counted(count, 'number')}, but the run's message option is "
                f"{self._size}",
                message,
                "send that many numbers, or change the option, such as +message=2",
            )


class _One:
    """A controller that acts for one robot."""

    def __init__(
        self, fleet: CoreFleet, number: int, host: ControllerHost, memory: Memory, channel: _Channel
    ) -> None:
        self._channel = channel
        self.numbers = [number]
        self.faults = Faults(host)
        self._member = fleet.members[number]
        self._workspace = Workspace(self._member)
        self._memory = memory
        self._act = timed(host.act) if host.in_python else host.act

    @breakable
    def ask(self, _waiting: list[int]) -> None:
        """Let it act for its robot, and pass its answer to the core."""
        workspace = self._workspace
        sensed = self._member.c.workspace.observation
        seen = Observation.of(workspace.observation, sensed.tilt, sensed.tilt_heading)
        if self._member.c.workspace.neighbour_room:
            seen = seen._replace(neighbours=self._member.neighbours())
        answer = self._act(seen, self._memory)
        message = _message_in(answer)
        self._channel.check(len(message), message)
        self._member.send(message)
        speed, turn_rate, used_random, *memory = settled(answer, len(self._memory))
        workspace.command[:] = (speed, turn_rate, used_random)
        self._memory = tuple(memory)
        workspace.memory[:] = self._memory


def _message_in(answer: Any) -> tuple[float, ...]:
    """Return the message in an answer; empty if the answer is not a command and a memory.

    Raises:
        ContractBroken: If the message is not a tuple of numbers.
    """
    try:
        asked, _ = answer
        message = asked[layout.CMD_SIZE]
    except (TypeError, ValueError, IndexError, KeyError):
        return ()
    numbers = isinstance(message, tuple | list) and all(
        isinstance(one, int | float | np.number) for one in message
    )
    if not numbers:
        raise _not_numbers(message, "write message=(1.0, 0.5)")
    return tuple(float(one) for one in message)


def _not_numbers(message: object, remedy: str) -> ContractBroken:
    rule = "the-message-is-not-a-tuple-of-numbers"
    return ContractBroken(rule, "the message is not a tuple of numbers", message, remedy)


class _Many:
    """A controller that acts for many robots at once."""

    def __init__(
        self, fleet: CoreFleet, host: ControllerHost, numbers: list[int], channel: _Channel
    ) -> None:
        self._channel = channel
        self.faults = Faults(host)
        self.numbers = numbers
        self._members = {number: fleet.members[number] for number in numbers}
        self._workspaces = {number: Workspace(fleet.members[number]) for number in numbers}
        first = self._workspaces[numbers[0]]
        # The goal of a robot in a fleet has no heading.
        self._seen = np.full((len(numbers), first.observation.size + layout.OBS_TAIL), np.nan)
        self._kept = np.zeros((len(numbers), first.memory.size))
        self._command = np.zeros((len(numbers), first.command.size))
        self._asker = Asker(host.controller, self._seen, self._kept, self._command)

    def ask(self, waiting: list[int]) -> None:
        """Let it act for some of its robots, and pass its answers to the core."""
        for row, number in enumerate(waiting):
            sensed = self._members[number].c.workspace.observation
            self._seen[row, : -layout.OBS_TAIL] = self._workspaces[number].observation
            self._seen[row, layout.OBS_TILT] = sensed.tilt
            self._seen[row, layout.OBS_TILT_HEADING] = sensed.tilt_heading
            self._kept[row] = self._workspaces[number].memory
        self._command[:] = 0.0
        after = np.empty((len(waiting), self._kept.shape[1]))
        self._asker.ask(len(waiting), after, self._neighbours(waiting))
        try:
            message = np.asarray(self._asker.message, np.float64)
        except (TypeError, ValueError):
            raise _not_numbers(self._asker.message, "use an array of numbers") from None
        sends = message.size > 0
        if sends and (message.ndim != 2 or len(message) != len(waiting)):
            raise ContractBroken(
                "message-is-of-shape-for-robots",
                f"message has shape {message.shape}, but there are {len(waiting)} robots",
                message,
                "use a row of numbers for each robot",
            )
        self._channel.check(message.shape[1] if sends else 0, message)
        for row, number in enumerate(waiting):
            if sends:
                self._members[number].send(message[row].tolist())
            self._workspaces[number].command[:] = self._command[row]
            self._workspaces[number].memory[:] = after[row]

    def _neighbours(self, waiting: list[int]) -> Floats | None:
        """Return what the robots sense of each other; ``None`` if they do not."""
        workspace = self._members[waiting[0]].c.workspace
        room = int(workspace.neighbour_room)
        if not room:
            return None
        width = layout.NEIGHBOUR_MESSAGE + int(workspace.observation.message_size)
        found = np.full((len(waiting), room, width), np.nan)
        for row, number in enumerate(waiting):
            for place, one in enumerate(self._members[number].neighbours()):
                found[row, place] = (*one[: layout.NEIGHBOUR_MESSAGE], *one.message)
        return found
