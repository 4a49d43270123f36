"""TangentBug: looks ahead with range beams, and goes round what is in the way along its tangents.

It drives to the target as long as it sees no wall before it, and else to that end of the wall, as
far as it sees, by which the way to the target would be shortest. When that way stops getting
shorter it drives up to the wall and follows it by touch, on the side to which it was drawn, until
it sees a free place that is nearer to the target than any place of the wall was, and goes there.

With a perfect scan and a robot that is a point it arrives if anybody can. Here the robot is a disc,
which takes the points that its beams meet for the walls, each as wide as itself, and between two
    beams it sees nothing: a long shot
past a thin wall can look free and not be so. The fuzzer shows what that costs.

It needs ``beams`` all round with a ``beam_range`` of ``RANGE``, which it gets unless the run says
otherwise.

Source: I. Kamon, E. Rimon and E. Rivlin, "TangentBug: a range-sensor-based navigation algorithm",
    The International
Journal of Robotics Research 17 (1998).
"""

from __future__ import annotations

import math

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, memory_at_reset, place, size_of
from sim.controllers.library import _boundary as body
from sim.controllers.memory_view import MemoryField
from sim.options.robot import RobotOptions

__all__ = ["BEAMS", "RANGE", "tangent_bug"]

BEAMS = 72
RANGE = 1.0  # m: further points are not looked at

_MODE = place("WgTangentBugMemory", "mode")
_BEST = place("WgTangentBugMemory", "best")

tangent_bug = CompiledController(
    "tangent-bug",
    CoreAct("tangent-bug"),
    memory_at_reset(size_of("WgTangentBugMemory"), {body.HAND: 1.0, _BEST: math.inf}),
    senses=(*body.SENSES, "beams"),
    needs=RobotOptions(beams=BEAMS, beam_range=RANGE),
    memory_fields=(
        MemoryField(
            "doing", _MODE, ("to the target", "by an end", "along the wall", "leaves the wall")
        ),
    ),
)
