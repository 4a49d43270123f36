"""Mapping: keeps a small coarse map of where it could not pass, and drives the shortest way that the map leaves open.

The map is a grid of nodes about the start. The robot drives from node to node; where a wall stops
it, it notes that edge as blocked, feels where the wall is, which blocks all edges on which it would
overlap that place, goes back, and plans again. If no way is left it must have been mistaken: then
    it empties the map, and feels for walls no more. What
it does not know it takes for free. Each plan that fails blocks an edge more, so it arrives if there
is a way along the edges of the grid, and the map holds all that it saw: with walls on a grid of
    their own that is so if ``pitch`` is half
a cell. With less memory the map is a window that moves with the robot, and what has left it is
    forgotten: then it may
go round in circles larger than its memory. ``mapping`` makes a controller with a map of any size.

Sources: A. Zelinsky, "A mobile robot exploration algorithm", IEEE Transactions on Robotics and
    Automation 8 (1992);
that it arrives, and how long that may take: S. Koenig, C. Tovey and Y. Smirnov, "Performance bounds
    for planning in
unknown terrain", Artificial Intelligence 147 (2003).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, memory_at_reset, place
from sim.controllers.library import _boundary as body
from sim.controllers.library import _lattice_map as lattice
from sim.controllers.memory_view import MemoryField, MemoryMap
from worldgen.errors import InvalidParameter

__all__ = ["PITCH", "mapper", "mapper_small", "mapping", "shown_map"]

Floats = npt.NDArray[np.float64]

PITCH = 0.05  # m: half a cell of the families' worlds
CERTAIN = 0.97  # of the radius: nearer than this to a wall there is no room, in spite of rounding
# nodes
FULL_SIDE = 128
SMALL_SIDE = 12
LEAST_SIDE = 8
MOST_SIDE = 1024

MODE = place("WgMapperMemory", "mode")
FROM_X = place("WgMapperMemory", "from_x")
FROM_Y = place("WgMapperMemory", "from_y")
START_X = place("WgMapperMemory", "start_x")
START_Y = place("WgMapperMemory", "start_y")
GRID = place("WgMapperMemory", "grid")
TRIES = place("WgMapperMemory", "tries")
NO_ROOM = place("WgMapperMemory", "no_room")

_START = 0.0  # values of MODE
_GO = 1.0


def shown_map(memory: Floats) -> MemoryMap:
    """The edges that the map has as blocked, and the plan from where it was made, in m."""
    if memory[MODE] == _START:
        return MemoryMap()
    origin = np.array((memory[START_X], memory[START_Y]))
    pitch = memory[GRID]
    done = int(memory[lattice.PLAN_AT])
    moves = lattice.planned_moves(memory)
    way = [(0, 0)]
    for move in moves:
        way.append(lattice.neighbour(*way[-1], move))
    at = way[min(max(done - 1 if memory[MODE] == _GO else done, 0), len(moves))]
    plan = np.array(way) - at + np.array((memory[FROM_X], memory[FROM_Y]))
    return MemoryMap(
        blocked=lattice.blocked_edges(memory) * pitch + np.tile(origin, 2),
        plan=plan * pitch + origin if moves else np.zeros((0, 2)),
    )


_FIELDS = (
    MemoryField("doing", MODE, ("start", "go", "to the target", "feel for the wall", "back")),
    MemoryField("tries", TRIES),
)


def mapping(
    name: str, side: int, pitch: float = PITCH, no_room: float = CERTAIN
) -> CompiledController:
    """Return a mapping controller with a map of a size of one's own.

    Args:
        name: For messages.
        side: Nodes of the map along a side, 8 to 1024; its memory is about a number for each 12
            nodes.
        pitch: Distance between two nodes, m; half a cell finds every way between walls on a grid.
        no_room: Share of the robot's radius nearer than which to a wall that it felt there is no
            room for it; 0 blocks only edges that it tried.

    Raises:
        InvalidParameter: If the map is too small or too large, the pitch is not above 0, or the
            share outside 0 to 10.
    """
    if not LEAST_SIDE <= side <= MOST_SIDE:
        raise InvalidParameter(
            "out-of-range",
            "side={side} is outside {least_side} to {most_side} nodes",
            "give one between",
            side=side,
            least_side=LEAST_SIDE,
            most_side=MOST_SIDE,
        )
    if not (math.isfinite(pitch) and pitch > 0.0):
        raise InvalidParameter(
            "out-of-range",
            "pitch={pitch:g} m is not above 0",
            "give the distance between two nodes of the map",
            pitch=pitch,
        )
    if not 0.0 <= no_room <= 10.0:
        raise InvalidParameter(
            "out-of-range",
            "no_room={no_room:g} is outside 0 to 10 times the robot's radius",
            "give a share near 1",
            no_room=no_room,
        )
    size = lattice.memory_size(side)
    return CompiledController(
        name,
        CoreAct("mapper"),
        memory_at_reset(size, {lattice.SIDE: float(side), GRID: pitch, NO_ROOM: no_room}),
        senses=body.SENSES,
        memory_fields=_FIELDS,
        memory_map=shown_map,
        memory_map_on=(*lattice.SHOWN, *range(lattice.NODES, size)),
    )


mapper = mapping("mapper", FULL_SIDE)
mapper_small = mapping("mapper-small", SMALL_SIDE)
