"""Wall following: drives to the target until it touches a wall, and then keeps its hand on that
wall forever.

It finds the way out of any maze whose walls are all connected, but goes around an island, or around
the room it is in, forever: the simplest example of a rule that works until it does not.

Source: the hand-on-wall rule, W. H. Matthews, "Mazes and Labyrinths: A General Account of Their
    History and
Developments" (1922), on the solution of mazes; for robots V. J. Lumelsky and A. A. Stepanov,
"Path-planning strategies for a point mobile automaton moving amidst unknown obstacles of arbitrary
shape", Algorithmica 2 (1987), for the step from one wall to the next.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers import _boundary as body

Floats = npt.NDArray[np.float64]

MODE = body.BODY_SIZE
GOAL, WALL = 0.0, 1.0


def _follow_wall(observation: Floats, memory: Floats, command: Floats) -> None:
    if memory[MODE] == GOAL and observation[layout.OBS_BUMP] != 0.0:
        memory[MODE] = WALL
        body.begin_following(memory, body.touched(observation))
    elif memory[MODE] == WALL:
        body.feel(observation, memory)
        memory[MODE] = GOAL if body.has_lost_it(memory) else WALL
    if memory[MODE] == WALL:
        body.follow(observation, memory, command)
    else:
        body.head_for_target(observation, memory, command)


def _act(observation: Floats, memory: Floats, command: Floats) -> None:
    _follow_wall(observation, memory, command)
