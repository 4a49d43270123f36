"""Pure pursuit: steer along the arc that leads to a point farther along a path.

At the start, the controller plans the shortest path of its body on the map that it knows, as if it
could turn on the spot, with some room to walls if there is any. In each step it drives along the arc
from its pose to the point of the path that is a fixed distance away. It does not know whether its
turning circle fits a bend of the path, so it hits walls there; if it may reverse, it then backs away
from the wall, turning on in the same direction, and tries again.

Source: R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", Carnegie Mellon
    University CMU-RI-TR-92-01 (1992).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from sim.controllers.base import Command, Memory, Observation
from sim.controllers.memory_view import MemoryField
from worldgen.reach.deciding import decide
from worldgen.world import Witness, World

# Places in the memory: the leg of the path that was nearest, steps left of backing away, the
# curvature meanwhile, 1/m; the largest one, whether the robot may reverse; then the path's points.
_LEG, _BACK, _AWAY, _LOCK, _REVERSE = range(5)
_POINTS = 5

# Radii of the robot for which it plans, the first that has a path: it cuts corners.
_SHARES = (2.0, 1.6, 1.3, 1.1, 1.0)


class _Place(NamedTuple):
    x: float
    y: float


@dataclass(frozen=True)
class PurePursuitCar:
    """Pursues a point of the shortest path.

    Args:
        lookahead: Distance of that point, radii of the robot.
        back: Distance that it backs away from a wall, radii of the robot.
    """

    lookahead: float = 2.0
    back: float = 4.0

    about = "Know the map, plan the shortest path, and pursue a point ahead on it."
    senses = ("bump", "heading", "x", "y", "time_step", "top_speed", "radius")
    memory_fields = (MemoryField("leg", _LEG), MemoryField("backs away", _BACK))

    def reset(self, world: World) -> Memory:
        """Return the memory: the path, and nothing done of it."""
        robot = world.robots[0]
        points = [(robot.start.x, robot.start.y), *((goal.x, goal.y) for goal in robot.goals)]
        # With room to spare if there is some; and a body that is not a disc may fit where the disc
        # around it does not.
        known = world.bare
        radii = [robot.radius * share for share in _SHARES]
        for radius in (*radii, robot.inner_radius):
            path = decide(known, radius=radius, cut=False).certificate if radius else None
            if isinstance(path, Witness):
                points = [*zip(path.x.tolist(), path.y.tolist(), strict=True), points[-1]]
                break
        radius = robot.drive.turning_radius
        lock = 1.0 / radius if radius > 0.0 else math.inf
        reverse = float(robot.drive.reverse or not robot.drive.is_car)
        return (0.0, 0.0, 0.0, lock, reverse, *(value for point in points for value in point))

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command for the next step, and the new memory."""
        now = list(memory)
        reach = observation.top_speed * observation.time_step
        here = _Place(observation.x, observation.y)
        leg, ahead = _pursued(memory, here, self.lookahead * observation.radius)
        now[_LEG] = float(leg)
        # The arc through a point: twice its distance to the side over its squared distance.
        bearing = math.atan2(ahead.y - here.y, ahead.x - here.x) - observation.heading
        away = math.dist(here, ahead)
        curvature = 2.0 * math.sin(bearing) / max(away, reach, 1e-9)
        if math.cos(bearing) < 0.0:
            # A point behind the robot is on no short arc.
            curvature = math.copysign(1e9, math.sin(bearing))
        most = min(memory[_LOCK], math.pi / (2.0 * reach))
        curvature = max(-most, min(most, curvature))
        if observation.bump and memory[_REVERSE] and not memory[_BACK]:
            now[_BACK] = float(math.ceil(self.back * observation.radius / reach))
            now[_AWAY] = -math.copysign(most, curvature)
        elif observation.bump:
            now[_BACK] = 0.0
        if now[_BACK]:
            now[_BACK] -= 1.0
            # Backwards, a turn to one side is steered to the other.
            rate = -now[_AWAY] * observation.top_speed
            return Command(-observation.top_speed, rate), tuple(now)
        speed = observation.top_speed
        return Command(speed, curvature * speed), tuple(now)


pure_pursuit_car = PurePursuitCar()


def _pursued(memory: Memory, here: _Place, lookahead: float) -> tuple[int, _Place]:
    """Return the leg next to the robot, and the point of the path to pursue."""
    points = [_Place(memory[k], memory[k + 1]) for k in range(_POINTS, len(memory) - 1, 2)]
    # The next leg is taken once it is as near as the one before.
    leg = int(memory[_LEG])
    place = _nearest(points, leg, here)
    while leg + 2 < len(points):
        after = _nearest(points, leg + 1, here)
        if math.dist(here, after) > math.dist(here, place):
            break
        leg, place = leg + 1, after
    # Walk along the path until it leaves the circle around the robot.
    for k in range(leg, len(points) - 1):
        end = points[k + 1]
        if math.dist(here, end) >= lookahead:
            return leg, _on_circle(place, end, here, lookahead)
        place = end
    return leg, points[-1]


def _nearest(points: list[_Place], leg: int, here: _Place) -> _Place:
    """Return the point of a leg of the path that is nearest to the robot."""
    (ax, ay), (bx, by) = points[leg], points[leg + 1]
    ex, ey = bx - ax, by - ay
    length_sq = ex * ex + ey * ey
    share = ((here.x - ax) * ex + (here.y - ay) * ey) / length_sq if length_sq else 0.0
    share = max(0.0, min(1.0, share))
    return _Place(ax + share * ex, ay + share * ey)


def _on_circle(begin: _Place, end: _Place, here: _Place, radius: float) -> _Place:
    """Return where a leg leaves a circle around the robot; its begin if that is outside."""
    ex, ey = end.x - begin.x, end.y - begin.y
    ux, uy = begin.x - here.x, begin.y - here.y
    a = ex * ex + ey * ey
    b = ux * ex + uy * ey
    c = ux * ux + uy * uy - radius * radius
    if c >= 0.0 or not a:
        return begin
    share = (-b + math.sqrt(b * b - a * c)) / a
    return _Place(begin.x + share * ex, begin.y + share * ey)
