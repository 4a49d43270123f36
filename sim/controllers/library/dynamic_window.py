"""Dynamic window: choose the best reachable velocity that still lets the robot stop in time.

Each pair of a speed and a turn rate is an arc. Arcs on which the robot could not brake before the
first obstacle are dropped. The others are scored by heading, free distance and speed. The robot
drives fast and never knowingly into anything. It looks one arc ahead, so it stops or oscillates
forever in cups and in front of long walls, and often sees a narrow door only when it is too late to
turn into it.

Source: Dieter Fox, Wolfram Burgard and Sebastian Thrun, "The dynamic window approach to collision
    avoidance", IEEE Robotics & Automation Magazine 4(1), 1997: admissible velocities (equation 14),
    the dynamic window (equation 15) and the objective (equation 13). Departures: obstacles are the
    ends of range beams, arcs are judged for the whole disc, and the objective is not smoothed over
    the window.
"""

from __future__ import annotations

from typing import NamedTuple

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, default_of, memory_at_reset, size_of
from sim.controllers.library._common import TO_TARGET, tuned_controller
from sim.options.robot import RobotOptions
from worldgen.parameters.bounds import check_between

# A step tries all pairs of a speed and a turn rate.
MOST_TRIED = 100

_DEFAULT = default_of("wg_dynamic_window_default")


class DynamicWindow(NamedTuple):
    """Tuned parameters.

    Args:
        margin: Safety distance added to the robot's radius, m.
        gain: Largest change of speed, m/s2, up or down.
        turn_gain: Largest change of turn rate, rad/s2.
        fastest_turn: Largest turn rate, rad/s.
        speeds: Number of speeds to try, from the slowest to the fastest within the window.
        turns: Number of turn rates to try, in the same way; an odd number includes the current one.
        ahead: Time after which an arc's heading is compared with the target's direction, s.
        least: Free distance that an arc must have, m. If no arc has it, the robot brakes and turns
            on the spot.
        far: Free distance beyond which more does not count, m.
        to_target: Weight of the heading.
        to_free: Weight of the free distance.
        to_speed: Weight of the speed.
    """

    margin: float = _DEFAULT["margin"]
    gain: float = _DEFAULT["gain"]
    turn_gain: float = _DEFAULT["turn_gain"]
    fastest_turn: float = _DEFAULT["fastest_turn"]
    speeds: int = int(_DEFAULT["speeds"])
    turns: int = int(_DEFAULT["turns"])
    ahead: float = _DEFAULT["ahead"]
    least: float = _DEFAULT["least"]
    far: float = _DEFAULT["far"]
    to_target: float = _DEFAULT["to_target"]
    to_free: float = _DEFAULT["to_free"]
    to_speed: float = _DEFAULT["to_speed"]


def dynamic_window_robot(tuned: DynamicWindow, name: str = "dynamic-window") -> CompiledController:
    """Return a dynamic-window controller with these parameters.

    Raises:
        InvalidParameter: If there are fewer than 2 or more than 100 speeds or turn rates.
    """
    check_between("speeds", tuned.speeds, 2, MOST_TRIED)
    check_between("turns", tuned.turns, 2, MOST_TRIED)
    return tuned_controller(dynamic_window, tuned, name)


dynamic_window = CompiledController(
    "dynamic-window",
    CoreAct("dynamic-window"),
    memory_at_reset(size_of("WgDynamicWindowMemory"), {}),
    about="Drive the best arc on which the robot could still stop in time.",
    senses=("bump", *TO_TARGET, "beams"),
    needs=RobotOptions(beams=36, beam_range=2.0),
    slow=True,
)
