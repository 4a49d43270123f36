"""Draw a run on the map.

It consists of the path, the endless cycle, the robot's size, and the walls that it hit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from worldgen.render.body_parts import BodyPose, body_shapes, front_mark, spread_poses
from worldgen.render.frame import Frame
from worldgen.render.overlay import Trail, WallPenetration
from worldgen.render.palette import (
    APPROACH,
    FLOOR,
    INK,
    LOOP,
    LOOP_HEAD,
    PAPER,
    PIERCED,
    SWEPT,
    TUNNEL,
    mix,
)
from worldgen.render.polyline import along, arc_length, arrow_places, corners, simplified
from worldgen.render.primitives import DrawnCells, DrawnCircle, DrawnLine, Paint, Primitive
from worldgen.support.arrays import Floats
from worldgen.world import Robot

# Deviations of a drawn trail from the true one, px; the first that gives a short enough line is
# used.
THIN = (0.15, 0.5, 1.5)
# Limit on the points of a drawn trail; more make an SVG of megabytes.
MOST_POINTS = 20_000
MOST_FOOTPRINTS = 6
# Outlines that together are the floor which a body covers.
MOST_SWEPT = 90
# More bumps than this would hide the map, and overlapping ones merge anyway.
MOST_DOTS = 400


def swept_parts(trail: Trail, frame: Frame, robot: Robot) -> list[Primitive]:
    """Return the floor that the robot's body covers in its cycle.

    It shows which gaps the body does not fit through.

    Args:
        trail: The run.
        frame: The map's place in the picture.
        robot: The robot.
    """
    robot_radius = robot.radius
    if trail.loop_from is None or stays_put(trail, frame, robot_radius):
        return []
    if not robot.is_disc and trail.headings is not None:
        rows = np.unique(np.linspace(trail.loop_from, len(trail.x) - 1, MOST_SWEPT).astype(int))
        paint = Paint(fill=SWEPT, opacity=0.3)
        return [
            part for row in rows for part in body_shapes(robot, _pose(trail, row), frame, (paint,))
        ]
    width = 2.0 * robot_radius * frame.scale
    return [
        DrawnLine(_thinned(frame.points(trail.loop)), Paint(stroke=SWEPT, width=width, opacity=0.6))
    ]


def _pose(trail: Trail, row: int) -> BodyPose:
    assert trail.headings is not None
    return BodyPose(float(trail.x[row]), float(trail.y[row]), float(trail.headings[row]))


def body_parts(trail: Trail, frame: Frame, robot: Robot) -> list[Primitive]:
    """Return a few outlines of a body along its trail, and the body at the end, lowest first.

    Args:
        trail: The run, with headings.
        frame: The map's place in the picture.
        robot: The robot, which has a footprint.
    """
    assert trail.headings is not None
    unit = frame.unit
    begin = trail.loop_from or 0
    parts: list[Primitive] = []
    thin = (Paint(fill=LOOP, opacity=0.08), Paint(stroke=LOOP, width=1.2 * unit, opacity=0.6))
    for pose in spread_poses(
        trail.x[begin:], trail.y[begin:], trail.headings[begin:], robot.radius, MOST_FOOTPRINTS
    ):
        parts += body_shapes(robot, pose, frame, thin)
    end = _pose(trail, len(trail.x) - 1)
    strong = (
        Paint(stroke=PAPER, width=4.4 * unit, opacity=0.8),
        Paint(fill=LOOP, opacity=0.3),
        Paint(stroke=LOOP, width=2.0 * unit),
    )
    return [*parts, *body_shapes(robot, end, frame, strong), *front_mark(robot, end, frame, LOOP)]


def _overlap_outlines(trail: Trail, frame: Frame, robot: Robot) -> list[Primitive]:
    """Return the outlines of a body at the first places where it cut a wall, if it is known how."""
    unit = frame.unit
    paints = (
        Paint(stroke=PAPER, width=4.6 * unit, opacity=0.8),
        Paint(stroke=TUNNEL, width=2.6 * unit),
    )
    poses = [
        BodyPose(mark.x, mark.y, mark.heading)
        for mark in trail.marks
        if mark.kind == "overlap" and mark.heading is not None
    ]
    first = poses[:MOST_FOOTPRINTS]
    return [part for pose in first for part in body_shapes(robot, pose, frame, paints)]


def trail_parts(trail: Trail, frame: Frame, robot: Robot) -> list[Primitive]:
    """Return the lines, footprints and marks of a trail, lowest first.

    Args:
        trail: The run.
        frame: The map's place in the picture.
        robot: The robot.
    """
    robot_radius = robot.radius
    # Bodies are drawn by their outlines; their discs would be far too large.
    is_body = not robot.is_disc and trail.headings is not None
    if is_body:
        robot_radius = robot.inner_radius
    outlines = body_parts(trail, frame, robot) if is_body else []
    radius = robot_radius * frame.scale
    unit = frame.unit
    approach = _thinned(frame.points(trail.approach))
    parts: list[Primitive] = []
    # Without a loop, there is only the path and its end.
    if trail.loop_from is None:
        parts += _way(approach, 2.2 * unit, unit)
        if not len(trail.places("end")) and not is_body:
            x, y = frame.points(trail.points[-1:])[0].tolist()
            parts += robot_at(x, y, radius, unit)
    else:
        if len(approach) > 1:
            parts.append(DrawnLine(approach, Paint(stroke=APPROACH, width=1.8 * unit)))
        loop = _thinned(frame.points(trail.loop))
        still = stays_put(trail, frame, robot_radius)
        if still:
            parts += [] if is_body else _spot(loop[0], radius, unit)
        else:
            parts += _way(loop, 3.2 * unit, unit) if is_body else _cycle(loop, radius, unit)
    if is_body:
        outlines += _overlap_outlines(trail, frame, robot)
    return outlines + parts + _marks(trail, frame, radius, is_body=is_body)


def _thinned(points: Floats) -> Floats:
    for tolerance in THIN:
        points = simplified(points, tolerance)
        if len(points) <= MOST_POINTS:
            break
    return points


def _way(points: Floats, width: float, unit: float) -> list[Primitive]:
    if len(points) < 2:
        return []
    casing = DrawnLine(points, Paint(stroke=PAPER, width=width + 2.0 * unit, opacity=0.7))
    line = DrawnLine(points, Paint(stroke=LOOP, width=width))
    size = 2.2 * width + 4.0 * unit
    total = float(arc_length(points)[-1])
    # A path shorter than its arrow heads would be covered by them.
    if total < 3.0 * size:
        return [casing, line]
    spacing = max(90.0 * unit, total / 14.0)
    heads = [
        arrow_head(x, y, angle, size, LOOP_HEAD)
        for x, y, angle in arrow_places(points, spacing, size)
    ]
    return [casing, line, *heads]


def _cycle(loop: Floats, radius: float, unit: float) -> list[Primitive]:
    parts: list[Primitive] = []
    for x, y in _footprint_places(loop, radius):
        parts.append(DrawnCircle(x, y, radius, Paint(fill=LOOP, opacity=0.10)))
        parts.append(DrawnCircle(x, y, radius, Paint(stroke=LOOP, width=1.2 * unit, opacity=0.6)))
    return parts + _way(loop, 3.2 * unit, unit)


def stays_put(trail: Trail, frame: Frame, robot_radius: float) -> bool:
    """Return True if the cycle is too small to see as a line. ``robot_radius`` in m."""
    if trail.loop_from is None:
        return False
    spread = float(np.max(np.ptp(trail.loop, axis=0))) * frame.scale
    return spread < max(3.0 * frame.unit, 0.1 * robot_radius * frame.scale)


def _spot(centre: Floats, radius: float, unit: float) -> list[Primitive]:
    """Return a cycle on one spot as the robot's disc, without an arrow: it may be turning."""
    x = float(centre[0])
    y = float(centre[1])
    shown = max(radius, 7.0 * unit)
    return [
        DrawnCircle(x, y, shown, Paint(fill=LOOP, opacity=0.3)),
        DrawnCircle(x, y, shown, Paint(stroke=PAPER, width=5.6 * unit, opacity=0.7)),
        DrawnCircle(x, y, shown, Paint(stroke=LOOP, width=3.6 * unit)),
        DrawnCircle(x, y, 3.0 * unit, Paint(fill=LOOP)),
    ]


def _footprint_places(loop: Floats, radius: float) -> Floats:
    """Return where the robot's disc is drawn: the cycle's corners, and where it hit something."""
    found: list[Floats] = []
    # Show the robot at corners of the loop, if there are few that don't overlap.
    for point in corners(simplified(loop, max(1.0, 0.2 * radius))):
        if all(np.hypot(*(point - other)) > 2.2 * radius for other in found):
            found.append(point)
        if len(found) > MOST_FOOTPRINTS:
            break
    if 2 <= len(found) <= MOST_FOOTPRINTS:
        # Otherwise spread the discs evenly.
        return np.array(found)
    total = float(arc_length(loop)[-1])
    count = min(MOST_FOOTPRINTS, max(1, int(total / (5.0 * radius))))
    return along(loop, np.arange(count) * total / count)


def robot_at(x: float, y: float, radius: float, unit: float) -> list[Primitive]:
    """Return the robot's disc at the end of a run, with its centre."""
    shown = max(radius, 4.0 * unit)
    return [
        DrawnCircle(x, y, shown, Paint(fill=LOOP, opacity=0.3)),
        DrawnCircle(x, y, shown, Paint(stroke=LOOP, width=2.0 * unit)),
        DrawnCircle(x, y, 2.2 * unit, Paint(fill=LOOP)),
    ]


def pierced_parts(
    cells: Sequence[WallPenetration], shape: tuple[int, int], frame: Frame
) -> list[Primitive]:
    """Return the walls that the robot entered.

    Red stripes on a light ground, and a frame, do not rely on colour alone.

    Args:
        cells: The wall cells.
        shape: Rows and columns of the grid.
        frame: The map's place in the picture.
    """
    mask = np.zeros(shape, np.bool_)
    unit = frame.unit
    inside = [cell for cell in cells if 0 <= cell.iy < shape[0] and 0 <= cell.ix < shape[1]]
    mask[[cell.iy for cell in inside], [cell.ix for cell in inside]] = True
    parts: list[Primitive] = []
    if inside:
        # PIERCED_GROUND on a wall.
        parts += [DrawnCells(mask, FLOOR, opacity=0.6), DrawnCells(mask, PIERCED, opacity=0.25)]
        parts.append(DrawnCells(mask, PIERCED, hatch=max(4.0 * unit, 0.2 * frame.cell)))
    for cell in cells:
        square = np.array(((0, 0), (1, 0), (1, 1), (0, 1))) + np.array((cell.ix, cell.iy))
        width = (2.0 if cell.place is None else 3.0) * unit
        parts.append(
            DrawnLine(frame.corners(square), Paint(stroke=PIERCED, width=width), closed=True)
        )
    return parts


def breach_crosses(cells: Sequence[WallPenetration], frame: Frame) -> list[Primitive]:
    """Return a red cross wherever the robot entered a wall named by the verdict, above all else."""
    parts: list[Primitive] = []
    unit = frame.unit
    for cell in cells:
        if cell.place is not None:
            x, y = frame.to_pixels(*cell.place)
            parts += cross_with_casing(x, y, unit, PIERCED)
    return parts


def _marks(trail: Trail, frame: Frame, radius: float, *, is_body: bool) -> list[Primitive]:
    unit = frame.unit
    parts: list[Primitive] = []
    # A body is drawn at its end with its outline.
    for place in () if is_body else trail.places("end"):
        x, y = frame.points(place[None])[0].tolist()
        parts += robot_at(x, y, radius, unit)
    for x, y in _distinct(frame.points(trail.places("bump")), 4.0 * unit):
        parts.append(DrawnCircle(x, y, 3.4 * unit, Paint(fill=PAPER)))
        parts.append(DrawnCircle(x, y, 2.4 * unit, Paint(fill=INK)))
    for index, (x, y) in enumerate(_distinct(frame.points(trail.places("overlap")), 4.0 * unit)):
        # Only the first places are drawn in true size, so that many of them don't cover the map.
        is_large = index < MOST_FOOTPRINTS and not is_body
        reach = max(radius, 7.0 * unit) if is_large else 3.0 * unit
        parts.append(DrawnCircle(x, y, reach, Paint(stroke=PAPER, width=4.6 * unit, opacity=0.8)))
        parts.append(
            DrawnCircle(
                x, y, reach, Paint(stroke=PIERCED if trail.pierced else TUNNEL, width=2.6 * unit)
            )
        )
    # After a pierced wall, crossings are not tunnels.
    tunnels = np.zeros((0, 2)) if trail.pierced else trail.places("tunnel")
    for x, y in _distinct(frame.points(tunnels), 4.0 * unit):
        parts += cross_with_casing(x, y, unit, TUNNEL)
    return parts


def _distinct(points: Floats, grain: float) -> Floats:
    if not len(points):
        return points
    _, first = np.unique(np.round(points / grain), axis=0, return_index=True)
    chosen = np.sort(first)
    return points[chosen[:: max(1, -(-len(chosen) // MOST_DOTS))]]


def cross(x: float, y: float, reach: float, colour: str, width: float) -> list[Primitive]:
    """Return an x-shaped mark."""
    paint = Paint(stroke=colour, width=width)
    arms = (((-1.0, -1.0), (1.0, 1.0)), ((-1.0, 1.0), (1.0, -1.0)))
    return [DrawnLine(np.array((x, y)) + reach * np.array(arm), paint) for arm in arms]


def cross_with_casing(x: float, y: float, unit: float, colour: str) -> list[Primitive]:
    """Return an x-shaped mark that is visible on walls and floor."""
    return cross(x, y, 7.0 * unit, PAPER, 7.0 * unit) + cross(x, y, 7.0 * unit, colour, 4.0 * unit)


def ring_and_cross(
    x: float, y: float, radius: float, reach: float, strokes: Iterable[Paint]
) -> list[Primitive]:
    """Return the mark of a target: in each stroke, the lowest first, a ring and a cross over it."""
    parts: list[Primitive] = []
    for stroke in strokes:
        parts.append(DrawnCircle(x, y, radius, stroke))
        for dx, dy in ((reach, 0.0), (0.0, reach)):
            parts.append(DrawnLine(np.array(((x - dx, y - dy), (x + dx, y + dy))), stroke))
    return parts


def robot_disc(
    x: float, y: float, radius: float, unit: float, *, colour: str, tint: float, width: float
) -> list[Primitive]:
    """Return the mark of a start: the robot's disc in its colour, visible on walls and floor."""
    return [
        DrawnCircle(x, y, radius + 1.5 * unit, Paint(fill=PAPER)),
        DrawnCircle(x, y, radius, Paint(fill=mix(PAPER, colour, tint))),
        DrawnCircle(x, y, radius, Paint(stroke=colour, width=width * unit)),
    ]


def heading_tick(x: float, y: float, radius: float, heading: float, paint: Paint) -> DrawnLine:
    """Return a tick on the rim of a robot's disc, in the direction of its heading, rad."""
    ahead = np.array((math.cos(heading), -math.sin(heading)))
    return DrawnLine(np.array((x, y)) + np.outer((0.45 * radius, radius), ahead), paint)


def arrow(
    start: tuple[float, float], end: tuple[float, float], unit: float, colour: str, head: str
) -> list[Primitive]:
    """Return an arrow between two points of the picture, px, with a head of its own colour."""
    line = np.array((start, end))
    angle = math.atan2(end[1] - start[1], end[0] - start[0])
    return [
        DrawnLine(line, Paint(stroke=PAPER, width=5.4 * unit, opacity=0.8)),
        DrawnLine(line, Paint(stroke=colour, width=3.0 * unit)),
        arrow_head(*end, angle, 13.0 * unit, head),
    ]


def arrow_head(x: float, y: float, angle: float, size: float, colour: str) -> DrawnLine:
    """Return a barbed head centred on the point, pointing along ``angle`` (rad, in pixel axes)."""
    shape = size * np.array(((0.6, 0.0), (-0.5, 0.45), (-0.25, 0.0), (-0.5, -0.45)))
    turn = np.array(((math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))))
    return DrawnLine(np.array((x, y)) + shape @ turn, Paint(fill=colour), closed=True)
