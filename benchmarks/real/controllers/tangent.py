"""Tangent Bug on range beams (Kamon, Rivlin and Rimon, 1996)."""

import math

from sim import Command, RobotOptions

BEAMS = 36
STEP = math.tau / BEAMS


class Tangent:
    """Heads for the end of the obstacle with the shortest detour; follows it in a local minimum."""

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

    def reset(self):
        # Mode; shortest distance to the target so far on this wall; the wall's bearing (world);
        # the last place.
        return (0.0, math.inf, 0.0, 0.0, 0.0)

    def act(self, seen, memory):
        following, shortest, wall, x, y = memory
        stuck = math.hypot(seen.x - x, seen.y - y) < 0.02 * seen.radius
        here = (seen.x, seen.y)
        bearing, reach = self.best(seen)
        if not following:
            if not seen.bump and reach <= seen.target_distance:
                return Command(seen.top_speed, bearing / seen.time_step), (
                    0.0,
                    shortest,
                    wall,
                    *here,
                )
            following = 1.0
            wall = seen.heading + (seen.bump_bearing if seen.bump else bearing)
        shortest = min(shortest, seen.target_distance)
        if reach < shortest - seen.radius and not stuck:
            return Command(seen.top_speed, bearing / seen.time_step), (0.0, shortest, 0.0, *here)
        ahead = min(range(-1, 4), key=lambda k: seen.beams[k])
        if seen.beams[ahead] < 1.15 * seen.radius:
            # An inner corner: the wall ahead is the one to follow.
            wall = seen.heading + ahead * STEP
        elif stuck:
            # Something that no beam hits holds it: turn away from the wall.
            wall += 0.5
        else:
            wall = seen.heading + seen.bump_bearing if seen.bump else wall - 0.5
        turn = math.remainder(wall + math.pi / 2 - 0.05 - seen.heading, math.tau)
        return Command(seen.top_speed, turn / seen.time_step), (following, shortest, wall, *here)

    def best(self, seen):
        """Return the bearing of the best visible place and its distance from the target."""
        to_target = math.remainder(seen.target_heading - seen.heading, math.tau)
        chosen = (math.inf, 0.0, math.inf)
        for k in range(BEAMS):
            near = min(seen.beams[(k + i) % BEAMS] for i in (-2, -1, 0, 1, 2))
            length = min(near - seen.radius, seen.target_distance)
            if length < seen.radius:
                continue
            bearing = math.remainder(k * STEP, math.tau)
            rest = math.hypot(
                seen.target_distance - length * math.cos(bearing - to_target),
                length * math.sin(bearing - to_target),
            )
            chosen = min(chosen, (length + rest, bearing, rest))
        k = round(to_target / STEP)
        if min(seen.beams[(k + i) % BEAMS] for i in (-2, -1, 0, 1, 2)) > seen.target_distance:
            return to_target, 0.0
        return chosen[1], chosen[2]
