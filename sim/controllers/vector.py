"""Asks a controller that acts for many robots at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.controllers.base import Command, Commands, Memory, Observation, Observations, VectorController
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
        ValueError, TypeError: If what it returns does not fit; and whatever else it raises.
    """
    asked, kept = controller.act_many(Observations.of(_locked(seen)), _locked(memory))
    asked = asked if type(asked) is Commands else Commands(*asked)
    for name, value in zip(Commands._fields, asked, strict=True):
        if np.shape(value) not in ((), (len(seen),)):
            raise TypeError(
                f"{name} is of shape {np.shape(value)} for {len(seen)} robots; give one number, or one each"
            )
    if np.shape(kept) != after.shape:
        raise TypeError(f"the memory came back in shape {np.shape(kept)}; it must keep its shape, {after.shape}")
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
