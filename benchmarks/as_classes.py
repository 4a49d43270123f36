"""Wrap compiled controllers as Python classes.

This shows how a campaign performs with the same controller written in the usual form.
``benchmarks.as_classes:bug2_stale_line`` is the fault ``fuzz.faults:bug2_stale_line`` as a class
whose ``act`` calls the compiled function.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.faults import FAULTS
from sim.controllers import CONTROLLERS, Command, CompiledController, Observation
from sim.controllers.base import Act, Memory
from sim.controllers.core_act import CoreAct
from sim.controllers.flat_act import compiled_act
from sim.kernels import layout
from sim.options.robot import RobotOptions


@dataclass(frozen=True)
class AsClass:
    """A compiled controller as a Python class.

    Like every class, it does not move in its first step.

    Args:
        controller: Name of the compiled controller.
    """

    controller: str

    @property
    def senses(self) -> tuple[str, ...]:
        """The senses that the compiled controller uses."""
        return _compiled(self.controller).senses

    @property
    def needs(self) -> RobotOptions:
        """Its requirements for the robot."""
        return _compiled(self.controller).needs

    def reset(self) -> Memory:
        """Return its initial memory."""
        return _compiled(self.controller).memory

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return its command and its new memory."""
        seen = np.array((*observation[: layout.OBS_SIZE], *observation.beams))
        kept = np.array(memory)
        command = np.zeros(layout.CMD_SIZE)
        _act(self.controller)(seen, kept, command)
        speed, turn_rate, used_random = command.tolist()
        return Command(speed, turn_rate, used_random != 0.0), tuple(kept.tolist())


@functools.cache
def _compiled(name: str) -> CompiledController:
    controller = CONTROLLERS.get(name)
    if not isinstance(controller, CompiledController):
        raise TypeError(f"{name} is not a compiled controller")
    return controller


@functools.cache
def _act(name: str) -> Act:
    """Return the function itself; an attribute of the controller would count as its state."""
    act = _compiled(name).act
    if isinstance(act, CoreAct):
        return act
    compiled: Act = compiled_act(act)
    return compiled


def __getattr__(name: str) -> Any:
    if name.replace("_", "-") not in FAULTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return AsClass(f"fuzz.faults:{name}")
