"""The thesis's robot: seek the signal, drive, and turn by a fixed or random angle when it collides.

Three behaviours (drive, seek, collide) compete under an arbiter, and the one in control keeps it
until it is done. Under ``stepped`` the thesis's own program runs, faithful to the last bit
(``sim/core/thesis_episode.c``). For the other motion models,
``sim/core/controllers/thesis_rules.c`` implements the same idea on the pose lattice, with the same
arbiter.

Names are from the robot's point of view. ``turn-right`` is the thesis's algorithm 1, which adds
pi/2 to a heading that grows clockwise, because y points down on its screen. Its legend calls that
"left", the side of the screen on which the robot then passes, and its text contradicts itself.

Source: the thesis on behaviour-based search and rescue robots that this program descends from
    (2005-2006), sections 3 and 4 and its listing; the arbiter is rebuilt from the prose.
"""

from __future__ import annotations

import math

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, memory_at_reset, place, size_of
from sim.controllers.memory_view import MemoryField

__all__ = ["RANDOM", "turn_left", "turn_random", "turn_right"]

# The thesis's numbers for its rules.
RIGHT = 1
LEFT = 2
RANDOM = 3

# The value of `behaviour` while no behaviour is in control.
_IDLE = -1
_BEHAVIOUR = place("WgThesisMemory", "behaviour")
_AT_RESET = memory_at_reset(
    size_of("WgThesisMemory"),
    {
        _BEHAVIOUR: _IDLE,
        place("WgThesisMemory", "target"): -1.0,
        place("WgThesisMemory", "speed"): 1.0,
        place("WgThesisMemory", "old_speed"): 1.0,
    },
)
_FIELDS = (
    MemoryField("behaviour", _BEHAVIOUR, ("none", "collide", "seek", "drive"), least=_IDLE),
    MemoryField("ticks left", place("WgThesisMemory", "counter")),
)
_SENSES = ("bump", "signal_heading", "heading", "time_step", "top_speed")


def _controller(name: str, rule: int) -> CompiledController:
    """Return the robot under one of the thesis's rules; it starts at its top speed."""
    return CompiledController(
        name,
        CoreAct(name),
        _AT_RESET,
        math.inf,
        thesis_rule=rule,
        randomised=rule == RANDOM,
        senses=(*_SENSES, "random") if rule == RANDOM else _SENSES,
        memory_fields=_FIELDS,
    )


turn_right = _controller("turn-right", RIGHT)
turn_left = _controller("turn-left", LEFT)
turn_random = _controller("turn-random", RANDOM)
