"""Mapping: keeps a small coarse map of where it could not pass, and drives the shortest way that the map leaves open.

The map is a grid of nodes about the start. The robot drives from node to node; where a wall stops it, it notes that
edge as blocked, feels where the wall is, which blocks all edges on which it would overlap that place, goes back, and
plans again. If no way is left it must have been mistaken: then it empties the map, and feels for walls no more. What
it does not know it takes for free. Each plan that fails blocks an edge more, so it arrives if there is a way along the
edges of the grid, and the map holds all that it saw: with walls on a grid of their own that is so if ``pitch`` is half
a cell. With less memory the map is a window that moves with the robot, and what has left it is forgotten: then it may
go round in circles larger than its memory. ``mapping`` makes a controller with a map of any size.

Sources: A. Zelinsky, "A mobile robot exploration algorithm", IEEE Transactions on Robotics and Automation 8 (1992);
that it arrives, and how long that may take: S. Koenig, C. Tovey and Y. Smirnov, "Performance bounds for planning in
unknown terrain", Artificial Intelligence 147 (2003).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.controllers.base import CompiledController
from sim.controllers.interim import _boundary as body
from sim.controllers.interim import _lattice_map as lattice
from sim.controllers.interim._directions import angle_of, distance, steer, wrap
from sim.controllers.memory_view import MemoryField, MemoryMap
from sim.kernels import layout
from sim.kernels._jit import allocating_kernel, rare_kernel
from sim.kernels.fdlibm import cos, sin
from worldgen.errors import InvalidParameter

__all__ = ["PITCH", "mapper", "mapper_small", "mapping", "shown_map"]

Floats = npt.NDArray[np.float64]

PITCH = 0.05  # m: half a cell of the families' worlds
CERTAIN = 0.97  # of the radius: nearer than this to a wall there is no room, in spite of rounding
FULL_SIDE, SMALL_SIDE = 128, 12  # nodes
LEAST_SIDE, MOST_SIDE = 8, 1024

# Memory beside the map: what it does; the node that it came from, the move; where it starts; distance of two nodes;
# position before the step; length of the step; failed returns; share of the robot's radius nearer than which to a place
# that it felt there is no room, 0 if it does not feel for walls.
MODE, FROM_X, FROM_Y, MOVE, START_X, START_Y, GRID, X, Y, STEP, TRIES, NO_ROOM = (lattice.OWN + k for k in range(12))

START, GO, DOOR, TOUCH, BACK = 0.0, 1.0, 2.0, 3.0, 4.0

_THERE = 0.01  # of the pitch: nearer to a node it is there
_STANDS = 0.02  # of the pitch: a free step of less cannot come nearer
_ALONG = 0.9  # share of a step by which a node must come nearer if a wall bent the way
_PROBE = 0.2  # of the pitch: step by which it feels for a wall
_MOST_TRIES = 12.0  # steps on the way back that a wall may bend before the nearest node is taken for the one it is at


@rare_kernel
def _begin(observation: Floats, memory: Floats) -> None:
    """Lays the grid through the start, and the window half-way to the target."""
    memory[START_X], memory[START_Y] = observation[layout.OBS_X], observation[layout.OBS_Y]
    far, heading = observation[layout.OBS_TARGET_DISTANCE] / memory[GRID], observation[layout.OBS_TARGET_HEADING]
    memory[lattice.TARGET_X], memory[lattice.TARGET_Y] = far * cos(heading), far * sin(heading)
    half = memory[lattice.SIDE] / 2.0
    memory[lattice.WINDOW_X] = math.floor(memory[lattice.TARGET_X] / 2.0 - half)
    memory[lattice.WINDOW_Y] = math.floor(memory[lattice.TARGET_Y] / 2.0 - half)


@rare_kernel
def _drive_to(observation: Floats, memory: Floats, command: Floats, x: float, y: float) -> None:
    """Commands a step towards a point, m."""
    here_x, here_y = observation[layout.OBS_X], observation[layout.OBS_Y]
    step = observation[layout.OBS_TIME_STEP]
    length = min(observation[layout.OBS_TOP_SPEED] * step, distance(here_x, here_y, x, y))
    turn = wrap(angle_of(x - here_x, y - here_y) - observation[layout.OBS_HEADING])
    steer(observation, command, turn, length / step)
    memory[X], memory[Y], memory[STEP] = here_x, here_y, length


@rare_kernel
def _arrived(observation: Floats, memory: Floats, x: float, y: float) -> bool:
    """Whether the robot is at a point, m, or as near as its steps get it."""
    left = distance(observation[layout.OBS_X], observation[layout.OBS_Y], x, y)
    moved = distance(observation[layout.OBS_X], observation[layout.OBS_Y], memory[X], memory[Y])
    near = _STANDS * memory[GRID]
    free = observation[layout.OBS_BUMP] == 0.0
    return bool(left < _THERE * memory[GRID] or (free and moved < near and left < 2.0 * near))


@rare_kernel
def _is_barred(observation: Floats, memory: Floats, x: float, y: float) -> bool:
    """Whether a wall stopped or bent the last step to a point, m."""
    before = distance(memory[X], memory[Y], x, y)
    after = distance(observation[layout.OBS_X], observation[layout.OBS_Y], x, y)
    return bool(observation[layout.OBS_BUMP] != 0.0 and before - after < _ALONG * memory[STEP])


@allocating_kernel
def _choose(observation: Floats, memory: Floats) -> None:
    """Chooses the next move from the node that the robot is at."""
    x, y = int(memory[FROM_X]), int(memory[FROM_Y])
    lattice.move_window(memory, x, y)
    move = lattice.next_move(memory)
    if move < 0 and not lattice.plan(memory, x, y):
        lattice.forget(memory)  # what it noted cannot all be true
        memory[NO_ROOM] = 0.0
        lattice.plan(memory, x, y)
    if move < 0:
        move = lattice.next_move(memory)
    memory[MODE] = DOOR if move < 0 else GO
    memory[MOVE] = float(move)


@rare_kernel
def _point(observation: Floats, memory: Floats) -> tuple[float, float]:
    """Where the robot is driving to, m."""
    if memory[MODE] == DOOR:
        far, heading = observation[layout.OBS_TARGET_DISTANCE], observation[layout.OBS_TARGET_HEADING]
        return observation[layout.OBS_X] + far * cos(heading), observation[layout.OBS_Y] + far * sin(heading)
    if memory[MODE] == TOUCH:
        towards, length = body.touched(observation), _PROBE * memory[GRID]
        return observation[layout.OBS_X] + length * cos(towards), observation[layout.OBS_Y] + length * sin(towards)
    x, y = int(memory[FROM_X]), int(memory[FROM_Y])
    if memory[MODE] == GO:
        x, y = lattice.neighbour(x, y, int(memory[MOVE]))
    return memory[START_X] + memory[GRID] * x, memory[START_Y] + memory[GRID] * y


@rare_kernel
def _feel(observation: Floats, memory: Floats) -> None:
    """Notes where the wall is that the robot felt for: there, if it did not slide."""
    here_x, here_y = observation[layout.OBS_X], observation[layout.OBS_Y]
    if observation[layout.OBS_BUMP] == 0.0 or distance(memory[X], memory[Y], here_x, here_y) > _STANDS * memory[GRID]:
        return
    towards, radius = body.touched(observation), observation[layout.OBS_RADIUS]
    x = (here_x + radius * cos(towards) - memory[START_X]) / memory[GRID]
    y = (here_y + radius * sin(towards) - memory[START_Y]) / memory[GRID]
    lattice.block_near(memory, x, y, memory[NO_ROOM] * radius / memory[GRID])


@rare_kernel
def _look(observation: Floats, memory: Floats) -> bool:
    """Takes in how the last step went; whether the robot is now at a node and needs a move."""
    x, y = _point(observation, memory)
    barred = _is_barred(observation, memory, x, y)
    if memory[MODE] == TOUCH:
        _feel(observation, memory)
        memory[MODE] = BACK
        return False
    if memory[MODE] != DOOR and _arrived(observation, memory, x, y):
        if memory[MODE] == GO:
            to_x, to_y = lattice.neighbour(int(memory[FROM_X]), int(memory[FROM_Y]), int(memory[MOVE]))
            memory[FROM_X], memory[FROM_Y] = float(to_x), float(to_y)
        memory[TRIES] = 0.0
        return True
    if not barred and not (memory[MODE] == DOOR and _arrived(observation, memory, x, y)):
        return False
    if memory[MODE] == GO:
        lattice.block(memory, int(memory[FROM_X]), int(memory[FROM_Y]), int(memory[MOVE]))
    elif memory[MODE] == DOOR:
        lattice.door(memory, int(memory[FROM_X]), int(memory[FROM_Y]))
    memory[TRIES] += 1.0
    memory[MODE] = TOUCH if memory[MODE] != BACK and barred and memory[NO_ROOM] > 0.0 else BACK
    if memory[TRIES] < _MOST_TRIES:
        return False
    memory[TRIES] = 0.0
    memory[FROM_X] = math.floor((observation[layout.OBS_X] - memory[START_X]) / memory[GRID] + 0.5)
    memory[FROM_Y] = math.floor((observation[layout.OBS_Y] - memory[START_Y]) / memory[GRID] + 0.5)
    memory[lattice.PLAN_LENGTH] = 0.0
    return True


@allocating_kernel
def _map(observation: Floats, memory: Floats, command: Floats) -> None:
    if memory[MODE] == START:
        _begin(observation, memory)
        _choose(observation, memory)
    elif _look(observation, memory):
        _choose(observation, memory)
    x, y = _point(observation, memory)
    _drive_to(observation, memory, command, x, y)


def _act(observation: Floats, memory: Floats, command: Floats) -> None:
    _map(observation, memory, command)


def shown_map(memory: Floats) -> MemoryMap:
    """The edges that the map has as blocked, and the plan from where it was made, in m."""
    if memory[MODE] == START:
        return MemoryMap()
    origin, pitch = np.array((memory[START_X], memory[START_Y])), memory[GRID]
    done, moves = int(memory[lattice.PLAN_AT]), lattice.planned_moves(memory)
    way = [(0, 0)]
    for move in moves:
        way.append(lattice.neighbour(*way[-1], move))
    at = way[min(max(done - 1 if memory[MODE] == GO else done, 0), len(moves))]
    plan = np.array(way) - at + np.array((memory[FROM_X], memory[FROM_Y]))
    return MemoryMap(
        blocked=lattice.blocked_edges(memory) * pitch + np.tile(origin, 2),
        plan=plan * pitch + origin if moves else np.zeros((0, 2)),
    )


_FIELDS = (
    MemoryField("doing", MODE, ("start", "go", "to the target", "feel for the wall", "back")),
    MemoryField("tries", TRIES),
)


def mapping(name: str, side: int, pitch: float = PITCH, no_room: float = CERTAIN) -> CompiledController:
    """A mapping controller with a map of a size of one's own.

    Args:
        name: For messages.
        side: Nodes of the map along a side, 8 to 1024; its memory is about a number for each 12 nodes.
        pitch: Distance between two nodes, m; half a cell finds every way between walls on a grid.
        no_room: Share of the robot's radius nearer than which to a wall that it felt there is no room for it; 0 blocks
            only edges that it tried.

    Raises:
        InvalidParameter: If the map is too small or too large, the pitch is not above 0, or the share outside 0 to 10.
    """
    if not LEAST_SIDE <= side <= MOST_SIDE:
        raise InvalidParameter(f"side={side} is outside {LEAST_SIDE} to {MOST_SIDE} nodes; give one between")
    if not (math.isfinite(pitch) and pitch > 0.0):
        raise InvalidParameter(f"pitch={pitch:g} m is not above 0; give the distance between two nodes of the map")
    if not 0.0 <= no_room <= 10.0:
        raise InvalidParameter(f"no_room={no_room:g} is outside 0 to 10 times the robot's radius; give a share near 1")
    memory = [0.0] * (lattice.memory_size(side))
    memory[lattice.SIDE], memory[GRID], memory[NO_ROOM] = float(side), pitch, no_room
    return CompiledController(
        name,
        _act,
        tuple(memory),
        senses=body.SENSES,
        memory_fields=_FIELDS,
        memory_map=shown_map,
        memory_map_on=(*lattice.SHOWN, *range(lattice.NODES, len(memory))),
    )


mapper = mapping("mapper", FULL_SIDE)
mapper_small = mapping("mapper-small", SMALL_SIDE)
