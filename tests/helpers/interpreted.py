"""A controller of the library in plain Python, to compare it with the core's."""

import numpy as np

from sim import Command
from tests.reference.sim import layout
from tests.reference.sim.library import ACTS


class Interpreted:
    """The same controller as a Python class, with no part of it compiled."""

    def __init__(self, controller):
        self._act, self._memory = ACTS[controller.act.name], controller.memory
        self.senses, self.needs = controller.senses, controller.needs

    def reset(self):
        return self._memory

    def act(self, observation, memory):
        seen = np.array([*observation[: layout.OBS_SIZE], *observation.beams], float)
        numbers, command = np.array(memory), np.zeros(layout.CMD_SIZE)
        self._act(seen, numbers, command)
        return Command(command[0], command[1], bool(command[2])), tuple(numbers.tolist())
