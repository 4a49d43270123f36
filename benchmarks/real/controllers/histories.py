"""Follow walls as ``wall_follower.py`` does, and keep books on it: faults that need a history."""

import math

from sim import Command, RobotOptions

BEAMS = 36
STEP = math.tau / BEAMS


class Histories:
    """Heads for the target; at a wall it keeps the wall on its right until it has gained."""

    needs = RobotOptions(beams=BEAMS, beam_range=1.0)
    senses = (
        "bump",
        "bump_bearing",
        "heading",
        "x",
        "y",
        "target_heading",
        "target_distance",
        "beams",
    )
    gain = 0.5  # radii closer to the target than where it met the wall

    def reset(self):
        # Closest to the target so far, m, and steps since then.
        self.closest = math.inf
        self.idle = 0
        # Following or not; distance to the target where it met the wall; wall's bearing (world);
        # the last place; steps on this wall, turns on it, rad, and walls so far.
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def act(self, seen, memory):
        following, met, wall, x, y, steps, turned, walls = memory
        stuck = math.hypot(seen.x - x, seen.y - y) < 0.02 * seen.radius
        here = (seen.x, seen.y)
        to_target = math.remainder(seen.target_heading - seen.heading, math.tau)
        self.idle = self.idle + 1 if seen.target_distance >= self.closest else 0
        self.closest = min(self.closest, seen.target_distance)
        is_late = self.idle > 1_500
        if not following:
            if not seen.bump:
                command = Command(seen.top_speed, to_target / seen.time_step)
                return command, (*memory[:3], *here, 0.0, 0.0, walls)
            following, met = 1.0, seen.target_distance
            wall = seen.heading + seen.bump_bearing
            walls += 1.0
        elif self.has_gained(seen, met, walls) and self.is_free(seen, to_target):
            command = Command(seen.top_speed, to_target / seen.time_step)
            return command, (0.0, 0.0, 0.0, *here, 0.0, 0.0, walls)
        ahead = min(range(-1, 4), key=lambda k: seen.beams[k])
        if seen.beams[ahead] < 1.15 * seen.radius:
            # An inner corner: the wall ahead is the one to follow.
            wall = seen.heading + ahead * STEP
        elif stuck:
            # Something that no beam hits holds it: turn away from the wall.
            wall += 0.5
        elif seen.bump:
            wall = seen.heading + seen.bump_bearing
        else:
            # Nothing touched: turn towards the wall, around its corner.
            wall -= 0.5
        steps += 1.0
        side = math.pi / 2
        if is_late:
            side = self.careful(seen)
        heading = wall + side - 0.05
        turn = math.remainder(heading - seen.heading, math.tau)
        turned += turn
        speed = seen.top_speed
        effort = 1.0
        state = (following, met, wall, *here, steps, turned, walls)
        return Command(effort * speed, turn / seen.time_step), state

    def careful(self, seen):
        """Return the angle to the wall, rad, for a robot that has been late for long."""
        room = seen.beams[0] / seen.radius
        return math.pi / 2 + (0.0 if room > 1.0 else 0.02)

    def has_gained(self, seen, met, walls):
        """Return True if it is closer to the target than where it met the wall, the last of many."""
        gained = seen.target_distance < met - self.gain * seen.radius
        return gained and walls > 0

    def is_free(self, seen, bearing):
        """Return True if there is room for a few radii in a direction."""
        k = round(bearing / STEP)
        return min(seen.beams[(k + i) % BEAMS] for i in (-2, -1, 0, 1, 2)) > 2.0 * seen.radius
