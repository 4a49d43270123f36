"""Convert worldgen's numbers to the conventions of ROS 2: grids, scans, poses, time.

This module needs neither rclpy nor worldgen. Both use metres, radians, x to the right, y up and
headings counter-clockwise from +x (REP 103); it handles the differences.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass

__all__ = [
    "FREE",
    "OCCUPIED",
    "Grid",
    "Pose",
    "Scan",
    "Twist",
    "between",
    "composed",
    "grid_of",
    "inverse",
    "pose_in_map",
    "quaternion",
    "scan_of",
    "stamp",
    "twist_between",
]

FREE = 0
OCCUPIED = 100
"""Values in a nav_msgs/OccupancyGrid. The value -1, unknown, never occurs in a world."""


@dataclass(frozen=True)
class Pose:
    """A position, m, and a heading, rad."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class Twist:
    """A velocity: m/s along the heading, and rad/s counter-clockwise."""

    speed: float = 0.0
    turn_rate: float = 0.0


@dataclass(frozen=True)
class Grid:
    """A nav_msgs/OccupancyGrid.

    ``data`` has the rows from the lowest y up; ``origin`` is the lower left corner.
    """

    width: int
    height: int
    resolution: float
    origin: Pose
    data: list[int]


@dataclass(frozen=True)
class Scan:
    """A sensor_msgs/LaserScan, counter-clockwise from ``angle_min``.

    A beam that returned nothing is infinite (REP 117).
    """

    angle_min: float
    angle_max: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: list[float]


def grid_of(text: str) -> Grid:
    """Return the map in a ``.grid`` file, with its original origin if it was imported from ROS.

    Args:
        text: The file's content (``docs/reference/grid-format.md``); the cells are those at time 0.

    Raises:
        ValueError: If it is not such a file.
    """
    head, found, cells = text.partition("\n%cells\n")
    magic, _, header = head.partition("\n")
    if not found or not magic.startswith("%worldgen-grid 1"):
        raise ValueError("this is not a .grid file of version 1")
    table = tomllib.loads(header)
    if "cell_size" not in table:
        raise ValueError("its cell_size is missing")
    lines = cells.splitlines()
    end = next((k for k, line in enumerate(lines) if line.startswith("%")), len(lines))
    rows = lines[:end][::-1]  # The file begins with the top row, an OccupancyGrid with the bottom.
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
        beam_range: Longest distance that a beam measures, m, the run's ``+beam_range``; a beam that
            meets nothing reports it.
        field: Angle from the first beam to the last, rad, centred on the heading, the run's
            ``+beam_field``. With 0 the beams are spread evenly in all directions, the first ahead.
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
    """Return x, y, z, w of a turn about z."""
    return 0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading)


def stamp(seconds: float) -> tuple[int, int]:
    """Return seconds and nanoseconds for a builtin_interfaces/Time, rounded to the nanosecond."""
    total = round(seconds * 1e9)
    return total // 10**9, total % 10**9


def composed(first: Pose, then: Pose) -> Pose:
    """Return ``then``, a pose in the frame of ``first``, in the frame that ``first`` is in."""
    cos = math.cos(first.heading)
    sin = math.sin(first.heading)
    x = first.x + cos * then.x - sin * then.y
    y = first.y + sin * then.x + cos * then.y
    return Pose(x, y, math.remainder(first.heading + then.heading, 2.0 * math.pi))


def inverse(pose: Pose) -> Pose:
    """Return the origin of the other frame, as seen from ``pose``."""
    cos = math.cos(pose.heading)
    sin = math.sin(pose.heading)
    return Pose(-cos * pose.x - sin * pose.y, sin * pose.x - cos * pose.y, -pose.heading)


def between(parent: Pose, child: Pose) -> Pose:
    """Return ``child`` in the frame of ``parent``; both are given in one frame."""
    return composed(inverse(parent), child)


def pose_in_map(pose: Pose, grid: Grid | None) -> Pose:
    """Return a pose of the world in the frame ``map``, whose grid need not begin at 0."""
    return (
        pose if grid is None else Pose(pose.x + grid.origin.x, pose.y + grid.origin.y, pose.heading)
    )


def twist_between(before: Pose, after: Pose, seconds: float) -> Twist:
    """Return the mean velocity between two poses, in the frame of the base as in nav_msgs."""
    x = after.x - before.x
    y = after.y - before.y
    # The robot turns first and then drives, so the new heading is that of the move.
    ahead = math.cos(after.heading) * x + math.sin(after.heading) * y
    return Twist(
        ahead / seconds, math.remainder(after.heading - before.heading, 2.0 * math.pi) / seconds
    )
