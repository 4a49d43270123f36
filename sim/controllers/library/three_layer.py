"""Three layers: one that reacts, one that supervises progress, and one that plans ahead.

The *controller* steers to a waypoint, in the nearest direction that is free for the whole disc. The
*sequencer* watches it. A waypoint is reached when the robot is in its cell; if that takes too long,
the sequencer reports it to the deliberator and starts again from the robot's position. The
*deliberator* holds a coarse map of where the sequencer failed, and plans a path through the rest of
it to the target. The next cell of the plan is the next waypoint.

By trial and error it gets out of cups and through most mazes. Its map is a square of 48 x 48 cells
around the middle between start and target, with a bit for each border between two cells. It does
not find paths outside the map, or passages that the map's cells cannot resolve. When the map
leaves no path, the robot forgets everything and tries again with more patience.

Sources: Erann Gat, "On three-layer architectures", in Artificial Intelligence and Mobile Robots
    (1998); R. Peter Bonasso, R. James Firby, Erann Gat, David Kortenkamp, David P. Miller and Marc
    G. Slack, "Experiences with an architecture for intelligent, reactive agents", Journal of
    Experimental & Theoretical Artificial Intelligence 9 (1997). The map, the plan and the steering
    are our own, and as simple as they can be.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, default_of, memory_at_reset, size_of
from sim.controllers.library._common import LOCATED, tuned_controller
from sim.controllers.memory_view import MemoryField, MemoryMap
from sim.kernels.layout import place
from sim.options.robot import RobotOptions
from worldgen.support.arrays import Floats

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
SIDE = UP - RIGHT  # cells along a side of the map


class ThreeLayer(NamedTuple):
    """Tuned parameters.

    Args:
        margin: Safety distance added to the robot's radius, m.
        pitch: Side of a cell of the map, in radii of the robot; larger if the map would not reach
            the target otherwise.
        reach: Minimum side of the map, as a multiple of the distance from start to target.
        look: Free distance that the controller requires in its direction, m.
        patience: Steps after which a waypoint is given up. They are multiplied by one more than the
            number of times that the map was forgotten.
    """

    margin: float = _DEFAULT["margin"]
    pitch: float = _DEFAULT["pitch"]
    reach: float = _DEFAULT["reach"]
    look: float = _DEFAULT["look"]
    patience: int = int(_DEFAULT["patience"])


def shown_map(memory: Floats) -> MemoryMap:
    """Return the closed borders between cells of the map, and the waypoint, in m."""
    if memory[LAID] == 0.0:
        return MemoryMap()
    corner = np.array((memory[CORNER_X], memory[CORNER_Y]))

    # Each number of the map is one row; its bits are the borders to the right of, or above, cells.
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


def three_layer_robot(tuned: ThreeLayer, name: str = "three-layer") -> CompiledController:
    """Return a three-layer controller with these parameters."""
    return tuned_controller(three_layer, tuned, name)


three_layer = CompiledController(
    "three-layer",
    CoreAct("three-layer"),
    memory_at_reset(MEMORY, {}),
    about="Plan on a coarse map, supervise progress, and steer around walls.",
    senses=(*LOCATED, "beams"),
    needs=RobotOptions(beams=36, beam_range=2.0),
    memory_fields=(
        MemoryField("steps to the waypoint", WAITED),
        MemoryField("map forgotten", FORGOTTEN),
    ),
    memory_map=shown_map,
    memory_map_on=(LAID, TO_X, TO_Y, *range(RIGHT, MEMORY)),
)
