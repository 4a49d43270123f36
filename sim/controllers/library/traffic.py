"""Controllers for several robots: straight at the target, keeping to the right, and ORCA.

None of them sees walls, so the robot slides along them. ``naive`` ignores other robots too, and
shows how demanding a world is. ``right-hand`` and ``orca`` sense robots up to 2 m away.

Sources: for ``right-hand``, the International Regulations for Preventing Collisions at Sea (1972),
    rules 14 and 15. For ``orca``, Jur van den Berg, Stephen J. Guy, Ming Lin and Dinesh Manocha,
    "Reciprocal n-body collision avoidance", Robotics Research (2011).
"""

from __future__ import annotations

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct
from sim.controllers.memory_view import MemoryField
from sim.kernels.layout import place
from sim.options.robot import RobotOptions

_SENSES = ("heading", "target_heading", "time_step", "top_speed", "radius")
_SENSING = RobotOptions(neighbour_range=2.0)

naive = CompiledController(
    "naive", CoreAct("naive"), senses=_SENSES, about="Drive straight at the target."
)

right_hand = CompiledController(
    "right-hand",
    CoreAct("right-hand"),
    senses=(*_SENSES, "neighbours"),
    needs=_SENSING,
    about="Drive at the target, and give way to the right of other robots.",
)

orca = CompiledController(
    "orca",
    CoreAct("orca"),
    (0.0,),
    about="Avoid collisions with other robots by choosing reciprocal velocities.",
    senses=(*_SENSES, "neighbours"),
    needs=_SENSING,
    memory_fields=(MemoryField("speed", place("WgOrcaMemory", "speed")),),
)
