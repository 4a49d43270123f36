"""Three layers: one reacts, one makes sure of progress, one plans ahead.

The *controller* steers to a waypoint in the nearest direction that is free for the whole disc. The
*sequencer* watches it: a waypoint is reached when the robot is in its cell; if that takes too long,
the sequencer reports it to the deliberator and starts again from the robot's place. The
*deliberator* keeps a coarse map of where the sequencer failed, and plans a path through the rest of
it to the target; the next cell of the plan is the next waypoint.

It gets out of cups and through most mazes by trial and error. Its map is a square of 48 x 48 cells
around the midpoint between start and target, with a bit for each passage between two cells; it does
not find paths outside the map, or passages that the map's cells cannot tell apart. When the map
leaves no path, it forgets everything and tries again with more patience.

Sources: Erann Gat, "On three-layer architectures", in Artificial Intelligence and Mobile Robots
    (1998); R. Peter
Bonasso, R. James Firby, Erann Gat, David Kortenkamp, David P. Miller and Marc G. Slack,
"Experiences with an architecture for intelligent, reactive agents", Journal of Experimental &
Theoretical Artificial Intelligence 9 (1997). The map, the plan and the steering are our own, and as
simple as possible.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import (
    angle_of,
    bearing_of,
    steer,
    target_bearing,
    wrap,
)
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SIDE = 48  # cells of the map per side; a row's bits must fit into the 53 of a float64
_ALL = (1 << SIDE) - 1
_MOST_FORGOTTEN = 7.0  # a number that grows forever would keep any state from recurring

# Memory: whether the map has been placed; where its corner is, m, and its cells' side, m; the
# waypoint's cell (-1: none); steps since it was set; how often the map was forgotten; the robot's
# cell, the previous one, and the target's; then a bit for each closed passage from a cell to its
# right neighbour, one number per row, and the same for its upper neighbour.
LAID, CORNER_X, CORNER_Y, PITCH, TO_X, TO_Y, WAITED, FORGOTTEN = 0, 1, 2, 3, 4, 5, 6, 7
HERE_X, HERE_Y, FROM_X, FROM_Y, TARGET_X, TARGET_Y = 8, 9, 10, 11, 12, 13
RIGHT = 14
UP = RIGHT + SIDE
MEMORY = UP + SIDE
AT_RESET = (0.0,) * MEMORY


class ThreeLayer(NamedTuple):
    """Tuned numbers.

    Args:
        margin: Margin added to the robot's radius, m.
        pitch: Side of a map cell, in robot radii; more if the map would otherwise not reach the
            target.
        reach: Minimum side of the map, as a multiple of the distance from start to target.
        look: Free distance, m, that the controller requires in its direction.
        patience: Steps after which a waypoint is given up, multiplied by one more than the number
            of times the map was forgotten.
    """

    margin: float = 0.002
    pitch: float = 20.0 / 7.0
    reach: float = 1.6
    look: float = 0.03
    patience: int = 40


def _lay(observation: Floats, memory: Floats, tuned: ThreeLayer) -> None:
    """Lays the map around the midpoint between start and target, with the target in the middle of
    its cell.
    """
    towards = observation[layout.OBS_TARGET_HEADING]
    far = observation[layout.OBS_TARGET_DISTANCE]
    pitch = max(tuned.pitch * observation[layout.OBS_RADIUS], tuned.reach * far / SIDE)
    way_x = far * cos(towards)
    way_y = far * sin(towards)
    column = SIDE // 2 + math.floor(0.5 * way_x / pitch)
    row = SIDE // 2 + math.floor(0.5 * way_y / pitch)
    memory[PITCH], memory[LAID], memory[TO_X] = pitch, 1.0, -1.0
    memory[TARGET_X] = float(column)
    memory[TARGET_Y] = float(row)
    memory[CORNER_X] = observation[layout.OBS_X] + way_x - (column + 0.5) * pitch
    memory[CORNER_Y] = observation[layout.OBS_Y] + way_y - (row + 0.5) * pitch


def _cell(memory: Floats, x: float, y: float) -> tuple[int, int]:
    """Column and row of the map's cell at a place, or the nearest cell for a place outside."""
    column = math.floor((x - memory[CORNER_X]) / memory[PITCH])
    row = math.floor((y - memory[CORNER_Y]) / memory[PITCH])
    return min(max(column, 0), SIDE - 1), min(max(row, 0), SIDE - 1)


def _spread(memory: Floats, near: Ints, wave: Ints) -> bool:
    """One round of the flood: cells next to ``near`` go into ``wave``.

    Returns whether there was a new one.
    """
    grown = False
    for row in range(SIDE):
        right = int(memory[RIGHT + row])
        cells = near[row]
        new = cells | ((cells & ~right) << 1) | ((cells >> 1) & ~right)
        if row > 0:
            new |= near[row - 1] & ~int(memory[UP + row - 1])
        if row < SIDE - 1:
            new |= near[row + 1] & ~int(memory[UP + row])
        wave[row] = new & _ALL
        grown = grown or wave[row] != cells
    return grown


def next_cell(
    memory: Floats, here: tuple[int, int], target: tuple[int, int], near: Ints, wave: Ints
) -> tuple[int, int]:
    """The deliberator's plan: the next cell on a shortest path to the target's.

    (-1, -1) if there is none. Floods the map from the target, a whole row of cells at a time, until
    the robot's cell is next to the flood.

    Args:
        memory: The map.
        here: Column and row of the robot.
        target: Column and row of the target.
        near: (SIDE,) zeros, workspace.
        wave: Same as above.
    """
    column, row = here
    near[target[1]] = 1 << target[0]
    for _ in range(SIDE * SIDE):
        if (
            column < SIDE - 1
            and (near[row] >> (column + 1)) & 1
            and not (int(memory[RIGHT + row]) >> column) & 1
        ):
            return column + 1, row
        if (
            column > 0
            and (near[row] >> (column - 1)) & 1
            and not (int(memory[RIGHT + row]) >> (column - 1)) & 1
        ):
            return column - 1, row
        if (
            row < SIDE - 1
            and (near[row + 1] >> column) & 1
            and not (int(memory[UP + row]) >> column) & 1
        ):
            return column, row + 1
        if (
            row > 0
            and (near[row - 1] >> column) & 1
            and not (int(memory[UP + row - 1]) >> column) & 1
        ):
            return column, row - 1
        if not _spread(memory, near, wave):
            break
        for k in range(SIDE):
            near[k] = wave[k]
    return -1, -1


def _steps_between(here: tuple[int, int], there: tuple[int, int]) -> int:
    """Columns and rows between two cells."""
    return abs(there[0] - here[0]) + abs(there[1] - here[1])


def _close(memory: Floats, here: tuple[int, int], there: tuple[int, int]) -> None:
    """Marks the passage between two cells as closed, if they are neighbours."""
    if _steps_between(here, there) != 1:
        return
    column = min(here[0], there[0])
    row = min(here[1], there[1])
    first = RIGHT if here[1] == there[1] else UP
    memory[first + row] = float(int(memory[first + row]) | (1 << column))


def _forget(memory: Floats) -> None:
    """Opens the whole map again."""
    for k in range(2 * SIDE):
        memory[RIGHT + k] = 0.0
    memory[FORGOTTEN] = min(memory[FORGOTTEN] + 1.0, _MOST_FORGOTTEN)


def _sequence(
    observation: Floats, memory: Floats, near: Ints, wave: Ints, tuned: ThreeLayer
) -> None:
    """The sequencer: checks whether the waypoint is reached or given up, and asks the deliberator
    for the next one.
    """
    here = _cell(memory, observation[layout.OBS_X], observation[layout.OBS_Y])
    target = (int(memory[TARGET_X]), int(memory[TARGET_Y]))
    before = (int(memory[HERE_X]), int(memory[HERE_Y]))
    if here != before:
        memory[FROM_X], memory[FROM_Y] = memory[HERE_X], memory[HERE_Y]
        memory[HERE_X] = float(here[0])
        memory[HERE_Y] = float(here[1])
    there = (int(memory[TO_X]), int(memory[TO_Y]))
    memory[WAITED] += 1.0
    late = memory[WAITED] > tuned.patience * (1.0 + memory[FORGOTTEN])
    if there[0] < 0 and here == target and not late:
        return  # on the last stretch
    if there[0] >= 0 and _steps_between(here, there) == 1 and not late:
        return
    if there[0] >= 0 and there != here:  # given up, or out of reach
        _close(memory, here if late else before, there)
    elif there[0] < 0 and late:  # the target's cell was entered on the wrong side of a wall
        _close(memory, here, (int(memory[FROM_X]), int(memory[FROM_Y])))
    memory[TO_X], memory[TO_Y], memory[WAITED] = -1.0, -1.0, 0.0
    if here == target and not late:
        return
    there = next_cell(memory, here, target, near, wave)
    if there[0] < 0:
        _forget(memory)
    memory[TO_X] = float(there[0])
    memory[TO_Y] = float(there[1])


def _is_free(observation: Floats, turn: float, look: float, tuned: ThreeLayer) -> bool:
    """Return whether the disc can drive this far, m, in a direction from the heading, according to
    the beams.
    """
    beams = observation.size - layout.OBS_SIZE
    radius = observation[layout.OBS_RADIUS] + tuned.margin
    for beam in range(beams):
        distance = observation[layout.OBS_SIZE + beam]
        if distance > look + radius:
            continue
        angle = bearing_of(beam, beams) - turn
        along = distance * cos(angle)
        across = distance * sin(angle)
        short = radius * radius - across * across
        if along > 0.0 and short > 0.0 and along - math.sqrt(short) < look:
            return False
    return True


def _react(observation: Floats, memory: Floats, command: Floats, tuned: ThreeLayer) -> None:
    """The controller: drives in the free direction nearest to the waypoint's, or to the target's in
    the last cell.
    """
    wanted = target_bearing(observation)
    beams = observation.size - layout.OBS_SIZE
    look = min(tuned.look, observation[layout.OBS_TARGET_DISTANCE])
    if memory[TO_X] >= 0.0:
        x = memory[CORNER_X] + (memory[TO_X] + 0.5) * memory[PITCH] - observation[layout.OBS_X]
        y = memory[CORNER_Y] + (memory[TO_Y] + 0.5) * memory[PITCH] - observation[layout.OBS_Y]
        wanted = wrap(angle_of(x, y) - observation[layout.OBS_HEADING])
    for k in range(beams + 1):
        away = bearing_of((k + 1) // 2, beams)
        turn = wrap(wanted + (away if k % 2 == 0 else -away))
        if _is_free(observation, turn, look, tuned):
            steer(observation, command, turn, observation[layout.OBS_TOP_SPEED])
            return
    steer(observation, command, wanted, observation[layout.OBS_TOP_SPEED])


def drive(
    observation: Floats, memory: Floats, command: Floats, near: Ints, wave: Ints, tuned: ThreeLayer
) -> None:
    """One step of all three layers.

    Args:
        observation: ``OBS_``.
        memory: See the top of the file.
        command: ``CMD_``.
        near: (SIDE,) zeros, workspace.
        wave: Same as above.
        tuned: Numbers.
    """
    if memory[LAID] == 0.0:
        _lay(observation, memory, tuned)
    _sequence(observation, memory, near, wave, tuned)
    _react(observation, memory, command, tuned)


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    drive(
        observation,
        memory,
        command,
        np.zeros(SIDE, np.int64),
        np.zeros(SIDE, np.int64),
        ThreeLayer(),
    )
