"""Potential field: the target pulls, walls push, and the robot drives down the slope.

It finds its way around single obstacles without any memory. It stops forever where push and pull
cancel: in front of a wall across its path, in any cup, and at doors whose posts push harder than
the target pulls.

Source: Oussama Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", The
    International Journal
of Robotics Research 5(1), 1986: the pull of equation 10 with the limited speed of equation 13, and
the push of "FIRAS", equation 18, summed over obstacles. A robot with range beams knows obstacles by
their nearest points: the beams that are shorter than their neighbours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import angle_of, bearing_of, steer, target_bearing
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

_NEAREST = 0.004  # m: smallest gap for which the push is computed, so that it stays finite


class PotentialField(NamedTuple):
    """Tuned numbers.

    Args:
        pull: Force per metre of distance from the target.
        far: Distance, m, beyond which the pull stops growing, which limits the speed.
        push: Gain of the walls' push; a larger one keeps the robot farther from walls, and out of
            narrow doors.
        influence: Gap, m, beyond which a wall does not push.
        full_force: Force at which the robot drives at its top speed; below that, the speed is
            proportional.
    """

    pull: float = 1.0
    far: float = 0.5
    push: float = 2.5e-5
    influence: float = 0.15
    full_force: float = 0.25


def _push(gap: float, tuned: PotentialField) -> float:
    """Khatib's equation 18 for a gap in m."""
    if gap >= tuned.influence:
        return 0.0
    near = max(gap, _NEAREST)
    return tuned.push * (1.0 / near - 1.0 / tuned.influence) / (near * near)


def drive(observation: Floats, memory: Floats, command: Floats, tuned: PotentialField) -> None:
    """One step: sums the forces in the robot's frame and drives along their sum."""
    beams = observation.size - layout.OBS_SIZE
    radius = observation[layout.OBS_RADIUS]
    towards = target_bearing(observation)
    pull = tuned.pull * min(observation[layout.OBS_TARGET_DISTANCE], tuned.far)
    force_x = pull * cos(towards)
    force_y = pull * sin(towards)
    nearest = math.inf
    for beam in range(beams):
        distance = observation[layout.OBS_SIZE + beam]
        nearest = min(nearest, distance)
        before = observation[layout.OBS_SIZE + (beam - 1) % beams]
        after = observation[layout.OBS_SIZE + (beam + 1) % beams]
        if distance < before and distance <= after:
            push = _push(distance - radius, tuned)
            angle = bearing_of(beam, beams)
            force_x -= push * cos(angle)
            force_y -= push * sin(angle)
    force = math.sqrt(force_x * force_x + force_y * force_y)
    top = observation[layout.OBS_TOP_SPEED]
    # At most half the gap in a step, because the slope of the push changes within millimetres
    # there.
    careful = max(nearest - radius, _NEAREST) / (2.0 * observation[layout.OBS_TIME_STEP])
    steer(
        observation,
        command,
        angle_of(force_x, force_y),
        min(top * min(force / tuned.full_force, 1.0), careful),
    )


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    drive(observation, memory, command, PotentialField())
