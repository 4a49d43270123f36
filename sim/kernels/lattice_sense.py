"""What a robot on the pose lattice senses: contact, signal, compass; and the lattice's trigonometry."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import kernel
from sim.kernels.fdlibm import atan
from sim.kernels.geometry import cell_state
from sim.kernels.layout import FREE, TURN, UNIT

__all__ = [
    "displacement",
    "heading_of",
    "heading_table",
    "random_draw",
    "sense",
    "signal_heading",
    "turn_towards",
]

Cells = npt.NDArray[np.uint8]

_SCALE_BITS = 30  # the table holds round(cos * 2**30): 10 nm over a 10 m step
_PER_RADIAN = TURN / (2.0 * math.pi)


def heading_table() -> npt.NDArray[np.int64]:
    """(65536,) int64: cos of every heading times 2**30, exactly symmetric under quarter turns and mirrors.

    The first eighth is rounded from ``math.cos`` and ``math.sin``; no value lies near enough to a half for
    two good mathematics libraries to round it differently (a test holds that margin).
    """
    eighth = TURN // 8
    scale = float(1 << _SCALE_BITS)
    quarter = np.zeros(2 * eighth + 1, np.int64)
    for k in range(eighth + 1):
        quarter[k] = math.floor(math.cos(k / _PER_RADIAN) * scale + 0.5)
        quarter[2 * eighth - k] = math.floor(math.sin(k / _PER_RADIAN) * scale + 0.5)
    half = np.concatenate([quarter, -quarter[-2::-1]])
    return np.concatenate([half, half[-2:0:-1]])


@kernel
def displacement(table: npt.NDArray[np.int64], heading: int, distance: int) -> tuple[int, int]:
    """Lattice displacement of a drive: rounded to the nearest point, halves away from zero."""
    half = 1 << (_SCALE_BITS - 1)
    along = distance * table[heading % TURN]
    across = distance * table[(heading - TURN // 4) % TURN]
    dx = (along + half) >> _SCALE_BITS if along >= 0 else -((half - along) >> _SCALE_BITS)
    dy = (across + half) >> _SCALE_BITS if across >= 0 else -((half - across) >> _SCALE_BITS)
    return dx, dy


@kernel
def heading_of(dx: int, dy: int, otherwise: int) -> int:
    """Heading, in units, of the vector (dx, dy); ``otherwise`` for the zero vector.

    Reduced to the first eighth of a turn, so it has every mirror symmetry exactly.
    """
    ax, ay = abs(dx), abs(dy)
    if ax == 0 and ay == 0:
        return otherwise
    if ay <= ax:
        units = int(math.floor(atan(float(ay) / float(ax)) * _PER_RADIAN + 0.5))
    else:
        units = TURN // 4 - int(math.floor(atan(float(ax) / float(ay)) * _PER_RADIAN + 0.5))
    if dx < 0:
        units = TURN // 2 - units
    if dy < 0:
        units = -units
    return units % TURN


@kernel
def turn_towards(heading: int, target: int) -> int:
    """Signed units, in (-half turn, half turn], from one heading to another."""
    turn = (target - heading) % TURN
    return turn - TURN if turn > TURN // 2 else turn


@kernel
def signal_heading(cells: Cells, x: int, y: int, target_x: int, target_y: int, heading: int) -> int:
    """Heading to the strongest of the nine cells round the robot: to its centre, or to the target in it.

    The thesis's sensor: a cell's strength falls with the squared distance of its centre from the target (the
    target's own cell is the strongest), walls and flames carry none, and the first of equals wins, rows from
    the top, columns from the left. In the thesis the target is a cell's centre; here it may be anywhere.
    """
    ix, iy, middle = x // UNIT, y // UNIT, UNIT // 2
    best_x, best_y, best = ix, iy, -1
    for place in range(-1, 9):  # the robot's own cell first: another must be strictly stronger
        jx = ix if place < 0 else ix + place % 3 - 1
        jy = iy if place < 0 else iy + 1 - place // 3
        dx, dy = jx * UNIT + middle - target_x, jy * UNIT + middle - target_y
        distance = dx * dx + dy * dy
        if jx == target_x // UNIT and jy == target_y // UNIT:
            distance = 0  # as in the thesis: nothing is stronger than the target's own cell
        if best < 0 or (distance < best and cell_state(cells, jx, jy) == FREE):
            best, best_x, best_y = distance, jx, jy
    if best_x == target_x // UNIT and best_y == target_y // UNIT:
        return heading_of(target_x - x, target_y - y, heading)
    return heading_of(best_x * UNIT + middle - x, best_y * UNIT + middle - y, heading)


@kernel
def random_draw(seed: int, index: int) -> float:
    """Draw number ``index`` (from 0) of the stream of a seed: SplitMix64's top 53 bits, in [0, 1)."""
    z = np.uint64(seed) + np.uint64(index + 1) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * 2.0**-53


@kernel
def sense(
    cells: Cells,
    settings: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    pose: tuple[int, int, int],
    contact: tuple[float, float],
    draws: int,
    observation: npt.NDArray[np.float64],
) -> None:
    """Fills the observation from the robot's pose (x, y, heading) and the normal of its last contact.

    Of the senses that cost time only those in ``SET_SENSES`` are filled.
    """
    x, y, heading = pose
    radians, metres, senses = scales[layout.SCALE_RADIANS], scales[layout.SCALE_METRES], settings[layout.SET_SENSES]
    bumped = contact[0] != 0.0 or contact[1] != 0.0
    observation[layout.OBS_BUMP] = 1.0 if bumped else 0.0
    observation[layout.OBS_HEADING] = turn_towards(0, heading) * radians
    observation[layout.OBS_X], observation[layout.OBS_Y] = x * metres, y * metres
    observation[layout.OBS_TIME_STEP] = scales[layout.SCALE_TIME_STEP]
    observation[layout.OBS_TOP_SPEED] = scales[layout.SCALE_TOP_SPEED]
    if senses & layout.SENSE_BUMP_BEARING != 0:
        observation[layout.OBS_BUMP_BEARING] = 0.0
        if bumped:
            wall = heading_of(int(-contact[0] * 1024.0), int(-contact[1] * 1024.0), heading)
            observation[layout.OBS_BUMP_BEARING] = turn_towards(heading, wall) * radians
    target_x, target_y = settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y]
    dx, dy = target_x - x, target_y - y
    if senses & (layout.SENSE_SIGNAL | layout.SENSE_TARGET_DISTANCE) != 0:
        away = math.sqrt(float(dx * dx + dy * dy))
        observation[layout.OBS_SIGNAL] = 1.0 / (1.0 + away * away / float(UNIT * UNIT))
        observation[layout.OBS_TARGET_DISTANCE] = away * metres
    if senses & layout.SENSE_SIGNAL_HEADING != 0:
        strongest = signal_heading(cells, x, y, target_x, target_y, heading)
        observation[layout.OBS_SIGNAL_HEADING] = turn_towards(0, strongest) * radians
    if senses & layout.SENSE_TARGET_HEADING != 0:
        observation[layout.OBS_TARGET_HEADING] = turn_towards(0, heading_of(dx, dy, heading)) * radians
    if senses & layout.SENSE_RANDOM != 0:
        observation[layout.OBS_RANDOM] = random_draw(settings[layout.SET_SEED], draws)
