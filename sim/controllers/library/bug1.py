"""Bug1: circle each obstacle once, and leave it where it came nearest to the target.

The robot drives straight to the target. If a wall stops it, at the hit point, it follows the
wall with its left hand all the way around, and notes the point nearest to the target: the leave
point. From the hit point it returns there by the shorter route, and drives straight to the target
again. Each leave point is nearer than the last, so it arrives if any robot can, on a path no longer
than the distance plus one and a half times the perimeters of the obstacles that it meets.

This holds if the world does not change. A place on the wall counts as the hit point or the leave
point if it is nearer than ``_SAME_PLACE`` of a step and the wall is in a similar direction. The
direction matters because the two sides of a narrow passage are also near each other, but face
opposite ways.

Source: V. J. Lumelsky and A. A. Stepanov, "Path-planning strategies for a point mobile automaton
    moving amidst unknown obstacles of arbitrary shape", Algorithmica 2 (1987), section 4.
"""

from __future__ import annotations

import math

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library._common import BY_TOUCH, HAND
from sim.controllers.memory_view import MemoryField, MemoryMap
from worldgen.support.arrays import Floats

AT = fields_of("WgBug1Memory")


def shown_map(memory: Floats) -> MemoryMap:
    """Return the hit point and the leave point, m, once they are known."""
    points = {"hit": AT.hit, "leave": AT.leave} if memory[AT.leave_far] < math.inf else {}
    return MemoryMap(
        places={name: (float(memory[k]), float(memory[k + 1])) for name, k in points.items()}
    )


bug1 = CompiledController(
    "bug1",
    CoreAct("bug1"),
    memory_at_reset(size_of("WgBug1Memory"), {HAND: 1.0, AT.leave_far: math.inf}),
    about="Circle each obstacle, then leave it where it was nearest to the target.",
    senses=BY_TOUCH,
    memory_fields=(
        MemoryField(
            "doing",
            AT.mode,
            ("start", "to the target", "meets a wall", "round it", "to the leave point"),
        ),
        MemoryField("nearest, m", AT.leave_far),
        MemoryField("path since the hit, m", AT.path),
    ),
    memory_map=shown_map,
    memory_map_on=(AT.hit, AT.hit + 1, AT.leave, AT.leave + 1, AT.leave_far),
)
