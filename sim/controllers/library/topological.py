"""A topological map: places where the robot made decisions, joined by the paths that it drove.

At a place the robot notes its *exits*: directions, out of 16 and the one to the target, that are
free for the whole disc and lead away from everything that the map holds. It leaves by the exit with
the shortest known path to the target: along the map to the exit's place, and then straight on. So
it drives back along its map when a place has no exits left. A leg ends at a wall, at an exit that
opens at the robot's side, or after four strides; the next place is there. When the map has no exit
left, the robot forgets it and makes a finer one.

Limit on the places in the map. When it is full, the oldest place is forgotten, with its links.
A robot with few places explores the same part again, and then its run may be an endless loop.

Sources: Benjamin Kuipers and Yung-Tai Byun, "A robot exploration and mapping strategy based on a
    semantic hierarchy of spatial representations", Robotics and Autonomous Systems 8 (1991); Brian
    Yamauchi, "A frontier-based approach for autonomous exploration", IEEE International Symposium
    on Computational Intelligence in Robotics and Automation (1997), for exits into what is
    unexplored. Departures: places have coordinates, because the robot knows where it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, memory_at_reset, size_of
from sim.controllers.library._common import LOCATED
from sim.controllers.memory_view import MemoryField, MemoryMap
from sim.controllers.variants import Variants
from sim.kernels.layout import place
from sim.options.robot import RobotOptions
from worldgen.parameters.bounds import Bounds
from worldgen.support.arrays import Floats

MOST = place("WgTopologicalMemory", "most")
MODE = place("WgTopologicalMemory", "mode")
LEVEL = place("WgTopologicalMemory", "level")
COUNT = place("WgTopologicalMemory", "count")
PLACES = size_of("WgTopologicalMemory")
PLACE = size_of("WgMapPlace")
LINKS = place("WgMapPlace", "links")

# Bits of a link, and how many there are.
_LINK_BITS = 10
_LINKS = 5


@dataclass(frozen=True)
class TopologicalOptions:
    """Options of the controller.

    Args:
        places: Places that the map has room for; each takes four numbers of memory.
    """

    places: Annotated[int, Bounds(4, 1000, "places")] = 256


def shown_map(memory: Floats) -> MemoryMap:
    """Return the places of the map and the paths between them, in m."""
    rows = memory[PLACES:].reshape(-1, PLACE)[: int(memory[COUNT])]
    points = rows[:, :2]

    # Each link is the neighbour's number and 1; each pair has one at both ends.
    packed = rows[:, LINKS].astype(np.int64)
    links = (packed[:, None] >> (_LINK_BITS * np.arange(_LINKS))) & ((1 << _LINK_BITS) - 1)
    one, slot = np.nonzero(links)
    other = links[one, slot] - 1
    first = one < other
    return MemoryMap(
        nodes=points, edges=np.column_stack((points[one[first]], points[other[first]]))
    )


_FIELDS = (
    MemoryField("doing", MODE, ("start", "explore", "travel along the map")),
    MemoryField("places", COUNT),
    MemoryField("fineness", LEVEL),
)


def topological_robot(options: TopologicalOptions, name: str = "topological") -> CompiledController:
    """Return a controller with a topological map of the given size."""
    size = PLACES + PLACE * options.places
    return CompiledController(
        name,
        CoreAct("topological"),
        memory_at_reset(size, {MOST: float(options.places)}),
        about="Map the places where the robot made decisions, and the paths between them.",
        senses=("bump", *LOCATED, "beams"),
        needs=RobotOptions(beams=72, beam_range=1.0),
        memory_fields=_FIELDS,
        memory_map=shown_map,
        memory_map_on=(COUNT, *range(PLACES, size)),
        variants=Variants(TopologicalOptions, topological_robot),
    )


topological = topological_robot(TopologicalOptions())
