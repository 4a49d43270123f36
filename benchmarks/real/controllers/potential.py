"""A potential field with noise against local minima (Barraquand and Latombe, 1991)."""

import math

from sim import Command, RobotOptions

BEAMS = 16
STEP = math.tau / BEAMS


class Potential:
    """Follows the force; where it makes no progress, it drives at random for a while."""

    needs = RobotOptions(beams=BEAMS, beam_range=1.0)
    senses = ("heading", "x", "y", "beams", "target_heading", "target_distance", "random")
    patience = 40  # steps without progress
    longest = 400  # steps of noise

    def reset(self):
        # Best distance so far, steps since then, steps of noise left, its direction, its length.
        return (math.inf, 0.0, 0.0, 0.0, 20.0)

    def act(self, seen, memory):
        best, stuck, noisy, direction, length = memory
        if seen.target_distance < best - 0.3 * seen.radius:
            best, stuck, length = seen.target_distance, 0.0, 20.0
        else:
            stuck += 1.0
        used = False
        if noisy > 0.0:
            noisy -= 1.0
            if int(noisy) % 25 == 0 or min(seen.beams) < 1.02 * seen.radius:
                direction, used = math.tau * seen.random, True
            heading = direction
            stuck = 0.0
        else:
            if stuck > self.patience:
                # Each time longer, until it comes closer.
                noisy, stuck, length = length, 0.0, min(self.longest, 1.5 * length)
            fx, fy = math.cos(seen.target_heading), math.sin(seen.target_heading)
            for k, distance in enumerate(seen.beams):
                gap = max(distance - seen.radius, 0.02 * seen.radius) / seen.radius
                if gap < 1.0:
                    push = 0.1 * (1.0 / gap - 1.0)
                    fx -= push * math.cos(seen.heading + k * STEP)
                    fy -= push * math.sin(seen.heading + k * STEP)
            heading = math.atan2(fy, fx)
        turn = math.remainder(heading - seen.heading, math.tau)
        memory = (best, stuck, noisy, direction, length)
        return Command(0.6 * seen.top_speed, turn / seen.time_step, used), memory
