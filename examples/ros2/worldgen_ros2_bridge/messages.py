"""Convert worldgen's numbers to the form of ROS 2 messages: grids, scans, poses, time.

It knows neither rclpy nor worldgen. Both use metres, radians, x to the right, y up and headings
counter-clockwise from +x (REP 103); differences are noted here.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass

FREE = 0
OCCUPIED = 100
"""Values of nav_msgs/OccupancyGrid; -1, unknown, never comes from a world."""


@dataclass(frozen=True)
class Pose:
    """A place, m, and a heading, rad."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class Twist:
    """Velocity: m/s along the heading, rad/s counter-clockwise."""

    speed: float = 0.0
    turn_rate: float = 0.0


@dataclass(frozen=True)
class Grid:
    """A nav_msgs/OccupancyGrid.

    ``data`` is row by row from the lowest y; ``origin`` is the lower-left corner.
    """

    width: int
    height: int
    resolution: float
    origin: Pose
    data: list[int]


@dataclass(frozen=True)
class Scan:
    """A sensor_msgs/LaserScan, counter-clockwise from ``angle_min``.

    Beams without a return are infinite (REP 117).
    """

    angle_min: float
    angle_max: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: list[float]


def grid_of(text: str) -> Grid:
    """Return the map in a ``.grid`` file; an imported ROS map keeps its origin.

    Args:
        text: The file's contents (see ``docs/reference/grid-format.md``); the cells are those at
            time 0.

    Raises:
        ValueError: If it isn't a ``.grid`` file.
    """
    head, found, cells = text.partition("\n%cells\n")
    magic, _, header = head.partition("\n")
    if not found or magic.split() not in (["%worldgen-grid", "1"], ["%worldgen-grid", "2"]):
        raise ValueError("this is not a .grid file of version 1 or 2")
    table = tomllib.loads(header)
    if "cell_size" not in table:
        raise ValueError("its cell_size is missing")
    lines = cells.splitlines()
    end = next((k for k, line in enumerate(lines) if line.startswith("%")), len(lines))
    # The file has the top row first, an OccupancyGrid the bottom row.
    rows = lines[:end][::-1]
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise ValueError("its rows of cells differ in length")
    x, y = table.get("provenance", {}).get("params", {}).get("origin", (0.0, 0.0))
    data = [OCCUPIED if cell == "#" else FREE for row in rows for cell in row]
    return Grid(
        len(rows[0]), len(rows), float(table["cell_size"]), Pose(float(x), float(y), 0.0), data
    )


def scan_of(beams: list[float], beam_range: float, field: float = 0.0) -> Scan:
    """Return range beams as a scan in the frame of the robot's base.

    Args:
        beams: Distances, m, counter-clockwise, as in the observation.
        beam_range: Longest distance that a beam measures, m: the run's ``+beam_range``; a beam that
            hits nothing returns it.
        field: Angle from the first to the last beam, rad, centred on the heading: the run's
            ``+beam_field``; with 0 the beams are spread evenly over a full turn, the first ahead,
            and none twice.
    """
    between_beams = field / max(len(beams) - 1, 1) if field else 2.0 * math.pi / max(len(beams), 1)
    first = -0.5 * field
    ranges = [distance if distance < beam_range else math.inf for distance in beams]
    return Scan(
        first,
        first + between_beams * max(len(beams) - 1, 0),
        between_beams,
        0.0,
        beam_range,
        ranges,
    )


def quaternion(heading: float) -> tuple[float, float, float, float]:
    """Return the quaternion x, y, z, w of a rotation about z."""
    return 0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading)


def stamp(seconds: float) -> tuple[int, int]:
    """Return a time as seconds and nanoseconds of builtin_interfaces/Time, rounded to nearest."""
    total = round(seconds * 1e9)
    return total // 10**9, total % 10**9


def composed(first: Pose, then: Pose) -> Pose:
    """Convert the pose ``then`` from the frame of ``first`` to the frame that ``first`` is in."""
    cos = math.cos(first.heading)
    sin = math.sin(first.heading)
    x = first.x + cos * then.x - sin * then.y
    y = first.y + sin * then.x + cos * then.y
    return Pose(x, y, math.remainder(first.heading + then.heading, 2.0 * math.pi))


def inverse(pose: Pose) -> Pose:
    """Return the other frame's origin, as seen from ``pose``."""
    cos = math.cos(pose.heading)
    sin = math.sin(pose.heading)
    return Pose(-cos * pose.x - sin * pose.y, sin * pose.x - cos * pose.y, -pose.heading)


def between(parent: Pose, child: Pose) -> Pose:
    """Return ``child`` in the frame of ``parent``, both given in one frame."""
    return composed(inverse(parent), child)


def pose_in_map(pose: Pose, grid: Grid | None) -> Pose:
    """Return a pose of the world in the frame ``map``, whose grid need not begin at 0."""
    return (
        pose if grid is None else Pose(pose.x + grid.origin.x, pose.y + grid.origin.y, pose.heading)
    )


def twist_between(before: Pose, after: Pose, seconds: float) -> Twist:
    """Return the mean velocity between two poses, in the base frame as in nav_msgs/Odometry."""
    x = after.x - before.x
    y = after.y - before.y
    # The robot turns first, then drives.
    ahead = math.cos(after.heading) * x + math.sin(after.heading) * y
    return Twist(
        ahead / seconds, math.remainder(after.heading - before.heading, 2.0 * math.pi) / seconds
    )
