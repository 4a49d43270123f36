"""Read Gazebo worlds: the parts of their models that stop a robot on the floor, and BARN's style.

Source: the SDFormat specification; Daffan/the-barn-challenge, ``run.py`` and
    ``jackal_helper/worlds/BARN``.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from worldgen.domain import DECIMAL
from worldgen.errors import FormatError
from worldgen.interop.format import Destination, decimal_text
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot, read_bounded
from worldgen.interop.geometry.raster import RasterBox, RasterDisc, natural_cell_size, painted
from worldgen.interop.geometry.shapes import Shapes, turned
from worldgen.interop.readers.xml_tree import XmlElement, read_xml
from worldgen.lattice import exact
from worldgen.support.arrays import Bools
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

# Prefix of our elements for facts that SDFormat lacks.
OURS = "worldgen:"
# The model that drives, in our own files.
_ROBOT = "robot"
MAX_BYTES = 64 << 20
# Heights, m; a body that ends below or begins above them stops no robot.
_FLOOR = Fraction(1, 50)
_ABOVE = Fraction(2)
# Tolerance, rad; a body that rolls or pitches more is not upright.
_FLAT = 1e-6
# Tolerance, m and rad, of a pose that Gazebo saved: bodies settle.
_MOVED = 1e-2
# Plugins that are parts of Gazebo, or connect it to ROS; none of them adds a body.
_SYSTEM = re.compile(
    r"(gz|ignition)[-_:]+(sim|gazebo)[-_:\d]*|(gz|ignition)::(sim|gazebo)::|libgazebo_ros_|gazebo_ros_"
)
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


class _BodyPose(NamedTuple):
    """A body's position, m, and rotation, rad."""

    x: Fraction = Fraction(0)
    y: Fraction = Fraction(0)
    z: Fraction = Fraction(0)
    roll: Fraction = Fraction(0)
    pitch: Fraction = Fraction(0)
    yaw: Fraction = Fraction(0)

    def then(self, inner: _BodyPose) -> _BodyPose:
        """Chain this pose with one given in its frame."""
        x = inner.x
        y = inner.y
        if self.yaw != 0 and (x or y):
            moved = turned(
                np.array([[x, y]], np.float64), (Fraction(0), Fraction(0)), float(self.yaw)
            )[0]
            x, y = (Fraction(float(value)) for value in moved)
        return _BodyPose(
            self.x + x, self.y + y, self.z + inner.z, self.roll + inner.roll, self.pitch + inner.pitch,
            self.yaw + inner.yaw,
        )  # fmt: skip

    @property
    def upright(self) -> bool:
        return all(abs(math.sin(angle)) < _FLAT for angle in (self.roll, self.pitch))


class _Frame(NamedTuple):
    """The part of the world that becomes cells.

    It is given by its lower-left corner and its sides, m, and the side of a cell.
    """

    left: Fraction
    low: Fraction
    width: Fraction
    height: Fraction
    cell_size: Fraction


@dataclass
class _GazeboScene:
    shapes: Shapes = field(default_factory=Shapes)
    posts: list[tuple[Fraction, Fraction, Fraction]] = field(default_factory=list)
    models: dict[str, _BodyPose] = field(default_factory=dict)
    low_or_high: int = 0
    unread: Counter[str] = field(default_factory=Counter)


def read_gazebo_world(
    path: Path, *, cell_size: float = 0.0, raster: Literal["outer", "inner"] = "outer"
) -> ForeignMap:
    """Read a Gazebo world file, including BARN's.

    Args:
        path: The ``.world`` or ``.sdf`` file.
        cell_size: Side of a cell, m; 0 means the recorded side in our own files, 0.15 in BARN's,
            and otherwise as large as the boxes allow, or 0.1.
        raster: Whether a cell is solid if a shape reaches into it, or only if it is completely
            inside one.

    Raises:
        FormatError: If the file breaks a rule, with the line if there is one.
    """
    # Parse the file.
    data = read_bounded(path, MAX_BYTES)
    root = read_xml(data)
    world = root.first("world")
    if root.name not in ("sdf", "gazebo") or world is None:
        raise FormatError(
            "missing-element",
            "has no <world>; a world of Gazebo is <sdf><world> ... </world></sdf>",
        )
    # Collect the shapes of all models.
    scene = _GazeboScene()
    own = world.first(f"{OURS}grid")
    _add_models(scene, world, passed_over="" if own is None else _ROBOT)
    _count_plugins(scene, world)
    # Turn them into cells.
    barn = _is_barn(scene)
    frame = _frame(scene, own, cell_size, barn=barn)
    walls, notes = _cells(scene, frame, inner=raster == "inner")
    if own is None:
        notes.append("everything beyond these cells is solid here, but open ground in Gazebo")
    params: dict[str, Value] = {"raster": raster}
    # Find the start, the target and the robot.
    start, target = _ends(scene, frame, barn=barn and own is None, ours=own is not None)
    radius = None
    speed = _number(world, f"{OURS}robot_speed")
    if own is not None and target is not None:
        target = (*target, *_disc_radius(world, "target"))
        radius = next(iter(_disc_radius(world, "start")), None)
    if scene.low_or_high:
        notes.append(
            f"{scene.low_or_high} shapes that lie flat on the floor, or above 2 m, are ignored"
        )
    origin = (float(frame.left), float(frame.low))
    return ForeignMap(
        walls, float(frame.cell_size), params, (*notes, *dict.fromkeys(scene.shapes.notes)), (), None,
        (ForeignRobot(start, target, radius, speed),), origin, unread=_unread(scene),
    )  # fmt: skip


def _unread(scene: _GazeboScene) -> tuple[str, ...]:
    """Return what in the world was not read, counted."""
    return tuple(
        f"{count} {what if count > 1 else what.replace('s ', ' ', 1)}"
        for what, count in sorted((+scene.unread).items())
    )


def _numbers(element: XmlElement, count: int) -> list[Fraction]:
    words = element.text.split()
    if len(words) != count or not all(map(DECIMAL.fullmatch, words)):
        name = f"<{element.name}>"
        raise FormatError(
            "wrong-count",
            "{name} is {text!q}",
            "it has {count} numbers",
            name=name,
            text=element.text.strip(),
            count=count,
            line=element.line,
        )
    return [Fraction(word) for word in words]


def _length(element: XmlElement, name: str) -> Fraction:
    found = element.first(name)
    value = _numbers(found, 1)[0] if found is not None else Fraction(0)
    if not 0 < value < 10**9:
        raise FormatError(
            "not-positive",
            "<{name}> needs a <{child}> above 0 m",
            name=element.name,
            child=name,
            line=(found or element).line,
        )
    return value


def _number(world: XmlElement, name: str) -> float | None:
    found = world.first(name)
    value = None if found is None else float(_numbers(found, 1)[0])
    if found is not None and value is not None and value <= 0:
        raise FormatError(
            "not-positive",
            "<{name}> is {value:g}; it must be above 0",
            name=name,
            value=value,
            line=found.line,
        )
    return value


def _pose(element: XmlElement) -> _BodyPose:
    found = element.first("pose")
    if found is None:
        return _BodyPose()
    if (
        found.attributes.get("relative_to", "")
        or found.attributes.get("frame", "")
        or "degrees" in found.attributes
    ):
        raise FormatError(
            "unsupported",
            "the pose is in another frame or unit",
            "write it in m and rad, relative to the element that contains it",
            line=found.line,
        )
    return _BodyPose(*_numbers(found, 6))


def _add_models(scene: _GazeboScene, world: XmlElement, *, passed_over: str) -> None:
    states = {
        model.attributes.get("name", ""): model
        for model in world.all("state", "model") if model.first("pose") is not None
    }  # fmt: skip
    for model in world.all("model"):
        name = model.attributes.get("name", "")
        own = _pose(model)
        state = states.pop(name, None)
        pose = own if state is None else _pose(state)
        scene.models[name] = pose
        if state is not None:
            _check_state(scene, state, model, pose)
        if passed_over and name == passed_over:
            model.pass_over()
        else:
            _add_model(scene, model, pose)
    # A state of something else, such as an included model, is not that of a shape read here.
    for state in states.values():
        state.pass_over()
    _count_includes(scene, world)
    for what, found in (
        ("populations of models", world.all("population")),
        ("models inserted by <state>", world.all("state", "insertions", "model")),
    ):
        for element in found:
            scene.unread[what] += 1
            element.pass_over()


def _check_state(
    scene: _GazeboScene, state: XmlElement, model: XmlElement, pose: _BodyPose
) -> None:
    """Report what a state changes besides the model's pose: its scale, and its links' places."""
    scale = state.first("scale")
    if scale is not None and any(value != 1 for value in _numbers(scale, 3)):
        scene.unread["models scaled by <state>"] += 1
    links = {link.attributes.get("name", ""): link for link in model.all("link")}
    for moved in state.all("link"):
        link = links.get(moved.attributes.get("name", ""))
        # Poses of links are in the world's frame here, and rounded.
        if link is None or moved.first("pose") is None:
            continue
        there, here = (
            [float(value) for value in one] for one in (_pose(moved), pose.then(_pose(link)))
        )
        off = [a - b for a, b in zip(there, here, strict=True)]
        off[3:] = [math.remainder(angle, 2 * math.pi) for angle in off[3:]]
        if max(map(abs, off)) > _MOVED:
            scene.unread["links moved by <state>"] += 1


def _count_includes(scene: _GazeboScene, parent: XmlElement) -> None:
    for include in parent.all("include"):
        include.pass_over()
        name = include.word("uri").rstrip("/").rpartition("/")[2].lower().replace(" ", "_")
        if name not in ("sun", "ground_plane"):
            scene.unread["models from other files"] += 1


def _add_model(scene: _GazeboScene, model: XmlElement, pose: _BodyPose) -> None:
    for link in model.all("link"):
        here = pose.then(_pose(link))
        for collision in link.all("collision"):
            for geometry in collision.all("geometry"):
                for shape in geometry.children:
                    _add_shape(
                        scene,
                        shape,
                        here.then(_pose(collision)),
                        upright=pose.upright and here.upright,
                    )
    for joint in model.all("joint"):
        if joint.attributes.get("type", "") != "fixed":
            scene.unread["joints with motion"] += 1
        joint.pass_over()
    _count_plugins(scene, model)
    _count_includes(scene, model)
    for inner in model.all("model"):
        _add_model(scene, inner, pose.then(_pose(inner)))


def _count_plugins(scene: _GazeboScene, parent: XmlElement) -> None:
    """Count the plugins that are not parts of Gazebo, because they can do anything."""
    for plugin in parent.all("plugin"):
        names = (plugin.attributes.get("filename", ""), plugin.attributes.get("name", ""))
        scene.unread["plugins of others"] += not any(map(_SYSTEM.match, names))
        plugin.pass_over()


def _add_shape(scene: _GazeboScene, shape: XmlElement, pose: _BodyPose, *, upright: bool) -> None:
    # Find out how tall the shape is; skip shapes that cannot be read.
    if shape.name == "empty":
        return
    if shape.name == "plane":
        _add_plane(scene, shape, pose, upright=upright and pose.upright)
        return
    if shape.name == "sphere":
        tall = 2 * _length(shape, "radius")
    elif shape.name == "cylinder":
        tall = _length(shape, "length")
    elif shape.name == "box" and (size := shape.first("size")) is not None:
        tall = _numbers(size, 3)[2]
    else:
        scene.unread[f"shapes of <{shape.name}>"] += 1
        shape.pass_over()
        return
    # Tilted shapes cannot be cut; shapes above or below the robot do not matter.
    if shape.name != "sphere" and not (upright and pose.upright):
        scene.unread[f"tilted shapes of <{shape.name}>"] += 1
        shape.pass_over()
    elif pose.z + tall / 2 <= _FLOOR or pose.z - tall / 2 >= _ABOVE:
        scene.low_or_high += 1
        shape.pass_over()
    elif shape.name == "box" and size is not None:
        x, y, _ = (side / 2 for side in _numbers(size, 3))
        scene.shapes.outline([(-x, -y), (x, -y), (x, y), (-x, y)], (pose.x, pose.y), pose.yaw)
    else:
        scene.posts.append((pose.x, pose.y, _length(shape, "radius")))


def _add_plane(scene: _GazeboScene, plane: XmlElement, pose: _BodyPose, *, upright: bool) -> None:
    """Treat a plane as the floor; a plane on edge is a wall, and is reported as unread."""
    plane.word("size")  # a floor has no edge for us
    normal = plane.first("normal")
    x, y, _ = _numbers(normal, 3) if normal is not None else (Fraction(0), Fraction(0), Fraction(1))
    if x != 0 or y != 0 or not upright:
        scene.unread["tilted shapes of <plane>"] += 1


def _is_barn(scene: _GazeboScene) -> bool:
    """Return True if the world contains only BARN's posts, each in its own cell of its lattice."""
    return (
        bool(scene.posts)
        and not (scene.shapes.boxes or scene.shapes.polygons)
        and all(
            radius == _POST
            and _LEFT < x < _LEFT + _WIDTH
            and _LOW < y < _LOW + _HEIGHT
            and all(abs(value / _LATTICE % 1 - Fraction(1, 2)) < _ROUNDED for value in (x, y))
            for x, y, radius in scene.posts
        )
    )


def _frame(scene: _GazeboScene, own: XmlElement | None, wanted: float, *, barn: bool) -> _Frame:
    """Return the part of the world to turn into cells.

    It comes from the file, or is BARN's own, or includes everything in the world.
    """
    # Our own files and BARN's have a known frame.
    size = Fraction(repr(wanted)) if wanted else None
    if own is not None:
        left, low, width, height, cell = _numbers(own, 5)
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
    bounds = [*_bounds(scene)]
    if not bounds:
        raise FormatError(
            "empty",
            "has nothing that could stop a robot: no cylinder, box or sphere on the floor"
            + ("; not read are {unread!l}" if scene.unread else ""),
            unread=[*_unread(scene)],
        )
    left, low = (min(bound[axis] for bound in bounds) for axis in (0, 1))
    right, high = (max(bound[axis] for bound in bounds) for axis in (2, 3))
    # Choose the cells so that all boxes fit, if there are only boxes.
    boxes = (
        []
        if scene.posts or scene.shapes.polygons
        else [_shifted(box, left, low) for box in scene.shapes.boxes]
    )
    cell = (
        size
        or (natural_cell_size(right - left, high - low, boxes) if boxes else None)
        or Fraction(repr(DEFAULT_CELL_SIZE))
    )
    return _Frame(left, low, right - left, high - low, cell)


def _bounds(scene: _GazeboScene) -> Iterator[RasterBox]:
    yield from scene.shapes.boxes
    yield from (RasterBox(x - r, y - r, x + r, y + r) for x, y, r in scene.posts)
    for polygon in scene.shapes.polygons:
        ends = [*polygon.min(axis=0).tolist(), *polygon.max(axis=0).tolist()]
        yield RasterBox(*map(Fraction, ends))


def _shifted(box: RasterBox, left: Fraction, low: Fraction) -> RasterBox:
    return RasterBox(box.left - left, box.low - low, box.right - left, box.high - low)


def _cells(scene: _GazeboScene, frame: _Frame, *, inner: bool) -> tuple[Bools, list[str]]:
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
    raster = painted((frame.width, frame.height), size, placed.paint)
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


def _ends(
    scene: _GazeboScene, frame: _Frame, *, barn: bool, ours: bool
) -> tuple[tuple[float, ...] | None, tuple[float, ...] | None]:
    """Return the start and the target: the challenge's, or the models of these names."""
    if barn:
        x, y, heading = map(Fraction, _START)
        goal = (
            float(Fraction(_GOAL[0]) - frame.left),
            float(Fraction(_GOAL[1]) - frame.low),
            _REACH,
        )
        return (float(x - frame.left), float(y - frame.low), float(heading)), goal
    start = scene.models.get("start")
    target = scene.models.get("target")
    if not ours or start is None or target is None:
        return None, None
    return (
        (float(start.x - frame.left), float(start.y - frame.low), float(start.yaw)),
        (float(target.x - frame.left), float(target.y - frame.low)),
    )


def _disc_radius(world: XmlElement, name: str) -> tuple[float, ...]:
    """Return the radius of the disc that marks a place, m; empty if there is none."""
    for model in world.all("model"):
        if model.attributes.get("name") == name:
            for disc in model.all("link", "visual", "geometry", "cylinder"):
                return (float(_length(disc, "radius")),)
    return ()
