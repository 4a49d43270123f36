"""Mapping: keeps a coarse map of where it could not pass, and drives the shortest open path.

The map is a grid of nodes around the start. The robot drives from node to node. If a wall stops it,
it marks that edge as blocked and feels where the wall is, which blocks all edges on which it would
overlap that place; then it goes back and plans again. If no path is left, it must have been
mistaken: it then clears the map, and stops feeling for walls. It treats unknown edges as free. Each
plan that fails blocks another edge, so it arrives if there is a path along the edges of the grid
and the map holds everything that it has found; for walls on a grid, such a path exists if ``pitch``
is half a cell. With less memory, the map is a window that moves with the robot, and nodes outside
it are forgotten, so the robot may drive in circles larger than its memory. ``mapping`` makes a
controller with a map of any size.

Sources: A. Zelinsky, "A mobile robot exploration algorithm", IEEE Transactions on Robotics and
Automation 8 (1992); for a proof that it arrives, and how long that may take: S. Koenig, C. Tovey
and Y. Smirnov, "Performance bounds for planning in unknown terrain", Artificial Intelligence 147
(2003).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers import _boundary as body
from tests.reference.sim.controllers import _lattice_map as lattice
from tests.reference.sim.controllers._directions import angle_of, distance, steer, wrap
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

PITCH = 0.05  # m: half a cell of the families' worlds
CERTAIN = 0.97  # radii: nearer than this to a wall there is no room, despite rounding
FULL_SIDE, SMALL_SIDE = 128, 12  # nodes
LEAST_SIDE, MOST_SIDE = 8, 1024

# Memory next to the map: what it does; the node that it came from, the move; where it starts;
# distance of two nodes; position before the step; length of the step; failed returns; the distance
# from a wall that it felt within which there is no room, as a share of the robot's radius, 0 if it
# does not feel for walls.
MODE, FROM_X, FROM_Y, MOVE, START_X, START_Y, GRID, X, Y, STEP, TRIES, NO_ROOM = (
    lattice.OWN + k for k in range(12)
)

START, GO, DOOR, TOUCH, BACK = 0.0, 1.0, 2.0, 3.0, 4.0

_THERE = 0.01  # fraction of the pitch: within this distance it is at a node
_STANDS = 0.02  # fraction of the pitch: a shorter free step cannot come nearer
_ALONG = 0.9  # share of a step by which a node must come nearer if a wall deflected the step
_PROBE = 0.2  # fraction of the pitch: length of a step that feels for a wall
# Steps on the way back that a wall may deflect before the nearest node counts as the one it is at.
_MOST_TRIES = 12.0


def _begin(observation: Floats, memory: Floats) -> None:
    """Lays the grid through the start, and the window halfway to the target."""
    memory[START_X] = observation[layout.OBS_X]
    memory[START_Y] = observation[layout.OBS_Y]
    far = observation[layout.OBS_TARGET_DISTANCE] / memory[GRID]
    heading = observation[layout.OBS_TARGET_HEADING]
    memory[lattice.TARGET_X] = far * cos(heading)
    memory[lattice.TARGET_Y] = far * sin(heading)
    half = memory[lattice.SIDE] / 2.0
    memory[lattice.WINDOW_X] = math.floor(memory[lattice.TARGET_X] / 2.0 - half)
    memory[lattice.WINDOW_Y] = math.floor(memory[lattice.TARGET_Y] / 2.0 - half)


def _drive_to(observation: Floats, memory: Floats, command: Floats, x: float, y: float) -> None:
    """Commands a step towards a point, m."""
    here_x = observation[layout.OBS_X]
    here_y = observation[layout.OBS_Y]
    step = observation[layout.OBS_TIME_STEP]
    length = min(observation[layout.OBS_TOP_SPEED] * step, distance(here_x, here_y, x, y))
    turn = wrap(angle_of(x - here_x, y - here_y) - observation[layout.OBS_HEADING])
    steer(observation, command, turn, length / step)
    memory[X], memory[Y], memory[STEP] = here_x, here_y, length


def _arrived(observation: Floats, memory: Floats, x: float, y: float) -> bool:
    """Return whether the robot is at a point, m, or as near as its steps allow."""
    left = distance(observation[layout.OBS_X], observation[layout.OBS_Y], x, y)
    moved = distance(observation[layout.OBS_X], observation[layout.OBS_Y], memory[X], memory[Y])
    near = _STANDS * memory[GRID]
    free = observation[layout.OBS_BUMP] == 0.0
    return bool(left < _THERE * memory[GRID] or (free and moved < near and left < 2.0 * near))


def _is_barred(observation: Floats, memory: Floats, x: float, y: float) -> bool:
    """Return whether a wall stopped or deflected the last step to a point, m."""
    before = distance(memory[X], memory[Y], x, y)
    after = distance(observation[layout.OBS_X], observation[layout.OBS_Y], x, y)
    return bool(observation[layout.OBS_BUMP] != 0.0 and before - after < _ALONG * memory[STEP])


def _choose(observation: Floats, memory: Floats) -> None:
    """Chooses the next move from the node that the robot is at."""
    x = int(memory[FROM_X])
    y = int(memory[FROM_Y])
    lattice.move_window(memory, x, y)
    move = lattice.next_move(memory)
    if move < 0 and not lattice.plan(memory, x, y):
        lattice.forget(memory)  # its notes cannot all be true
        memory[NO_ROOM] = 0.0
        lattice.plan(memory, x, y)
    if move < 0:
        move = lattice.next_move(memory)
    memory[MODE] = DOOR if move < 0 else GO
    memory[MOVE] = float(move)


def _point(observation: Floats, memory: Floats) -> tuple[float, float]:
    """Return where the robot is driving to, m."""
    if memory[MODE] == DOOR:
        far = observation[layout.OBS_TARGET_DISTANCE]
        heading = observation[layout.OBS_TARGET_HEADING]
        return observation[layout.OBS_X] + far * cos(heading), observation[
            layout.OBS_Y
        ] + far * sin(heading)
    if memory[MODE] == TOUCH:
        towards = body.touched(observation)
        length = _PROBE * memory[GRID]
        return observation[layout.OBS_X] + length * cos(towards), observation[
            layout.OBS_Y
        ] + length * sin(towards)
    x = int(memory[FROM_X])
    y = int(memory[FROM_Y])
    if memory[MODE] == GO:
        x, y = lattice.neighbour(x, y, int(memory[MOVE]))
    return memory[START_X] + memory[GRID] * x, memory[START_Y] + memory[GRID] * y


def _feel(observation: Floats, memory: Floats) -> None:
    """Notes the place of the wall that the robot felt for, unless the robot slid."""
    here_x = observation[layout.OBS_X]
    here_y = observation[layout.OBS_Y]
    if (
        observation[layout.OBS_BUMP] == 0.0
        or distance(memory[X], memory[Y], here_x, here_y) > _STANDS * memory[GRID]
    ):
        return
    towards = body.touched(observation)
    radius = observation[layout.OBS_RADIUS]
    x = (here_x + radius * cos(towards) - memory[START_X]) / memory[GRID]
    y = (here_y + radius * sin(towards) - memory[START_Y]) / memory[GRID]
    lattice.block_near(memory, x, y, memory[NO_ROOM] * radius / memory[GRID])


def _look(observation: Floats, memory: Floats) -> bool:
    """Processes the last step; returns whether the robot is now at a node and needs a move."""
    x, y = _point(observation, memory)
    barred = _is_barred(observation, memory, x, y)
    if memory[MODE] == TOUCH:
        _feel(observation, memory)
        memory[MODE] = BACK
        return False
    if memory[MODE] != DOOR and _arrived(observation, memory, x, y):
        if memory[MODE] == GO:
            to_x, to_y = lattice.neighbour(
                int(memory[FROM_X]), int(memory[FROM_Y]), int(memory[MOVE])
            )
            memory[FROM_X] = float(to_x)
            memory[FROM_Y] = float(to_y)
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
