"""Tell whether a trajectory is in another frame than the world's, before it is called impossible."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from sim.audit.judge import Audit
from worldgen.errors import Message
from worldgen.logs.trajectory import Trajectory
from worldgen.support.arrays import Bools
from worldgen.world import World

# Kinds of findings that a shift can cause or cure.
_BY_PLACE = ("tunnel", "overlap", "outside", "burned")
# Key of the provenance of a world with the cells of a turned picture: x and y, m, of the picture's
# lower-left corner in the map's frame, and its yaw, rad.
_PICTURE = "picture"
# rad. A yaw that is nearer to a quarter turn is a rounded one, and moves no cells.
_QUARTER = 1e-3
# Decimals of a place, m, that a shift leaves.
_PLACES = 9
# A pose is at the world's start if it is nearer than this, in radii of the robot.
_AT_THE_START = 1.0

Judge = Callable[[World, Trajectory], Audit]


@dataclass(frozen=True)
class MapFrame:
    """Where a world is in the frame of the map that it was imported from.

    Args:
        x: The grid's lower-left corner, m.
        y: The same.
        yaw: The grid's x axis, rad; not 0 for the cells of a turned picture.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    @classmethod
    def of(cls, world: World) -> MapFrame:
        """Return the frame that the world's provenance knows, or the world's own."""
        made = world.provenance
        return cls() if made is None else cls(*made.map_pose)

    def into_world(self, own: Trajectory) -> Trajectory:
        """Return a trajectory of the map's frame in the world's."""
        if self == MapFrame():
            return own
        x, y = own.x - self.x, own.y - self.y
        turned = own.headings
        if self.yaw != 0.0:
            c, s = math.cos(self.yaw), math.sin(self.yaw)
            x, y = c * x + s * y, c * y - s * x
            turned = None if turned is None else turned - self.yaw
        # Exact comparisons would see the errors of rounding.
        return replace(own, x=x.round(_PLACES), y=y.round(_PLACES), headings=turned)


def doubtful_frame(
    world: World, audits: Mapping[int, Audit], judge: Judge, here: Mapping[int, Trajectory]
) -> Message | None:
    """Return why trajectories with findings are rather in the frame of the imported map, or None.

    Args:
        world: The world; its provenance knows where the map's (0, 0) is.
        audits: Results by robot, of the trajectories as they are.
        judge: Audits a trajectory of one robot in its world.
        here: The trajectories by robot.

    Returns:
        A message if they fit better in the map's frame, or if most of their poses, the first one
        too, are outside the world. Poses that begin at the world's start are only in the map's frame
        if they have no finding there.
    """
    wrong = _wrong(audits)
    if not wrong:
        return None
    is_at_start = any(_is_at_start(world, robot, own) for robot, own in here.items())
    clear, inside, count = _counts(world, here)
    frame = MapFrame.of(world)
    if frame != MapFrame():
        there = {robot: frame.into_world(own) for robot, own in here.items()}
        clear_there, inside_there, _ = _counts(world, there)
        own = {robot: judge(_alone(world, robot), one) for robot, one in there.items()}
        wrong_there = _wrong(own)
        is_better = (clear_there, -wrong_there) > (clear, -wrong) and 2 * inside_there >= count
        # A start may have been taken from the log, without its frame.
        if is_better and not (is_at_start and wrong_there):
            return Message(
                "map-frame",
                "in the world's frame {clear} of {count} poses are free, with {wrong} findings; in its "
                "map's, in which the world's (0, 0) is ({left:g}, {low:g}) m, {there}, with {fewer}",
                "add {needs!l}, or --frame=corner to judge the poses as they are",
                at_terminal=True,
                needs=["--frame=map"],
                clear=clear,
                count=count,
                there=clear_there,
                wrong=wrong,
                fewer=wrong_there,
                left=frame.x,
                low=frame.y,
            )
    width, height = world.width * world.cell_size, world.height * world.cell_size
    is_out = not any(_is_inside(world, own)[0] for own in here.values())
    if is_out and 2 * inside < count and not is_at_start:
        return Message(
            "other-frame",
            "{outside} of {count} poses are outside the world, which is {width:g} x {height:g} m from "
            "(0, 0), so the log is in another frame",
            "import the map that it belongs to, and add --frame map; --frame corner judges the poses as "
            "they are",
            at_terminal=True,
            outside=count - inside,
            count=count,
            width=width,
            height=height,
        )
    return None


def resampled_note(world: World) -> str:
    """Return what findings mean in a world whose cells are larger than the walls of its map.

    A map with a yaw is turned, and a cell is solid if anything solid reaches into it. Empty for any
    other world.
    """
    params = {} if world.provenance is None else world.provenance.params
    yaw = params.get("yaw")
    if not isinstance(yaw, float) or _PICTURE in params:
        return ""
    rest = abs(math.remainder(yaw, 0.5 * math.pi))
    if rest < _QUARTER:
        return ""
    return (
        "the map was turned, so walls may be up to two cells larger than in its picture; a world from "
        "worldgen import --frame picture has the picture's own cells"
    )


def _alone(world: World, robot: int) -> World:
    return world.alone(robot) if world.is_fleet else world


def _wrong(audits: Mapping[int, Audit]) -> int:
    return sum(finding.kind in _BY_PLACE for audit in audits.values() for finding in audit.findings)


def _is_at_start(world: World, number: int, own: Trajectory) -> bool:
    """Return True if a trajectory begins where the world's robot does."""
    robot = world.robots[number - 1]
    away = math.hypot(own.x[0] - robot.start.x, own.y[0] - robot.start.y)
    return away <= _AT_THE_START * robot.radius


def _is_inside(world: World, own: Trajectory) -> Bools:
    """Return which poses, (n,), are in the grid."""
    inside: Bools = (
        (own.x >= 0.0)
        & (own.x <= world.width * world.cell_size)
        & (own.y >= 0.0)
        & (own.y <= world.height * world.cell_size)
    )
    return inside


def _counts(world: World, found: Mapping[int, Trajectory]) -> tuple[int, int, int]:
    """Return how many poses have their centre in a free cell, how many are inside, and all."""
    clear = inside = count = 0
    for own in found.values():
        within = _is_inside(world, own)
        ix = np.minimum(own.x[within] // world.cell_size, world.width - 1).astype(int)
        iy = np.minimum(own.y[within] // world.cell_size, world.height - 1).astype(int)
        clear += int(np.count_nonzero(~world.walls[iy, ix]))
        inside += int(np.count_nonzero(within))
        count += len(own.x)
    return clear, inside, count
