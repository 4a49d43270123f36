"""Shortest paths of a car between two poses in the open: Dubins, and Reeds and Shepp."""

from __future__ import annotations

import math
from typing import NamedTuple

from worldgen._core import ffi, lib
from worldgen.world import Pose


class Curve(NamedTuple):
    """Arcs of the turning circle and straight lines, driven one after the other.

    Args:
        parts: Steering (1 left, 0 straight, -1 right) and amount of each part: the angle of an arc,
            rad, or the length of a line, m; negative backwards.
        length: m.
    """

    parts: tuple[tuple[int, float], ...]
    length: float


def curves(start: Pose, end: Pose, turning_radius: float, *, reverse: bool) -> list[Curve]:
    """Return the paths between two poses of which the shortest is optimal, shortest first.

    Args:
        start: The first pose.
        end: The last pose.
        turning_radius: Least radius of the axle's path, m.
        reverse: True if the car may also drive backwards (Reeds and Shepp), False for Dubins's car.

    Source: ``worldgen/core/car/curves.c`` names the papers.
    """
    cosine = math.cos(start.heading)
    sine = math.sin(start.heading)
    dx = (end.x - start.x) / turning_radius
    dy = (end.y - start.y) / turning_radius
    goal = (dx * cosine + dy * sine, dy * cosine - dx * sine, end.heading - start.heading)
    room = ffi.new("WgCurve[]", lib.WG_MOST_CURVES)
    count = (lib.wg_reeds_shepp if reverse else lib.wg_dubins)(*goal, room)
    return [_curve_of(room[index], turning_radius) for index in range(count)]


def _curve_of(found: object, turning_radius: float) -> Curve:
    parts = tuple(
        (found.steer[part], found.amount[part] * (1.0 if found.steer[part] else turning_radius))  # type: ignore[attr-defined]
        for part in range(found.count)  # type: ignore[attr-defined]
    )
    return Curve(parts, found.length * turning_radius)  # type: ignore[attr-defined]
