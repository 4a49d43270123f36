"""Check the JSON of a glTF file before a library builds the scene.

The result is a well-formed tree of bounded size. trimesh 5.2 allocates whatever an accessor claims:
a file of 400 bytes can ask for 22 GiB. It also silently drops some nodes with more than one parent.

Source: The Khronos Group, "glTF 2.0 Specification", 2021.
"""

from __future__ import annotations

import struct
from typing import Any

from worldgen.errors import FormatError
from worldgen.interop.account import NamedParts, damage, parse_json, report_unread

MOST_FACES = 5_000_000
_MOST_NODES = 200_000
_MOST_DEPTH = 200
# Limit on the numbers in all accessors together.
_MOST_VALUES = 60_000_000
_COMPRESSED = (
    "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_mesh_quantization",
)  # fmt: skip
# One mesh at many places, which only this extension lists.
_INSTANCING = "EXT_mesh_gpu_instancing"
_TRIANGLES = (4, 5, 6)
# The modes that trimesh skips: loops and strips of lines, and fans of triangles.
_SKIPPED = (2, 3, 6)
# Extensions about materials, pictures, lights and texts.
_HARMLESS = (
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_", "KHR_xmp",
    "EXT_mesh_manifold", "KHR_animation_pointer",
)  # fmt: skip
# What trimesh reads, by the name of the list, and of what an item of it has.
_READ = {
    "nodes": ("mesh", "children", "matrix", "translation", "rotation", "scale"),
    "accessors": ("bufferView", "byteOffset", "componentType", "count", "type"),
    "bufferViews": ("buffer", "byteOffset", "byteLength", "byteStride"),
    "buffers": ("uri", "byteLength"),
}
# What a glTF file has besides surfaces.
_NO_SURFACES = frozenset({
    "asset", "name", "extras", "cameras", "camera", "images", "materials", "material", "samplers", "textures",
    "accessors/max", "accessors/min", "accessors/normalized", "bufferViews/target",
    "attributes/NORMAL", "attributes/TANGENT",
    *(f"attributes/{kind}_{n}" for kind in ("TEXCOORD", "COLOR") for n in range(8)),
})  # fmt: skip
_PARTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def gltf_json(data: bytes) -> dict[str, Any]:
    """Return the document of a ``.gltf`` or ``.glb`` file.

    Raises:
        FormatError: If it is neither, or not a JSON object.
    """
    text = data
    # A binary file has its JSON in the first chunk.
    if data[:4] == b"glTF":
        if len(data) < 20:
            raise FormatError("ends-early", "ends within its header", "export it again")
        version, _, size, kind = struct.unpack_from("<III4s", data, 4)
        if version != 2 or kind != b"JSON" or 20 + size > len(data):
            raise FormatError(
                "wrong-header", "is not binary glTF 2.0 of the length it claims", "export it again"
            )
        text = data[20 : 20 + size]
        _account_for_chunks(data, 20 + size)
    try:
        document = parse_json(text, _NO_SURFACES)
    except FormatError:
        raise
    except (ValueError, RecursionError) as error:
        raise FormatError("not-json", "has no readable JSON in it", "export it again") from error
    if not isinstance(document, dict):
        raise FormatError("not-json", "is not a glTF document", "export it again")
    return document


def _account_for_chunks(data: bytes, at: int) -> None:
    """Report the chunks of a binary file after its JSON, except one of numbers for its buffer."""
    known = [b"BIN\0"]
    while at + 8 <= len(data):
        size, kind = struct.unpack_from("<I4s", data, at)
        if kind in known:
            known.remove(kind)
        else:
            report_unread("chunks of unknown content")
        at += 8 + size
    report_unread("bytes after the last chunk", max(len(data) - at, 0))


def take_surfaces(document: dict[str, Any]) -> None:
    """Take what trimesh reads of a document that :func:`check_gltf` accepts.

    The rest is unread unless it is harmless: sparse accessors, morph targets, skins, animations,
    nodes outside the scene, extensions.
    """
    for name, parts in _READ.items():
        for item in document.get(name, []):
            for part in parts:
                item.get(part)
    for mesh in document.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            mode = primitive.get("mode", 4)
            primitive.get("indices")
            primitive.get("attributes").get("POSITION")
            report_unread("parts of lines, or of fans of triangles", mode in _SKIPPED)
            # Data of the user's own.
            for name in [name for name in primitive["attributes"] if name.startswith("_")]:
                primitive["attributes"].get(name)
    _take_scene(document)
    _take_extensions(document)


def _take_scene(document: dict[str, Any]) -> None:
    """Take the one scene that is shown, and report meshes that are not in it."""
    nodes = document.get("nodes", [])
    scenes = document.get("scenes")
    if not scenes:
        report_unread("nodes outside any scene", sum("mesh" in node for node in nodes))
        return
    waiting = list(scenes[document.get("scene", 0)].get("nodes", []))
    shown = set(waiting)
    while waiting:
        inner = nodes[waiting.pop()].get("children", [])
        shown.update(inner)
        waiting += inner
    hidden = [node for number, node in enumerate(nodes) if number not in shown and "mesh" in node]
    report_unread("nodes outside the scene", len(hidden))
    for other in scenes:
        other.pass_over()


def _take_extensions(part: Any) -> None:
    """Take all lists and tables of extensions, and report those that might be obstacles."""
    waiting = [part]
    strange: set[str] = set()
    while waiting:
        part = waiting.pop()
        if isinstance(part, list):
            waiting += [item for item in part if isinstance(item, NamedParts | list)]
        elif isinstance(part, NamedParts):
            waiting += [part.peek(name) for name in part if name not in ("extensions", "extras")]
            for key in ("extensions", "extensionsUsed", "extensionsRequired"):
                if key in part:
                    strange.update(name for name in part.get(key) if not name.startswith(_HARMLESS))
            if isinstance(part.peek("extensions"), NamedParts):
                part["extensions"].pass_over()
    for name in sorted(strange):
        report_unread(f"extensions {name}")


def check_gltf(document: dict[str, Any]) -> None:
    """Reject what a reader would choke on or misread.

    Raises:
        FormatError: If the nodes are not trees, there is too much of anything, or the triangles are
            compressed.
    """
    try:
        _check_extensions(document)
        _check_sizes(document)
        _check_nodes(document)
        take_surfaces(document)
    except (TypeError, KeyError, IndexError, AttributeError, ValueError, OverflowError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(
            "wrong-structure",
            "breaks the rules of glTF 2.0 ({reason})",
            "export it again; glTF-Validator reports where",
            reason=damage(error),
        ) from error


def _check_extensions(document: dict[str, Any]) -> None:
    named = [*document.get("extensionsUsed", []), *document.get("extensionsRequired", [])]
    if _INSTANCING in named:
        raise FormatError(
            "instanced",
            "needs {extension}, which is not supported",
            "export it without instancing, so that each copy of a mesh has its own node",
            extension=_INSTANCING,
        )
    used = sorted({name for name in named if name in _COMPRESSED})
    if used:
        raise FormatError(
            "compressed",
            "needs {extensions!l}, which is not supported",
            "export it without compression",
            extensions=used,
        )


def _check_sizes(document: dict[str, Any]) -> None:
    values = 0
    for accessor in document.get("accessors", []):
        count = accessor["count"]
        if not isinstance(count, int) or count < 0:
            raise ValueError(f"a count of {count!r}"[:60])
        values += count * _PARTS.get(accessor.get("type"), 1)
    if values > _MOST_VALUES or len(document.get("nodes", [])) > _MOST_NODES:
        raise FormatError("too-large", "holds more than the limit", "export a smaller part of it")


def _check_nodes(document: dict[str, Any]) -> None:
    """Check that each node has at most one parent and is not its own ancestor.

    An instance counts each time it is placed.
    """
    # Each node may have one parent.
    nodes = document.get("nodes", [])
    parent = [-1] * len(nodes)
    for number, node in enumerate(nodes):
        for child in node.get("children", []):
            if not isinstance(child, int) or not 0 <= child < len(nodes) or parent[child] >= 0:
                raise FormatError(
                    "no-tree",
                    "node {node} is not a valid child node in glTF",
                    "export it again",
                    node=child,
                )
            parent[child] = number

    # Visit each level once, starting at the roots; a node that is never met is in a cycle.
    level = [number for number in range(len(nodes)) if parent[number] < 0]
    met = 0
    depth = 0
    while level:
        met += len(level)
        depth += 1
        level = [child for number in level for child in nodes[number].get("children", [])]
    if met < len(nodes):
        raise FormatError("no-tree", "its nodes form a cycle", "export it again")
    if depth > _MOST_DEPTH:
        raise FormatError(
            "too-deep",
            "its nodes are {depth} levels deep; the limit is {most}",
            depth=depth,
            most=_MOST_DEPTH,
        )

    # Bound the number of triangles, counting every instance.
    sizes = [_faces(document, mesh) for mesh in document.get("meshes", [])]
    total = sum(sizes[node["mesh"]] for node in nodes if "mesh" in node)
    if total > MOST_FACES:
        raise FormatError(
            "too-large",
            "has {faces} triangles; the limit is {most}",
            "simplify it, or export a part of it",
            faces=total,
            most=MOST_FACES,
        )


def _faces(document: dict[str, Any], mesh: dict[str, Any]) -> int:
    count = 0
    for primitive in mesh.get("primitives", []):
        if primitive.get("mode", 4) in _TRIANGLES:
            accessor = primitive.get("indices", primitive["attributes"].get("POSITION"))
            count += document["accessors"][accessor]["count"] // (
                3 if primitive.get("mode", 4) == _TRIANGLES[0] else 1
            )
    return count


def root_extras(document: dict[str, Any]) -> dict[str, Any]:
    """Return the facts about the world in one of our own files; nothing for other files."""
    for node in document.get("nodes", []):
        extras = node.get("extras")
        if node.get("name") == "worldgen" and isinstance(extras, dict):
            return _joined(extras)
    return {}


def _joined(extras: dict[str, Any]) -> dict[str, Any]:
    """Join the two numbers of each point."""
    joined = {name: value for name, value in extras.items() if name[-2:] not in ("_x", "_y")}
    for name, value in extras.items():
        if name.endswith("_x") and f"{name[:-2]}_y" in extras:
            joined[name[:-2]] = [value, extras[f"{name[:-2]}_y"]]
    return joined
