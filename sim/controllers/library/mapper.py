"""Mapping: remember where the robot could not pass, and drive the shortest path that remains.

The map is a coarse grid of nodes around the start, and the robot drives from node to node. Where a
wall stops it, it marks that edge as blocked. It then feels for the wall, which blocks all edges on
which the robot would overlap that place, returns, and plans again. If no path remains, the map must
be mistaken: the robot empties it and no longer feels for walls. Unknown edges count as free. Each
plan that fails blocks another edge, so the robot arrives if there is a path along the edges of the
grid and the map holds everything that it has seen. If walls are on a grid too, a ``pitch`` of half
a cell guarantees this. With less memory, the map is a window that moves with the robot and forgets
everything outside it; the robot may then drive in circles larger than its map. ``mapping`` makes a
controller with a map of any size.

Sources: A. Zelinsky, "A mobile robot exploration algorithm", IEEE Transactions on Robotics and
    Automation 8 (1992). For the proof of arrival and the time bound: S. Koenig, C. Tovey and Y.
    Smirnov, "Performance bounds for planning in unknown terrain", Artificial Intelligence 147
    (2003).
"""

from __future__ import annotations

import math

import numpy as np

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, memory_at_reset, place
from sim.controllers.library import _boundary as body
from sim.controllers.library import _lattice_map as lattice
from sim.controllers.memory_view import MemoryField, MemoryMap
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Floats

__all__ = ["PITCH", "mapper", "mapper_small", "mapping", "shown_map"]


# Distance between two nodes, m: half a cell of the families' worlds.
PITCH = 0.05

# Fraction of the radius. Closer than this to a wall, the robot certainly does not fit, despite
# rounding.
CERTAIN = 0.97

# Sizes of maps, in nodes along a side.
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

# Values of MODE.
_START = 0.0
_GO = 1.0


def shown_map(memory: Floats) -> MemoryMap:
    """Return the blocked edges of the map, and the plan from the place where it was made, in m."""
    if memory[MODE] == _START:
        return MemoryMap()

    # Follow the plan's moves from its first node, and shift it so that the robot's node fits.
    origin = np.array((memory[START_X], memory[START_Y]))
    pitch = memory[GRID]
    done = int(memory[lattice.PLAN_AT])
    moves = lattice.planned_moves(memory)
    nodes = [(0, 0)]
    for move in moves:
        nodes.append(lattice.neighbour(*nodes[-1], move))
    at = nodes[min(max(done - 1 if memory[MODE] == _GO else done, 0), len(moves))]
    plan = np.array(nodes) - at + np.array((memory[FROM_X], memory[FROM_Y]))
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
    """Return a mapping controller with a map of the given size.

    Args:
        name: Name in messages.
        side: Nodes along a side of the map, 8 to 1024. The memory takes about one number per 12
            nodes.
        pitch: Distance between two nodes, m; half a cell finds every path between walls on a grid.
        no_room: Fraction of the robot's radius. Closer than this to a wall that it felt, the robot
            does not fit; 0 blocks only edges that it tried.

    Raises:
        InvalidParameter: If the map is too small or too large, the pitch is not above 0, or the
            fraction is outside 0 to 10.
    """
    if not LEAST_SIDE <= side <= MOST_SIDE:
        raise InvalidParameter(
            "out-of-range",
            "side={side} is outside {least_side} to {most_side} nodes",
            "give a number in that range",
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
            "give a fraction near 1",
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
