"""Behaviours of ``ir-sim`` (Python, MIT licence): velocity obstacles and the social force model.

Its author is Ruihua Han. ``pip install ir-sim``; README.md next to this file has the details.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

from irsim.lib.behavior.behavior_methods import DiffRVO, SFMVelocity
from irsim.util.util import vel_world2diff

from sim import Command, RobotOptions

# Angle between two beams, rad.
FIELD = 2.0 * math.pi / 72


@dataclass(frozen=True)
class VelocityObstacles:
    """``rvo`` for a differential robot among walls, which are line segments here."""

    needs: ClassVar = RobotOptions(beams=72)
    # Top speed, robot radii per second.
    pace: float = 6.0

    def reset(self):
        # Speed, heading of the velocity.
        return (0.0, 0.0)

    def act(self, seen, memory):
        top = min(seen.top_speed, self.pace * seen.radius)
        chosen = DiffRVO(
            _state(seen, memory, top),
            vxmax=top,
            vymax=top,
            acce=top,
            mode="vo",
            line_segments=_walls(seen, 5.0),
        )
        speed = float(chosen[0, 0])
        turn_rate = float(chosen[1, 0])
        return Command(speed, turn_rate), (speed, seen.heading)


@dataclass(frozen=True)
class SocialForce(VelocityObstacles):
    """``sfm`` for a differential robot.

    The reach of the walls' force is in robot radii, because the original is meant for people.
    """

    # Robot radii over which the walls' force falls to 1/e.
    reach: float = 0.5

    def act(self, seen, memory):
        top = min(seen.top_speed, self.pace * seen.radius)
        velocity = SFMVelocity(
            _state(seen, memory, top), line_segments=_walls(seen, 15.0), vmax=top, step_time=seen.time_step,
            sigma_obstacle=self.reach * seen.radius, force_factor_obstacle=2.0 * top,
        )  # fmt: skip
        chosen = vel_world2diff(
            seen.heading, list(velocity), w_max=4.0, guarantee_time=seen.time_step, tolerance=0.02
        )
        speed = float(chosen[0, 0])
        turn_rate = float(chosen[1, 0])
        return Command(speed, turn_rate), (speed, seen.heading)


def _state(seen, memory, top):
    """Return a robot's state as IR-SIM passes it: place, velocity, radius, wish, heading."""
    speed, heading = memory
    wish = [top * math.cos(seen.target_heading), top * math.sin(seen.target_heading)]
    return [
        seen.x,
        seen.y,
        speed * math.cos(heading),
        speed * math.sin(heading),
        seen.radius,
        *wish,
        seen.heading,
    ]


def _walls(seen, radii):
    """Return walls as segments [x1, y1, x2, y2] that join hits too close to pass between."""
    hits = [
        (
            seen.x + d * math.cos(seen.heading + k * FIELD),
            seen.y + d * math.sin(seen.heading + k * FIELD),
        )
        for k, d in enumerate(seen.beams)
    ]
    walls = []
    for k, (d, (x, y)) in enumerate(zip(seen.beams, hits, strict=True)):
        # Skip hits that are far away, or so far apart that the robot fits between.
        if (
            min(d, seen.beams[k - 1]) > radii * seen.radius
            or math.dist(hits[k - 1], (x, y)) > 2.0 * seen.radius
        ):
            continue
        # Lengthen the last wall if this segment continues it nearly straight.
        if walls and walls[-1][2:] == [*hits[k - 1]] and _turn(walls[-1], x, y) < 0.1:
            walls[-1][2:] = [x, y]
        else:
            walls.append([*hits[k - 1], x, y])
    return walls


def _turn(wall, x, y):
    """Return the angle, rad, between a segment and the direction from its end to a point."""
    there = (wall[2] - wall[0], wall[3] - wall[1])
    on = (x - wall[2], y - wall[3])
    return abs(math.atan2(there[0] * on[1] - there[1] * on[0], there[0] * on[0] + there[1] * on[1]))
