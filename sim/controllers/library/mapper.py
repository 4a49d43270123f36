"""Mapping: remember where the robot could not pass, and drive the shortest path that remains.

The map is a coarse grid of nodes around the start, and the robot drives from node to node. If a
wall stops it, it marks that edge as blocked. It then feels for the wall, which blocks all edges on
which the robot would overlap that place, returns, and plans again. If no path remains, the map must
be mistaken: the robot empties it and no longer feels for walls. Unknown edges count as free. Each
plan that fails blocks another edge, so the robot arrives if there is a path along the edges of the
grid and the map holds everything that it has seen. If walls are on a grid too, a ``pitch`` of half
a cell guarantees this. With less memory, the map is a window that moves with the robot and forgets
everything outside it; the robot may then drive in circles larger than its map. ``mapping`` makes a
controller with a map of any size. ``team-mapper`` is for fleets: its robots tell each other where
they have touched walls.

Sources: A. Zelinsky, "A mobile robot exploration algorithm", IEEE Transactions on Robotics and
    Automation 8 (1992). For the proof of arrival and the time bound: S. Koenig, C. Tovey and Y.
    Smirnov, "Performance bounds for planning in unknown terrain", Artificial Intelligence 147
    (2003).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library._common import BY_TOUCH
from sim.controllers.memory_view import MemoryField, MemoryMap
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter
from worldgen.parameters.bounds import check_between
from worldgen.support.arrays import Floats

AT = fields_of("WgMapperMemory")

TEAM = fields_of("WgTeamMemory")

# Distance between two nodes, m: half a cell of the families' worlds.
PITCH = 0.05

# Fraction of the radius. At a smaller distance from a wall, the robot certainly does not fit,
# despite rounding.
CERTAIN = 0.97

# Sizes of maps, in nodes along a side.
FULL_SIDE = 128
SMALL_SIDE = 12
LEAST_SIDE = 8
MOST_SIDE = 1024

# Values of the mode.
_START = 0.0
_GO = 1.0

# ``sim/core/controllers/shared/lattice_map.c`` packs several entries of the map into each number:
# moves, at 3 bits each, and nodes, at 4 bits each.
_MOVES_A_WORD = 16
_NODES_A_WORD = 12

# Nodes at most this far from the target along each axis have an edge to it.
_REACH = 2


def memory_size(side: int) -> int:
    """Return the number of memory entries that a map takes, given the nodes along one side."""
    return size_of("WgMapperMemory") + -(-side * side // _NODES_A_WORD)


def neighbour(x: int, y: int, move: int) -> tuple[int, int]:
    """Return the node that a move leads to.

    Moves are numbered counter-clockwise by eighths of a turn; 0 is east.
    """
    dx = 1 if move in (0, 1, 7) else (-1 if move in (3, 4, 5) else 0)
    dy = 1 if move in (1, 2, 3) else (-1 if move in (5, 6, 7) else 0)
    return x + dx, y + dy


def blocked_edges(memory: Floats) -> Floats:
    """Return the edges that are blocked on the map: (n, 4), x and y of the nodes at both ends.

    A blocked door is an edge that ends at the target.
    """
    # Unpack the four bits of each node, one for each direction in which an edge leaves it.
    side = int(memory[AT.side])
    words = memory[size_of("WgMapperMemory") :].astype(np.int64)
    nodes = (words[:, None] >> (4 * np.arange(_NODES_A_WORD))) & 15
    bits = nodes.ravel()[: side * side].reshape(side, side)

    # The map is a ring in both directions, so that the window can move without copying.
    low_x = int(memory[AT.window_x])
    low_y = int(memory[AT.window_y])
    found = []
    for move in range(4):
        row, column = np.nonzero((bits >> move) & 1)
        x = low_x + (column - low_x) % side
        y = low_y + (row - low_y) % side
        dx, dy = neighbour(0, 0, move)
        found.append(np.column_stack((x, y, x + dx, y + dy)).astype(np.float64))

    # Doors are the edges between the target and the nodes around it.
    for number in range(4 * _REACH * _REACH):
        if (int(memory[AT.doors]) >> number) & 1:
            up, along = divmod(number, 2 * _REACH)
            node_x, node_y = (math.floor(memory[AT.target_x + k]) - _REACH + 1 for k in range(2))
            found.append(
                np.array([[node_x + along, node_y + up, memory[AT.target_x], memory[AT.target_y]]])
            )
    return np.concatenate(found)


def planned_moves(memory: Floats) -> list[int]:
    """Return all moves of the plan, including those already done."""
    count = int(memory[AT.plan_length])
    return [
        (int(memory[AT.plan + k // _MOVES_A_WORD]) >> (3 * (k % _MOVES_A_WORD))) & 7
        for k in range(count)
    ]


def shown_map(memory: Floats) -> MemoryMap:
    """Return the blocked edges of the map, and the plan from the place where it was made, in m."""
    if memory[AT.mode] == _START:
        return MemoryMap()

    # Follow the plan's moves from its first node, and shift it so that the robot's node fits.
    origin = np.array((memory[AT.start_x], memory[AT.start_y]))
    pitch = memory[AT.grid]
    done = int(memory[AT.plan_at])
    moves = planned_moves(memory)
    nodes = [(0, 0)]
    for move in moves:
        nodes.append(neighbour(*nodes[-1], move))
    at = nodes[min(max(done - 1 if memory[AT.mode] == _GO else done, 0), len(moves))]
    plan = np.array(nodes) - at + np.array((memory[AT.from_x], memory[AT.from_y]))
    return MemoryMap(
        blocked=blocked_edges(memory) * pitch + np.tile(origin, 2),
        plan=plan * pitch + origin if moves else np.zeros((0, 2)),
    )


_FIELDS = (
    MemoryField("doing", AT.mode, ("start", "go", "to the target", "feel for the wall", "back")),
    MemoryField("tries", AT.tries),
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
        no_room: Fraction of the robot's radius. The robot does not fit at a smaller distance from a
        wall that it felt; 0 blocks only edges that it tried.

    Raises:
        InvalidParameter: If the map is too small or too large, the pitch is not above 0, or the
            fraction is outside 0 to 10.
    """
    check_between("side", side, LEAST_SIDE, MOST_SIDE, "nodes")
    if not (math.isfinite(pitch) and pitch > 0.0):
        raise InvalidParameter(
            "out-of-range",
            "pitch={pitch:g} m is not above 0",
            "use the distance between two nodes of the map",
            pitch=pitch,
        )
    check_between("no_room", no_room, 0, 10, "times the robot's radius")
    size = memory_size(side)
    return CompiledController(
        name,
        CoreAct("mapper"),
        memory_at_reset(size, {AT.side: float(side), AT.grid: pitch, AT.no_room: no_room}),
        senses=BY_TOUCH,
        about=f"Map where it could not pass, {side} x {side} nodes, and plan around it.",
        memory_fields=_FIELDS,
        memory_map=shown_map,
        memory_map_on=(
            AT.doors,
            *range(AT.plan_length, AT.mode),
            *range(size_of("WgMapperMemory"), size),
        ),
    )


mapper = mapping("mapper", FULL_SIDE)
mapper_small = mapping("mapper-small", SMALL_SIDE)


def team_mapping(driven: CompiledController, name: str) -> CompiledController:
    """Return a mapper for fleets that tells the robots near it where it has touched walls.

    Args:
        driven: The mapper that drives, from :func:`mapping`.
        name: Name in messages.
    """
    before = size_of("WgTeamMemory")
    read = driven.memory_map
    assert read is not None

    def shown(memory: Floats) -> MemoryMap:
        """Return the mapper's map, and the places on walls that the robot knows, in m."""
        count = int(memory[TEAM.count])
        places = memory[TEAM.points : TEAM.points + 2 * count].reshape(-1, 2)
        return replace(read(memory[before:]), nodes=places.copy())

    return replace(
        driven,
        name=name,
        act=CoreAct("team-mapper"),
        memory=((0.0,) * before + driven.memory),
        senses=(*driven.senses, "neighbours"),
        needs=RobotOptions(neighbour_range=2.0, message=8),
        about="Like mapper, but tell the robots around where walls are, and learn from them.",
        memory_fields=tuple(one._replace(place=one.place + before) for one in driven.memory_fields),
        memory_map=shown,
        memory_map_on=(*range(TEAM.count, before), *(at + before for at in driven.memory_map_on)),
    )


team_mapper = team_mapping(mapper, "team-mapper")
