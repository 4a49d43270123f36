"""ROS bags: the last map or costmap, with the robot where it was and where it had to go."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, Literal

import numpy as np

from worldgen.domain import CELL_SIZES
from worldgen.errors import FormatError, InvalidWorld
from worldgen.interop.format import Format
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap, ForeignRobot, check_sides
from worldgen.interop.readers.ros_layout import RosLayout
from worldgen.interop.readers.ros_metadata import RosMetadata
from worldgen.logs.bag import MAGIC, Bag, Grid, read_bag
from worldgen.logs.frames import Track
from worldgen.parameters.bounds import check_between
from worldgen.robot import MOST_CORNERS, convex_footprint
from worldgen.support.arrays import Bools, Floats
from worldgen.support.plain_text import counted
from worldgen.world import Value

# Values from which a map's cell is occupied, and up to which it is free: those of map savers. A
# costmap has 100 in obstacles, and costs around them.
_MAP = (65, 19)
_COSTMAP = (100, 99)
# Corners of a polygon that is meant as a disc, and their largest deviation from it, as a share.
_FEWEST_OF_A_DISC = 12
_ROUND = 0.02


def read_bag_world(
    path: Path,
    *,
    unknown: Literal["solid", "free"] = "solid",
    topic: str = "",
    poses: str = "",
    frame: Literal["map", "picture"] = "map",
) -> ForeignMap:
    """Read a bag's last map or costmap, and the robot's footprint, first pose and last goal.

    Args:
        path: An ``.mcap``, a ``.bag``, a ``.db3``, or a folder of ROS 2.
        unknown: How to treat cells that are neither occupied nor free: ``solid`` or ``free``.
        topic: Topic of the map; by default /map, else a global, else a local costmap.
        poses: Topic of the robot's poses; by default /tf, else Odometry, else other poses.
        frame: Which way cells lie if the map is turned: along the axes of its frame (``map``), or
            its own (``picture``).

    Raises:
        FormatError: If the bag is damaged, has no map, or the extra is not installed.
    """
    bag = read_bag(path)
    name, grid = _chosen_grid(bag, topic)
    check_between("resolution", grid.resolution, *CELL_SIZES, "m")
    check_sides(grid.cells.shape[1], grid.cells.shape[0])
    solid, notes = _walls(name, grid, unknown)

    # Lay the cells along the axes of the map's frame, or leave them as they are.
    x, y, yaw = grid.origin
    metadata = RosMetadata(path, grid.resolution, (x, y), 0.65, 0.196, yaw=yaw)
    layout = RosLayout.of(metadata, solid.shape, frame)
    robot, more = _robot(bag, name, grid, poses)
    if yaw == 0.0:
        robot = robot._replace(
            start=_from_corner(robot.start, (x, y)), target=_from_corner(robot.target, (x, y))
        )
    robot = layout.placed(robot, metadata)
    made: dict[str, Value] = {
        "topic": name, "frame": grid.frame, "origin": list(layout.corner), "unknown": unknown,
    }  # fmt: skip
    made |= {"yaw": yaw} if yaw != 0.0 else {}
    made |= {"picture": [x, y, yaw]} if layout.is_picture else {}
    cells = layout.cells(solid)
    height, width = cells.shape
    if robot.target is not None and not (
        0.0 <= robot.target[0] <= width * grid.resolution
        and 0.0 <= robot.target[1] <= height * grid.resolution
    ):
        more.append("the goal is outside the map, so a target was chosen")
        robot = robot._replace(target=None)
    return ForeignMap(
        cells, grid.resolution, made, (*notes, *layout.notes(metadata), *more),
        tuple(layout.warnings(metadata)), origin=layout.corner, is_picture=True, robots=(robot,),
        is_resampled=layout.rest != 0.0,
    )  # fmt: skip


def _chosen_grid(bag: Bag, topic: str) -> tuple[str, Grid]:
    name = topic or bag.grid_topic()
    if name is None:
        raise FormatError(
            "no-map-found",
            "the bag has no map: no OccupancyGrid on any topic",
            "record /map or a costmap too, or import the map's YAML file and audit the bag in that world",
        )
    if name not in bag.grids:
        raise FormatError(
            "no-such-topic",
            "no map on {topic!q}",
            "topics with maps are {known!l:none}",
            topic=name,
            known=list(bag.grids),
        )
    return name, bag.grids[name]


def _walls(name: str, grid: Grid, unknown: str) -> tuple[Bools, list[str]]:
    """Return which cells are solid, row 0 the lowest, with notes."""
    is_costmap = "costmap" in name
    occupied, free = _COSTMAP if is_costmap else _MAP
    solid = grid.cells >= occupied
    unsure = ~solid & ~((grid.cells >= 0) & (grid.cells <= free))
    notes = []
    if is_costmap:
        notes.append("of its costs, only 100 counts as solid: the rest keeps robots from walls")
    if count := np.count_nonzero(unsure):
        notes.append(
            f"{count:,} of {unsure.size:,} cells are neither occupied nor free; they count as {unknown}"
        )
    return solid | unsure if unknown == "solid" else solid, notes


def _robot(bag: Bag, name: str, grid: Grid, topic: str) -> tuple[ForeignRobot, list[str]]:
    """Return the robot, with its places in the map's frame, and where they are from."""
    robot = ForeignRobot()
    notes = []
    said = [f"the map is from {name}"]
    others = sorted(bag.grids.keys() - {name})
    if others:
        notes.append(f"not used: {', '.join(others)}; +topic=NAME takes another map")
    track: Track | None = None
    try:
        source, track = bag.poses_in(grid.frame, topic)
    except FormatError as error:
        if topic:
            raise
        notes.append(f"{error.message.problem}; start and target were chosen")
    goal = bag.goal_in(grid.frame)
    if track is not None and len(track.x):
        robot = robot._replace(start=_pose(track, 0))
        said.append(f"the start from {source}, the first of {counted(len(track.x), 'pose')}")
    if goal is not None:
        robot = robot._replace(target=goal[1][:2])
        said.append(f"the target from {goal[0]}")
    elif track is not None and len(track.x) > 1:
        robot = robot._replace(target=_pose(track, -1)[:2])
        said.append("the target is the last pose, as there is no goal")
    body = bag.footprint()
    if body is not None:
        own, what = _body(body[1])
        robot = robot._replace(**own)
        said.append(f"{what} from {body[0]}")
    return robot, ["; ".join(said), *notes]


def _pose(track: Track, row: int) -> tuple[float, float, float]:
    return float(track.x[row]), float(track.y[row]), math.remainder(track.yaw[row], math.tau)


def _from_corner(
    place: tuple[float, ...] | None, origin: tuple[float, float]
) -> tuple[float, ...] | None:
    return place and (place[0] - origin[0], place[1] - origin[1], *place[2:])


def _body(corners: Floats) -> tuple[dict[str, Any], str]:
    """Return a robot's radius or footprint by its outline, and how it is called."""
    far = np.hypot(*corners.T) if len(corners) else np.zeros(0)
    if len(far) >= _FEWEST_OF_A_DISC and np.ptp(far) <= _ROUND * far.max():
        return {"radius": round(float(far.max()), 4)}, "the radius"
    # Poses and transforms are not exact to less than a millimetre.
    rounded = [(round(float(x), 3), round(float(y), 3)) for x, y in corners]
    try:
        footprint = convex_footprint(dict.fromkeys(rounded))
    except InvalidWorld:
        return {}, f"no footprint, as it is not convex or has over {MOST_CORNERS} corners,"
    return {"footprint": footprint}, "the footprint"


bag = Format(
    "bag",
    "ROS bag, .mcap, .bag, .db3 or a folder",
    (".mcap", ".bag", ".db3"),
    re.compile(MAGIC),
    read_bag_world,
    usual_robot=FLOOR_ROBOT,
)
