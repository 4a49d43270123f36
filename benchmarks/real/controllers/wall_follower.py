"""Follow a wall with the right hand, and leave it for the target: Bug2 with range beams."""

import math

from sim import Command, RobotOptions

BEAMS = 36
STEP = math.tau / BEAMS


class WallFollower:
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
        # Following or not; distance to the target where it met the wall; wall's bearing (world);
        # the last place.
        return (0.0, 0.0, 0.0, 0.0, 0.0)

    def act(self, seen, memory):
        following, met, wall, x, y = memory
        stuck = math.hypot(seen.x - x, seen.y - y) < 0.02 * seen.radius
        here = (seen.x, seen.y)
        to_target = math.remainder(seen.target_heading - seen.heading, math.tau)
        if not following:
            if not seen.bump:
                return Command(seen.top_speed, to_target / seen.time_step), (*memory[:3], *here)
            following, met = 1.0, seen.target_distance
            wall = seen.heading + seen.bump_bearing
        elif seen.target_distance < met - self.gain * seen.radius and self.is_free(seen, to_target):
            return Command(seen.top_speed, to_target / seen.time_step), (0.0, 0.0, 0.0, *here)
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
        heading = wall + math.pi / 2 - 0.05
        turn = math.remainder(heading - seen.heading, math.tau)
        return Command(seen.top_speed, turn / seen.time_step), (following, met, wall, *here)

    def is_free(self, seen, bearing):
        """Return True if there is room for a few radii in a direction."""
        k = round(bearing / STEP)
        return min(seen.beams[(k + i) % BEAMS] for i in (-2, -1, 0, 1, 2)) > 2.0 * seen.radius
