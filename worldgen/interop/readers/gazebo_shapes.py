"""The shapes of a Gazebo world that can stop a robot, seen from above.

Boxes, cylinders, spheres and polylines count wherever they are between the floor and the height of
a tall robot; meshes are cut at the height of a lidar.

Source: the SDFormat specification 1.12, ``<geometry>``.
"""

from __future__ import annotations

import importlib.util
import math
from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np

from worldgen.errors import FormatError, InvalidWorld
from worldgen.interop.format.foreign_map import naming
from worldgen.interop.geometry.section import Bodies, Section, cut, outlines, sort_bodies
from worldgen.interop.geometry.shapes import Point, Shapes, hull, turned
from worldgen.interop.readers.gazebo_files import Home, ModelFiles
from worldgen.interop.readers.gazebo_models import Model, ModelTree
from worldgen.interop.readers.gazebo_poses import BodyPose, numbers
from worldgen.interop.readers.xml_tree import XmlElement
from worldgen.support.arrays import Floats

# Heights above the floor, m; a body that ends below or begins above them stops no robot.
FLOOR = Fraction(1, 50)
ABOVE = Fraction(2)
# Height above the floor and side, m, of a flat box that may itself be the floor.
_SLAB_TOP = Fraction(3, 10)
_SLAB_SIDE = Fraction(2)
# Corners of the prism that stands for a tilted cylinder.
_CORNERS = 32
# Triangles of all meshes together, each as often as it is placed.
_MOST_PLACED = 30_000_000
_MESHES = ("dae", "stl", "obj", "glb", "gltf")


@dataclass
class GazeboScene:
    """What a world has that could stop a robot, m.

    Args:
        files: Finds the files of meshes.
        floor: Height of the floor, m.
        slice_height: Height of the plane in which meshes are cut, m above the floor.
        is_outer: True if round shapes become polygons around them, else within them.
        shapes: Boxes, and polygons seen from above.
        posts: Discs: x, y, radius.
        sections: Outlines of meshes and polylines.
        models: Poses of the world's models, by name.
        low_or_high: Number of shapes that are flat on the floor or overhead.
        off_plane: Number of meshes that are neither, but not at the height of the cut.
        open_bodies: Number of bodies of meshes that enclose nothing.
        slabs: Areas, m2, of large flat boxes that may be the floor, by the height of their top, m.
        lacks_collada: True if a mesh is not read because a package is missing.
        unread: What is not read, and how often.
        lowest: Height of the lowest point added since it was set, m.
    """

    files: ModelFiles
    floor: Fraction
    slice_height: float
    is_outer: bool
    shapes: Shapes = field(default_factory=Shapes)
    posts: list[tuple[Fraction, Fraction, Fraction]] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)
    models: dict[str, BodyPose] = field(default_factory=dict)
    low_or_high: int = 0
    off_plane: int = 0
    open_bodies: int = 0
    slabs: dict[Fraction, Fraction] = field(default_factory=dict)
    lacks_collada: bool = False
    unread: Counter[str] = field(default_factory=Counter)
    lowest: float = math.inf
    _meshes: dict[Path, Bodies] = field(default_factory=dict)
    _placed: int = 0

    @property
    def is_empty(self) -> bool:
        """True if nothing stops a robot."""
        return not (self.posts or self.sections or self.shapes.boxes or self.shapes.polygons)

    def add(self, model: Model, pose: BodyPose, tree: ModelTree) -> None:
        """Add the shapes of a model, and of the models in it."""
        joined = {
            part.text.strip()
            for joint in model.element.all("joint")
            for end in ("parent", "child")
            for part in joint.all(end)
        }
        # The lowest point of each body: a link, or all that are joined.
        lowest = {"": -math.inf if "world" in joined else math.inf}
        for link in model.element.all("link"):
            model.pose(link)  # a link without shapes has a place too
            self.lowest = math.inf
            for collision in link.all("collision"):
                at = pose.then(model.pose(collision, link))
                for geometry in collision.all("geometry"):
                    with naming(model.path):
                        self._add_geometry(geometry, at, model.home)
            if link.word("gravity") in ("0", "false"):
                continue
            name = link.attributes.get("name", "")
            body = "" if name in joined else name
            lowest[body] = min(lowest.get(body, math.inf), self.lowest)
        if not model.is_static:
            hovering = [low for low in lowest.values() if self.floor + ABOVE <= low < math.inf]
            self.unread[f"bodies above {ABOVE} m that may fall"] += len(hovering)
        for joint in model.element.all("joint"):
            moves = not model.is_static and joint.attributes.get("type", "") != "fixed"
            self.unread["joints with motion"] += moves
            joint.pass_over()
        with naming(model.path):
            tree.count_plugins(model.element)
        for inner in model.models:
            self.add(inner, pose.then(model.pose_of(inner)), tree)

    def _add_geometry(self, geometry: XmlElement, at: BodyPose, home: Home) -> None:
        self._add_polylines([*geometry.all("polyline")], at)
        for shape in geometry.children:
            if shape.name == "mesh":
                self._add_mesh(shape, at, home)
            elif shape.name == "plane":
                self._add_plane(shape, at)
            elif shape.name not in ("empty", "polyline"):
                self._add_shape(shape, at)

    def _add_plane(self, plane: XmlElement, at: BodyPose) -> None:
        """Treat a plane as the floor; a plane on edge is a wall, and is reported as unread."""
        plane.word("size")  # a floor has no edge for us
        normal = plane.first("normal")
        x, y, _ = numbers(normal, 3) if normal is not None else (Fraction(0),) * 3
        if x != 0 or y != 0 or at.tilt is not None:
            self.unread["shapes of <plane>, tilted"] += 1

    def _add_shape(self, shape: XmlElement, at: BodyPose) -> None:
        """Add a box, a cylinder, a sphere or a capsule."""
        if shape.name == "box" and (size := shape.first("size")) is not None:
            x, y, tall = numbers(size, 3)
        elif shape.name == "sphere":
            x = y = tall = 2 * length(shape, "radius")
        elif shape.name in ("cylinder", "capsule"):
            x = y = 2 * length(shape, "radius")
            tall = length(shape, "length") + (x if shape.name == "capsule" else 0)
        else:
            self._pass_over(shape, f"shapes of <{shape.name}>")
            return
        self.add_solid(shape.name, (x, y, tall), at)

    def add_solid(self, kind: str, size: tuple[Fraction, Fraction, Fraction], at: BodyPose) -> None:
        """Add a body whose middle is at a pose.

        Args:
            kind: box, cylinder, sphere or capsule; the axis of a round one is z.
            size: Its length, width and height, m.
            at: Its pose.
        """
        x, y, tall = size
        is_round = kind != "box"
        if at.tilt is None or kind == "sphere":
            top = at.z + tall / 2
            if self._is_beyond(at.z - tall / 2, top):
                self.low_or_high += 1
            elif is_round:
                self.posts.append((at.x, at.y, x / 2))
            else:
                self.shapes.outline(_rectangle(x, y), (at.x, at.y), at.yaw)
                if top <= self.floor + _SLAB_TOP and min(x, y) >= _SLAB_SIDE:
                    self.slabs[top] = max(self.slabs.get(top, x * y), x * y)
        elif kind == "capsule":
            self.unread["shapes of <capsule>, tilted"] += 1
        else:
            rim = _rectangle(x, y)
            if is_round:
                rim = _circle(x / 2, math.cos(math.pi / _CORNERS) if self.is_outer else 1.0)
            self._add_prism(rim, tall, at)

    def _add_prism(self, rim: list[Point], tall: Fraction, at: BodyPose) -> None:
        """Add what is seen from above of a tilted prism, between the floor and a robot's height."""
        flat = np.array(rim, np.float64)
        half = np.full((len(rim), 1), float(tall) / 2)
        corners = at.moved(np.concatenate([np.hstack([flat, -half]), np.hstack([flat, half])]))
        # All edges between corners of a convex body stay in it, so their ends are enough.
        seen = _between(corners, float(self.floor + FLOOR), float(self.floor + ABOVE))
        self.lowest = min(self.lowest, float(corners[:, 2].min()))
        if len(seen) == 0:
            self.low_or_high += 1
        else:
            self.shapes.polygons.append(hull(seen))

    def _add_polylines(self, polylines: list[XmlElement], at: BodyPose) -> None:
        """Add outlines that Gazebo extrudes; of several, those within others are holes."""
        rings = []
        for polyline in polylines:
            tall = length(polyline, "height")
            ring = [(x, y) for x, y in (numbers(one, 2) for one in polyline.all("point"))]
            ring = ring[:-1] if ring[:1] == ring[-1:] else ring
            if len(ring) < 3:
                raise FormatError(
                    "too-few",
                    "a <polyline> has {count} corners",
                    "it needs at least 3",
                    count=len(ring),
                    line=polyline.line,
                )
            if at.tilt is not None:
                self._pass_over(polyline, "shapes of <polyline>, tilted")
            elif self._is_beyond(at.z, at.z + tall):
                self.low_or_high += 1
            else:
                rings.append(ring)
        if len(rings) == 1:
            self.shapes.outline(rings[0], (at.x, at.y), at.yaw)
        elif rings:
            moved = [
                turned(np.array(ring, np.float64), (at.x, at.y), float(at.yaw)) for ring in rings
            ]
            try:
                section = outlines(moved)
            except InvalidWorld as error:
                raise FormatError.of(error.message) from error
            # Outlines that cancel each other leave nothing.
            if len(section.closed):
                self.sections.append(section)

    def _add_mesh(self, mesh: XmlElement, at: BodyPose, home: Home) -> None:
        """Cut a mesh, at its pose and scale, where a lidar would see it."""
        uri = mesh.first("uri")
        path = None if uri is None else self.files.mesh(uri, home)
        if uri is None or path is None:
            self._pass_over(mesh, "meshes not found")
            return
        if mesh.first("submesh") is not None:
            self._pass_over(mesh, "parts of meshes")
            return
        scale = mesh.first("scale")
        sides = np.array([1.0] * 3 if scale is None else numbers(scale, 3), np.float64)
        bodies = self._bodies(path)
        if bodies is None:
            return
        self._placed += len(bodies.closed) + len(bodies.sheets)
        if self._placed > _MOST_PLACED:
            raise FormatError(
                "too-large",
                "its meshes have more than {most} triangles, each as often as it is placed",
                "simplify them",
                most=_MOST_PLACED,
            )
        vertices = at.moved(bodies.vertices * sides)
        is_beyond = self._is_beyond(vertices[:, 2].min(), vertices[:, 2].max())
        section = cut(bodies._replace(vertices=vertices), float(self.floor) + self.slice_height)
        if sides.prod() < 0:
            # A mirror turns bodies inside out.
            section = section._replace(closed=section.closed[:, ::-1])
        if len(section.closed) or len(section.sheets):
            self.sections.append(section)
            self.open_bodies += bodies.open_count
        elif is_beyond:
            self.low_or_high += 1
        else:
            self.off_plane += 1

    def _bodies(self, path: Path) -> Bodies | None:
        """Return the triangles of a file, m, which is loaded once; None if they cannot be had."""
        kind = path.suffix.lower().removeprefix(".")
        if kind not in _MESHES:
            self.unread[f"meshes of .{kind[:20]}"] += 1
            return None
        if kind == "dae" and importlib.util.find_spec("collada") is None:
            self.unread["meshes of .dae"] += 1
            self.lacks_collada = True
            return None
        if path not in self._meshes:
            # trimesh takes a second to import, so it is imported when a mesh is read.
            from worldgen.interop.readers.mesh_file import load_mesh

            with naming(path):
                raw = load_mesh(path, kind)
            self._meshes[path] = sort_bodies(raw.vertices, raw.faces)
        return self._meshes[path]

    def _is_beyond(self, low: float | Fraction, high: float | Fraction) -> bool:
        """Return True if nothing between these heights can touch a robot on the floor."""
        self.lowest = min(self.lowest, float(low))
        return high <= self.floor + FLOOR or low >= self.floor + ABOVE

    def _pass_over(self, shape: XmlElement, what: str) -> None:
        self.unread[what] += 1
        shape.pass_over()


def length(element: XmlElement, name: str) -> Fraction:
    """Return a length in an element, m.

    Raises:
        FormatError: If it is missing or not above 0.
    """
    found = element.first(name)
    value = numbers(found, 1)[0] if found is not None else Fraction(0)
    if value <= 0:
        raise FormatError(
            "not-positive",
            "<{name}> needs a <{child}> above 0 m",
            name=element.name,
            child=name,
            line=(found or element).line,
        )
    return value


def _rectangle(x: Fraction, y: Fraction) -> list[Point]:
    """Return the corners of a rectangle about the origin, with these sides."""
    return [(-x / 2, -y / 2), (x / 2, -y / 2), (x / 2, y / 2), (-x / 2, y / 2)]


def _circle(radius: Fraction, apothem: float) -> list[Point]:
    """Return the corners of a polygon about the origin whose sides are that share of it away."""
    angles = [2 * math.pi * number / _CORNERS for number in range(_CORNERS)]
    far = float(radius) / apothem
    return [(Fraction(far * math.cos(one)), Fraction(far * math.sin(one))) for one in angles]


def _between(corners: Floats, low: float, high: float) -> Floats:
    """Return x and y of the corners of a convex body's part between two heights."""
    found = [corners[(corners[:, 2] >= low) & (corners[:, 2] <= high), :2]]
    # Of each segment between two corners, add where it crosses a height.
    one, other = np.triu_indices(len(corners), 1)
    for level in (low, high):
        crosses = (corners[one, 2] < level) != (corners[other, 2] < level)
        begin, end = corners[one[crosses]], corners[other[crosses]]
        share = (level - begin[:, 2]) / (end[:, 2] - begin[:, 2])
        found.append(begin[:, :2] + share[:, None] * (end[:, :2] - begin[:, :2]))
    return np.concatenate(found)
