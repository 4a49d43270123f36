"""Worlds of Webots: the bodies that stop a robot on the floor.

Source: the Webots Reference Manual, "Nodes and Functions"; the Webots User Guide, "Floors" and
    "Apartment Structure".
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from worldgen.errors import FormatError
from worldgen.interop.account import report_unread
from worldgen.interop.format import Format
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap, ForeignRobot
from worldgen.interop.readers.gazebo_files import ModelFiles
from worldgen.interop.readers.gazebo_poses import BodyPose
from worldgen.interop.readers.gazebo_shapes import ABOVE, FLOOR, GazeboScene
from worldgen.interop.readers.gazebo_world import (
    scene_notes,
    scene_warnings,
    solid_cells,
    world_frame,
)
from worldgen.interop.readers.webots_tree import MAX_BYTES, WebotsFile, WebotsNode, read_webots
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.world import Value

Vector = tuple[Fraction, Fraction, Fraction]

# Since then, z is up, and cylinders and the PROTOs of walls and floors stand along z instead of y.
_Z_UP = 2022
# Sizes of a wall that gives none, m.
_WALL = (Fraction(1, 5), Fraction(1), Fraction(12, 5))
_OLD_WALL = (Fraction(1), Fraction(12, 5), Fraction(1, 5))
# Nodes that cannot be an obstacle.
_HARMLESS_NODES = frozenset({
    "Background", "DirectionalLight", "Fog", "PointLight", "SpotLight", "TexturedBackground",
    "TexturedBackgroundLight", "Viewpoint", "WorldInfo",
})  # fmt: skip
_PROTOS = ("Floor", "RectangleArena", "TexturedBackground", "TexturedBackgroundLight", "Wall")
_OFFICIAL = re.compile(
    r"(webots:/|https://raw\.githubusercontent\.com/cyberbotics/webots/[^/]+)/"
    r"projects/(objects/(backgrounds|floors|apartment_structure)|(robots/.+))/protos/[A-Za-z0-9_-]+\.proto"
)
# Names of fields besides those that give a body its shape or its place.
_HARMLESS = frozenset({
    "appearance", "bottom", "castShadows", "contactMaterial", "description", "floorAppearance",
    "floorTextureUrl", "floorTileSize", "ico", "immersionProperties", "isPickable", "locked", "model",
    "name", "physics", "radarCrossSection", "recognitionColors", "rotationStep", "side", "subdivision",
    "texture", "tileSize", "top", "translationStep", "wallAppearance", "wallColor", "wallTextureUrl",
    "wallTileSize",
})  # fmt: skip


class _Place(NamedTuple):
    """Where a node's children are: a pose, and how much they are scaled along its axes."""

    pose: BodyPose = BodyPose()
    scale: Vector = (Fraction(1),) * 3

    @property
    def is_even(self) -> bool:
        """True if all axes are scaled alike."""
        return len(set(self.scale)) == 1


@dataclass
class _World:
    """Collect the bodies of a world, in a frame whose z is up.

    Args:
        file: The world.
        scene: Receives the bodies.
        folder: That of the file.
        robots: Places of the robots with a body.
        only_seen: Number of shapes that have no ``boundingObject``.
        movable: Number of bodies that a robot could push.
        floors: Heights of the floors, m.
    """

    file: WebotsFile
    scene: GazeboScene
    folder: Path
    robots: list[BodyPose] = field(default_factory=list)
    only_seen: int = 0
    movable: int = 0
    floors: set[Fraction] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.is_old = self.file.year < _Z_UP
        self.is_y_up = _is_y_up(self.file)

    @property
    def unread(self) -> Counter[str]:
        """What is not read, and how often."""
        return self.scene.unread

    def add(self, node: WebotsNode, at: _Place, *, is_seen: bool = False) -> None:
        """Add a node.

        Args:
            node: The node.
            at: Its place.
            is_seen: True if it is in a body whose shape is given otherwise, so that shapes in it are
                only seen.
        """
        kind = node.kind
        if kind in _PROTOS and not self._is_official(kind):
            self._pass_over(node, f"nodes of another {kind}")
        elif kind in _HARMLESS_NODES:
            node.pass_over()
        elif kind == "Robot" or self._is_robot(node):
            self._add_robot(node, at)
        elif kind in ("Group", "Pose", "Transform", "Solid"):
            place = self._inner(node, at)
            if place is not None and kind == "Solid":
                self._add_solid(node, place)
            elif place is not None:
                for child in node.nodes("children"):
                    self.add(child, place, is_seen=is_seen)
        elif kind == "Shape" and is_seen:
            node.pass_over()
        elif kind == "Shape":
            self.only_seen += 1
            self._add_bounds(node, at)
        elif kind in ("Floor", "RectangleArena", "Wall"):
            place = self._inner(node, at)
            if place is not None:
                self._add_proto(node, place)
        else:
            self._pass_over(node, f"nodes of {kind[:40]}")

    def _add_solid(self, node: WebotsNode, place: _Place) -> None:
        bounds = node.nodes("boundingObject")
        is_movable = bool(node.nodes("physics"))
        self.movable += is_movable
        self.scene.lowest = math.inf
        for bound in bounds:
            self._add_bounds(bound, place)
        if is_movable and self.scene.floor + ABOVE <= self.scene.lowest < math.inf:
            self.unread[f"bodies above {ABOVE} m that may fall"] += 1
        for child in node.nodes("children"):
            self.add(child, place, is_seen=bool(bounds))

    def _add_bounds(self, node: WebotsNode, at: _Place) -> None:
        """Add a node of a ``boundingObject``, or a shape that stands for one."""
        if node.kind == "Shape":
            for geometry in node.nodes("geometry"):
                self._add_geometry(geometry, at)
        elif node.kind in ("Group", "Pose", "Transform"):
            place = self._inner(node, at)
            for child in node.nodes("children") if place is not None else ():
                self._add_bounds(child, place or at)
        else:
            self._add_geometry(node, at)

    def _add_geometry(self, node: WebotsNode, at: _Place) -> None:
        kind = node.kind.lower()
        if kind == "plane":
            node.get("size")  # a floor has no edge for us
            self._add_floor(self._upright(at))
            return
        if kind == "box":
            sides = self._vector(node, "size")
            if sides is not None:
                self._add_box(node, sides, at)
                return
        elif kind in ("cylinder", "capsule", "sphere"):
            radius = node.numbers("radius", 1)
            height = [Fraction(0)] if kind == "sphere" else node.numbers("height", 1)
            if radius is not None and height is not None:
                self._add_round(node, radius[0], height[0], at)
                return
        else:
            self._pass_over(node, f"shapes of {node.kind[:40]}")
            return
        # Defaults differ between releases.
        self._pass_over(node, f"shapes of {node.kind} without a size")

    def _add_box(self, node: WebotsNode, sides: Vector, at: _Place) -> None:
        _check_positive(node, sides)
        x, y, tall = (side * scale for side, scale in zip(sides, at.scale, strict=True))
        self.scene.add_solid("box", (x, y, tall), at.pose)

    def _add_round(self, node: WebotsNode, radius: Fraction, height: Fraction, at: _Place) -> None:
        kind = node.kind.lower()
        _check_positive(node, (radius, *([] if kind == "sphere" else [height])))
        if not at.is_even:
            self.unread[f"shapes of {node.kind}, scaled unevenly"] += 1
            return
        scale = at.scale[0]
        across = 2 * radius * scale
        tall = height * scale + (0 if kind == "cylinder" else across)
        self.scene.add_solid(kind, (across, across, tall), self._upright(at))

    def _add_floor(self, pose: BodyPose) -> None:
        if pose.tilt is not None:
            self.unread["shapes of Plane, tilted"] += 1
            return
        self.floors.add(exact(float(pose.z)))
        if abs(pose.z - self.scene.floor) > FLOOR:
            self.unread["shapes of Plane, above or below the floor"] += 1

    def _upright(self, at: _Place) -> BodyPose:
        """Return the pose of a shape whose axis is z, but was y in old releases."""
        axis = self._turned((Fraction(0), Fraction(self.is_old), Fraction(not self.is_old)))
        if axis[2]:
            return at.pose
        about = (0.0, 1.0, 0.0) if axis[0] else (-1.0, 0.0, 0.0)
        quarter = Fraction(math.pi / 2)
        return at.pose.then(BodyPose.about((Fraction(0),) * 3, about, quarter))

    def _add_proto(self, node: WebotsNode, at: _Place) -> None:
        """Add a wall or a floor of Webots' own, whose walls stand around it."""
        if node.kind == "Wall":
            size = node.numbers("size", 3) or (_OLD_WALL if self.is_old else _WALL)
            _check_positive(node, size)
            x, y, z = size
            up = self._flat(Fraction(0), Fraction(0), (y if self.is_old else z) / 2)
            self._add_box(node, self._turned((x, y, z)), self._moved(at, up))
            return
        is_arena = node.kind == "RectangleArena"
        sides = node.numbers("floorSize" if is_arena else "size", 2)
        _check_positive(node, sides or ())
        self._add_floor(self._upright(at))
        if not is_arena:
            return
        x, y = sides or (Fraction(1), Fraction(1))
        (thick,) = node.numbers("wallThickness", 1) or [Fraction(1, 100)]
        (tall,) = node.numbers("wallHeight", 1) or [Fraction(1, 10)]
        _check_positive(node, (thick, tall))
        for side in (-1, 1):
            beside = self._flat(side * (x + thick) / 2, Fraction(0), tall / 2)
            ahead = self._flat(Fraction(0), side * (y + thick) / 2, tall / 2)
            self._add_box(node, self._flat(thick, y, tall), self._moved(at, beside))
            self._add_box(node, self._flat(x + 2 * thick, thick, tall), self._moved(at, ahead))

    def _flat(self, x: Fraction, y: Fraction, up: Fraction) -> Vector:
        """Return a vector along the sides of a floor and up from it."""
        return self._turned((x, up, y) if self.is_old else (x, y, up))

    def _moved(self, at: _Place, by: Vector) -> _Place:
        x, y, z = (part * scale for part, scale in zip(by, at.scale, strict=True))
        return at._replace(pose=at.pose.then(BodyPose(x, y, z)))

    def _add_robot(self, node: WebotsNode, at: _Place) -> None:
        """Note where a robot is; its body moves, so it is not part of the world."""
        place = self._inner(node, at)
        has_body = (
            node.kind != "Robot" or bool(node.get("children")) or bool(node.get("boundingObject"))
        )
        self.unread["supervisors that may change the world"] += node.text("supervisor") == "TRUE"
        if has_body and place is not None:
            self.robots.append(place.pose)
        node.pass_over()

    def _inner(self, node: WebotsNode, at: _Place) -> _Place | None:
        """Return where the children of a node are; None if that is not read."""
        place = self._vector(node, "translation") or (Fraction(0),) * 3
        rotation = node.numbers("rotation", 4) or [
            Fraction(0),
            Fraction(0),
            Fraction(1),
            Fraction(0),
        ]
        scale = self._vector(node, "scale") or (Fraction(1),) * 3
        x, y, z = self._turned((rotation[0], rotation[1], rotation[2]))
        if not any((x, y, z)):
            raise FormatError(
                "out-of-range",
                "rotation of {kind} has an axis of length 0",
                "use 0 0 1 0",
                kind=node.kind[:40],
                line=node.line,
            )
        if min(scale) <= 0 or (rotation[3] and not at.is_even):
            # A turned body that is scaled unevenly is skewed.
            self._pass_over(node, f"nodes of {node.kind}, mirrored or skewed")
            return None
        moved = self._moved(at, place).pose
        turned = BodyPose.about((Fraction(0),) * 3, (float(x), float(y), float(z)), rotation[3])
        sx, sy, sz = (one * other for one, other in zip(at.scale, scale, strict=True))
        return _Place(moved.then(turned), (sx, sy, sz))

    def _vector(self, node: WebotsNode, name: str) -> Vector | None:
        found = node.numbers(name, 3)
        return None if found is None else self._turned((found[0], found[1], found[2]))

    def _turned(self, vector: Vector) -> Vector:
        """Return a vector of the file with east, north and up along x, y and z."""
        x, y, z = vector
        return (z, x, y) if self.is_y_up else vector

    def _is_robot(self, node: WebotsNode) -> bool:
        """Return True if a node is one of Webots' own robots: only they have a controller."""
        known = _OFFICIAL.fullmatch(self.file.protos.get(node.kind) or "")
        return known is not None and known[4] is not None and node.get("controller") is not None

    def _is_official(self, kind: str) -> bool:
        """Return True if a name means Webots' own PROTO, not one of the project's."""
        address = self.file.protos.get(kind)
        if address is not None:
            known = _OFFICIAL.fullmatch(address)
            return known is not None and known[4] is None
        return not any(
            (folder / "protos" / f"{kind}.proto").exists()
            for folder in (self.folder, self.folder / "..")
        )

    def _pass_over(self, node: WebotsNode, what: str) -> None:
        self.unread[what] += 1
        node.pass_over()


def _is_y_up(file: WebotsFile) -> bool:
    """Return True if y is up, which ``WorldInfo`` says, or the release implies."""
    infos = [node for node in file.nodes if node.kind == "WorldInfo"]
    system = infos[0].text("coordinateSystem") if infos else ""
    if system not in ("", "ENU", "NUE"):
        raise FormatError(
            "unsupported",
            "has the coordinate system {system!q}",
            "use ENU or NUE",
            system=system[:40],
            line=infos[0].line,
        )
    gravity = infos[0].get("gravity", []) if infos else []
    if not system and len(gravity) == 3:
        # Before R2020b, gravity was a vector.
        x, y, z = infos[0].numbers("gravity", 3) or [Fraction(0)] * 3
        if x or (y < 0) == (z < 0) or max(y, z) > 0:
            raise FormatError(
                "unsupported", "has gravity along no axis", "use 0 -9.81 0", line=infos[0].line
            )
        return y < 0
    return system == "NUE" or (not system and file.year < _Z_UP)


def _check_positive(node: WebotsNode, lengths: tuple[Fraction, ...] | list[Fraction]) -> None:
    if any(length <= 0 for length in lengths):
        raise FormatError(
            "not-positive",
            "{kind} has a side or radius that is not above 0 m",
            "give it a length above 0 m",
            kind=node.kind,
            line=node.line,
        )


def read_webots_world(
    path: Path, *, cell_size: float = 0.0, floor_height: float = 0.0
) -> ForeignMap:
    """Read a world of Webots: boxes, cylinders, spheres and capsules, walls, floors and arenas.

    Args:
        path: The ``.wbt`` file.
        cell_size: Side of a cell, m; 0 means as large as the boxes allow, or 0.1.
        floor_height: Height of the floor, m: of an upper floor, or of a slab to drive on; 0 means
            that of the file's only floor, if it has one.

    Raises:
        FormatError: If a file breaks a rule, with the line if there is one.
    """
    check_between("floor_height", floor_height, -1000.0, 1000.0, "m")
    file = read_webots(path)
    world = _collected(path, file, exact(floor_height))
    if not floor_height and len(world.floors) == 1 and max(map(abs, world.floors)) > FLOOR:
        world = _collected(path, file, min(world.floors))
    scene = world.scene
    # Turn them into cells.
    frame = world_frame(scene, None, cell_size, barn=False)
    walls, notes = solid_cells(scene, frame, inner=False)
    for what, count in scene.unread.items():
        report_unread(what, count)
    params: dict[str, Value] = {"floor_height": float(scene.floor)} if scene.floor else {}
    origin = (float(frame.left), float(frame.low))
    return ForeignMap(
        walls, float(frame.cell_size), params, (*notes, *_notes(world), *scene_notes(scene)),
        scene_warnings(scene), None, (_robot(world, frame.left, frame.low),), origin,
    )  # fmt: skip


def _collected(path: Path, file: WebotsFile, floor: Fraction) -> _World:
    """Return a world's bodies, with heights from a floor, m."""
    scene = GazeboScene(ModelFiles(path), floor, slice_height=0.0, is_outer=True)
    world = _World(file, scene, path.parent)
    for node in file.nodes:
        world.add(node, _Place())
    scene.unread["robots besides the first"] += max(len(world.robots) - 1, 0)
    return world


def _robot(world: _World, left: Fraction, low: Fraction) -> ForeignRobot:
    if not world.robots:
        return ForeignRobot()
    pose = world.robots[0]
    at = (float(pose.x - left), float(pose.y - low))
    # Old robots drive along an axis of their own choice.
    turn = pose.turn
    heading = () if world.is_old else (math.atan2(turn[1][0], turn[0][0]),)
    return ForeignRobot((*at, *heading))


def _notes(world: _World) -> Iterator[str]:
    """Yield sentences about what was read, and how."""
    yield "everything beyond these cells is solid here, but open ground in Webots"
    if world.is_y_up:
        yield "y is up in this world (NUE): its z is x here, and its x is y"
    if world.robots:
        yield "the start is the place of the first robot, whose body is not part of the world"
    if world.scene.floor:
        yield f"heights count from the floor, which is at {float(world.scene.floor):g} m"
    if world.only_seen:
        yield (
            f"shapes without a boundingObject count as solid, but Webots lets robots drive through "
            f"them: {world.only_seen}"
        )
    if world.movable:
        yield f"bodies with physics, which a robot could push, count as fixed: {world.movable}"


webots = Format(
    "webots",
    "world of Webots, .wbt",
    (".wbt",),
    re.compile(rb"(?:\xef\xbb\xbf)?#VRML_SIM\b"),
    read_webots_world,
    most_bytes=MAX_BYTES,
    harmless=_HARMLESS,
    usual_robot=FLOOR_ROBOT,
)
