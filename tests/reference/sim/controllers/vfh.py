"""VFH+: the robot drives through the opening that requires the least turning.

Obstacles around the robot fill a polar histogram, each widened by the robot's radius. The remaining
free sectors are openings; of the directions through them, the robot takes the cheapest: near the
target's, the heading and the previous choice. It drives fast and smoothly past clutter. It sees
only as far as its beams and has no map: in a deeper cup, or behind a long wall, it drives back and
forth forever.

Source: Iwan Ulrich and Johann Borenstein, "VFH+: reliable obstacle avoidance for fast mobile
robots", IEEE International Conference on Robotics and Automation, 1998: the four stages and the
weights of section 3. Departures: the histogram is filled from the scan of one step rather than from
a certainty grid, so the nearest obstacle of a sector counts, not a sum; the speed falls with the
density in the chosen direction as in their "The vector field histogram" (1991), equation 11.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import (
    WHOLE_TURN,
    bearing_of,
    steer,
    target_bearing,
    wrap,
)
from tests.reference.sim.fdlibm import atan, cos, sin

Floats = npt.NDArray[np.float64]

SECTORS = 72  # 5 degrees each, in the world's frame
_WIDTH = WHOLE_TURN / SECTORS
# memory: 1 for each blocked sector, then the last chosen heading, sectors; negative if there is
# none yet.
LAST = SECTORS
AT_RESET = (0.0,) * SECTORS + (-1.0,)


class VfhPlus(NamedTuple):
    """Tuned numbers.

    Args:
        safety: Margin by which obstacles are widened besides the robot's radius, in radii.
        window: Distance, in radii of the robot, beyond which obstacles do not count.
        low: Density, 0 (at the window's edge) to 1 (at the robot), below which a blocked sector
            becomes free.
        high: Density above which a free sector becomes blocked.
        wide: Width, in sectors, of an opening that is passed along its side instead of through its
            middle.
        to_target: Cost of a sector between a direction and the target's; larger than the two others
            together.
        to_heading: Cost of a sector between it and the heading.
        to_last: Cost of a sector between it and the last chosen direction.
        turning_radius: m, for a robot that cannot turn on the spot; 0 masks no directions.
        slowest: Share of the top speed in the densest direction.
    """

    safety: float = 1.0 / 7.0
    window: float = 40.0 / 7.0
    low: float = 0.6
    high: float = 0.7
    wide: int = 16
    to_target: float = 5.0
    to_heading: float = 2.0
    to_last: float = 2.0
    turning_radius: float = 0.0
    slowest: float = 0.15


def _fill(observation: Floats, density: Floats, tuned: VfhPlus) -> None:
    """Stage 1: the polar histogram.

    Each beam's obstacle covers the sectors that the widened obstacle covers.
    """
    beams = observation.size - layout.OBS_SIZE
    reach = observation[layout.OBS_RADIUS] * (1.0 + tuned.safety)
    window = tuned.window * observation[layout.OBS_RADIUS]
    for beam in range(beams):
        distance = observation[layout.OBS_SIZE + beam]
        if distance >= window:
            continue
        share = 1.0 - distance / window
        half = (
            0.5 * math.pi
            if distance <= reach
            else atan(reach / math.sqrt(distance * distance - reach * reach))
        )
        middle = observation[layout.OBS_HEADING] + bearing_of(beam, beams)
        first = math.ceil((middle - half) / _WIDTH)
        last = math.floor((middle + half) / _WIDTH)
        for sector in range(first, last + 1):
            density[sector % SECTORS] = max(density[sector % SECTORS], share)


def _block(density: Floats, memory: Floats, tuned: VfhPlus) -> None:
    """Stage 2: the binary histogram; a sector stays as it was between the two thresholds."""
    for sector in range(SECTORS):
        if density[sector] > tuned.high:
            memory[sector] = 1.0
        elif density[sector] < tuned.low:
            memory[sector] = 0.0


def _reachable_side(observation: Floats, tuned: VfhPlus) -> tuple[float, float]:
    """Stage 3: how far to the right and to the left the robot can turn before its circle meets an
    obstacle, rad.
    """
    beams, turn = observation.size - layout.OBS_SIZE, tuned.turning_radius
    near = turn + observation[layout.OBS_RADIUS] * (1.0 + tuned.safety)
    right, left = -math.pi, math.pi
    if turn <= 0.0:
        return right, left
    for beam in range(beams):
        angle = wrap(bearing_of(beam, beams))
        distance = observation[layout.OBS_SIZE + beam]
        if distance >= tuned.window * observation[layout.OBS_RADIUS]:
            continue
        x = distance * cos(angle)
        y = distance * sin(angle)
        if angle < 0.0 and x * x + (y + turn) * (y + turn) < near * near:
            right = max(right, angle)
        if angle > 0.0 and x * x + (y - turn) * (y - turn) < near * near:
            left = min(left, angle)
    return right, left


def _apart(one: float, other: float) -> float:
    """Sectors between two directions, the shorter way around."""
    away = abs(one - other) % SECTORS
    return min(away, SECTORS - away)


def _cost(way: float, target: float, heading: float, last: float, tuned: VfhPlus) -> float:
    """Stage 4's cost of a direction; all in sectors."""
    cost = tuned.to_target * _apart(way, target) + tuned.to_heading * _apart(way, heading)
    return cost if last < 0.0 else cost + tuned.to_last * _apart(way, last)


def _is_free(sector: int, heading: float, sides: tuple[float, float], memory: Floats) -> bool:
    """Return whether the masked histogram leaves a sector open."""
    turn = wrap((sector % SECTORS - heading) * _WIDTH)
    return bool(memory[sector % SECTORS] == 0.0) and sides[0] <= turn <= sides[1]


def _choose(
    heading: float, target: float, sides: tuple[float, float], memory: Floats, tuned: VfhPlus
) -> float:
    """Stage 4: the cheapest direction through an opening, sectors; -1 if all are blocked."""
    last = memory[LAST]
    border = 0
    while border < SECTORS and _is_free(border, heading, sides, memory):
        border += 1
    if border == SECTORS:
        return target
    best, least = -1.0, math.inf
    right = border + 1
    while right < border + SECTORS:
        left = right
        while left < border + SECTORS and _is_free(left, heading, sides, memory):
            left += 1
        width = left - right  # sectors right .. left - 1 are free
        if width > 0:
            ways = (0.5 * (right + left - 1), -1.0, -1.0)
            if width > tuned.wide:
                near = right + 0.5 * tuned.wide
                far = left - 1 - 0.5 * tuned.wide
                inside = (target - near) % SECTORS <= far - near
                ways = (near, far, target if inside else -1.0)
            for way in ways:
                cost = _cost(way, target, heading, last, tuned) if way >= 0.0 else math.inf
                if cost < least:
                    best, least = way % SECTORS, cost
        right = left + 1
    return best


def drive(
    observation: Floats, memory: Floats, command: Floats, density: Floats, tuned: VfhPlus
) -> None:
    """One step of the four stages; stops if every direction is blocked.

    Args:
        observation: ``OBS_``.
        memory: The binary histogram and the last choice.
        command: ``CMD_``.
        density: (SECTORS,) zeros, workspace.
        tuned: Numbers.
    """
    heading = (observation[layout.OBS_HEADING] / _WIDTH) % SECTORS
    target = (heading + target_bearing(observation) / _WIDTH) % SECTORS
    _fill(observation, density, tuned)
    _block(density, memory, tuned)
    way = _choose(heading, target, _reachable_side(observation, tuned), memory, tuned)
    memory[LAST] = way
    if way < 0.0:
        return
    dense = density[math.floor(way + 0.5) % SECTORS]
    share = max(1.0 - dense / tuned.high, tuned.slowest)
    steer(
        observation,
        command,
        wrap((way - heading) * _WIDTH),
        share * observation[layout.OBS_TOP_SPEED],
    )


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    drive(observation, memory, command, np.zeros(SECTORS), VfhPlus())
