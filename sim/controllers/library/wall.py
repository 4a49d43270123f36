"""Wall following: drive to the target until a wall is touched, then keep a hand on it forever.

It finds the exit of any maze whose walls are all connected. It circles an island, or the room that
it is in, endlessly: the simplest example of a rule that works until it does not.

Source: the hand-on-wall rule, W. H. Matthews, "Mazes and Labyrinths: A General Account of Their
    History and Developments" (1922), on the solution of mazes; for robots V. J. Lumelsky and A. A.
    Stepanov, "Path-planning strategies for a point mobile automaton moving amidst unknown obstacles
    of arbitrary shape", Algorithmica 2 (1987), for the step from one wall to the next.
"""

from __future__ import annotations

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library._common import BY_TOUCH, HAND
from sim.controllers.memory_view import MemoryField

AT = fields_of("WgWallMemory")


def _controller(name: str, hand: float, side: str) -> CompiledController:
    doing = MemoryField("doing", AT.mode, ("to the target", "along the wall"))
    memory = memory_at_reset(size_of("WgWallMemory"), {HAND: hand})
    return CompiledController(
        name,
        CoreAct("wall"),
        memory,
        senses=BY_TOUCH,
        memory_fields=(doing,),
        about=f"Drive to the target; once a wall is touched, keep the {side} hand on it.",
    )


wall_left = _controller("wall-left", 1.0, "left")
wall_right = _controller("wall-right", -1.0, "right")
