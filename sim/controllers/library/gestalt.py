"""GESTALT: a small grid of how well the ground can be driven on, by which arcs are scored.

The grid moves with the robot. A cell has a degree of goodness from 1 to 15, or is unknown: beams
that pass a cell make it better, beams that end there make it much worse, and touch makes it bad
immediately. The robot scores arcs in 17 directions by the goodness of the ground under it and by
the progress that they make, drives the best one for five radii without looking, and looks again.
Where no arc is good, it forgets the grid. It only knows its surroundings, so it drives back and
forth in cups and in front of long walls.

Source: Steven B. Goldberg, Mark W. Maimone and Larry Matthies, "Stereo vision and rover navigation
    software for planetary exploration", IEEE Aerospace Conference (2002), section 4. Departures:
    cells are judged by range beams and by touch instead of by stereo, and the robot may begin an
    arc in any direction, because it turns on the spot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library._common import BY_TOUCH
from sim.controllers.memory_view import MemoryField, MemoryMap
from sim.controllers.variants import Variants
from sim.options.robot import RobotOptions
from worldgen.parameters.bounds import Bounds
from worldgen.support.arrays import Floats

AT = fields_of("WgGestaltMemory")

CELLS = size_of("WgGestaltMemory")

# Cells in a number of the memory, and the best degree.
_CELLS_A_WORD = 12
_BEST = 15


@dataclass(frozen=True)
class GestaltOptions:
    """Options of the controller.

    Args:
        side: Cells along a side of the grid. A cell is half a radius wide, and twelve of them take
            one number of memory.
    """

    side: Annotated[int, Bounds(8, 128, "cells")] = 40


def shown_map(memory: Floats) -> MemoryMap:
    """Return the cells that the controller has judged, with their degrees from 0 to 1."""
    side = int(memory[AT.side])
    pitch = memory[AT.pitch]
    if pitch == 0.0:
        return MemoryMap()
    words = memory[CELLS:].astype(np.int64)
    degrees = ((words[:, None] >> (4 * np.arange(_CELLS_A_WORD))) & _BEST).ravel()[: side * side]

    # A cell's place in the memory is its place in the world, modulo the window's side.
    row, column = np.nonzero(degrees.reshape(side, side))
    worth = degrees.reshape(side, side)[row, column]
    column = memory[AT.window_x] + (column - memory[AT.window_x]) % side
    row = memory[AT.window_y] + (row - memory[AT.window_y]) % side
    corners = np.column_stack((column, row, column + 1.0, row + 1.0)) * pitch
    return MemoryMap(degrees=np.column_stack((corners, worth / _BEST)))


def gestalt_robot(options: GestaltOptions, name: str = "gestalt") -> CompiledController:
    """Return a GESTALT controller with a grid of the given size."""
    words = -(-(options.side**2) // _CELLS_A_WORD)
    size = CELLS + words
    return CompiledController(
        name,
        CoreAct("gestalt"),
        memory_at_reset(size, {AT.side: float(options.side)}),
        about="Score arcs on a small grid that rates how easy the ground is to drive on.",
        senses=(*BY_TOUCH, "beams"),
        needs=RobotOptions(beams=72, beam_range=1.0),
        memory_fields=(MemoryField("metres of the arc left", AT.left),),
        memory_map=shown_map,
        memory_map_on=(AT.window_x, AT.window_y, *range(CELLS, size)),
        variants=Variants(GestaltOptions, gestalt_robot),
    )


gestalt = gestalt_robot(GestaltOptions())
