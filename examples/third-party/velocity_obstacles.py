"""ORCA, HRVO and human-like navigation of ``navground`` (C++ with Python bindings, MIT licence).

Its author is Jérôme Guzzi, IDSIA. ``pip install navground``; README.md next to this file has the
details.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from navground import core
from navground.core import behaviors, kinematics

from sim import Command, RobotOptions

# Angle between two beams, rad.
FIELD = 2.0 * math.pi / 72


@dataclass(frozen=True)
class _Navground:
    """Asks one of navground's behaviours, which is created again in each step.

    Its only state is what the robot sees.
    """

    needs: ClassVar = RobotOptions(beams=72)
    behaviour: ClassVar[Any] = None
    settings: ClassVar[dict[str, float]] = {}
    # Top speed, robot radii per second.
    pace: float = 6.0

    def reset(self):
        # Speed, turn rate.
        return (0.0, 0.0)

    def act(self, seen, memory):
        top = min(seen.top_speed, self.pace * seen.radius)
        wheels = kinematics.TwoWheelsDifferentialDriveKinematics(
            max_speed=top, wheel_axis=2.0 * seen.radius
        )
        robot = self.behaviour(wheels, seen.radius)
        robot.optimal_speed = top
        robot.horizon = 20.0 * seen.radius
        # Lengths are multiples of the radius, so that robots of every size behave the same.
        robot.safety_margin = 0.1 * seen.radius
        for name, value in self.settings.items():
            setattr(robot, name, value)
        robot.position = (seen.x, seen.y)
        robot.orientation = seen.heading
        robot.twist = core.Twist2((memory[0], 0.0), memory[1], core.Frame.relative)
        robot.target = core.Target.Point(_at(seen, seen.target_distance, seen.target_heading), 0.0)
        # Join neighbouring hits to segments if the robot doesn't fit between them.
        hits = [_at(seen, d, seen.heading + k * FIELD) for k, d in enumerate(seen.beams)]
        pairs = [
            (a, b)
            for a, b in zip(hits, hits[1:] + hits[:1], strict=True)
            if math.dist(a, b) < 2.0 * seen.radius
        ]
        robot.environment_state.line_obstacles = [core.LineSegment(*pair) for pair in pairs]
        twist = robot.to_frame(robot.compute_cmd(seen.time_step), core.Frame.relative)
        chosen = (float(twist.velocity[0]), float(twist.angular_speed))
        return Command(*chosen), chosen


class Orca(_Navground):
    """Optimal reciprocal collision avoidance."""

    behaviour = behaviors.ORCABehavior
    # Seconds; with the default of 10 s it creeps, even in an empty room.
    settings: ClassVar = {"static_time_horizon": 1.0}


class Hrvo(_Navground):
    """Hybrid reciprocal velocity obstacles."""

    behaviour = behaviors.HRVOBehavior


class HumanLike(_Navground):
    """The heading along which the remaining path looks shortest."""

    behaviour = behaviors.HLBehavior


def _at(seen, distance, heading):
    return (seen.x + distance * math.cos(heading), seen.y + distance * math.sin(heading))
