"""The controllers for several robots as plain Python classes, bit for bit as in the core."""

from __future__ import annotations

import math

from sim.controllers import Command
from sim.options.robot import RobotOptions
from tests.reference.sim import fdlibm
from tests.reference.sim.controllers._directions import angle_of, wrap

_SENSING = RobotOptions(neighbour_range=2.0)
MARGIN = 1.3
ROOM = 1.05
HORIZON = 2.0
CLOSE = 1e-9
STANDING = 1e-3
HALVINGS = 40


def _steer(seen, turn, speed):
    return Command(speed, turn / seen.time_step)


class Naive:
    def reset(self):
        return ()

    def act(self, seen, memory):
        return _steer(seen, wrap(seen.target_heading - seen.heading), seen.top_speed), memory


class RightHand:
    needs = _SENSING

    def reset(self):
        return ()

    def act(self, seen, memory):
        target = wrap(seen.target_heading - seen.heading)
        turn = target
        speed = seen.top_speed
        for other in seen.neighbours:
            distance = math.sqrt(other.x * other.x + other.y * other.y)
            bearing = angle_of(other.x, other.y)
            sine = min(1.0, MARGIN * (seen.radius + other.radius) / distance)
            half = fdlibm.atan(sine / math.sqrt(1.0 - sine * sine)) if sine < 1.0 else math.pi / 2.0
            if not -half <= wrap(bearing - turn) <= half:
                continue
            away = wrap(other.heading - bearing)
            if other.speed == 0.0 or abs(away) > 0.75 * math.pi:
                turn = wrap(bearing - half)
            elif bearing < 0.0 < away:
                speed = 0.0
        if abs(wrap(turn - target)) > math.pi / 2.0:
            turn = wrap(target - math.pi / 2.0)
        return _steer(seen, turn, speed), memory


def _plane(own, relative, place, radii, time_step):
    """Return the normal, and the least product with it of an allowed velocity."""
    far = math.sqrt(place[0] * place[0] + place[1] * place[1])
    horizon = HORIZON if far > radii else time_step
    inverse = 1.0 / horizon
    cap = (relative[0] - place[0] * inverse, relative[1] - place[1] * inverse)
    depth = math.sqrt(cap[0] * cap[0] + cap[1] * cap[1])
    normal = (-1.0, 0.0)
    if depth > 0.0:
        by = 1.0 / depth
        normal = (cap[0] * by, cap[1] * by)
    out = radii / horizon - depth
    if far > radii:
        leg = math.sqrt(far * far - radii * radii)
        by = 1.0 / far
        ahead = (place[0] * by, place[1] * by)
        is_left = ahead[0] * relative[1] - ahead[1] * relative[0] >= 0.0
        cosine = leg / far
        sine = radii / far if is_left else -radii / far
        side = (ahead[0] * cosine - ahead[1] * sine, ahead[0] * sine + ahead[1] * cosine)
        if relative[0] * side[0] + relative[1] * side[1] >= leg / horizon:
            normal = (-side[1], side[0]) if is_left else (side[1], -side[0])
            out = -(relative[0] * normal[0] + relative[1] * normal[1])
    return normal, (normal[0] * own[0] + normal[1] * own[1]) + 0.5 * out


class Orca:
    needs = _SENSING

    def reset(self):
        return (0.0,)

    def act(self, seen, memory):
        own = (memory[0], 0.0)
        planes = []
        for other in seen.neighbours:
            theirs = (
                other.speed * fdlibm.cos(other.heading),
                other.speed * fdlibm.sin(other.heading),
            )
            relative = (own[0] - theirs[0], own[1] - theirs[1])
            radii = ROOM * (seen.radius + other.radius)
            planes.append(_plane(own, relative, (other.x, other.y), radii, seen.time_step))
        bearing = wrap(seen.target_heading - seen.heading)
        top = seen.top_speed
        wanted = (top * fdlibm.cos(bearing), top * fdlibm.sin(bearing))
        x, y = _safest(planes, top, wanted)
        speed = math.sqrt(x * x + y * y)
        speed = speed if speed > STANDING * top else 0.0
        return _steer(seen, angle_of(x, y) if speed > 0.0 else 0.0, speed), (speed,)


def _safest(planes, top, wanted):
    found = _nearest(planes, top, wanted, 0.0)
    if found is not None:
        return found
    enough = max([0.0, *(least for _, least in planes)])
    little = 0.0
    best = (0.0, 0.0)
    for _ in range(HALVINGS):
        slack = 0.5 * (little + enough)
        found = _nearest(planes, top, wanted, slack)
        if found is None:
            little = slack
        else:
            enough = slack
            best = found
    return best


def _nearest(planes, top, wanted, slack):
    """Return the allowed velocity nearest to the wanted one; ``None`` if there is none."""
    best_sq = math.inf
    best = None
    for x, y in _candidates(planes, top, wanted, slack):
        dx = x - wanted[0]
        dy = y - wanted[1]
        off_sq = dx * dx + dy * dy
        if off_sq < best_sq and _is_allowed(planes, top, slack, x, y):
            best_sq = off_sq
            best = (x, y)
            if best_sq == 0.0:
                break
    return best


def _is_allowed(planes, top, slack, x, y):
    most = top + CLOSE
    return x * x + y * y <= most * most and all(
        not normal[0] * x + normal[1] * y < least - slack - CLOSE for normal, least in planes
    )


def _candidates(planes, top, wanted, slack):
    yield wanted
    for which, (normal, own) in enumerate(planes):
        least = own - slack
        by = least - (normal[0] * wanted[0] + normal[1] * wanted[1])
        yield wanted[0] + normal[0] * by, wanted[1] + normal[1] * by
        across_sq = top * top - least * least
        if across_sq >= 0.0:
            across = math.sqrt(across_sq)
            for by in (across, -across):
                yield normal[0] * least + -normal[1] * by, normal[1] * least + normal[0] * by
        for other, theirs in planes[:which]:
            determinant = normal[0] * other[1] - normal[1] * other[0]
            if determinant != 0.0:
                others = theirs - slack
                yield (
                    (least * other[1] - others * normal[1]) / determinant,
                    (normal[0] * others - other[0] * least) / determinant,
                )
