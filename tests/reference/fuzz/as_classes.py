"""The planted faults as plain Python classes.

``tests.reference.fuzz.as_classes:bug2_stale_line``.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.faults import FAULTS
from sim import Command
from sim.kernels import layout

# Importing these modules adds their faults to ACTS.
from tests.reference.fuzz import faults_by_sight, faults_by_touch  # noqa: F401
from tests.reference.fuzz.planting import FAULTS as ACTS


@dataclass(frozen=True)
class PlainFault:
    """A fault whose Python is interpreted, as a user would have written it."""

    name: str

    @property
    def senses(self):
        return FAULTS[self.name].senses

    @property
    def needs(self):
        return FAULTS[self.name].needs

    def reset(self):
        return FAULTS[self.name].memory

    def act(self, observation, memory):
        seen = np.array((*observation[: layout.OBS_SIZE], *observation.beams), float)
        kept = np.array(memory)
        command = np.zeros(3)
        ACTS[self.name](seen, kept, command)
        speed, turn_rate, used_random = command.tolist()
        return Command(speed, turn_rate, used_random != 0.0), tuple(kept.tolist())


def __getattr__(name):
    fault = name.replace("_", "-")
    if fault not in ACTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return PlainFault(fault)
