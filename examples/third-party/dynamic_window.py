"""The dynamic window approach of ``dynamic-window-approach`` (C with Python bindings, MIT licence).

Its author is goktug97. ``pip install dynamic-window-approach``; README.md beside this file has the whole.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import dwa
import numpy as np

from sim import Command, RobotOptions

FIELD = 2.0 * math.pi / 36  # rad between two beams


@dataclass(frozen=True)
class DynamicWindow:
    """Drives with the (speed, turn rate) that costs least over the next second and a half."""

    needs: ClassVar = RobotOptions(beams=36)
    pace: float = 6.0  # top speed, robot radii a second
    approach: float = 1.0  # top speed near the target, 1/s, so that the robot can still turn to it
    look_ahead: float = 1.0  # s
    heading: float = 0.05  # weights: of an error of 1 rad,
    velocity: float = 1.0  # of standing still,
    clearance: float = 0.1  # and of a robot radius from the nearest point; below 1 / radius, see README.md

    def reset(self):
        return (0.0, 0.0)  # speed, turn rate

    def act(self, seen, memory):
        r, top = seen.radius, min(seen.top_speed, self.pace * seen.radius, self.approach * seen.target_distance)
        ahead = min(self.look_ahead, seen.target_distance / top)
        config = dwa.Config(
            max_speed=top, min_speed=0.0, max_accel=4.0 * top, velocity_resolution=top / 8,
            max_yawrate=2.0, max_dyawrate=8.0, yawrate_resolution=0.2, dt=seen.time_step, predict_time=ahead,
            heading=self.heading, clearance=self.clearance * r, velocity=self.velocity / top, base=[r, r, -r, -r],
        )  # fmt: skip
        near = [(d, seen.heading + k * FIELD) for k, d in enumerate(seen.beams) if d < top * ahead + 4.0 * r]
        points = [(seen.x + d * math.cos(a), seen.y + d * math.sin(a)) for d, a in near]
        cloud = np.array(points, np.float32).reshape(-1, 2)
        goal = (
            seen.x + seen.target_distance * math.cos(seen.target_heading),
            seen.y + seen.target_distance * math.sin(seen.target_heading),
        )
        velocity = (min(memory[0], top), memory[1])
        chosen = dwa.planning((seen.x, seen.y, seen.heading), velocity, goal, cloud, config)
        return Command(*chosen), chosen
