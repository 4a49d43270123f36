"""The thesis's robot: seek the signal, drive, and turn by a fixed or random angle when it collides.

Three behaviours (drive, seek, collide) compete under an arbiter, and the behaviour in control keeps
it until it is done. Under ``stepped`` the thesis's own program runs, faithful to the last bit
(``sim/core/thesis/thesis_episode.c``). For the other motion models,
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

import numpy as np

from sim.controllers.base import CompiledController
from sim.controllers.behaviours.arbitration import Arbitration, PartFacts, in_words
from sim.controllers.behaviours.library import IDLE, TURN_WORDS, TURNS, collide, drive, seek
from sim.controllers.core_act import CoreAct, memory_at_reset, size_of
from sim.controllers.memory_view import MemoryField
from sim.kernels.layout import place
from sim.options.thesis import ThesisOptions
from worldgen.support.arrays import Floats, Ints

# The thesis's numbers for its rules.
RIGHT = 1
LEFT = 2
RANDOM = 3

# The value of `behaviour` while no behaviour is in control.
_IDLE = -1
_BEHAVIOUR = place("WgShared", "behaviour")
_AT_RESET = memory_at_reset(size_of("WgShared"), IDLE)
_FIELDS = (MemoryField("ticks left", place("WgShared", "counter")),)
_PARTS = (collide, seek, drive)
_SEEK = _PARTS.index(seek)


def _acted(memories: Floats) -> Ints:
    """Return the behaviour that acted in each step; see ``Arbitration``."""
    behaviour = memories[:, _BEHAVIOUR].astype(np.int64)
    before = behaviour[:-1]
    after = behaviour[1:]

    # Only seek can take control and be done in one step, and it then changes the target heading.
    acted = np.where(after >= 0, after, np.where(before >= 0, before, _SEEK))

    # In the step that ends a run no behaviour acts; its move comes from the previous behaviour.
    idle = (before < 0) & (memories[1:] == memories[:-1]).all(axis=1)
    last = np.maximum.accumulate(np.where(idle, -1, np.arange(len(acted))))
    return np.where(last >= 0, acted[last], _IDLE)


def thesis_arbitration(rule: int, options: ThesisOptions | None = None) -> Arbitration:
    """Return how the thesis's robot arbitrates.

    Args:
        rule: The rule of its turn.
        options: Options of the thesis's program, if that runs the robot.
    """
    told = ThesisOptions() if options is None else options
    turn = next(word for word, number in TURNS.items() if number == rule)
    words = {"turn": TURN_WORDS[turn]}
    if rule != RANDOM and told.turn_angle != ThesisOptions.turn_angle:
        words["turn"] = f"turn {turn} by {math.degrees(told.turn_angle):.4g} degrees"
    ticks = {collide: float(told.collide_ticks), drive: float(told.drive_ticks)}
    parts = []
    for priority, one in enumerate(_PARTS):
        duration = ticks.get(one, one.duration)
        parts.append(
            PartFacts(
                one.name,
                one.applies,
                in_words(one.does, words | {"duration": f"{duration:g}"}),
                float(priority),
                duration,
                told.arbiter in ("A5", "interruptible"),
            )
        )
    return Arbitration(tuple(parts), "priority", _acted)


_SENSES = ("bump", "signal_heading", "heading", "time_step", "top_speed")


def _controller(name: str, rule: int, way: str) -> CompiledController:
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
        arbitration=thesis_arbitration(rule),
        about=f"Drive towards the signal, and turn {way} at each wall: the thesis's robot {rule}.",
    )


turn_right = _controller("turn-right", RIGHT, "right")
turn_left = _controller("turn-left", LEFT, "left")
turn_random = _controller("turn-random", RANDOM, "at random")
