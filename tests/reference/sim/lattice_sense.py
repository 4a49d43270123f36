"""What a robot on the pose lattice senses: contact, signal, compass.

And the lattice's trigonometry.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.fdlibm import atan, cos, sin
from tests.reference.sim.geometry import cell_state
from tests.reference.sim.lattice_rays import (
    beam_heading,
    ray_distance,
    smoke_on_the_way,
    walls_on_the_way,
)
from tests.reference.sim.layout import FREE, TURN, UNIT

Cells = npt.NDArray[np.uint8]
Decoys = tuple[tuple[int, int, float], ...]

_MIDDLE = UNIT // 2
_SCALE_BITS = 30  # the table holds round(cos * 2**30): 10 nm over a 10 m step
_MOST_HALVINGS = 1000
_POSE = (layout.OBS_X, layout.OBS_Y, layout.OBS_HEADING)
_APART = (
    0x5DEECE66D1CE4E5B  # makes the simulator's own stream of a seed different from the controller's
)
_PER_RADIAN = TURN / (2.0 * math.pi)


def heading_table() -> npt.NDArray[np.int64]:
    """(131072,) int64: cos of every heading times 2**30, symmetric under quarter turns and mirrors.

    The first eighth is rounded from ``math.cos`` and ``math.sin``; no value lies near enough to a
    half for two good mathematics libraries to round it differently (a test checks that margin). The
    second half of the table has the rounding errors, times 2**60, from our own functions, which
    give the same bits everywhere.
    """
    eighth = TURN // 8
    scale = float(1 << _SCALE_BITS)
    coarse, fine = np.zeros(2 * eighth + 1, np.int64), np.zeros(2 * eighth + 1, np.int64)
    for k in range(eighth + 1):
        angle = k / _PER_RADIAN
        for place, rough, exact in (
            (k, math.cos(angle), cos(angle)),
            (2 * eighth - k, math.sin(angle), sin(angle)),
        ):
            coarse[place] = math.floor(rough * scale + 0.5)
            fine[place] = math.floor((exact - coarse[place] / scale) * scale * scale + 0.5)
    return np.concatenate([_whole_turn(coarse), _whole_turn(fine)])


def _whole_turn(quarter: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    half = np.concatenate([quarter, -quarter[-2::-1]])
    return np.concatenate([half, half[-2:0:-1]])


def displacement(table: npt.NDArray[np.int64], heading: int, distance: int) -> tuple[int, int]:
    """Lattice displacement of a drive: rounded to the nearest point, halves away from zero."""
    half = 1 << (_SCALE_BITS - 1)
    along = distance * table[heading % TURN]
    across = distance * table[(heading - TURN // 4) % TURN]
    dx = (along + half) >> _SCALE_BITS if along >= 0 else -((half - along) >> _SCALE_BITS)
    dy = (across + half) >> _SCALE_BITS if across >= 0 else -((half - across) >> _SCALE_BITS)
    return dx, dy


def heading_of(dx: int, dy: int, otherwise: int) -> int:
    """Heading, in units, of the vector (dx, dy); ``otherwise`` for the zero vector.

    Reduced to the first eighth of a turn, so it has every mirror symmetry exactly.
    """
    ax, ay = abs(dx), abs(dy)
    if ax == 0 and ay == 0:
        return otherwise
    if ay <= ax:
        units = math.floor(atan(float(ay) / float(ax)) * _PER_RADIAN + 0.5)
    else:
        units = TURN // 4 - math.floor(atan(float(ax) / float(ay)) * _PER_RADIAN + 0.5)
    if dx < 0:
        units = TURN // 2 - units
    if dy < 0:
        units = -units
    return units % TURN


def turn_towards(heading: int, target: int) -> int:
    """Signed units, in (-half turn, half turn], from one heading to another."""
    turn = (target - heading) % TURN
    return turn - TURN if turn > TURN // 2 else turn


def random_draw(seed: int, index: int) -> float:
    """Draw number ``index`` (from 0) of the stream of a seed.

    SplitMix64's top 53 bits, in [0, 1).
    """
    z = np.uint64(seed) + np.uint64(index + 1) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * 2.0**-53


# Channels of the simulator's own random numbers in one step; each number is drawn independently.
NOISE_SLIP, NOISE_WAY, NOISE_TURN, NOISE_SIGNAL, NOISE_BEAMS = 0, 1, 2, 8, 1024
_CHANNELS = 4096


def noise_channel(step: int, channel: int) -> int:
    """Number of the random draw of a channel in a step."""
    return step * _CHANNELS + channel


def noise_draw(settings: npt.NDArray[np.int64], draw: int) -> float:
    """One of the simulator's own random numbers, in [0, 1), separate from those that the controller
    gets.
    """
    return random_draw(settings[layout.SET_SEED] ^ _APART, draw)


def signal_heading(cells: Cells, x: int, y: int, target_x: int, target_y: int, heading: int) -> int:
    """Heading to the strongest of the nine cells around the robot:

    to its centre, or to the target in it. The thesis's sensor: a cell's strength falls with the
    squared distance of its centre from the target (the target's own cell is the strongest), walls
    and flames carry none, and ties go to the first, rows from the top, columns from the left. In
    the thesis the target is a cell's centre; here it may be anywhere.
    """
    best_x, best_y = _strongest_of_nine(cells, x // UNIT, y // UNIT, target_x, target_y)
    if best_x == target_x // UNIT and best_y == target_y // UNIT:
        return heading_of(target_x - x, target_y - y, heading)
    return heading_of(best_x * UNIT + _MIDDLE - x, best_y * UNIT + _MIDDLE - y, heading)


def _strongest_of_nine(
    cells: Cells, ix: int, iy: int, target_x: int, target_y: int
) -> tuple[int, int]:
    """The cell, of the nine around (ix, iy), that :func:`signal_heading` points to."""
    away_x, away_y = ix * UNIT + _MIDDLE - target_x, iy * UNIT + _MIDDLE - target_y
    if (
        max(abs(away_x), abs(away_y)) > 2 * UNIT
        and abs(away_x) != _MIDDLE
        and abs(away_y) != _MIDDLE
    ):
        # If the target's cell is not one of the nine, and one of them is nearer than all others and
        # free, that one wins.
        near_x = ix - (away_x > _MIDDLE) + (away_x < -_MIDDLE)
        near_y = iy - (away_y > _MIDDLE) + (away_y < -_MIDDLE)
        if cell_state(cells, near_x, near_y) == FREE:
            return near_x, near_y
    best_x, best_y, best = ix, iy, -1
    for place in range(-1, 9):  # the robot's own cell first: another must be strictly stronger
        jx = ix if place < 0 else ix + place % 3 - 1
        jy = iy if place < 0 else iy + 1 - place // 3
        dx, dy = jx * UNIT + _MIDDLE - target_x, jy * UNIT + _MIDDLE - target_y
        distance = dx * dx + dy * dy
        if jx == target_x // UNIT and jy == target_y // UNIT:
            distance = 0  # as in the thesis: nothing is stronger than the target's own cell
        if best < 0 or (distance < best and cell_state(cells, jx, jy) == FREE):
            best, best_x, best_y = distance, jx, jy
    return best_x, best_y


def _in_field(dx: int, dy: int, heading: int, half_field: float) -> bool:
    """Return whether a direction is in the sensor's field.

    It reaches equally far to either side of the heading.
    """
    return (
        half_field >= TURN // 2
        or abs(turn_towards(heading, heading_of(dx, dy, heading))) <= half_field
    )


def _sent(
    cells: Cells,
    settings: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    source: tuple[int, int],
    place: tuple[int, int],
) -> float:
    """Strength at a place of a source of strength 1: 1 / (1 + squared distance in cells).

    Walls and smoke in between reduce it, and it is 0 beyond the sensor's range.
    """
    x, y = place
    dx, dy = source[0] - x, source[1] - y
    away_sq = float(dx * dx + dy * dy)
    longest = scales[layout.SCALE_SENSOR_RANGE]
    if away_sq > longest * longest:
        return 0.0
    value = 1.0 / (1.0 + away_sq / float(UNIT * UNIT))
    if settings[layout.SET_SIGNAL] != layout.OPEN:
        walls = walls_on_the_way(cells, x, y, *source)
        if walls > 0:
            value = (
                0.0
                if settings[layout.SET_SIGNAL] == layout.BLOCKED or walls > _MOST_HALVINGS
                else value / 2.0**walls
            )
    smoke = scales[layout.SCALE_SMOKE]
    if smoke > 0.0:
        for _ in range(smoke_on_the_way(cells, x, y, *source, settings[layout.SET_SMOKE_REACH])):
            value *= 1.0 - smoke
    return value


def _sources(
    settings: npt.NDArray[np.int64], decoys: Decoys
) -> list[tuple[tuple[int, int], float]]:
    """Places and strengths of all sources, the target first."""
    target = (settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y])
    return [(target, 1.0), *(((x, y), strength) for x, y, strength in decoys)]


def _noisy(
    settings: npt.NDArray[np.int64], scales: npt.NDArray[np.float64], value: float, draw: int
) -> float:
    """A strength as the sensor reads it; ``draw`` is the number of the random draw."""
    noise = scales[layout.SCALE_SENSOR_NOISE]
    return (
        value if noise == 0.0 else value * (1.0 + noise * (2.0 * noise_draw(settings, draw) - 1.0))
    )


def _signal_here(
    cells: Cells,
    settings: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    pose: tuple[int, int, int],
    decoys: Decoys,
    step: int,
) -> float:
    """Strength of the signal at the robot, from the sources in the sensor's field."""
    x, y, heading = pose
    half_field = scales[layout.SCALE_SENSOR_FIELD]
    value = 0.0
    for source, strength in _sources(settings, decoys):
        if _in_field(source[0] - x, source[1] - y, heading, half_field):
            value += strength * _sent(cells, settings, scales, source, (x, y))
    return _noisy(settings, scales, value, noise_channel(step, NOISE_SIGNAL))


def _reading(
    cells: Cells,
    settings: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    place: tuple[int, int],
    shift: tuple[int, int, int],
    decoys: Decoys,
    draw: int,
) -> float:
    """Strength of the signal that the sensor reads for a place near the robot.

    Args:
        cells: Cell states.
        settings: ``SET_``.
        scales: ``SCALE_``.
        place: x, y, lattice units.
        shift: Direction from the robot to the place, and the robot's heading.
        decoys: Other sources than the target.
        draw: Number of the random draw of the noise.
    """
    if not _in_field(*shift, scales[layout.SCALE_SENSOR_FIELD]):
        return 0.0
    value = 0.0
    for source, strength in _sources(settings, decoys):
        value += strength * _sent(cells, settings, scales, source, place)
    return _noisy(settings, scales, value, draw)


def _strongest_cell(
    cells: Cells,
    settings: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    pose: tuple[int, int, int],
    decoys: Decoys,
    step: int,
) -> int:
    """Like :func:`signal_heading`, for a sensor with other limits.

    The robot's own heading if it senses nothing.
    """
    x, y, heading = pose
    ix, iy, middle, sees = x // UNIT, y // UNIT, UNIT // 2, settings[layout.SET_SENSOR_CELLS]
    target_x, target_y = settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y]
    best, best_x, best_y = 0.0, x, y
    for place in range(-1, (2 * sees + 1) * (2 * sees + 1)):
        jx = ix if place < 0 else ix + place % (2 * sees + 1) - sees
        jy = iy if place < 0 else iy + sees - place // (2 * sees + 1)
        home = jx == target_x // UNIT and jy == target_y // UNIT
        at_x, at_y = (target_x, target_y) if home else (jx * UNIT + middle, jy * UNIT + middle)
        if (place >= 0 and jx == ix and jy == iy) or cell_state(cells, jx, jy) != FREE:
            continue
        value = _reading(
            cells,
            settings,
            scales,
            (at_x, at_y),
            (at_x - x, at_y - y, heading),
            decoys,
            noise_channel(step, NOISE_SIGNAL + 1 + place + 1),
        )
        if value > best:
            best, best_x, best_y = value, at_x, at_y
    return heading_of(best_x - x, best_y - y, heading)


def sense(
    cells: Cells,
    headings: npt.NDArray[np.int64],
    settings: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    state: npt.NDArray[np.int64],
    odometry: npt.NDArray[np.float64],
    contact: tuple[float, float],
    step: int,
    observation: npt.NDArray[np.float64],
    decoys: Decoys = (),
) -> None:
    """Fills the observation; of the senses that cost time, only those in ``SET_SENSES``.

    Args:
        cells: Cell states.
        headings: :func:`heading_table`.
        settings: ``SET_``.
        scales: ``SCALE_``.
        state: The robot's state.
        odometry: Its measured pose: x and y, lattice units, and heading, heading units.
        contact: Normal of its last contact; 0, 0 for none.
        step: Number of the step.
        observation: (OBS_SIZE + beams,), filled.
        decoys: Other sources of the signal than the target.
    """
    x, y, heading = state[layout.STATE_X], state[layout.STATE_Y], state[layout.STATE_HEADING]
    radians, metres, senses = (
        scales[layout.SCALE_RADIANS],
        scales[layout.SCALE_METRES],
        settings[layout.SET_SENSES],
    )
    bumped = contact[0] != 0.0 or contact[1] != 0.0
    observation[layout.OBS_BUMP] = 1.0 if bumped else 0.0
    observation[layout.OBS_HEADING] = turn_towards(0, heading) * radians
    observation[layout.OBS_X], observation[layout.OBS_Y] = x * metres, y * metres
    observation[layout.OBS_TIME_STEP] = scales[layout.SCALE_TIME_STEP]
    observation[layout.OBS_TOP_SPEED] = scales[layout.SCALE_TOP_SPEED]
    observation[layout.OBS_RADIUS] = scales[layout.SCALE_RADIUS]
    if senses & layout.SENSE_BUMP_BEARING != 0:
        observation[layout.OBS_BUMP_BEARING] = 0.0
        if bumped:
            wall = heading_of(int(-contact[0] * 1024.0), int(-contact[1] * 1024.0), heading)
            observation[layout.OBS_BUMP_BEARING] = turn_towards(heading, wall) * radians
    target_x, target_y = settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y]
    dx, dy = target_x - x, target_y - y
    if senses & layout.SENSE_TARGET_DISTANCE != 0:
        observation[layout.OBS_TARGET_DISTANCE] = math.sqrt(float(dx * dx + dy * dy)) * metres
    if senses & layout.SENSE_TARGET_HEADING != 0:
        observation[layout.OBS_TARGET_HEADING] = (
            turn_towards(0, heading_of(dx, dy, heading)) * radians
        )
    if senses & layout.SENSE_SIGNAL != 0:
        observation[layout.OBS_SIGNAL] = _signal_here(
            cells, settings, scales, (x, y, heading), decoys, step
        )
    if senses & layout.SENSE_SIGNAL_HEADING != 0:
        if settings[layout.SET_PLAIN_SENSOR] != 0:
            strongest = signal_heading(cells, x, y, target_x, target_y, heading)
        else:
            strongest = _strongest_cell(cells, settings, scales, (x, y, heading), decoys, step)
        observation[layout.OBS_SIGNAL_HEADING] = turn_towards(0, strongest) * radians
    if senses & layout.SENSE_RANDOM != 0:
        observation[layout.OBS_RANDOM] = random_draw(
            settings[layout.SET_SEED], state[layout.STATE_DRAWS]
        )
    if senses & layout.SENSE_TIME != 0:
        observation[layout.OBS_TIME] = step * scales[layout.SCALE_TIME_STEP]
    if senses & layout.SENSE_ODOMETRY != 0:
        if settings[layout.SET_MEASURES] != 0:
            observation[layout.OBS_ODOMETRY_X] = odometry[0] * metres
            observation[layout.OBS_ODOMETRY_Y] = odometry[1] * metres
            observation[layout.OBS_ODOMETRY_HEADING] = (
                turn_towards(0, math.floor(odometry[2] + 0.5)) * radians
            )
        else:
            for k in range(3):
                observation[layout.OBS_ODOMETRY_X + k] = observation[_POSE[k]]
    if senses & layout.SENSE_BEAMS != 0:
        _sense_beams(cells, headings, settings, scales, (x, y, heading), step, observation)


def _sense_beams(
    cells: Cells,
    headings: npt.NDArray[np.int64],
    settings: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    pose: tuple[int, int, int],
    step: int,
    observation: npt.NDArray[np.float64],
) -> None:
    """Fills in the range beams, m.

    A beam that hits nothing, or is lost, gives its longest distance.
    """
    x, y, heading = pose
    beams, longest, metres = (
        settings[layout.SET_BEAMS],
        scales[layout.SCALE_BEAM_RANGE],
        scales[layout.SCALE_METRES],
    )
    noise, dropout = scales[layout.SCALE_BEAM_NOISE], scales[layout.SCALE_BEAM_DROPOUT]
    for beam in range(beams):
        towards = beam_heading(heading, beam, beams, scales[layout.SCALE_BEAM_FIELD])
        distance = ray_distance(cells, headings, x, y, towards, longest)
        if noise > 0.0:
            wrong = 2.0 * noise_draw(settings, noise_channel(step, NOISE_BEAMS + beam)) - 1.0
            distance = min(distance * (1.0 + noise * wrong), longest)
        if (
            dropout > 0.0
            and noise_draw(settings, noise_channel(step, 2 * NOISE_BEAMS + beam)) < dropout
        ):
            distance = longest
        observation[layout.OBS_SIZE + beam] = distance * metres
