"""Call a controller that acts for many robots at once, and check what it returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.clock.controller_time import timed
from sim.clock.stopping import breakable
from sim.controllers.base import (
    Command,
    Commands,
    Memory,
    Observation,
    Observations,
    VectorController,
)
from sim.controllers.contract import ContractBroken, no_command, no_memory
from sim.kernels import layout
from worldgen.support.arrays import Floats


class Asker:
    """Calls a controller that acts for many robots, always with the same arrays.

    Args:
        controller: The controller.
        seen: (n, OBS_SIZE + beams + OBS_TAIL) the robots' observations.
        memory: (n, m) the robots' memories.
        command: (n, CMD_SIZE) filled in each step.
    """

    def __init__(
        self, controller: VectorController, seen: Floats, memory: Floats, command: Floats
    ) -> None:
        self._act = timed(controller.act_many)
        self._seen = _locked(seen)
        self._memory = _locked(memory)
        self._command = command
        self.message: npt.ArrayLike = ()
        self._count = -1
        self._observed = Observations.of(self._seen[:0])
        self._memories = self._memory[:0]

    @breakable
    def ask(self, count: int, after: Floats, neighbours: Floats | None = None) -> None:
        """Let the controller act for the robots in the first ``count`` rows.

        The messages to other robots are in ``message`` afterwards.

        Args:
            count: Rows, at least 1.
            after: (count, m) filled with the memories after the step.
            neighbours: (count, most, 5 + message) the neighbours that the robots sense, if they do.

        Raises:
            ContractBroken: If the result does not fit. Exceptions of the controller pass through.
        """
        # Twenty views cost as much as simulating a hundred robots, and the count seldom changes.
        if count != self._count:
            self._observed = Observations.of(self._seen[:count])
            self._memories = self._memory[:count]
            self._count = count
        else:
            # `bump` is a copy, because it is the one column that its view does not keep up to date.
            bump = self._seen[:count, layout.OBS_BUMP] != 0.0
            self._observed = Observations._make((bump, *self._observed[1:]))
        if neighbours is not None:
            self._observed = self._observed._replace(neighbours=neighbours)
        answer = self._act(self._observed, self._memories)

        # The answer must have one command and one memory for each robot.
        try:
            asked, kept = answer
        except (TypeError, ValueError):
            raise no_memory(answer, "act_many") from None
        try:
            asked = asked if type(asked) is Commands else Commands(*asked)
        except TypeError:
            raise no_command(asked, "act_many") from None
        for name, value in zip(Commands._fields[: layout.CMD_SIZE], asked, strict=False):
            if np.shape(value) not in ((), (count,)):
                raise ContractBroken(
                    f"{name.replace('_', '-')}-is-of-shape-for-robots",
                    f"{name} has shape {np.shape(value)}, but there are {count} robots",
                    value,
                    "use one number, or one for each robot",
                )
        if np.shape(kept) != after.shape:
            error = (
                f"the returned memory has shape {np.shape(kept)}, but its shape was {after.shape}"
            )
            raise ContractBroken(
                "the-memory-came-back-in-shape-but-was-given-in-shape",
                error,
                kept,
                "keep its shape: one row per robot",
            )

        # Copy the answer into the core's arrays.
        command = self._command[:count]
        command[:, layout.CMD_SPEED] = asked.speed
        command[:, layout.CMD_TURN_RATE] = asked.turn_rate
        command[:, layout.CMD_DRAW] = np.asarray(asked.used_random) != 0
        after[...] = kept
        self.message = asked.message


@dataclass(frozen=True)
class OneOfMany:
    """A controller of many robots, wrapped as a Python class for one robot."""

    controller: VectorController

    def reset(self) -> Memory:
        """Return the wrapped controller's memory at reset."""
        return self.controller.reset()

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command and the memory of the only robot."""
        last = (observation.tilt, observation.tilt_heading, observation.goal_heading)
        numbers = (*observation[: layout.OBS_SIZE], *observation.beams, *last)
        seen = np.array([numbers])
        before = np.array([memory])
        command = np.zeros((1, layout.CMD_SIZE))
        after = np.empty_like(before)
        Asker(self.controller, seen, before, command).ask(1, after)
        speed, turn_rate, used_random = command[0].tolist()
        return Command(speed, turn_rate, used_random != 0.0), tuple(after[0].tolist())


def _locked(array: Floats) -> Floats:
    view = array.view()
    view.flags.writeable = False
    return view
