"""Draw a robot's body, a disc or a polygon with a mark of its front, and where it is tightest."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, Mark, hue
from worldgen.render.polyline import along, arc_length
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import Robot, Target, Witness, World

# Outlines along a witness; more would hide the map.
MOST_OUTLINES = 7
# Poses of a witness at which the room around the body is measured.
_MOST_POSES = 600
# Cells; with less to spare, a body touches a wall.
_TOUCH = 1 / 1024
# Cells. Walls are touched together if their distances differ by less, and not beyond a distance.
_SAME = 0.03
_NEAR = 0.5
# Cells by which the room at places that are about as tight may differ.
_AS_TIGHT = 0.1
# A body that is clear at more degrees than these, or in more ranges, isn't held by its heading.
_MOSTLY_FREE = 240
_FEW_RANGES = 2
# rad; a body is measured at least this often in a turn.
_TURN = math.pi / 90


class BodyPose(NamedTuple):
    """Where a body is: x and y, m, and its heading, rad."""

    x: float
    y: float
    heading: float


def outline(robot: Robot, pose: BodyPose) -> Floats:
    """Return the corners (k, 2) of a polygon at a pose, m."""
    return robot_points(np.array(robot.footprint, np.float64), pose)


def body_shapes(
    robot: Robot, pose: BodyPose, frame: Frame, paints: Sequence[Paint]
) -> list[Primitive]:
    """Return the robot's polygon in each paint, lowest first."""
    points = frame.points(outline(robot, pose))
    return [DrawnLine(points, paint, closed=True) for paint in paints]


def front_mark(robot: Robot, pose: BodyPose, frame: Frame, colour: str) -> list[Primitive]:
    """Return a wedge in a polygon that points ahead, and a dot at its axle.

    A car has wheels at its axle, because it cannot turn on the spot.
    """
    corners = np.array(robot.footprint, np.float64)
    front = corners[:, 0].max()
    across = np.ptp(corners[:, 1])
    size = 0.38 * min(across, np.ptp(corners[:, 0]))
    # The wedge is inside, in the middle of what is farthest ahead.
    middle = corners[corners[:, 0] > front - 1e-9, 1].mean()
    wedge = np.array(
        ((front - 0.25 * size, middle), (front - 1.25 * size, middle + 0.6 * size),
         (front - 1.25 * size, middle - 0.6 * size))
    )  # fmt: skip
    marked = robot_points(wedge, pose)
    parts: list[Primitive] = [DrawnLine(frame.points(marked), Paint(fill=colour), closed=True)]
    unit = frame.unit
    if robot.drive.is_car:
        left, right = corners[:, 1].max(), corners[:, 1].min()
        for side in (0.8 * left, 0.8 * right):
            wheel = np.array(((-0.35 * size, side), (0.35 * size, side)))
            paint = Paint(stroke=colour, width=max(0.25 * size * frame.scale, 1.5 * unit))
            parts.append(DrawnLine(frame.points(robot_points(wheel, pose)), paint))
    x, y = frame.to_pixels(pose.x, pose.y)
    return [
        *parts,
        DrawnCircle(x, y, max(1.6 * unit, 0.07 * size * frame.scale), Paint(fill=colour)),
    ]


def robot_points(points: Floats, pose: BodyPose) -> Floats:
    """Return points (n, 2) of the robot's frame in the world's, m."""
    cos = math.cos(pose.heading)
    sin = math.sin(pose.heading)
    turned: Floats = points @ np.array(((cos, sin), (-sin, cos))) + np.array((pose.x, pose.y))
    return turned


def solid_body(
    robot: Robot, pose: BodyPose, frame: Frame, *, colour: str, mark: Mark
) -> list[Primitive]:
    """Return a polygon in its colour, visible on walls and floor, with its front."""
    unit = frame.unit
    casing = Paint(
        fill=hue("floor"), stroke=hue("floor"), width=(mark.width + 3.0) * unit, opacity=0.8
    )
    paints = (casing, mark.inside(colour), mark.line(unit, colour))
    return [*body_shapes(robot, pose, frame, paints), *front_mark(robot, pose, frame, colour)]


def spread_poses(x: Floats, y: Floats, headings: Floats, reach: float, most: int) -> list[BodyPose]:
    """Return poses along a path at equal distances, a few of those that a body passes.

    Args:
        x: (n,) m.
        y: (n,) m.
        headings: (n,) rad, at these points.
        reach: Length of the body, m; poses are not nearer to each other.
        most: Number of poses at most.
    """
    points = np.column_stack((x, y))
    lengths = arc_length(points)
    total = float(lengths[-1])
    count = max(1, min(most, int(total / max(1.3 * reach, 1e-9))))
    at = (np.arange(count) + 0.5) * total / count
    places = along(points, at)
    rows = np.clip(np.searchsorted(lengths, at, side="right") - 1, 0, len(headings) - 1)
    return [
        BodyPose(float(place[0]), float(place[1]), float(headings[row]))
        for place, row in zip(places, rows, strict=True)
    ]


def witness_parts(
    world: World, robot: Robot, proof: Witness, frame: Frame, colour: str
) -> list[Primitive]:
    """Return a path that fits; of a body, outlines along it and a stronger one where it is tightest."""
    if len(proof.x) < 2:
        return []
    unit = frame.unit
    points = frame.points(np.column_stack((proof.x, proof.y)))
    parts: list[Primitive] = [
        DrawnLine(points, paint) for paint in MARKS["witness"].lines(unit, colour)
    ]
    if robot.is_disc or proof.headings is None:
        return parts
    thin = MARKS["witness-body"].line(unit, colour)
    poses = spread_poses(proof.x, proof.y, proof.headings, robot.radius, MOST_OUTLINES)
    parts += [part for pose in poses for part in body_shapes(robot, pose, frame, (thin,))]
    ghost = None if world.is_fleet else tightest_pose(world, proof)
    if ghost is not None:
        mark = MARKS["tightest"]
        parts += body_shapes(robot, ghost, frame, (mark.inside(), mark.line(unit)))
    return parts


def spare_words(world: World, proof: Witness) -> str | None:
    """Return ``0.03 m to spare at heading 41 degrees``, of a witness's tightest place, or None."""
    ghost = tightest_pose(world, proof)
    if ghost is None:
        return None
    degrees = math.degrees(math.remainder(ghost.heading, 2.0 * math.pi))
    # Rounding keeps -0 and 360 away.
    heading = f"at heading {round(degrees) % 360} degrees"
    if proof.clearance < _TOUCH * world.cell_size:
        return f"touches a wall {heading}"
    return f"{proof.clearance:.2g} m to spare {heading}"


def fitting_headings(world: World, place: BodyPose) -> list[tuple[int, int]]:
    """Return the headings at which the body is clear at a place, to the degree.

    Returns:
        Ranges (first, last), degrees in [0, 360), the lowest first; the last of one that goes past
        360 is less than its first. One range (0, 359) if every heading fits.
    """
    robot = world.robots[0]
    own = round(math.degrees(place.heading)) % 360
    fits = [own == k or _is_clear(world, robot, place, k) for k in range(360)]
    if all(fits):
        return [(0, 359)]
    firsts = [k for k in range(360) if fits[k] and not fits[k - 1]]
    lasts = [k for k in range(360) if fits[k] and not fits[(k + 1) % 360]]
    if lasts[0] < firsts[0]:
        lasts = [*lasts[1:], lasts[0]]
    return list(zip(firsts, lasts, strict=True))


def _is_clear(world: World, robot: Robot, place: BodyPose, degrees: int) -> bool:
    corners = outline(robot, place._replace(heading=math.radians(degrees))) / world.cell_size
    return _gap(world.walls, corners) >= 0.0


def tight_words(world: World) -> str:
    """Return how the body fits where its witness is tightest; empty without such a witness.

    ``0.03 m to spare at heading 41 degrees; it fits there only at headings within 3 degrees of 41 or
    221``.
    """
    proof = world.certificate
    if not isinstance(proof, Witness) or (spare := spare_words(world, proof)) is None:
        return ""
    # A passage is tightest from where the body enters it, and shows best halfway how it fits.
    passage = tight_poses(world, proof)
    ranges = fitting_headings(world, passage[len(passage) // 2])
    # Where it fits in more ways, or nearly turns around, it isn't held by its heading.
    widths = [(last - first) % 360 + 1 for first, last in ranges]
    if len(ranges) > _FEW_RANGES or sum(widths) > _MOSTLY_FREE:
        return spare
    middles = sorted(
        (first + width // 2) % 360 for (first, _), width in zip(ranges, widths, strict=True)
    )
    named = " or ".join(map(str, middles))
    return f"{spare}; it fits there only at headings within {max(widths) // 2} degrees of {named}"


def tightest_pose(world: World, proof: Witness) -> BodyPose | None:
    """Return the pose of a witness at which the body is nearest to a wall; None for a disc.

    It is found among some hundred poses along the path: a picture needs no more.
    """
    return next(iter(tight_poses(world, proof)), None)


def tight_poses(world: World, proof: Witness) -> list[BodyPose]:
    """Return a witness's poses in its tightest passage: the tightest one, and those about as tight.

    Returns:
        The tightest one, then all of them in order along the path; nothing for a disc.
    """
    robot = world.robots[0]
    if robot.is_disc or proof.headings is None or not len(proof.x):
        return []
    poses = _fine_poses(proof, robot.radius)
    gaps = [_gap(world.walls, outline(robot, pose) / world.cell_size) for pose in poses]
    first = int(np.argmin(gaps))
    limit = gaps[first] + _AS_TIGHT
    passage = itertools.takewhile(
        lambda pair: pair[1] <= limit, zip(poses[first:], gaps[first:], strict=True)
    )
    return [poses[first], *(pose for pose, _ in passage)]


def room_at(world: World, pose: BodyPose) -> float:
    """Return the distance of the robot's body at a pose from the nearest wall, m."""
    return _gap(world.walls, outline(world.robots[0], pose) / world.cell_size) * world.cell_size


def _fine_poses(proof: Witness, reach: float) -> list[BodyPose]:
    assert proof.headings is not None
    turns = np.diff(proof.headings)
    turns -= 2.0 * math.pi * np.round(turns / (2.0 * math.pi))
    lengths = np.hypot(np.diff(proof.x), np.diff(proof.y))
    motion = lengths + reach * np.abs(turns)
    step = max(float(motion.sum()) / _MOST_POSES, 1e-9)
    poses = [BodyPose(float(proof.x[0]), float(proof.y[0]), float(proof.headings[0]))]
    for row, length in enumerate(motion):
        count = max(1, math.ceil(length / step), math.ceil(abs(turns[row]) / _TURN))
        for share in (np.arange(min(count, _MOST_POSES)) + 1) / min(count, _MOST_POSES):
            poses.append(
                BodyPose(
                    float(proof.x[row] + share * (proof.x[row + 1] - proof.x[row])),
                    float(proof.y[row] + share * (proof.y[row + 1] - proof.y[row])),
                    float(proof.headings[row] + share * turns[row]),
                )
            )
    return poses


def _gap(walls: Bools, corners: Floats) -> float:
    """Return how far apart a polygon and the nearest solid cell are, at most, in cells."""
    _, gaps = _gaps(walls, corners)
    return float(gaps.min()) if len(gaps) else 2.0


def _gaps(walls: Bools, corners: Floats) -> tuple[Ints, Floats]:
    """Return the solid cells (n, 2) near a polygon, and how far away each is, in cells.

    That is the largest gap along an axis of either: less than the distance next to a corner, but
    least where the room is.
    """
    cells = solid_near(walls, corners)
    along_side = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack((along_side[:, 1], -along_side[:, 0]))
    normals /= np.hypot(*normals.T)[:, None]
    offsets = (normals * corners).sum(axis=1)
    nearest = cells @ normals.T + np.minimum(normals, 0.0).sum(axis=1) - offsets
    gaps: Floats = np.maximum(
        nearest.max(axis=1),
        np.maximum(cells - corners.max(axis=0), corners.min(axis=0) - cells - 1.0).max(axis=1),
    )
    return cells, gaps


def solid_near(walls: Bools, corners: Floats) -> Ints:
    """Return the solid cells (n, 2), columns and rows, around some points; outside all is solid."""
    height, width = walls.shape
    low = np.floor(corners.min(axis=0)).astype(int) - 2
    high = np.ceil(corners.max(axis=0)).astype(int) + 2
    ys, xs = np.mgrid[low[1] : high[1], low[0] : high[0]]
    outside = (xs < 0) | (ys < 0) | (xs >= width) | (ys >= height)
    solid = outside | walls[np.clip(ys, 0, height - 1), np.clip(xs, 0, width - 1)]
    return np.stack((xs[solid], ys[solid]), axis=1)


def nearest_cells(
    walls: Bools, robot: Robot, pose: BodyPose, cell_size: float
) -> list[tuple[int, int]]:
    """Return the solid cells that a robot touches at a pose: the nearest, if they are near enough.

    Args:
        walls: (height, width) bool.
        robot: The robot.
        pose: Where it bumped.
        cell_size: m.
    """
    if robot.is_disc:
        place = np.array((pose.x, pose.y)) / cell_size
        radius = robot.radius / cell_size
        cells = solid_near(walls, np.array((place - radius, place + radius)))
        beyond = np.maximum(np.maximum(cells - place, place - cells - 1.0), 0.0)
        gaps = np.hypot(*beyond.T) - radius
    else:
        cells, gaps = _gaps(walls, outline(robot, pose) / cell_size)
    if not len(gaps):
        return []
    touching = gaps <= min(float(gaps.min()) + _SAME, _NEAR)
    return [(int(ix), int(iy)) for ix, iy in cells[touching]]


def goal_wedge(target: Target, frame: Frame, radius: float, colour: str) -> list[Primitive]:
    """Return a wedge at the rim of a target that points along its goal's heading, if it has one.

    Args:
        target: The target.
        frame: The map's place in the picture.
        radius: Radius of the target as drawn, px.
        colour: Its colour.
    """
    if target.heading is None:
        return []
    x, y = frame.to_pixels(target.x, target.y)
    heading = target.heading
    ahead = np.array((math.cos(heading), -math.sin(heading)))
    aside = np.array((-ahead[1], ahead[0]))
    unit = frame.unit
    base = radius + 3.0 * unit
    tip = base + MARKS["goal"].size * unit
    points = np.array((x, y)) + np.array((tip * ahead, base * ahead + 6.0 * unit * aside,
                                          base * ahead - 6.0 * unit * aside))  # fmt: skip
    paint = Paint(fill=colour, stroke=hue("floor"), width=1.2 * unit)
    return [DrawnLine(points, paint, closed=True)]
