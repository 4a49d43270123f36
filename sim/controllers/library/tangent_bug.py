"""TangentBug: look ahead with range beams, and go around obstacles along their tangents.

The robot drives to the target as long as it sees no wall in front of it. Otherwise it drives to the
visible end of that wall through which the path to the target would be shortest. When that path
stops getting shorter, it drives up to the wall and follows it by touch, on the side that it was
heading for, until it sees a free place that is nearer to the target than any place on the wall.
Then it drives to that point.

With a perfect scan and a point robot, it arrives if any robot can. Here the robot is a disc. It
treats each point that a beam hits as a wall as wide as the robot, and sees nothing between two
beams, so a long line of sight past a thin wall can look free when it is not. The fuzzer shows the
cost of this.

It needs ``beams`` in all directions with a ``beam_range`` of ``RANGE``, and gets them unless the
run sets these options differently.

Source: I. Kamon, E. Rimon and E. Rivlin, "TangentBug: a range-sensor-based navigation algorithm",
    The International Journal of Robotics Research 17 (1998).
"""

from __future__ import annotations

import math

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library._common import BY_TOUCH, HAND
from sim.controllers.memory_view import MemoryField
from sim.options.robot import RobotOptions

AT = fields_of("WgTangentBugMemory")

BEAMS = 72
# Metres; the controller ignores points that are farther away.
RANGE = 1.0

tangent_bug = CompiledController(
    "tangent-bug",
    CoreAct("tangent-bug"),
    memory_at_reset(size_of("WgTangentBugMemory"), {HAND: 1.0, AT.best: math.inf}),
    about="Look ahead, and go around obstacles along their tangents.",
    senses=(*BY_TOUCH, "beams"),
    needs=RobotOptions(beams=BEAMS, beam_range=RANGE),
    memory_fields=(
        MemoryField(
            "doing", AT.mode, ("to the target", "by an end", "along the wall", "leaves the wall")
        ),
    ),
)
