"""Load the triangles of a mesh file, all in one frame.

trimesh reads binary files and COLLADA; this module checks its input and output, and reads texts, of
which trimesh skips what is spelled unusually.
"""

from __future__ import annotations

import base64
import importlib.util
import io
import itertools
import logging
import re
import struct
import tomllib
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh

from worldgen.errors import FormatError, WorldgenError
from worldgen.interop.account import damage, report_unread
from worldgen.interop.format.foreign_map import MAX_FILE_BYTES, read_bounded, sibling_file
from worldgen.interop.readers.collada_tree import check_collada
from worldgen.interop.readers.gltf_tree import MOST_FACES, check_gltf, gltf_json, root_extras
from worldgen.plugins.installation import pip_install
from worldgen.support.arrays import Floats, Ints
from worldgen.support.plain_text import quote

_HELD_LINE = re.compile(rb"^# (\w+ = .{1,200})$", re.MULTILINE)
# Words of an OBJ file: corners and faces, and those that only name or paint them.
_OBJ = frozenset(
    b"v vn vt f o g s mtllib usemtl usemap maplib d_interp c_interp lod shadow_obj".split()
)
_STL_SOLID = rb"^[ \t]*(end)?solid\b[^\r\n]*"
_STL_FACET = (
    rb"\bfacet\s+normal(?:\s+\S+){3}\s+outer\s+loop"
    + rb"\s+vertex\s+(\S+)\s+(\S+)\s+(\S+)" * 3
    + rb"\s+endloop\s+endfacet\b"
)
_STL_TEXT = re.compile(rb"(?im)" + _STL_SOLID + rb"|" + _STL_FACET)
_STL_FRAME = re.compile(
    rb"worldgen: m, z up; size (\d+) (\d+); "
    rb"(?:cell (\S+); origin (\S+) (\S+)|bits ([A-Za-z0-9+/]{32})) *"
)
# Largest coordinate, in the file's unit; its square is still a finite number.
_FURTHEST = 1e15


class RawMesh(NamedTuple):
    """A mesh as stored in its file.

    Args:
        up: The axis that points up by the format's convention, ``y`` or ``z``.
        vertices: (n, 3) float64, in the file's unit and axes; COLLADA's in m.
        faces: (m, 3) int64.
        held: Facts about the world in a file from worldgen, by the names of
            :data:`~worldgen.interop.format.HELD`, and ``size``; empty for other files.
    """

    up: str
    vertices: Floats
    faces: Ints
    held: dict[str, Any]


def load_mesh(path: Path, kind: str) -> RawMesh:
    """Read a mesh file.

    Args:
        path: The file.
        kind: Its format: ``glb``, ``gltf``, ``stl``, ``obj`` or ``dae``, which needs ``collada``.

    Raises:
        FormatError: If the file breaks its format's rules, is too large, or has no triangles.
    """
    data = read_bounded(path)
    # Check the file before a library reads it.
    if kind in ("glb", "gltf"):
        up = "y"
        document = gltf_json(data)
        check_gltf(document)
        held = root_extras(document)
    elif kind == "dae":
        if importlib.util.find_spec("collada") is None:
            raise FormatError(
                "missing-package",
                "is COLLADA, which needs a package",
                "{command}",
                command=pip_install("collada"),
            )
        unit, up, surfaces = check_collada(data)
        held = {}
    else:
        up = "z"
        if (kind == "obj" and b"\0" in data[:4]) or not data.strip():
            raise FormatError("empty", "holds no mesh", "use a file with triangles")
        held = _held(data, kind)
    if kind == "obj":
        vertices, faces = _obj_triangles(data)
    elif kind == "stl" and not _is_binary_stl(data):
        vertices, faces = _stl_triangles(data)
    else:
        scene = _loaded(data, kind, path)
        if kind == "dae":
            report_unread("surfaces of COLLADA", max(surfaces - len(scene.graph.nodes_geometry), 0))
        vertices, faces, left_out = _in_one_frame(scene)
        if kind == "dae":
            vertices = vertices * unit
        report_unread("parts other than surfaces, such as points and lines", left_out)
    _check_arrays(vertices, faces)
    return RawMesh(up, vertices, faces, held)


def _obj_triangles(data: bytes) -> tuple[Floats, Ints]:
    """Return the corners and triangles of an OBJ file, and report its other lines.

    trimesh silently drops faces after a tab, counts relative corners from the end of the file, and
    takes all faces for as many corners as the first line has.
    """
    places: list[float] = []
    triangles: list[tuple[int, int, int]] = []
    others: Counter[bytes] = Counter()
    plain = data.removeprefix(b"\xef\xbb\xbf").replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    with _reading("obj"):
        for line in plain.splitlines():
            words = line.partition(b"#")[0].split()
            word = words[0] if words else b""
            if word == b"v":
                if len(words) < 4:
                    raise FormatError(
                        "wrong-count", "has vertices without three coordinates", "export it again"
                    )
                places += map(_number, words[1:4])
            elif word == b"f":
                triangles += _fan(words[1:], len(places) // 3)
                _check_face_count(len(triangles))
            elif word and word not in _OBJ:
                others[word] += 1
    for word in sorted(others):
        report_unread(f"lines {quote(word, 20)}", others[word])
    if max((max(corners) for corners in triangles), default=-1) >= len(places) // 3:
        raise _no_corner()
    return (
        np.array(places, np.float64).reshape(-1, 3),
        np.array(triangles, np.int64).reshape(-1, 3),
    )


def _fan(words: list[bytes], count: int) -> Iterator[tuple[int, int, int]]:
    """Yield the triangles of a face whose corners count from 1, or back from the last vertex."""
    if len(words) < 3:
        raise FormatError("wrong-count", "has a face of fewer than 3 corners", "export it again")
    found = [int(_number(word.partition(b"/")[0], int)) for word in words]
    corners = [number - 1 if number > 0 else count + number for number in found]
    if 0 in found or min(corners) < 0:
        raise _no_corner()
    for one, other in itertools.pairwise(corners[1:]):
        yield corners[0], one, other


def _number(word: bytes, kind: Callable[[bytes], float] = float) -> float:
    # Python allows 1_000 for 1000.
    if b"_" in word:
        raise ValueError(f"{word.decode(errors='replace')} is not a number")
    return kind(word)


def _is_binary_stl(data: bytes) -> bool:
    return len(data) >= 84 and len(data) == 84 + 50 * struct.unpack_from("<I", data, 80)[0]


def _stl_triangles(data: bytes) -> tuple[Floats, Ints]:
    """Return the corners and triangles of an STL file of text, and report its other words."""
    data = data.replace(b"\r", b"\n")
    found = [*_STL_TEXT.finditer(data)]
    facets = [one.groups()[1:] for one in found if one[2] is not None]
    ends = sum(one[1] is not None for one in found)
    if 2 * ends != len(found) - len(facets):
        raise FormatError("ends-early", "has a solid without its endsolid", "export it again")
    _check_face_count(len(facets))
    with _reading("stl"):
        numbers = [_number(word) for words in facets for word in words]
    report_unread("words besides facets", len(_STL_TEXT.sub(b"", data).split()))
    # A facet in the line of a solid's name counts as its name.
    report_unread("facets", data.lower().count(b"endfacet") - len(facets))
    return np.array(numbers, np.float64).reshape(-1, 3), np.arange(3 * len(facets)).reshape(-1, 3)


def _held(data: bytes, kind: str) -> dict[str, Any]:
    """Return the facts about the world in a file that worldgen wrote.

    They are in comments, as TOML, or in the header of an STL file.
    """
    if kind == "stl":
        found = _STL_FRAME.match(data[:80])
        if found is None:
            return {}
        width, height, *decimals, bits = found.groups()
        # Numbers with too many digits for the header are stored as their bits.
        numbers = struct.unpack("<3d", base64.b64decode(bits)) if bits else map(float, decimals)
        cell, x, y = numbers
        return {"size": [int(width), int(height)], "cell_size": cell, "origin": [x, y]}
    head = data[: 1 << 14]
    if b"worldgen: m, z up" not in head[:200]:
        return {}
    try:
        return tomllib.loads(b"\n".join(_HELD_LINE.findall(head)).decode())
    except (ValueError, RecursionError):
        return {}


class _Beside(trimesh.resolvers.Resolver):
    """Opens files that the mesh file names for trimesh, only in its folder or below it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._left = MAX_FILE_BYTES

    def get(self, name: str) -> bytes:
        data = read_bounded(sibling_file(self._path, "uri", name), self._left)
        self._left -= len(data)
        return data

    __getitem__ = get

    def keys(self) -> list[str]:
        return []

    def namespaced(self, namespace: str) -> _Beside:
        return self

    def write(self, name: str, data: bytes) -> None:
        raise NotImplementedError


@contextmanager
def _quiet() -> Iterator[None]:
    """Hide a library's log and warnings from the user; truncated text is an error."""
    loggers = [logging.getLogger(name) for name in ("trimesh", "trimesh.util")]
    before = [logger.disabled for logger in loggers]
    for logger in loggers:
        logger.disabled = True
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            warnings.filterwarnings("error", message="string or file could not be read")
            yield
    finally:
        for logger, was_disabled in zip(loggers, before, strict=True):
            logger.disabled = was_disabled


@contextmanager
def _reading(kind: str) -> Iterator[None]:
    """Turn any exception inside into a fault of the file, because that is what it is."""
    try:
        yield
    except WorldgenError:
        raise
    # A damaged file can make a library raise anything.
    except Exception as error:
        raise FormatError(
            "unreadable-mesh",
            "cannot be read as {kind} ({reason})",
            "export it again, or in another format",
            kind=kind,
            reason=damage(error),
        ) from error


def _loaded(data: bytes, kind: str, path: Path) -> Any:
    """Return the scene that trimesh makes of a file."""
    with _reading(kind), _quiet():
        return trimesh.load_scene(
            io.BytesIO(data),
            file_type=kind,
            # The only other files that COLLADA names are pictures.
            resolver=None if kind == "dae" else _Beside(path),
            process=False,
            skip_materials=True,
        )


def _in_one_frame(scene: Any) -> tuple[Floats, Ints, int]:
    """Return all triangles of a scene, each instance in its place, and the number of empty ones."""
    # Collect the vertices and triangles of every part.
    places: list[Floats] = [np.zeros((0, 3))]
    triangles: list[Ints] = [np.zeros((0, 3), np.int64)]
    count = 0
    faces = 0
    left_out = 0
    matrices = _node_matrices(scene.graph)
    names = {node: name for name, nodes in scene.graph.geometry_nodes.items() for node in nodes}
    for node in scene.graph.nodes_geometry:
        matrix = matrices[node]
        part = scene.geometry[names[node]]
        if not isinstance(part, trimesh.Trimesh) or not len(part.faces):
            left_out += 1
            continue
        faces += len(part.faces)
        _check_face_count(faces)
        vertices = np.asarray(part.vertices, np.float64)
        corners = np.asarray(part.faces, np.int64)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise FormatError(
                "wrong-count", "has vertices without three coordinates", "export it again"
            )
        if corners.min() < 0 or corners.max() >= len(vertices):
            raise _no_corner()
        # Move the part into place; a mirror turns its triangles inside out.
        with np.errstate(all="ignore"):
            # Round each product and sum once, so that every machine gets the same bits.
            moved = sum(vertices[:, [axis]] * matrix[:3, axis] for axis in range(3)) + matrix[:3, 3]
            mirrored = np.linalg.det(matrix[:3, :3]) < 0
        places.append(np.asarray(moved))
        triangles.append((corners[:, ::-1] if mirrored else corners) + count)
        count += len(vertices)
    return np.concatenate(places), np.concatenate(triangles), left_out


def _node_matrices(graph: Any) -> dict[str, Floats]:
    """Return the place of every node of a scene, (4, 4), each from its parent's.

    trimesh multiplies the whole chain for each node, in time cubic in the chain's length.
    """
    inner: dict[str, list[tuple[str, Floats]]] = {}
    for parent, child, edge in graph.to_edgelist():
        matrix = np.array(edge.get("matrix", np.eye(4)), np.float64)
        inner.setdefault(parent, []).append((child, matrix))
    found = {graph.base_frame: np.eye(4)}
    waiting = [graph.base_frame]
    with np.errstate(all="ignore"):
        while waiting:
            parent = waiting.pop()
            outer = found[parent]
            for child, matrix in inner.pop(parent, ()):
                # Each product is rounded, and then the sum, so that every machine gets the same bits.
                found[child] = np.asarray(sum(outer[:, [k]] * matrix[k] for k in range(4)))
                waiting.append(child)
    return found


def _no_corner() -> FormatError:
    return FormatError("out-of-range", "has a triangle without vertices", "export it again")


def _check_face_count(count: int) -> None:
    if count > MOST_FACES:
        raise FormatError(
            "too-large",
            "has more than {most} triangles",
            "simplify it, or export a part of it",
            most=MOST_FACES,
        )


def _check_arrays(vertices: Floats, faces: Ints) -> None:
    if not len(faces):
        raise FormatError(
            "no-triangles", "has no triangles", "export surfaces, not points or lines"
        )
    used = vertices[faces.reshape(-1)]
    if not (np.isfinite(used).all() and np.abs(used).max() < _FURTHEST):
        raise FormatError(
            "not-a-number",
            "has a vertex whose coordinates are not usable numbers",
            "export it again",
        )
