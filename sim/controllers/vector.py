"""Asks a controller that acts for many robots at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.controllers.base import Command, Commands, Memory, Observation, Observations, VectorController
from sim.controllers.contract import ContractBroken, no_command, no_memory
from sim.kernels import layout

__all__ = ["OneOfMany", "ask"]

Floats = npt.NDArray[np.float64]


def ask(controller: VectorController, seen: Floats, memory: Floats, command: Floats, after: Floats) -> None:
    """Lets a controller act for n robots.

    Args:
        controller: The controller.
        seen: (n, OBS_SIZE + beams) what kernels observed.
        memory: (n, m) the robots' memories.
        command: (n, CMD_SIZE), filled.
        after: (n, m), filled: their memories then.

    Raises:
        ContractBroken: If what it returns does not fit; and whatever it raises itself.
    """
    answer = controller.act_many(Observations.of(_locked(seen)), _locked(memory))
    try:
        asked, kept = answer
    except (TypeError, ValueError):
        raise no_memory(answer, "act_many") from None
    try:
        asked = asked if type(asked) is Commands else Commands(*asked)
    except TypeError:
        raise no_command(asked, "act_many") from None
    for name, value in zip(Commands._fields, asked, strict=True):
        if np.shape(value) not in ((), (len(seen),)):
            error = f"{name} is of shape {np.shape(value)} for {len(seen)} robots"
            raise ContractBroken(error, value, "give one number, or one for each robot")
    if np.shape(kept) != after.shape:
        error = f"the memory came back in shape {np.shape(kept)}, and was given in {after.shape}"
        raise ContractBroken(error, kept, "return it in the shape in which it came: a row for each robot")
    command[:, layout.CMD_SPEED], command[:, layout.CMD_TURN_RATE] = asked.speed, asked.turn_rate
    command[:, layout.CMD_DRAW] = np.asarray(asked.used_random) != 0
    after[...] = kept


@dataclass(frozen=True)
class OneOfMany:
    """A controller of many robots as a Python class for one."""

    controller: VectorController

    def reset(self) -> Memory:
        """As the controller's."""
        return self.controller.reset()

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """The only robot's command and memory."""
        seen, before = np.array([[*observation[:-1], *observation.beams]]), np.array([memory])
        command, after = np.zeros((1, layout.CMD_SIZE)), np.empty_like(before)
        ask(self.controller, seen, before, command, after)
        speed, turn_rate, used_random = command[0].tolist()
        return Command(speed, turn_rate, used_random != 0.0), tuple(after[0].tolist())


def _locked(array: Floats) -> Floats:
    view = array.view()
    view.flags.writeable = False
    return view
