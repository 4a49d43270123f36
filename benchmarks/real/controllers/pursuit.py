"""A* and regulated pure pursuit (Macenski et al., 2023)."""

import math

import numpy as np
from routes import plan_in, progress, wrapped

from sim import Command


class Pursuit:
    """Drives arcs to a point of the path a little way ahead."""

    senses = ("heading", "x", "y", "target_distance")
    lookahead = 4  # places on the path
    turn_rate = 4.0  # rad/s

    def reset(self, world):
        return (0.0, *plan_in(world).ravel().tolist())

    def act(self, seen, memory):
        path = np.reshape(memory[1:], (-1, 2))
        k = progress(path, int(memory[0]), seen.x, seen.y)
        carrot = path[min(k + self.lookahead, len(path) - 1)]
        dx, dy = carrot[0] - seen.x, carrot[1] - seen.y
        distance = math.hypot(dx, dy)
        bearing = wrapped(math.atan2(dy, dx) - seen.heading)
        memory = (float(k), *memory[1:])
        if abs(bearing) > math.pi / 3:
            # Turn on the spot, no further than to the carrot.
            rate = math.copysign(min(self.turn_rate, abs(bearing) / seen.time_step), bearing)
            return Command(0.0, rate), memory
        curvature = 2.0 * math.sin(bearing) / max(distance, 1e-6)
        # Regulate: no faster than the turn rate allows on this arc.
        speed = min(seen.top_speed, self.turn_rate / max(abs(curvature), 1e-6))
        rate = max(-self.turn_rate, min(self.turn_rate, speed * curvature))
        return Command(speed, rate), memory
