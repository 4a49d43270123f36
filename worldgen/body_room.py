"""Room for a body in a family's world: how wide passages are, and a start and a target to fit in.

Families lay out their worlds for a disc. Here a robot with a footprint, or a car, gets the disc whose
passages it can drive along and around corners. Everything is a proposal; the prover decides.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from hashlib import sha256

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.lattice import TURN, cell_middle, heading_from_lattice
from worldgen.random_streams import RandomStream
from worldgen.reach import decide
from worldgen.reach.still.cells import reachable_cells
from worldgen.robot import Drive, Pose, Robot, Target
from worldgen.robot_overrides import RobotOverrides, waypoints_at
from worldgen.support.arrays import Bools, Floats
from worldgen.timeline import Timeline
from worldgen.world import DEFAULT_CELL_SIZE, DEFAULT_ROBOT_RADIUS, Value, Witness, World

# Headings to try at the start, around a full turn.
_HEADINGS = 16
# Cells that a robot's radius is long by default, which is what the usual sizes of families suit.
_USUAL_CELLS = DEFAULT_ROBOT_RADIUS / DEFAULT_CELL_SIZE
# Digits of the radius of a disc for which a world is laid out.
_DIGITS = 4
# Width of passages of a car that cannot reverse, turning radii: a wall is half as thick by default, so
# that it can drive one bend after another.
_AFTER_ANOTHER = 4 / 3
# Cells by which rounding may let a body overlap a wall that it touches.
_TOUCH = 1e-9


@dataclass(frozen=True)
class FittedRobot:
    """A robot with a body, a drive or a goal of its own, in the worlds of a family.

    Args:
        overrides: The body, drive and goal.
        radius: Radius of the robot if it is a disc, m; for a footprint, that of the disc for which
            worlds are laid out.
        any_heading: Whether the body must fit with any heading everywhere, because walls change.
    """

    overrides: RobotOverrides
    radius: float = DEFAULT_ROBOT_RADIUS
    any_heading: bool = False

    @property
    def layout_radius(self) -> float:
        """The radius, m, of the disc for which worlds are laid out, unless it is given."""
        plain = Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 1.0), self.radius)
        return layout_radius(self.overrides.applied_to_robot(plain), any_heading=self.any_heading)

    def suited_sizes(self) -> dict[str, float]:
        """Return the parameters of a family that suit the body."""
        if not self.overrides.changes_body:
            return {}
        radius = self.layout_radius
        sizes = {"cell_size": usual_cell(radius)}
        return sizes if self.overrides.footprint is None else {**sizes, "robot_radius": radius}

    def laid_out_for(self, params: Mapping[str, Value]) -> dict[str, Value]:
        """Return a family's parameters with the radius for which it lays out its worlds."""
        is_round = self.overrides.footprint is None
        if not (self.overrides.changes_body and is_round and "robot_radius" in params):
            return dict(params)
        return {**params, "robot_radius": self.layout_radius}

    def put_into(self, world: World) -> World:
        """Return a world with this robot at its start.

        Raises:
            InvalidParameter: If there is no room for it.
            InvalidWorld: If no world can have such a robot.
        """
        if not self.overrides.given():
            return world
        robot = replace(world.robots[0], radius=self.radius)
        world = with_room(world, self.overrides.applied_to_robot(robot))
        return with_chosen_waypoints(world, self.overrides)


def layout_radius(robot: Robot, *, any_heading: bool = False) -> float:
    """Return the radius, m, of the disc for which a family lays out the passages of a robot.

    Args:
        robot: The robot.
        any_heading: Whether the body must fit with any heading everywhere.
    """
    radius = max(robot.inner_radius, 0.5 * _passage(robot))
    return rounded_up(max(radius, robot.radius) if any_heading else radius, _DIGITS)


def usual_cell(radius: float) -> float:
    """Return the side of a cell, m, in which a disc has as many cells as the default one has."""
    return rounded_up(radius / _USUAL_CELLS, 2)


def rounded_up(value: float, digits: int) -> float:
    """Return a number above 0 with this many digits that is not below another one."""
    last = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    # A number that has no more digits, but for rounding errors, stays as it is.
    return round(math.ceil(round(value / last, 6)) * last, 12)


def _passage(robot: Robot) -> float:
    """Return the width, m, of passages that a robot can drive along, and around right angles.

    A rectangle of length L and width W that turns while it moves needs (L / 2 + W) / sqrt(2) at a
    right angle: it is tightest half way. A car that drives an arc needs the outer radius of what it
    sweeps less the inner one divided by sqrt(2); if it cannot reverse, it needs room between bends.
    """
    if robot.is_disc:
        width = length = 2.0 * robot.radius
        half = robot.radius
    else:
        xs, ys = zip(*robot.footprint, strict=True)
        length = max(xs) - min(xs)
        width = max(ys) - min(ys)
        half = max(map(abs, ys))
    least, most = sorted((length, width))
    needed = 2.0 * robot.radius if robot.is_disc else max(width, (most / 2 + least) / math.sqrt(2))
    if robot.drive.is_car:
        turning = robot.drive.turning_radius
        outer = turning + robot.radius
        if not robot.is_disc:
            outer = max(math.hypot(x, turning + abs(y)) for x, y in robot.footprint)
        needed = max(needed, outer - max(turning - half, 0.0) / math.sqrt(2))
        if not robot.drive.reverse:
            needed = max(needed, _AFTER_ANOTHER * turning)
    return needed


def with_spared_path(world: World) -> World:
    """Return a car's world without what changes on one of its paths, which is its witness.

    A car's path is proved around all cells that ever change, which a fire often leaves none of.
    Without a path through the world as it is before anything changes, it is returned as it is.
    """
    witness = decide(replace(world.bare, timeline=Timeline()), cut=False).certificate
    if not isinstance(witness, Witness):
        return world
    # Every cell within reach of the body on it.
    size = world.cell_size
    reach = world.robot_radius / size + 1.0
    marked = np.zeros(world.walls.shape, np.bool_)
    ys, xs = np.indices(marked.shape) + 0.5
    points = np.column_stack((witness.x, witness.y)) / size
    for begin, end in itertools.pairwise(points):
        for share in np.linspace(0.0, 1.0, math.ceil(math.dist(begin, end)) + 1):
            x, y = begin + share * (end - begin)
            marked |= np.hypot(xs - x, ys - y) <= reach + 1.0
    events = world.timeline
    kept = ~marked[events.iy, events.ix]
    timeline = Timeline(events.times[kept], events.ix[kept], events.iy[kept], events.states[kept])
    return replace(world, timeline=timeline, certificate=witness)


def with_room(world: World, robot: Robot) -> World:
    """Return a family's world with a robot, which fits at its start and somewhere in its target.

    If the body is in a wall at the start, it gets another heading. If it fits with none, at the start
    or the target, walls make way until it can turn there. So do they at its waypoints, which stay where
    they are; only the border is in the way there.

    Args:
        world: The world; its robot says where start and target are.
        robot: The robot, with the same start and target.

    Raises:
        InvalidParameter: If there is no room to turn within the world's border.
    """
    start = robot.start
    target = robot.target
    walls = world.walls
    if not robot.is_disc:
        place = (start.x, start.y)
        fits = _fitting(world, walls, robot, place, start.heading)
        if fits is None:
            walls, place = _cleared(world, walls, robot, place)
            fits = start.heading
        start = Pose(*place, fits)
        place = (target.x, target.y)
        wanted = start.heading if target.heading is None else target.heading
        fits = _fitting(world, walls, robot, place, wanted)
        if fits is None or (target.heading is not None and fits != wanted):
            walls, place = _cleared(world, walls, robot, place)
            target = replace(target, x=place[0], y=place[1])
    for goal in robot.waypoints:
        walls = _without_cells_at(world, walls, robot, goal)
    return replace(world.bare, walls=walls, robots=(replace(robot, start=start, target=target),))


def with_chosen_waypoints(world: World, overrides: RobotOverrides) -> World:
    """Return the world with as many waypoints as are asked for, if their places are not given.

    They are in the middle of cells that a disc in the robot can reach from its start if nothing
    changes, chosen by the walls, the start and the target. If there are fewer, some are the same. A
    world that has as many waypoints stays as it is.

    Raises:
        InvalidParameter: If there is no such cell.
    """
    robot = world.robots[0]
    count = overrides.waypoint_count
    if not overrides.chooses_waypoints or len(robot.waypoints) == count:
        return world
    disc = replace(
        robot, footprint=(), drive=Drive(), radius=robot.inner_radius or robot.radius, waypoints=()
    )
    still = replace(world.bare, timeline=Timeline(), robots=(disc,))
    cells = np.argwhere(reachable_cells(still)).tolist()
    if not cells:
        raise InvalidParameter(
            "no-room",
            "waypoints={count}, and the robot reaches the middle of no cell",
            "use a larger size or cell_size, or a smaller robot",
            count=count,
        )
    made = sha256(np.packbits(world.walls).tobytes() + repr((disc.start, disc.target)).encode())
    rng = RandomStream(int.from_bytes(made.digest()[:8], "little"))
    places: list[tuple[float, float, float]] = []
    for _ in range(count):
        iy, ix = cells[rng.below(len(cells))]
        if len(cells) > count - len(places) - 1:
            cells.remove([iy, ix])
        places.append((cell_middle(ix, world.cell_size), cell_middle(iy, world.cell_size), 0.0))
    robot = replace(robot, waypoints=waypoints_at(places, robot.target))
    return replace(world.bare, robots=(robot,))


def _without_cells_at(world: World, walls: Bools, robot: Robot, goal: Target) -> Bools:
    """Return walls without the cells nearer to a goal than the robot's radius, except at the border."""
    near = _is_near(world, (goal.x / world.cell_size, goal.y / world.cell_size), robot)
    near[[0, -1], :] = False
    near[:, [0, -1]] = False
    return walls & ~near


def with_fitting_heading(world: World) -> World:
    """Return the world with the heading at the start, nearest to the given one, that fits.

    A world with a disc, or whose body fits with no heading, stays as it is.
    """
    robot = world.robots[0]
    start = robot.start
    if robot.is_disc:
        return world
    heading = _fitting(world, world.walls, robot, (start.x, start.y), start.heading)
    if heading in (None, start.heading):
        return world
    return replace(world, start=replace(start, heading=heading))


def _fitting(
    world: World, walls: Bools, robot: Robot, place: tuple[float, float], wanted: float
) -> float | None:
    """Return the heading nearest to a wanted one with which a body is clear; None if it never is."""
    return next(
        (heading for heading in _nearby(wanted) if _is_clear(world, walls, robot, place, heading)),
        None,
    )


def _nearby(wanted: float) -> Iterator[float]:
    yield wanted
    for k in range(1, _HEADINGS // 2 + 1):
        for sign in (1, -1):
            part = sign * k * TURN // _HEADINGS
            yield math.remainder(wanted + heading_from_lattice(part % TURN), math.tau)


def _is_clear(
    world: World, walls: Bools, robot: Robot, place: tuple[float, float], heading: float
) -> bool:
    """Return True if a body is clear of walls, but for rounding errors."""
    cosine = math.cos(heading)
    sine = math.sin(heading)
    corners = np.array([(x * cosine - y * sine, x * sine + y * cosine) for x, y in robot.footprint])
    corners = (corners + place) / world.cell_size
    low = np.floor(corners.min(axis=0) + _TOUCH).astype(int)
    high = np.ceil(corners.max(axis=0) - _TOUCH).astype(int)
    if (low < 0).any() or high[0] > world.width or high[1] > world.height:
        return False
    cells = np.argwhere(walls[low[1] : high[1], low[0] : high[0]])[:, ::-1] + low
    return not _overlaps(corners, cells.astype(np.float64)).any()


def _overlaps(corners: Floats, cells: Floats) -> Bools:
    """Return (n,) bool, which cells a convex polygon overlaps within their bounding box.

    Args:
        corners: (k, 2) float64, counter-clockwise, cells.
        cells: (n, 2) float64, lower-left corners.

    Source: separating axes; Ericson, Real-Time Collision Detection (2005), 5.2.1.
    """
    along = np.roll(corners, -1, axis=0) - corners
    # Outward normals; the corner of a cell that is least far out is the one opposite to them.
    normals = np.stack((along[:, 1], -along[:, 0]), axis=1) / np.hypot(*along.T)[:, None]
    nearest = cells[:, None, :] + (normals < 0.0)
    out = ((nearest - corners) * normals).sum(axis=2)
    overlapping: Bools = (out < -_TOUCH).all(axis=1)
    return overlapping


def _cleared(
    world: World, walls: Bools, robot: Robot, place: tuple[float, float]
) -> tuple[Bools, tuple[float, float]]:
    """Return walls that leave room to turn near a place, and the middle of that room, m.

    The border stays solid, so that the room moves inwards from there.

    Raises:
        InvalidParameter: If there is no such room.
    """
    side = world.cell_size
    reach = robot.radius / side
    middle = []
    for at, cells in zip(place, (world.width, world.height), strict=True):
        # On half cells, as places of families are.
        low = math.ceil(2.0 * (1.0 + reach))
        high = math.floor(2.0 * (cells - 1.0 - reach))
        if low > high:
            raise InvalidParameter(
                "no-room",
                "the robot needs {needed:g} m to turn, and there are {room:g} m between the walls",
                "use a larger size or cell_size, or a smaller footprint",
                needed=2.0 * robot.radius,
                room=(cells - 2) * side,
            )
        middle.append(min(max(round(2.0 * at / side), low), high) / 2.0)
    x, y = middle
    walls = walls & ~_is_near(world, (x, y), robot)
    return walls, (round(x * side, 9), round(y * side, 9))


def _is_near(world: World, place: tuple[float, float], robot: Robot) -> Bools:
    """Return (height, width) bool, the cells nearer to a place, cells, than the robot's radius."""
    x, y = place
    reach = robot.radius / world.cell_size
    columns = np.arange(world.width)
    rows = np.arange(world.height)
    across = np.maximum(np.maximum(columns - x, x - columns - 1.0), 0.0)
    up = np.maximum(np.maximum(rows - y, y - rows - 1.0), 0.0)
    near: Bools = across[None, :] ** 2 + up[:, None] ** 2 < reach * reach
    return near
