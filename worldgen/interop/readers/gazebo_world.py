"""Read Gazebo worlds: the parts of their models that stop a robot on the floor, and BARN's style.

Source: the SDFormat specification; Daffan/the-barn-challenge, ``run.py`` and
    ``jackal_helper/worlds/BARN``.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from worldgen.errors import FormatError
from worldgen.interop.account import report_unread
from worldgen.interop.format import Destination, decimal_text
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot
from worldgen.interop.geometry.raster import (
    Raster,
    RasterBox,
    RasterDisc,
    natural_cell_size,
    painted,
)
from worldgen.interop.geometry.section import Section
from worldgen.interop.geometry.shapes import Shapes
from worldgen.interop.geometry.solid_scene import numbered
from worldgen.interop.readers.gazebo_files import MAX_BYTES, VARIABLES, ModelFiles
from worldgen.interop.readers.gazebo_models import OURS, Model, ModelTree
from worldgen.interop.readers.gazebo_poses import BodyPose, numbers, own_pose
from worldgen.interop.readers.gazebo_shapes import ABOVE, GazeboScene, length
from worldgen.interop.readers.places_text import read_kind
from worldgen.interop.readers.xml_tree import XmlElement
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.plugins.installation import pip_install
from worldgen.support.arrays import Bools
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

__all__ = [
    "MAX_BYTES",
    "OURS",
    "grid_line",
    "read_gazebo_world",
    "scene_notes",
    "scene_warnings",
    "solid_cells",
    "world_frame",
]

# The models that drive, in our own files.
_ROBOT = re.compile(r"robot(_[0-9]+)?")
# Tolerance, m and rad, of a pose that Gazebo saved: bodies settle.
_MOVED = 1e-2
# Side of a cell, m, of a world with meshes, as of a mesh on its own.
_MESH_CELL = Fraction(1, 20)
# Decimals of the ends of what is in floating point, m.
_PLACES = 6
# Names of missing models that are listed.
_MOST_LISTED = 5
# BARN's posts, and the distance between them, m.
_POST = Fraction("0.075")
_LATTICE = Fraction("0.15")
# Tolerance, as a fraction of the lattice's spacing, because coordinates have six digits.
_ROUNDED = Fraction(1, 10**6)
# Places of BARN's posts, m.
_LEFT = Fraction("-4.5")
_LOW = Fraction(0)
_WIDTH = Fraction("4.5")
_HEIGHT = Fraction(15)
# The challenge's target; it counts as reached within 1 m.
_START = ("-2.25", "3", "1.57")
_GOAL = ("-2.25", "13")
_REACH = 1.0


def grid_line(world: World, destination: Destination) -> str:
    """Return our own element, from which an exported world can be restored.

    It has the grid's corner, sides and cell size, m.
    """
    side = exact(world.cell_size)
    grid = [
        destination.x(0.0),
        destination.y(0.0),
        *(decimal_text(n * side) for n in (world.width, world.height, 1)),
    ]
    return f"    <{OURS}grid>{' '.join(grid)}</{OURS}grid>"


class _Frame(NamedTuple):
    """The part of the world that becomes cells.

    It is given by its lower-left corner and its sides, m, and the side of a cell.
    """

    left: Fraction
    low: Fraction
    width: Fraction
    height: Fraction
    cell_size: Fraction


def read_gazebo_world(
    path: Path,
    *,
    cell_size: float = 0.0,
    raster: Literal["outer", "inner"] = "outer",
    slice_height: float = 0.2,
    floor_height: float = 0.0,
) -> ForeignMap:
    """Read a Gazebo world, BARN's also, or a model, with the models and meshes that it names.

    Args:
        path: The ``.world`` or ``.sdf`` file.
        cell_size: Side of a cell, m; 0 means the recorded side in our own files, 0.15 in BARN's,
            0.05 in worlds with meshes, and otherwise as large as the boxes allow, or 0.1.
        raster: Whether a cell is solid if a shape reaches into it, or only if it is completely
            inside one.
        slice_height: Height of the plane in which meshes are cut, m above the floor, such as the
            lidar's.
        floor_height: Height of the floor, m: of an upper floor, or of a slab to drive on.

    Raises:
        FormatError: If a file breaks a rule, with the line if there is one.
    """
    check_between("slice_height", slice_height, 0.0, 1000.0, "m")
    check_between("floor_height", floor_height, -1000.0, 1000.0, "m")
    # Parse the files.
    files = ModelFiles(path)
    root = files.read(path)
    world = root.first("world") or root
    if root.name not in ("sdf", "gazebo") or (world is root and not any(root.all("model"))):
        raise FormatError(
            "missing-element",
            "has no <world> and no <model>; a world of Gazebo is <sdf><world> ... </world></sdf>",
        )
    tree = ModelTree(files, path)
    models = tree.world(world)
    # Collect the shapes of all models.
    scene = GazeboScene(
        files, exact(floor_height), slice_height, raster == "outer", unread=tree.unread
    )
    own = world.first(f"{OURS}grid")
    _add_models(scene, models, tree, is_own=own is not None)
    tree.count_plugins(world)
    # Turn them into cells.
    barn = _is_barn(scene)
    frame = world_frame(scene, own, cell_size, barn=barn)
    walls, notes = solid_cells(scene, frame, inner=raster == "inner")
    if own is None:
        notes.append("everything beyond these cells is solid here, but open ground in Gazebo")
    params: dict[str, Value] = {"raster": raster}
    if floor_height:
        params["floor_height"] = floor_height
    if scene.sections or scene.off_plane:
        params["slice_height"] = slice_height
    origin = (float(frame.left), float(frame.low))
    robots = _robots(world, scene, origin, is_barn=barn and own is None, is_own=own is not None)
    for what, count in scene.unread.items():
        report_unread(what, count)
    return ForeignMap(
        walls, float(frame.cell_size), params, (*notes, *_included(tree), *scene_notes(scene)),
        scene_warnings(scene), None, robots, origin,
    )  # fmt: skip


def _included(tree: ModelTree) -> Iterator[str]:
    if tree.included:
        yield f"models read from other files: {len(tree.included)}"


def scene_notes(scene: GazeboScene) -> Iterator[str]:
    """Yield sentences about what was read, and how."""
    if scene.low_or_high:
        yield f"{scene.low_or_high} shapes that lie flat on the floor, or above {ABOVE} m, are ignored"
    if scene.sections:
        yield (
            f"meshes are cut {scene.slice_height:g} m above the floor, like a lidar's view; what ends "
            f"below or begins above does not count"
        )
    if scene.open_bodies:
        yield (
            f"{scene.open_bodies} bodies of meshes are not closed; their surfaces are walls, and "
            f"their insides stay free"
        )
    yield from dict.fromkeys(scene.shapes.notes)


def scene_warnings(scene: GazeboScene) -> tuple[str, ...]:
    """Return sentences about likely mistakes."""
    found = []
    if scene.slabs:
        top = max(scene.slabs, key=lambda height: scene.slabs[height])
        found.append(
            f"a flat box of {float(scene.slabs[top]):g} m2 that ends at {float(top):g} m is an "
            f"obstacle; if robots drive on it, add +floor_height={float(top):g}"
        )
    if scene.off_plane:
        found.append(
            f"meshes between the floor and {ABOVE} m that are not cut at {scene.slice_height:g} m, and "
            f"do not count: {scene.off_plane}; if they can touch the robot, use another "
            f"+slice_height"
        )
    if scene.files.missing:
        names = [*scene.files.missing]
        more = f", and {len(names) - _MOST_LISTED} more" if len(names) > _MOST_LISTED else ""
        found.append(
            f"not found: {', '.join(name[:100] for name in names[:_MOST_LISTED])}{more}; put the "
            f"folders into `models` next to the world, or list their folder in {VARIABLES[0]}"
            + (
                "; `gz fuel download -u ADDRESS` fetches one"
                if "://fuel." in "".join(names)
                else ""
            )
        )
    if scene.lacks_collada:
        found.append(f"reading meshes in .dae needs a package: {pip_install('collada')}")
    return tuple(found)


def _number(world: XmlElement, name: str) -> float | None:
    found = world.first(name)
    value = None if found is None else float(numbers(found, 1)[0])
    if found is not None and value is not None and value <= 0:
        raise FormatError(
            "not-positive",
            "<{name}> is {value:g}; it must be above 0",
            name=name,
            value=value,
            line=found.line,
        )
    return value


def _add_models(scene: GazeboScene, world: Model, tree: ModelTree, *, is_own: bool) -> None:
    states: dict[str, list[XmlElement]] = {}
    for state in world.element.all("state", "model"):
        states.setdefault(state.attributes.get("name", ""), []).append(state)
    for model in world.models:
        changes = states.pop(model.name, [])
        pose = world.pose_of(model)
        for state in changes:
            if state.first("pose") is not None:
                pose = world.pose(state)
        scene.models[model.name] = pose
        links = dict(_links(model, pose)) if changes else {}
        for state in changes:
            _check_state(scene, state, links)
        if is_own and _ROBOT.fullmatch(model.name):
            model.element.pass_over()
        else:
            scene.add(model, pose, tree)
    # A state of something else, such as a light, is not that of a shape read here.
    for state in itertools.chain.from_iterable(states.values()):
        state.pass_over()
    for what, found in (
        ("populations of models", world.element.all("population")),
        ("models inserted by <state>", world.element.all("state", "insertions", "model")),
    ):
        for element in found:
            scene.unread[what] += 1
            element.pass_over()


def _links(model: Model, pose: BodyPose, prefix: str = "") -> Iterator[tuple[str, BodyPose]]:
    """Yield the names and places of a model's links, and of those of the models in it."""
    for link in model.element.all("link"):
        yield prefix + link.attributes.get("name", ""), pose.then(model.pose(link))
    for inner in model.models:
        at = pose.then(model.pose_of(inner))
        yield from _links(inner, at, f"{prefix}{inner.name}::")


def _check_state(scene: GazeboScene, state: XmlElement, links: dict[str, BodyPose]) -> None:
    """Report what a state changes besides the model's pose: its scale, and its links' places."""
    scale = state.first("scale")
    if scale is not None and any(value != 1 for value in numbers(scale, 3)):
        scene.unread["models scaled by <state>"] += 1
    for moved in state.all("link"):
        here = links.get(moved.attributes.get("name", ""))
        # What is not here cannot move, and other parts of a state are no places.
        if here is None or moved.first("pose") is None:
            continue
        # Poses of links are in the world's frame here, and rounded.
        there = own_pose(moved)[0]
        off = [float(a - b) for a, b in zip(there.place, here.place, strict=True)]
        off += [
            a - b
            for one, other in zip(there.turn, here.turn, strict=True)
            for a, b in zip(one, other, strict=True)
        ]
        if max(map(abs, off)) > _MOVED:
            scene.unread["links moved by <state>"] += 1


def _is_barn(scene: GazeboScene) -> bool:
    """Return True if the world contains only BARN's posts, each in its own cell of its lattice."""
    return (
        bool(scene.posts)
        and not (scene.shapes.boxes or scene.shapes.polygons or scene.sections)
        and all(
            radius == _POST
            and _LEFT < x < _LEFT + _WIDTH
            and _LOW < y < _LOW + _HEIGHT
            and all(abs(value / _LATTICE % 1 - Fraction(1, 2)) < _ROUNDED for value in (x, y))
            for x, y, radius in scene.posts
        )
    )


def world_frame(scene: GazeboScene, own: XmlElement | None, wanted: float, *, barn: bool) -> _Frame:
    """Return the part of the world to turn into cells.

    It comes from the file, or is BARN's own, or includes everything in the world.
    """
    # Our own files and BARN's have a known frame.
    size = Fraction(repr(wanted)) if wanted else None
    if own is not None:
        left, low, width, height, cell = numbers(own, 5)
        if min(width, height, cell) <= 0:
            raise FormatError(
                "wrong-form",
                "<{ours}grid> has its corner, then its sides and its cells' above 0 m",
                ours=OURS,
                line=own.line,
            )
        return _Frame(left, low, width, height, size or cell)
    if barn:
        return _Frame(_LEFT, _LOW, _WIDTH, _HEIGHT, size or _LATTICE)
    # For any other, take the bounds of everything in it.
    if scene.is_empty:
        raise FormatError(
            "empty",
            "has nothing that could stop a robot: no cylinder, box, sphere or mesh on the floor"
            + ("; not read are {unread!l}" if +scene.unread else ""),
            "{warnings}",
            unread=sorted(+scene.unread),
            warnings="; ".join(scene_warnings(scene)),
        )
    bounds = [*_bounds(scene)]
    left, low = (min(bound[axis] for bound in bounds) for axis in (0, 1))
    right, high = (max(bound[axis] for bound in bounds) for axis in (2, 3))
    # Choose the cells so that all boxes fit, if there are only boxes.
    boxes = (
        []
        if scene.posts or scene.shapes.polygons or scene.sections
        else [_shifted(box, left, low) for box in scene.shapes.boxes]
    )
    cell = (
        size
        or (natural_cell_size(right - left, high - low, boxes) if boxes else None)
        or (_MESH_CELL if scene.sections else Fraction(repr(DEFAULT_CELL_SIZE)))
    )
    # A needle still takes a cell.
    return _Frame(left, low, max(right - left, cell), max(high - low, cell), cell)


def _bounds(scene: GazeboScene) -> Iterator[RasterBox]:
    yield from scene.shapes.boxes
    yield from (RasterBox(x - r, y - r, x + r, y + r) for x, y, r in scene.posts)
    outlines = [segments.reshape(-1, 2) for section in scene.sections for segments in section]
    for points in (*scene.shapes.polygons, *outlines):
        if len(points):
            # Without their rounding errors, ends that look round are.
            ends = [*points.min(axis=0).tolist(), *points.max(axis=0).tolist()]
            yield RasterBox(*(exact(round(end, _PLACES)) for end in ends))


def _shifted(box: RasterBox, left: Fraction, low: Fraction) -> RasterBox:
    return RasterBox(box.left - left, box.low - low, box.right - left, box.high - low)


def solid_cells(scene: GazeboScene, frame: _Frame, *, inner: bool) -> tuple[Bools, list[str]]:
    """Return the cells that a scene makes solid, and sentences about them."""
    size = frame.cell_size
    # Paint all shapes, from the grid's corner.
    corner = np.array([frame.left, frame.low], np.float64)
    placed = Shapes(
        [_shifted(box, frame.left, frame.low) for box in scene.shapes.boxes],
        [
            RasterDisc(float(x - frame.left), float(y - frame.low), float(radius))
            for x, y, radius in scene.posts
        ],
        [polygon - corner for polygon in scene.shapes.polygons],
    )
    sections = [Section(*(segments - corner for segments in section)) for section in scene.sections]

    def paint(raster: Raster) -> None:
        placed.paint(raster)
        for section in sections:
            raster.section(section)

    raster = painted((frame.width, frame.height), size, paint)
    # Solid cells are either completely covered, or at least touched.
    if inner:
        return raster.full, [
            "only cells completely inside a shape are solid, so a robot may get through here but "
            "not in Gazebo"
        ]
    count = f"{raster.partly} of {np.count_nonzero(raster.solid)} solid cells of {float(size):g} m"
    return raster.solid, [
        f"{count} are only partly covered, for example by posts"
    ] if raster.partly else []


def _robots(
    world: XmlElement,
    scene: GazeboScene,
    origin: tuple[float, float],
    *,
    is_barn: bool,
    is_own: bool,
) -> tuple[ForeignRobot, ...]:
    """Return the robots of the challenge, or of our own file, whose places are models."""
    left, low = map(exact, origin)
    speed = _number(world, f"{OURS}robot_speed")
    words = [found.text.strip() for found in world.all(f"{OURS}footprint")]
    if is_barn:
        x, y, heading = map(Fraction, _START)
        goal_x, goal_y = map(Fraction, _GOAL)
        start = (float(x - left), float(y - low), float(heading))
        return (ForeignRobot(start, (float(goal_x - left), float(goal_y - low), _REACH)),)
    robots = [ForeignRobot(speed=speed)]
    for number in itertools.count(1):
        names = [numbered(name, number) for name in ("start", "target")]
        if not is_own or not all(name in scene.models for name in names):
            break
        at, to = (scene.models[name] for name in names)
        start = (float(at.x - left), float(at.y - low), float(at.yaw))
        target = (float(to.x - left), float(to.y - low), *_disc_radius(world, names[1]))
        radius = next(iter(_disc_radius(world, names[0])), None)
        robots[number - 1 :] = [ForeignRobot(start, target, radius, speed)]
    if len(words) == len(robots):
        kinds = [read_kind({"footprint": word}).footprint for word in words]
        robots = [one._replace(footprint=kind) for one, kind in zip(robots, kinds, strict=True)]
    return tuple(robots)


def _disc_radius(world: XmlElement, name: str) -> tuple[float, ...]:
    """Return the radius of the disc that marks a place, m; empty if there is none."""
    for model in world.all("model"):
        if model.attributes.get("name") == name:
            for disc in model.all("link", "visual", "geometry", "cylinder"):
                return (float(length(disc, "radius")),)
    return ()
