"""Layout of the arrays of the thesis's simulator, and the constants of its robot.

The thesis's own frame: pixels, y down, ten pixels a cell, ``cells[x, y]``; heading 0 is -x, pi/2 is
-y (up), growing clockwise on the screen; milliseconds.

``cells`` (int32) holds the signal: the squared distance in cells to the target's cell (0 there),
changed by the noise filter, or ``WALL``, or ``FLAME``, which carries no signal and does not stop
the robot. The border must be ``WALL``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

# How an episode ends.
LIMIT, REACHED, LOOP, TUNNEL, BURNED = 0, 1, 2, 3, 4

# How a recurrence of the complete state ends it: never; when it is found; in the last step of the
# budget, if its state is that of step ``Setup.loop_entry``.
NO_LOOP, SEEK_LOOP, PROVE_LOOP = 0, 1, 2

# The new state of a cell.
FREE, SOLID, BURNING = 0, 1, 2

CELL = 10.0  # px per cell; the listing's `length`
ROBOT_RADIUS = 7.0  # px
ROBOT_SPEED = 0.2  # px per ms; at 15 ms a tick moves 2 or 3 px, decided by the last bit of a cosine

WALL = -2  # signal value of a wall, as in the thesis's map files
FLAME = -3  # our addition; the thesis has no fire

OPEN, WEAKENED, BLOCKED = 0, 1, 2  # what walls do to the signal

# One more ending: no draw was left; append some and call again.
NEEDS_DRAWS = 6

# state (float64) ROLLING is the speed at which the robot actually moves; without inertia and
# friction it is SPEED.
X, Y, HEADING, TARGET_HEADING, SPEED, OLD_SPEED, ROLLING = 0, 1, 2, 3, 4, 5, 6
STATE_SIZE = 7

# mode (int64). BEHAVIOUR is IDLE when no behaviour is in charge; TICKS_LEFT is 0 unless collide or
# drive is in charge.
COLLISION, BEHAVIOUR, TICKS_LEFT, DRAWS_USED = 0, 1, 2, 3
MODE_STATE_SIZE = 4  # up to here, together with `state`: everything that decides the future
ACTIVE = 4  # behaviour that acted in the last tick
MOVE = 5  # how the last tick's move ended, see tests.reference.sim.stepped_motion
ESCAPES = 6  # 1 if the collide behaviour took control in the last tick
MODE_SIZE = 7

# counts (int64): reports and bookkeeping; a step that never happened is -1.
OUT_ENDING, OUT_STEPS, OUT_PERIOD, OUT_COLLISIONS, OUT_LAST_NEW_CELL = 0, 1, 2, 3, 4
OUT_DIGEST = 5  # rolling FNV-1a hash of seven words a tick, as the bits of a uint64
OUT_ACTIVATIONS = 6  # times that the collide behaviour took control
OUT_HIT_STEP, OUT_HIT_IX, OUT_HIT_IY, OUT_HIT_STATE = (
    7,
    8,
    9,
    10,
)  # causes of BURNED; SOLID is falling debris
OUT_OVERLAP_STEP, OUT_OVERLAP_IX, OUT_OVERLAP_IY = (
    11,
    12,
    13,
)  # first tick that ends deeper than tolerated
OUT_TUNNEL_STEP, OUT_TUNNEL_IX, OUT_TUNNEL_IY = (
    14,
    15,
    16,
)  # first tick whose straight path enters a wall
OUT_IN_WALL_STEP, OUT_IN_WALL_IX, OUT_IN_WALL_IY = (
    17,
    18,
    19,
)  # first tick that ends with the centre in one
NEXT_EVENT = 20
TRACE_START = 21  # step before the first row of the trace, for recordings in pieces
OVERLAP_BEGAN, OVERLAP_CAUSE = (22, 23)  # the current overlap: its first step (-1: none), its move
OUT_OVERLAP_BEGAN, OUT_OVERLAP_CAUSE, OUT_TUNNEL_BEGAN, OUT_TUNNEL_CAUSE = (
    24,
    25,
    26,
    27,
)  # as they were then
OUT_VISITED = 28  # cells that the centre was in after a tick
COUNTS_SIZE = 29

# sums (float64), px: driven length; deepest overlap at the end of a tick
SUM_PATH, SUM_OVERLAP = 0, 1
SUM_SIZE = 2

# One row of a trace (float64): state, then mode, after a tick.
ROW_MODE = STATE_SIZE
ROW_SIZE = STATE_SIZE + MODE_SIZE

HASH_START = 1469598103934665603


class Setup(NamedTuple):
    """The robot and the options of the run.

    Pass ints as ints and floats as floats: types select code.

    Args:
        rule: Turn after a collision: 1 heading + turn_angle, 2 heading - turn_angle, 3 random.
        time_step: ms per tick.
        sense: Reach of the signal sensor in cells, :func:`sensor_cells`.
        collide_ticks: Counter of the collide behaviour; the thesis's is 5 and drives 6 ticks.
        drive_ticks: Counter of the drive behaviour; the thesis's is 2 and drives 3 ticks.
        turn_angle: Turn of rules 1 and 2, rad; the thesis's is pi/2.
        radius: px.
        speed: px per ms.
        tolerance: Overlap with a wall that is not reported, px.
        steps: Maximum number of ticks.
        find_loop: How a recurrence of the complete state, after the last event, ends the run:
            ``NO_LOOP``, ...
        digest: 1 to compute the digest of the trace; else 0.
        stop_at_tunnel: 1 to end as ``TUNNEL`` when the centre's path enters a wall; else 0.
        reading: Reading of the arbiter, see :mod:`tests.reference.sim.thesis_arbiter`.
        repairs: Bits of the faults of the motion that are repaired, see
            :mod:`tests.reference.sim.stepped_motion`.
        acceleration: largest gain in a ms, px per ms; 0 for immediate changes.
        friction: loss in a ms of a robot that rolls out, px per ms; 0 for immediate stops.
        wall_friction: Share of a slide that is lost to friction.
        slip: Largest share of a tick's path that is lost.
        sensor_field: Angle that the sensor covers, rad; 0 for all around.
        sensor_noise: Largest relative error of a reading.
        signal: ``OPEN``, ``WEAKENED`` or ``BLOCKED`` by walls on its straight path.
        map_scale: Side of a cell of the robot's map, cells.
        target_x: Column of the target's cell, where the signal comes from.
        target_y: Its row.
        seed: Seed of slip and sensor noise, not negative.
        loop_entry: Step of the state that ``PROVE_LOOP`` compares with the last one.
    """

    rule: int
    time_step: float
    sense: int = 1
    collide_ticks: int = 5
    drive_ticks: int = 2
    turn_angle: float = math.pi / 2
    radius: float = ROBOT_RADIUS
    speed: float = ROBOT_SPEED
    tolerance: float = 1.0
    steps: int = 20_000
    find_loop: int = NO_LOOP
    digest: int = 1
    stop_at_tunnel: int = 0
    reading: int = 0
    repairs: int = 0
    acceleration: float = 0.0
    friction: float = 0.0
    wall_friction: float = 0.0
    slip: float = 0.0
    sensor_field: float = 0.0
    sensor_noise: float = 0.0
    signal: int = 0
    map_scale: int = 1
    target_x: int = 0
    target_y: int = 0
    seed: int = 0
    loop_entry: int = 0


class Arena(NamedTuple):
    """The surroundings; ``cells`` and ``visited`` change during an episode.

    Args:
        cells: (width, height) int32, the signal now.
        light: (width, height) int32, the signal that returns when a cell becomes free.
        events: (n, 4) int64, rows (step, x, y, state), sorted by step; applied before that step
            moves.
        visited: (width, height) uint8, cells that the centre has been in at the end of a tick.
    """

    cells: npt.NDArray[np.int32]
    light: npt.NDArray[np.int32]
    events: npt.NDArray[np.int64]
    visited: npt.NDArray[np.uint8]


@dataclass
class Search:
    """What the search for a recurrence remembers.

    Args:
        states: The bytes of the complete state after each step.
        next: The step whose state is looked up next.
        known: While a loop is proved, the state at its entry.
    """

    states: dict[int, bytes] = field(default_factory=dict)
    next: int = 0
    known: bytes = b""


class Progress(NamedTuple):
    """The state of a run; an episode that ran out of ticks or draws continues from here.

    Args:
        state: (STATE_SIZE,) float64.
        mode: (MODE_SIZE,) int64.
        counts: (COUNTS_SIZE,) int64.
        sums: (SUM_SIZE,) float64.
        search: For a recurring state.
    """

    state: npt.NDArray[np.float64]
    mode: npt.NDArray[np.int64]
    counts: npt.NDArray[np.int64]
    sums: npt.NDArray[np.float64]
    search: Search


def new_arena(
    cells: npt.NDArray[np.int32],
    light: npt.NDArray[np.int32],
    events: npt.NDArray[np.int64] | None = None,
) -> Arena:
    """Return surroundings for one episode, with copies of the arrays that it changes."""
    rows = (
        np.zeros((0, 4), np.int64) if events is None else np.array(events, np.int64).reshape(-1, 4)
    )
    return Arena(
        np.array(cells, np.int32), np.array(light, np.int32), rows, np.zeros(cells.shape, np.uint8)
    )


def new_progress(x: float, y: float, heading: float, speed: float = ROBOT_SPEED) -> Progress:
    """A run before its first tick.

    It is already driving, aiming at heading 0, with no behaviour in charge, as in the thesis.

    Args:
        x: px.
        y: px.
        heading: rad.
        speed: px per ms.
    """
    state = np.array([x, y, heading, 0.0, speed, speed, speed], np.float64)
    mode = np.array([0, -1, 0, 0, -1, 0, 0], np.int64)
    counts = np.zeros(COUNTS_SIZE, np.int64)
    counts[[OUT_HIT_STEP, OUT_OVERLAP_STEP, OUT_TUNNEL_STEP, OUT_IN_WALL_STEP, OVERLAP_BEGAN]] = -1
    counts[OUT_DIGEST] = HASH_START
    return Progress(state, mode, counts, np.zeros(SUM_SIZE), Search())
