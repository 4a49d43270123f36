"""Three layers: one that reacts, one that sees to it that things get done, one that thinks ahead.

The *controller* steers to a waypoint in the nearest direction that is free for the whole disc. The
*sequencer* watches it: a waypoint is reached when the robot is in its cell; if that takes too long,
    the sequencer says so to the
deliberator and starts afresh from where the robot is. The *deliberator* holds a coarse map of where
the sequencer got nowhere, and plans a way through the rest of it to the target; the next cell of
the plan is the next waypoint.

It gets out of cups and through most mazes, by trying. Its map is a square of 48 x 48 cells about
the middle between start and target, a bit for each way between two cells: what lies outside, and
    passages that cells of the map cannot
tell apart, it does not find. When the map leaves no way, all is forgotten and it tries again, now
with more patience.

Sources: Erann Gat, "On three-layer architectures", in Artificial Intelligence and Mobile Robots
    (1998); R. Peter
Bonasso, R. James Firby, Erann Gat, David Kortenkamp, David P. Miller and Marc G. Slack,
"Experiences with an architecture for intelligent, reactive agents", Journal of Experimental &
Theoretical Artificial Intelligence 9 (1997). The map, the plan and the steering are our own, as
simple as they can be.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, default_of, memory_at_reset, place, size_of
from sim.controllers.memory_view import MemoryField, MemoryMap
from sim.options.robot import RobotOptions

__all__ = ["SIDE", "ThreeLayer", "three_layer", "three_layer_robot"]

Floats = npt.NDArray[np.float64]

_DEFAULT = default_of("wg_three_layer_default")
LAID = place("WgThreeLayerMemory", "laid")
CORNER_X = place("WgThreeLayerMemory", "corner_x")
CORNER_Y = place("WgThreeLayerMemory", "corner_y")
PITCH = place("WgThreeLayerMemory", "pitch")
TO_X = place("WgThreeLayerMemory", "to_x")
TO_Y = place("WgThreeLayerMemory", "to_y")
WAITED = place("WgThreeLayerMemory", "waited")
FORGOTTEN = place("WgThreeLayerMemory", "forgotten")
RIGHT = place("WgThreeLayerMemory", "right")
UP = place("WgThreeLayerMemory", "up")
MEMORY = size_of("WgThreeLayerMemory")
SIDE = UP - RIGHT  # cells of the map a side
AT_RESET = memory_at_reset(MEMORY, {})
SENSES = (
    "heading",
    "x",
    "y",
    "target_heading",
    "target_distance",
    "time_step",
    "top_speed",
    "radius",
    "beams",
)
NEEDS = RobotOptions(beams=36, beam_range=2.0)


class ThreeLayer(NamedTuple):
    """Tuned numbers.

    Args:
        margin: What the robot is taken to be larger by than it is, m.
        pitch: Side of a cell of the map, in radii of the robot; more where the map would not reach
            the target.
        reach: Least side of the map, times the distance from start to target.
        look: Free way, m, that the controller wants in the direction it takes.
        patience: Steps after which a waypoint is given up, times one more than the map has been
            forgotten.
    """

    margin: float = _DEFAULT["margin"]
    pitch: float = _DEFAULT["pitch"]
    reach: float = _DEFAULT["reach"]
    look: float = _DEFAULT["look"]
    patience: int = int(_DEFAULT["patience"])


def shown_map(memory: Floats) -> MemoryMap:
    """The closed borders between cells of the map, and the waypoint, in m."""
    if memory[LAID] == 0.0:
        return MemoryMap()
    corner = np.array((memory[CORNER_X], memory[CORNER_Y]))
    pitch = memory[PITCH]
    bits = np.arange(SIDE)
    row, column = np.nonzero((memory[RIGHT : RIGHT + SIDE].astype(np.int64)[:, None] >> bits) & 1)
    upright = np.column_stack((column + 1, row, column + 1, row + 1))
    row, column = np.nonzero((memory[UP : UP + SIDE].astype(np.int64)[:, None] >> bits) & 1)
    level = np.column_stack((column, row + 1, column + 1, row + 1))
    point = corner + (memory[TO_X : TO_Y + 1] + 0.5) * pitch
    return MemoryMap(
        blocked=np.concatenate((upright, level)) * pitch + np.tile(corner, 2),
        places={"waypoint": (float(point[0]), float(point[1]))} if memory[TO_X] >= 0.0 else {},
    )


_FIELDS = (MemoryField("steps to the waypoint", WAITED), MemoryField("map forgotten", FORGOTTEN))


def three_layer_robot(tuned: ThreeLayer, name: str = "three-layer") -> CompiledController:
    """Return a robot of three layers with these numbers."""
    act = CoreAct("three-layer") if tuned == ThreeLayer() else CoreAct("three-layer-tuned")
    return CompiledController(
        name,
        act,
        AT_RESET if tuned == ThreeLayer() else AT_RESET + tuple(map(float, tuned)),
        senses=SENSES,
        needs=NEEDS,
        memory_fields=_FIELDS,
        memory_map=shown_map,
        memory_map_on=(LAID, TO_X, TO_Y, *range(RIGHT, MEMORY)),
    )


three_layer = three_layer_robot(ThreeLayer())
