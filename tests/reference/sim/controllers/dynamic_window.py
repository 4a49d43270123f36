"""Dynamic window: choose the best speed and turn rate in reach that let the robot stop in time.

Each pair of speed and turn rate is an arc. Arcs on which the robot could not brake before the first
obstacle are dropped; the rest are judged by their direction, their free length and their speed. It
drives fast and never knowingly into anything. It looks one arc ahead, so it stops or oscillates
forever in cups and in front of long walls, and often sees a narrow door only when it is too late to
turn into it.

Source: Dieter Fox, Wolfram Burgard and Sebastian Thrun, "The dynamic window approach to collision
    avoidance", IEEE
Robotics & Automation Magazine 4(1), 1997: admissible velocities (equation 14), the dynamic window
(equation 15) and the objective (equation 13). Departures: obstacles are the ends of range beams,
arcs are judged for the whole disc, and the objective is not smoothed over the window.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import (
    WHOLE_TURN,
    angle_of,
    bearing_of,
    target_bearing,
    wrap,
)
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

SPEED, TURN_RATE = 0, 1  # memory: last commanded m/s and rad/s
# Commands are multiples of 1/1024 m/s and rad/s, so that states can recur and loops can be proved.
_GRAIN = 1024.0


class DynamicWindow(NamedTuple):
    """Tuned numbers.

    Args:
        margin: Margin added to the robot's radius, m.
        gain: Greatest change of speed, m/s2, up or down.
        turn_gain: Greatest change of turn rate, rad/s2.
        fastest_turn: rad/s.
        speeds: Number of speeds to try, from the slowest to the fastest within the window.
        turns: Number of turn rates to try, spaced in the same way; an odd number keeps the current
            one.
        ahead: Time, s, after which an arc's heading is compared with the target's direction.
        least: Free length, m, that an arc must have; if there is none, the robot brakes and turns
            on the spot.
        far: Free length, m; anything longer makes no difference.
        to_target: Weight of the heading.
        to_free: Weight of the free length.
        to_speed: Weight of the speed.
    """

    margin: float = 0.003
    gain: float = 20.0
    turn_gain: float = 400.0
    fastest_turn: float = 12.0
    speeds: int = 5
    turns: int = 11
    ahead: float = 0.1
    least: float = 0.02
    far: float = 0.25
    to_target: float = 1.0
    to_free: float = 0.8
    to_speed: float = 0.3


def arc_to_contact(x: float, y: float, speed: float, turn_rate: float, radius: float) -> float:
    """Length of an arc until a disc meets a point, m; inf if it never does.

    Args:
        x: Distance of the point ahead of the robot, m.
        y: Distance of the point to its left, m.
        speed: m/s, positive.
        turn_rate: rad/s.
        radius: Radius of the disc, m. A point inside it counts as met immediately if it is ahead.
    """
    if x * x + y * y < radius * radius:
        return 0.0 if x > 0.0 else math.inf
    if abs(turn_rate) < 1e-6:
        if x <= 0.0 or abs(y) >= radius:
            return math.inf
        return x - math.sqrt(radius * radius - y * y)
    bend = speed / abs(
        turn_rate
    )  # the circle's radius; mirrored so that it always bends to the left
    off = bend - y if turn_rate > 0.0 else bend + y  # from the point up to the circle's centre
    away = math.sqrt(x * x + off * off)
    if abs(away - bend) >= radius or bend == 0.0:
        return math.inf
    share = min(max((bend * bend + away * away - radius * radius) / (2.0 * bend * away), -1.0), 1.0)
    turned = angle_of(off, x) % WHOLE_TURN - angle_of(share, math.sqrt(1.0 - share * share))
    return max(turned, 0.0) * bend


def _fill(observation: Floats, points: Floats) -> None:
    """Fills in the ends of the beams, m, in the robot's frame."""
    for beam in range(points.shape[0]):
        distance = observation[layout.OBS_SIZE + beam]
        angle = bearing_of(beam, points.shape[0])
        points[beam, 0] = distance * cos(angle)
        points[beam, 1] = distance * sin(angle)


def _free_way(points: Floats, speed: float, turn_rate: float, radius: float, far: float) -> float:
    """Length of an arc until a disc meets the first beam's end, m; at most ``far``."""
    free = far
    for beam in range(points.shape[0]):
        x = points[beam, 0]
        y = points[beam, 1]
        reach = free + radius
        if x * x + y * y < reach * reach:
            free = min(free, arc_to_contact(x, y, speed, turn_rate, radius))
    return free


def _facing(observation: Floats, speed: float, turn_rate: float, tuned: DynamicWindow) -> float:
    """How well an arc faces the target after a while: 1 straight at it, 0 away from it."""
    turned = turn_rate * tuned.ahead
    # On an arc, the chord so far is half the turn away from the heading.
    way = speed * tuned.ahead
    half = 0.5 * turned
    towards = target_bearing(observation)
    far = observation[layout.OBS_TARGET_DISTANCE]
    x = far * cos(towards) - way * cos(half)
    y = far * sin(towards) - way * sin(half)
    return 1.0 - abs(wrap(angle_of(x, y) - turned)) / math.pi


def drive(
    observation: Floats, memory: Floats, command: Floats, points: Floats, tuned: DynamicWindow
) -> None:
    """One step: judges every pair in the window and commands the best.

    Brakes and turns if none is admissible.

    Args:
        observation: ``OBS_``.
        memory: Last commanded speed and turn rate.
        command: ``CMD_``.
        points: (beams, 2), workspace.
        tuned: Numbers.
    """
    _fill(observation, points)
    step = observation[layout.OBS_TIME_STEP]
    top = observation[layout.OBS_TOP_SPEED]
    radius = observation[layout.OBS_RADIUS] + tuned.margin
    if observation[layout.OBS_BUMP] != 0.0:
        memory[SPEED] = 0.0  # the wall has stopped the wheels
    slow = max(memory[SPEED] - tuned.gain * step, 0.0)
    fast = min(memory[SPEED] + tuned.gain * step, top)
    right = max(memory[TURN_RATE] - tuned.turn_gain * step, -tuned.fastest_turn)
    left = min(memory[TURN_RATE] + tuned.turn_gain * step, tuned.fastest_turn)
    best, best_speed, best_turn = -1.0, slow, tuned.fastest_turn
    for i in range(tuned.speeds):
        speed = slow + (fast - slow) * i / (tuned.speeds - 1)
        for j in range(tuned.turns):
            turn_rate = right + (left - right) * j / (tuned.turns - 1)
            free = _free_way(points, speed, turn_rate, radius, tuned.far) if speed > 0.0 else 0.0
            if free < tuned.least or speed * speed > 2.0 * free * tuned.gain:
                continue
            worth = tuned.to_target * _facing(observation, speed, turn_rate, tuned)
            worth += tuned.to_free * free / tuned.far + tuned.to_speed * speed / top
            if worth > best:
                best, best_speed, best_turn = worth, speed, turn_rate
    memory[SPEED] = math.floor(best_speed * _GRAIN) / _GRAIN
    memory[TURN_RATE] = math.floor(best_turn * _GRAIN + 0.5) / _GRAIN
    command[layout.CMD_SPEED] = memory[SPEED]
    command[layout.CMD_TURN_RATE] = memory[TURN_RATE]


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    drive(
        observation,
        memory,
        command,
        np.zeros((observation.size - layout.OBS_SIZE, 2)),
        DynamicWindow(),
    )
