"""What our own plans in SVG and GeoJSON say about their worlds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot
from worldgen.interop.geometry.drawing import Drawing
from worldgen.interop.geometry.drawing_options import DrawingOptions


class OwnPlan(NamedTuple):
    """Size in cells, cell size and origin, m, and the robot of a plan that ``export`` wrote."""

    size: tuple[float, ...]
    cell_size: float
    origin: tuple[float, ...]
    robot: ForeignRobot


def own_plan(facts: object) -> OwnPlan | None:
    """Return what our own writer says about its plan; None if it is not possible."""
    if not isinstance(facts, Mapping):
        return None
    size, origin = (_numbers(facts, name, 2) for name in ("size", "origin"))
    cell = _above_0(facts, "cell_size")
    if not size or not origin or cell is None or min(size) < 1:
        return None
    start, target = (_numbers(facts, name, 2) for name in ("start", "target"))
    reach = _above_0(facts, "target_radius")
    robot = ForeignRobot(
        (*start, *(_numbers(facts, "heading", 1) or (0.0,))) if start else None,
        (*target, *(() if reach is None else (reach,))) if target else None,
        _above_0(facts, "robot_radius"),
        _above_0(facts, "robot_speed"),
    )
    return OwnPlan(size, cell, origin, robot)


def own_map(drawing: Drawing, options: DrawingOptions, plan: OwnPlan) -> ForeignMap:
    """Return the cells of our own plan, as it may have been edited since."""
    (width, height), (x, y) = plan.size, plan.origin
    drawing.unit, drawing.unit_from = 1.0, "worldgen"
    drawing.cell_size = plan.cell_size
    drawing.page = (x, y, x + width * plan.cell_size, y + height * plan.cell_size)
    drawing.robot = plan.robot
    found = drawing.map(options)
    return replace(found, is_picture=False, origin=(x, y))


def _numbers(facts: Mapping[str, Any], name: str, count: int) -> tuple[float, ...]:
    value = facts.get(name)
    items = value if isinstance(value, list) else [value]
    plain = [
        float(item)
        for item in items
        if isinstance(item, int | float) and not isinstance(item, bool) and abs(item) < 1e12
    ]
    usable = len(plain) == len(items) == count and all(map(math.isfinite, plain))
    return tuple(plain) if usable else ()


def _above_0(facts: Mapping[str, Any], name: str) -> float | None:
    found = _numbers(facts, name, 1)
    return found[0] if found and found[0] > 0 else None
