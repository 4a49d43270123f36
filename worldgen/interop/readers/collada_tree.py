"""Check a COLLADA file before a library builds the scene, and account for what the library skips.

Source: The Khronos Group, "COLLADA 1.4.1 Specification", 2008.
"""

from __future__ import annotations

from collections import Counter

from worldgen.domain import DECIMAL
from worldgen.errors import FormatError
from worldgen.interop.account import report_unread
from worldgen.interop.readers.gltf_tree import MOST_FACES
from worldgen.interop.readers.xml_tree import XmlElement, parse_xml

# Primitives of a mesh that become triangles; drawn lines, such as edges, stop nobody.
_SURFACES = ("triangles", "polylist", "polygons", "tristrips", "trifans")
# Meshes that the file places, each as often as it does.
_MOST_PLACED = 200_000
_MOST_DEPTH = 100
# Lengths, m, that a unit of a sensible file may have.
_UNITS = (1e-6, 1e6)


def check_collada(data: bytes) -> tuple[float, str, int]:
    """Return the file's unit, m, its axis up, and the number of surfaces that its scene places.

    Raises:
        FormatError: If it is not COLLADA, has no sensible unit, or places too much.
    """
    root = parse_xml(data)
    if root.name.rpartition(":")[2] != "COLLADA":
        raise FormatError(
            "wrong-root",
            "begins with <{name}>; a COLLADA file begins with <COLLADA>",
            "export it again",
            name=root.name[:40],
            line=root.line,
        )
    scene = _Placed(root)
    report_unread("parts of COLLADA other than plain meshes", scene.others)
    return _unit(root), _up(root), scene.surfaces


def _up(root: XmlElement) -> str:
    axis = root.word("asset", "up_axis", default="Y_UP")
    if axis not in ("Y_UP", "Z_UP"):
        raise FormatError(
            "unsupported", "has the axis {axis!q} up", "export it with z up", axis=axis[:20]
        )
    return axis[0].lower()


def _unit(root: XmlElement) -> float:
    unit = root.first("asset", "unit")
    text = "1" if unit is None else unit.attributes.get("meter", "1").strip()
    if not DECIMAL.fullmatch(text) or not _UNITS[0] <= float(text) <= _UNITS[1]:
        raise FormatError(
            "out-of-range",
            "has units of {text!q} m",
            "use {low:g} to {high:g}",
            text=text[:40],
            low=_UNITS[0],
            high=_UNITS[1],
        )
    return float(text)


class _Placed:
    """Counts what a scene places, before anybody builds it: nodes can multiply each other."""

    def __init__(self, root: XmlElement) -> None:
        self.surfaces = 0
        self.others = 0
        self._steps = 0
        self._faces = 0
        self._nodes: dict[str, XmlElement] = {}
        self._meshes = {
            mesh.attributes.get("id", ""): mesh
            for mesh in root.all("library_geometries", "geometry")
        }
        scenes = [*root.all("library_visual_scenes", "visual_scene")]
        for top in (*scenes, *root.all("library_nodes")):
            self._name(top)
        named = root.first("scene", "instance_visual_scene")
        url = "" if named is None else named.attributes.get("url", "")
        for scene in scenes:
            if f"#{scene.attributes.get('id', '')}" == url:
                self._visit(scene, 0)

    def _name(self, parent: XmlElement) -> None:
        for node in parent.all("node"):
            self._nodes[node.attributes.get("id", "")] = node
            self._name(node)

    def _visit(self, node: XmlElement, depth: int) -> None:
        self._steps += 1
        if self._steps > _MOST_PLACED or depth > _MOST_DEPTH:
            raise FormatError(
                "too-large",
                "has more than {most} nodes, or nodes {deep} deep",
                "simplify it",
                most=_MOST_PLACED,
                deep=_MOST_DEPTH,
            )
        for inner in node.all("node"):
            self._visit(inner, depth + 1)
        for instance in node.all("instance_node"):
            target = self._nodes.get(instance.attributes.get("url", "").removeprefix("#"))
            if target is None:
                self.others += 1
            else:
                self._visit(target, depth + 1)
        for instance in node.all("instance_geometry"):
            self._count(self._meshes.get(instance.attributes.get("url", "").removeprefix("#")))
        # A skin can be anywhere that its bones put it.
        self.others += sum(1 for _ in node.all("instance_controller"))

    def _count(self, geometry: XmlElement | None) -> None:
        mesh = None if geometry is None else geometry.first("mesh")
        if mesh is None:
            self.others += 1
            return
        kinds = Counter(part.name for part in mesh.children)
        self.surfaces += sum(kinds[kind] for kind in _SURFACES)
        for part in mesh.children:
            if part.name in _SURFACES:
                count = part.attributes.get("count", "0").strip()
                self._faces += int(count) if count.isdecimal() and len(count) < 10 else 0
        if self._faces > MOST_FACES:
            raise FormatError(
                "too-large",
                "has more than {most} triangles",
                "simplify it, or export a part of it",
                most=MOST_FACES,
            )
