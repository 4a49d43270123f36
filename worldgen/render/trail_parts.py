"""Draw a run on the map: the path, the endless period, where it ends, and the walls it hit."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from worldgen.render.body_parts import (
    BodyPose,
    body_shapes,
    front_mark,
    nearest_cells,
    spread_poses,
)
from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, hue, mix
from worldgen.render.overlay import Trail, WallPenetration
from worldgen.render.polyline import along, arc_length, arrow_places, simplified
from worldgen.render.primitives import DrawnCells, DrawnCircle, DrawnLine, Paint, Primitive
from worldgen.support.arrays import Bools, Floats
from worldgen.world import Robot

# Deviations of a drawn trail from the true one, px; the first that gives a short enough line is
# used.
THIN = (0.15, 0.5, 1.5)
# Limit on the points of a drawn trail; more make an SVG of megabytes.
MOST_POINTS = 20_000
MOST_FOOTPRINTS = 6
# Limit on the marks of one kind; more would hide the map, and overlapping ones merge anyway.
MOST_DOTS = 400
# A tangled period is that many times as long as half the outline of its box, and is drawn thinner if it
# would fill more than a share of that: with this share of its width at least.
_TANGLE = 4.0
_FULL = 0.5
_THINNEST = 0.4
# Share of the floor's colour in a wall that the robot entered, so that its stripes stand out.
_LIGHTER = 0.6


def band_parts(trail: Trail, frame: Frame, robot: Robot, colour: str) -> list[Primitive]:
    """Return the light band below what the robot repeats, which sets it off from the path into it."""
    mark = MARKS["band"]
    if trail.repeats_from is None or stays_put(trail, frame, robot):
        return []
    points = _thinned(frame.points(trail.loop))
    width = mark.width * frame.unit * _share_of_width(trail, points, frame.unit)
    return [DrawnLine(points, Paint(stroke=colour, width=width, opacity=mark.fill))]


def robot_at(
    trail: Trail, row: int, frame: Frame, robot: Robot, colour: str, name: str
) -> list[Primitive]:
    """Return the robot at a point of its path, in true size, with its heading if that is known.

    Args:
        trail: Its path.
        row: Index of the point.
        frame: The map's place in the picture.
        robot: The robot.
        colour: Its colour.
        name: The mark: ``end`` or ``nearest``.
    """
    mark = MARKS[name]
    unit = frame.unit
    if not robot.is_disc and trail.headings is not None:
        pose = _pose(trail, row)
        paints = (mark.inside(colour), mark.line(unit, colour))
        return [*body_shapes(robot, pose, frame, paints), *front_mark(robot, pose, frame, colour)]
    places = trail.places("end")
    at = places[:1] if name == "end" and len(places) else trail.points[row][None]
    x, y = frame.points(at)[0].tolist()
    radius = max((robot.radius if robot.is_disc else robot.inner_radius) * frame.scale, mark.size)
    parts: list[Primitive] = [
        DrawnCircle(x, y, radius, mark.inside(colour)),
        DrawnCircle(x, y, radius, mark.line(unit, colour)),
        # An arrival depends on this point.
        DrawnCircle(x, y, 2.0 * unit, Paint(fill=colour)),
    ]
    if trail.headings is not None:
        tick = Paint(stroke=colour, width=MARKS["heading"].width * unit)
        parts.append(heading_tick(x, y, radius, float(trail.headings[row]), tick))
    return parts


def approach_parts(trail: Trail, frame: Frame, robot: Robot, colour: str) -> list[Primitive]:
    """Return the path into what the robot repeats, which fades in."""
    if trail.repeats_from is None:
        return []
    return _fading(_thinned(frame.points(trail.approach)), "approach", colour, frame.unit)


def run_parts(trail: Trail, frame: Frame, robot: Robot, colour: str) -> list[Primitive]:
    """Return the path of a run that repeats nothing, which fades in."""
    if trail.repeats_from is not None:
        return []
    points = _thinned(frame.points(trail.points))
    unit = frame.unit
    heads = _heads(
        points, "trail", colour, unit, max(90.0 * unit, float(arc_length(points)[-1]) / 6)
    )
    return [*_fading(points, "trail", colour, unit), *heads]


def loop_parts(trail: Trail, frame: Frame, robot: Robot, colour: str) -> list[Primitive]:
    """Return one period as a closed line with one arrow, or a spot if it is too small to see."""
    return [] if trail.loop_from is None else _repeated(trail, frame, robot, colour, "loop")


def stay_parts(trail: Trail, frame: Frame, robot: Robot, colour: str) -> list[Primitive]:
    """Return the path on which a run without a proved period reaches nothing new."""
    return [] if trail.stays_from is None else _repeated(trail, frame, robot, colour, "stay")


def _repeated(trail: Trail, frame: Frame, robot: Robot, colour: str, name: str) -> list[Primitive]:
    points = _thinned(frame.points(trail.loop))
    unit = frame.unit
    if stays_put(trail, frame, robot):
        return _spot(points[0], robot.inner_radius * frame.scale, colour, unit)
    length = float(arc_length(points)[-1])
    thin = _share_of_width(trail, points, unit) * unit
    lines: list[Primitive] = [DrawnLine(points, paint) for paint in MARKS[name].lines(thin, colour)]
    return [*lines, *_heads(points, name, colour, unit, max(length, 1.0))]


def _share_of_width(trail: Trail, points: Floats, unit: float) -> float:
    """Return the share of its width with which a period is drawn that would fill its own box."""
    if trail.loop_from is None:
        return 1.0
    width = MARKS["loop"].width * unit
    sides = np.ptp(points, axis=0)
    length = float(arc_length(points)[-1])
    if length <= _TANGLE * float(sides.sum()):
        return 1.0
    return min(1.0, max(_THINNEST, _FULL * float(np.prod(sides + width)) / (length * width)))


def body_parts(trail: Trail, frame: Frame, robot: Robot, colour: str) -> list[Primitive]:
    """Return a few outlines of a body along its period, or its whole path."""
    if robot.is_disc or trail.headings is None:
        return []
    begin = trail.repeats_from or 0
    mark = MARKS["body"]
    poses = spread_poses(
        trail.x[begin:], trail.y[begin:], trail.headings[begin:], robot.radius, MOST_FOOTPRINTS
    )
    paints = (mark.inside(colour), mark.line(frame.unit, colour))
    return [part for pose in poses for part in body_shapes(robot, pose, frame, paints)]


def touched_parts(
    trails: Sequence[Trail], walls: Bools, robots: Sequence[Robot], frame: Frame
) -> list[Primitive]:
    """Return a line along each side of a wall cell that a robot touches where the trails have bumps.

    Args:
        trails: A path of each robot.
        walls: (height, width) bool, the cells that are solid at some time.
        robots: The robots.
        frame: The map's place in the picture.
    """
    mark = MARKS["touched"]
    cell_size = frame.cell / frame.scale
    sides: dict[tuple[int, int, int, int], None] = {}
    for trail, robot in zip(trails, robots, strict=False):
        bumps = [one for one in trail.marks if one.kind == "bump"]
        for one in bumps[:: max(1, -(-len(bumps) // MOST_DOTS))]:
            pose = BodyPose(one.x, one.y, one.heading or 0.0)
            for cell in nearest_cells(walls, robot, pose, cell_size):
                sides.update(dict.fromkeys(_facing(cell, one.x / cell_size, one.y / cell_size)))
    width = min(mark.width * frame.unit, 0.4 * frame.cell)
    paint = Paint(stroke=hue(mark.colour), width=width)
    inset = 0.5 * width / frame.cell
    parts: list[Primitive] = []
    height, across = walls.shape
    for ix, iy, dx, dy in sides:
        # Between two walls there is nothing to touch.
        if not (0 <= ix + dx < across and 0 <= iy + dy < height) or walls[iy + dy, ix + dx]:
            continue
        # Just inside the wall, from one of its corners to the next, where a round end of the next begins.
        middle = np.array((ix + 0.5 + (0.5 - inset) * dx, iy + 0.5 + (0.5 - inset) * dy))
        along = (0.5 - 0.6 * inset) * np.array((abs(dy), abs(dx)))
        parts.append(DrawnLine(frame.corners((middle - along, middle + along)), paint))
    return parts


def _facing(cell: tuple[int, int], x: float, y: float) -> list[tuple[int, int, int, int]]:
    """Return the sides of a cell that face a place: its indices, and the side's direction."""
    ix, iy = cell
    across = -1 if x < ix else int(x > ix + 1)
    up = -1 if y < iy else int(y > iy + 1)
    return [(ix, iy, dx, dy) for dx, dy in ((across, 0), (0, up)) if dx or dy]


def overlap_parts(trail: Trail, frame: Frame, robot: Robot, colour: str) -> list[Primitive]:
    """Return the robot where it cut a wall, in true size at the first places, and crosses."""
    unit = frame.unit
    mark = MARKS["overlap"]
    paints = mark.lines(unit)
    is_body = not robot.is_disc and trail.headings is not None
    parts: list[Primitive] = []
    if is_body:
        poses = [
            BodyPose(one.x, one.y, one.heading)
            for one in trail.marks
            if one.kind == "overlap" and one.heading is not None
        ]
        for pose in poses[:MOST_FOOTPRINTS]:
            parts += body_shapes(robot, pose, frame, paints)
    for index, (x, y) in enumerate(_distinct(frame.points(trail.places("overlap")), 4.0 * unit)):
        # Only the first places are drawn in true size, so that many of them don't cover the map.
        is_large = index < MOST_FOOTPRINTS and not is_body
        reach = max(robot.radius * frame.scale, mark.size * unit) if is_large else 3.0 * unit
        parts += [DrawnCircle(x, y, reach, paint) for paint in paints]
    # After a pierced wall, crossings are not tunnels.
    tunnels = np.zeros((0, 2)) if trail.pierced else trail.places("tunnel")
    for x, y in _distinct(frame.points(tunnels), 4.0 * unit):
        parts += breach_cross(x, y, unit)
    return parts


def _pose(trail: Trail, row: int) -> BodyPose:
    assert trail.headings is not None
    return BodyPose(float(trail.x[row]), float(trail.y[row]), float(trail.headings[row]))


def _thinned(points: Floats) -> Floats:
    for tolerance in THIN:
        points = simplified(points, tolerance)
        if len(points) <= MOST_POINTS:
            break
    return points


def _fading(points: Floats, name: str, colour: str, unit: float) -> list[Primitive]:
    """Return a line in pieces of equal length, each stronger than the one before."""
    mark = MARKS[name]
    lengths = arc_length(points)
    total = float(lengths[-1])
    if total <= 0.0:
        return []
    parts: list[Primitive] = []
    if mark.casing:
        parts.append(DrawnLine(points, mark.lines(unit)[0]))
    bounds = total * np.arange(len(mark.fade) + 1) / len(mark.fade)
    ends = along(points, bounds)
    for k, share in enumerate(mark.fade):
        inner = points[(lengths > bounds[k]) & (lengths < bounds[k + 1])]
        piece = np.concatenate((ends[k : k + 1], inner, ends[k + 1 : k + 2]))
        # A mixed colour, because lines with an opacity add up where a path crosses itself.
        paint = Paint(stroke=mix(hue("floor"), colour, share), width=mark.width * unit)
        parts.append(DrawnLine(piece, paint))
    return parts


def _heads(points: Floats, name: str, colour: str, unit: float, spacing: float) -> list[Primitive]:
    size = 1.25 * MARKS[name].size * unit
    # A path shorter than its arrow head would be covered by it.
    if len(points) < 2 or float(arc_length(points)[-1]) < 2.0 * size:
        return []
    return [
        arrow_head(x, y, angle, size, colour, casing=1.2 * unit)
        for x, y, angle in arrow_places(points, spacing, 0.6 * size)
    ]


def stays_put(trail: Trail, frame: Frame, robot: Robot) -> bool:
    """Return True if what the robot repeats is too small to see as a line."""
    if trail.repeats_from is None:
        return False
    radius = robot.radius if robot.is_disc else robot.inner_radius
    spread = float(np.max(np.ptp(trail.loop, axis=0))) * frame.scale
    return spread < max(3.0 * frame.unit, 0.1 * radius * frame.scale)


def _spot(centre: Floats, radius: float, colour: str, unit: float) -> list[Primitive]:
    """Return a period on one spot as the robot's disc, without an arrow: it may be turning."""
    x = float(centre[0])
    y = float(centre[1])
    mark = MARKS["spot"]
    shown = max(radius, mark.size * unit)
    return [
        DrawnCircle(x, y, shown, mark.inside(colour)),
        *(DrawnCircle(x, y, shown, paint) for paint in mark.lines(unit, colour)),
        DrawnCircle(x, y, 3.0 * unit, Paint(fill=colour)),
    ]


def pierced_parts(
    cells: Sequence[WallPenetration], shape: tuple[int, int], frame: Frame
) -> list[Primitive]:
    """Return the walls that the robot entered, and without stripes the cell that caught it.

    Red stripes on a light ground, and a frame, do not rely on colour alone.

    Args:
        cells: The cells.
        shape: Rows and columns of the grid.
        frame: The map's place in the picture.
    """
    mask = np.zeros(shape, np.bool_)
    mark = MARKS["pierced"]
    unit = frame.unit
    inside = [cell for cell in cells if 0 <= cell.iy < shape[0] and 0 <= cell.ix < shape[1]]
    mask[[cell.iy for cell in inside], [cell.ix for cell in inside]] = True
    parts: list[Primitive] = []
    if inside:
        parts += [DrawnCells(mask, hue("floor"), opacity=_LIGHTER)]
        parts += [DrawnCells(mask, hue(mark.colour), opacity=mark.fill)]
        walls = mask.copy()
        walls[[cell.iy for cell in inside], [cell.ix for cell in inside]] = [
            cell.is_entered for cell in inside
        ]
        hatch = max(mark.size * unit, 0.2 * frame.cell)
        parts.append(DrawnCells(walls, hue(mark.colour), hatch=hatch))
    for cell in cells:
        square = np.array(((0, 0), (1, 0), (1, 1), (0, 1))) + np.array((cell.ix, cell.iy))
        width = (mark.width if cell.place is None else 1.5 * mark.width) * unit
        paint = Paint(stroke=hue(mark.colour), width=width)
        parts.append(DrawnLine(frame.corners(square), paint, closed=True))
    return parts


def pierced_ground() -> str:
    """Return the colour below the stripes of a wall that the robot entered."""
    light = mix(hue("wall"), hue("floor"), _LIGHTER)
    return mix(light, hue("pierced"), MARKS["pierced"].fill)


def breach_crosses(cells: Sequence[WallPenetration], frame: Frame) -> list[Primitive]:
    """Return a red cross wherever the robot entered a wall named by the verdict, above all else."""
    parts: list[Primitive] = []
    for cell in cells:
        if cell.place is not None:
            x, y = frame.to_pixels(*cell.place)
            parts += breach_cross(x, y, frame.unit)
    return parts


def _distinct(points: Floats, grain: float) -> Floats:
    if not len(points):
        return points
    _, first = np.unique(np.round(points / grain), axis=0, return_index=True)
    chosen = np.sort(first)
    return points[chosen[:: max(1, -(-len(chosen) // MOST_DOTS))]]


def breach_cross(x: float, y: float, unit: float) -> list[Primitive]:
    """Return an x-shaped mark that is visible on walls and floor."""
    mark = MARKS["breach"]
    arms = (((-1.0, -1.0), (1.0, 1.0)), ((-1.0, 1.0), (1.0, -1.0)))
    reach = mark.size * unit
    return [
        DrawnLine(np.array((x, y)) + reach * np.array(arm), paint)
        for paint in mark.lines(unit)
        for arm in arms
    ]


def heading_tick(x: float, y: float, radius: float, heading: float, paint: Paint) -> DrawnLine:
    """Return a tick on the rim of a robot's disc, in the direction of its heading, rad."""
    ahead = np.array((math.cos(heading), -math.sin(heading)))
    return DrawnLine(np.array((x, y)) + np.outer((0.45 * radius, radius), ahead), paint)


def arrow(
    start: tuple[float, float], end: tuple[float, float], unit: float, name: str
) -> list[Primitive]:
    """Return an arrow between two points of the picture, px: the mark ``pushed`` or ``blocked``."""
    mark = MARKS[name]
    line = np.array((start, end))
    angle = math.atan2(end[1] - start[1], end[0] - start[0])
    head = arrow_head(*end, angle, mark.size * unit, hue(mark.colour), casing=unit)
    return [*(DrawnLine(line, paint) for paint in mark.lines(unit)), head]


def arrow_head(
    x: float, y: float, angle: float, size: float, colour: str, casing: float = 0.0
) -> DrawnLine:
    """Return a barbed head centred on the point, pointing along ``angle`` (rad, in pixel axes)."""
    shape = size * np.array(((0.6, 0.0), (-0.5, 0.45), (-0.25, 0.0), (-0.5, -0.45)))
    turn = np.array(((math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))))
    paint = Paint(fill=colour, stroke=hue("floor") if casing else None, width=casing or 1.0)
    return DrawnLine(np.array((x, y)) + shape @ turn, paint, closed=True)
