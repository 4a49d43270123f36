"""Bug2: follow an obstacle until it crosses the straight line to the target again, nearer to it.

The robot drives straight to the target. If a wall stops it, at the hit point, it follows the
wall with its left hand until it crosses the line from the hit point to the target, at a place
nearer to the target than the hit point. It returns to that place and drives on. The line enters the
obstacle at the hit point and ends outside, so it leaves somewhere on the same wall. Such a place
therefore exists, and each one is nearer than the last, so the robot arrives if any robot can. It is
often quicker than Bug1, because it need not see the whole obstacle. In mazes it may pass the same
places many times.

In the paper, the line is the one from the start to the target. Here each hit point defines its own
line, which differs by the distance that the robot slid along a wall before it stopped.

Source: V. J. Lumelsky and A. A. Stepanov, "Path-planning strategies for a point mobile automaton
    moving amidst unknown obstacles of arbitrary shape", Algorithmica 2 (1987), section 5.
"""

from __future__ import annotations

import math

import numpy as np

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library._common import BY_TOUCH, HAND
from sim.controllers.memory_view import MemoryField, MemoryMap
from worldgen.support.arrays import Floats

AT = fields_of("WgBug2Memory")


def shown_map(memory: Floats) -> MemoryMap:
    """Return the hit point, m, and the line from it to the target, once they are known."""
    if memory[AT.hit_far] == math.inf:
        return MemoryMap()
    hit = memory[AT.hit_x : AT.hit_y + 1]
    towards = memory[AT.line_x : AT.line_y + 1]
    line = np.array((hit, hit + memory[AT.hit_far] * towards))
    return MemoryMap(plan=line, places={"hit": (float(hit[0]), float(hit[1]))})


bug2 = CompiledController(
    "bug2",
    CoreAct("bug2"),
    memory_at_reset(size_of("WgBug2Memory"), {HAND: 1.0, AT.hit_far: math.inf}),
    about="Follow an obstacle until back on the line to the target, but nearer to it.",
    senses=BY_TOUCH,
    memory_fields=(
        MemoryField(
            "doing", AT.mode, ("start", "to the target", "round the obstacle", "to the line")
        ),
        MemoryField("hit point's distance, m", AT.hit_far),
    ),
    memory_map=shown_map,
    memory_map_on=(AT.hit_x, AT.hit_y, AT.hit_far, AT.line_x, AT.line_y),
)
