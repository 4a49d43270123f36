"""Heading control by PID, along a planned path."""

import math

import numpy as np
from routes import plan_in, progress, wrapped

from sim import Command


class Pid:
    """Steers to a point ahead with a PID controller and a limited turn rate."""

    senses = ("heading", "x", "y", "target_distance")
    kp, ki, kd = 8.0, 200.0, 0.0
    turn_rate = 7.0  # rad/s
    limit = 0.005  # rad s, of the integral

    def reset(self, world):
        # Integral of the error, last error, place on the path.
        return (0.0, 0.0, 0.0, *plan_in(world).ravel().tolist())

    def act(self, seen, memory):
        integral, last, k = memory[:3]
        path = np.reshape(memory[3:], (-1, 2))
        k = progress(path, int(k), seen.x, seen.y)
        goal = path[min(k + 3, len(path) - 1)]
        error = wrapped(math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading)
        integral += error * seen.time_step
        integral = max(-self.limit, min(self.limit, integral))
        rate = self.kp * error + self.ki * integral + self.kd * (error - last) / seen.time_step
        rate = max(-self.turn_rate, min(self.turn_rate, rate))
        speed = 0.25 * min(seen.top_speed, 20.0 * seen.target_distance)
        return Command(speed, rate), (integral, error, float(k), *memory[3:])
