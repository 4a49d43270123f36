"""Read 3MF: a ZIP archive with an XML model.

trimesh 5.2 reads 3MF too, with two more libraries, but its time grows with the square of the number
of parts: 4,000 parts take 2.7 s, 40,000 more than 90 s, and worldgen writes a part per wall. It
also unpacks archives without a limit.

Source: 3MF Consortium, "3D Manufacturing Format Core Specification", version 1.3, 2021.
"""

from __future__ import annotations

import io
import tomllib
import zipfile
import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from worldgen.errors import FormatError
from worldgen.interop.account import damage, report_unread
from worldgen.interop.readers.gltf_tree import MOST_FACES
from worldgen.interop.readers.xml_tree import XmlElement, read_xml
from worldgen.support.arrays import Floats, Ints

UNITS = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}
_MODEL = "3D/3dmodel.model"
# Limit on the unpacked bytes.
_MOST_XML = 256 << 20
# Deepest nesting of components.
_MOST_DEPTH = 16
# Limit on items and components, each counted as often as it is placed.
_MOST_PARTS = 200_000

Mesh = tuple[Floats, Ints]


@dataclass
class _Model:
    """The objects of a file, and how many parts and triangles it may still place."""

    objects: dict[str, XmlElement]
    meshes: dict[str, list[Mesh]] = field(default_factory=dict)
    parts: int = _MOST_PARTS
    faces: int = MOST_FACES


def read_threemf(data: bytes) -> tuple[Floats, Ints, dict[str, Any], float]:
    """Return the vertices, the triangles, the facts of a file from worldgen, and metres per unit.

    Raises:
        FormatError: If the file breaks the format's rules.
    """
    root = read_xml(_unpacked(data))
    unit = root.attributes.get("unit", "millimeter")
    if _plain(root.name) != "model" or unit not in UNITS:
        raise FormatError("wrong-structure", "has no <model> in a unit of 3MF", "export it again")
    objects = {
        element.attributes.get("id", ""): element
        for element in _children(root, "resources", "object")
        if element.attributes.get("type", "model") != "other"
    }
    found: list[Mesh] = []
    model = _Model(objects)
    try:
        for item in _children(root, "build", "item"):
            name = item.attributes.get("objectid", "")
            found += _placed(model, name, _transform(item), _MOST_DEPTH)
    except (ValueError, KeyError, IndexError, OverflowError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(
            "wrong-structure",
            "breaks the rules of 3MF ({reason})",
            "export it again",
            reason=damage(error),
        ) from error
    return (*_joined(found), _held(root), UNITS[unit])


def _unpacked(data: bytes) -> bytes:
    """Return the model's XML.

    The archive may claim any size, so only the bytes that are read are unpacked.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive, archive.open(_MODEL) as stream:
            text = stream.read(_MOST_XML + 1)
            others = [name for name in archive.namelist() if name.endswith(".model")]
            report_unread("models in the archive besides the first", len(others) - 1)
    except (
        zipfile.BadZipFile,
        zlib.error,
        KeyError,
        EOFError,
        OSError,
        RuntimeError,
        ValueError,
    ) as error:
        raise FormatError(
            "not-an-archive",
            "is not a ZIP archive that contains {model}",
            "export it again",
            model=_MODEL,
        ) from error
    if len(text) > _MOST_XML:
        raise FormatError(
            "too-large", "unpacks to more than {most} bytes", "simplify it", most=_MOST_XML
        )
    return text


def _plain(name: str) -> str:
    return name.rpartition(":")[2]


def _children(element: XmlElement, *names: str) -> list[XmlElement]:
    """Return the elements at the end of a path of names, whatever their prefixes."""
    known = dict.fromkeys(child.name for child in element.inside if _plain(child.name) == names[0])
    found = [child for name in known for child in element.all(name)]
    return (
        [deeper for child in found for deeper in _children(child, *names[1:])]
        if names[1:]
        else found
    )


def _transform(element: XmlElement) -> Floats:
    """Return a transform, (4, 3): three rows that turn and stretch, one that moves."""
    words = element.attributes.get("transform")
    if words is None:
        return np.concatenate([np.eye(3), np.zeros((1, 3))])
    return np.array(words.split(), np.float64).reshape(4, 3)


def _placed(model: _Model, name: str, transform: Floats, depth: int) -> list[Mesh]:
    """Return the meshes of an object and of its components, each in its place."""
    if depth == 0:
        raise FormatError("too-deep", "its components are nested too deeply", "export it flat")
    model.parts -= 1
    if model.parts < 0 or model.faces < 0:
        raise FormatError(
            "too-large",
            "has more than {parts} parts or {faces} triangles",
            "simplify it",
            parts=_MOST_PARTS,
            faces=MOST_FACES,
        )
    element = model.objects[name]
    if name not in model.meshes:
        model.meshes[name] = [_mesh(mesh) for mesh in _children(element, "mesh")]
    found: list[Mesh] = []
    for vertices, faces in model.meshes[name]:
        model.faces -= len(faces)
        moved = sum(vertices[:, [axis]] * transform[axis] for axis in range(3)) + transform[3]
        mirrored = np.linalg.det(transform[:3]) < 0
        found.append((np.asarray(moved), faces[:, ::-1] if mirrored else faces))
    for component in _children(element, "components", "component"):
        inner = _transform(component)
        whole = np.concatenate(
            [inner[:3] @ transform[:3], inner[3:] @ transform[:3] + transform[3]]
        )
        found += _placed(model, component.attributes["objectid"], whole, depth - 1)
    return found


def _mesh(mesh: XmlElement) -> Mesh:
    places = [
        [float(vertex.attributes[axis]) for axis in ("x", "y", "z")]
        for vertex in _children(mesh, "vertices", "vertex")
    ]
    corners = [
        [int(triangle.attributes[corner]) for corner in ("v1", "v2", "v3")]
        for triangle in _children(mesh, "triangles", "triangle")
    ]
    vertices = np.array(places, np.float64).reshape(-1, 3)
    faces = np.array(corners, np.int64).reshape(-1, 3)
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise ValueError("a triangle without vertices")
    return vertices, faces


def _joined(found: list[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in found)])
    vertices = [np.zeros((0, 3)), *(vertices for vertices, _ in found)]
    faces = [
        np.zeros((0, 3), np.int64),
        *(faces + start for (_, faces), start in zip(found, starts, strict=False)),
    ]
    return np.concatenate(vertices), np.concatenate(faces)


def _held(root: XmlElement) -> dict[str, Any]:
    """Return the facts in a file from worldgen, which are in an element of metadata, as TOML."""
    for element in _children(root, "metadata"):
        if element.attributes.get("name") == "worldgen:world":
            try:
                return tomllib.loads(element.text)
            except (ValueError, RecursionError):
                return {}
    return {}
