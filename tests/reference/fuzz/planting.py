"""Plants a fault in a controller of the library:

its own plain Python, with one deviation around it.
"""

import math
from collections.abc import Callable
from typing import Any

from tests.reference.sim import layout
from tests.reference.sim.library import ACTS

Act = Callable[..., None]
Floats = Any

FAULTS: dict[str, Act] = {}
"""Acts by the name of the fault."""


def unwrap_turn(observation: Floats, command: Floats) -> None:
    """Makes the commanded turn the difference of two headings in [-pi, pi), as if nobody had
    wrapped it.
    """
    turn = command[layout.CMD_TURN_RATE] * observation[layout.OBS_TIME_STEP]
    if observation[layout.OBS_HEADING] + turn > math.pi:
        command[layout.CMD_TURN_RATE] = (turn - 2.0 * math.pi) / observation[layout.OBS_TIME_STEP]


def seeded(base: str) -> Callable[[Callable[..., None]], Act]:
    """Makes an act function from a function ``(observation, memory, command, base)``.

    It calls ``base`` in its own way.
    """

    def plant(deviation: Callable[..., None]) -> Act:
        def act(observation: Floats, memory: Floats, command: Floats) -> None:
            deviation(observation, memory, command, ACTS[base])

        FAULTS[deviation.__name__.replace("_", "-")] = act
        return act

    return plant
