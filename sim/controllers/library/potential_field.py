"""Potential field: the target attracts, walls repel, and the robot drives down the slope.

It finds its way around single obstacles without any memory. It stops forever where the forces
cancel: in front of a wall across its path, in any cup, and at doors whose posts repel it more than
the target attracts.

Source: Oussama Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", The
    International Journal of Robotics Research 5(1), 1986: the attraction of equation 10 with the
    limited speed of equation 13, and the repulsion of "FIRAS", equation 18, summed over obstacles.
    A robot with range beams knows obstacles by their nearest points: the beams that are shorter
    than their neighbours.
"""

from __future__ import annotations

from typing import NamedTuple

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, default_of
from sim.controllers.library._common import TO_TARGET, tuned_controller
from sim.options.robot import RobotOptions

_DEFAULT = default_of("wg_potential_field_default")


class PotentialField(NamedTuple):
    """Tuned parameters.

    Args:
        pull: Attracting force per metre of distance from the target.
        far: Distance beyond which the attraction does not grow, m, which limits the speed.
        push: Gain of the walls' repulsion. A larger gain keeps the robot farther from walls, and
            out of narrow doors.
        influence: Gap beyond which a wall does not repel, m.
        full_force: Force at which the robot drives at its top speed; below it, speed is
            proportional.
    """

    pull: float = _DEFAULT["pull"]
    far: float = _DEFAULT["far"]
    push: float = _DEFAULT["push"]
    influence: float = _DEFAULT["influence"]
    full_force: float = _DEFAULT["full_force"]


def potential_field_robot(
    tuned: PotentialField, name: str = "potential-field"
) -> CompiledController:
    """Return a potential-field controller with these parameters."""
    return tuned_controller(potential_field, tuned, name)


potential_field = CompiledController(
    "potential-field",
    CoreAct("potential-field"),
    about="Drive as if the target attracted the robot and walls repelled it.",
    senses=(*TO_TARGET, "beams"),
    needs=RobotOptions(beams=36, beam_range=2.0),
)
