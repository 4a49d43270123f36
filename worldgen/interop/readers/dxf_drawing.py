"""Read DXF as a drawing, by ezdxf: lines are walls, and so is what is filled.

A closed line encloses an area but does not fill it: a room is drawn like a column. Layers that are
off or frozen, paper space, texts and dimensions show no obstacle.

Source: Autodesk, "DXF Reference"; ezdxf reads the file and computes curves.
"""

from __future__ import annotations

import io
import logging
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

from worldgen.errors import FormatError
from worldgen.interop.account import report_unread
from worldgen.interop.format.foreign_map import ForeignMap, read_bounded
from worldgen.interop.geometry.drawing import (
    TURN,
    Drawing,
    arc_points,
    check_crossings,
    filled,
    finite,
    too_large,
)
from worldgen.interop.geometry.drawing_options import DrawingOptions
from worldgen.support.arrays import Floats
from worldgen.support.plain_text import quote

# $INSUNITS, m.
_UNITS = {
    1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 8: 0.0254e-6, 9: 0.0254e-3, 10: 0.9144,
    11: 1e-10, 12: 1e-9, 13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0, 17: 1e9, 21: 1200 / 3937,
}  # fmt: skip
_UNIT_NAMES = {1: "inches", 2: "feet", 4: "millimetres", 5: "centimetres", 6: "metres", 10: "yards"}
_ANNOTATIONS = frozenset({
    "TEXT", "MTEXT", "ATTRIB", "ATTDEF", "ARCALIGNEDTEXT", "RTEXT", "DIMENSION", "ARC_DIMENSION",
    "LARGE_RADIAL_DIMENSION", "LEADER", "MLEADER", "MULTILEADER", "TOLERANCE", "ACAD_TABLE",
})  # fmt: skip
# They draw nothing in a plan.
_HARMLESS = frozenset(
    {"POINT", "VIEWPORT", "SEQEND", "LIGHT", "SUN", "CAMERA", "SECTION", "OLEFRAME"}
)
_CURVES = frozenset({"LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "HELIX"})
_SURFACES = frozenset({"SOLID", "TRACE", "3DFACE"})
_MOST_DEPTH = 24
_MOST_COPIES = 400_000
# What ezdxf raises for values that a program should not have written.
_DAMAGE = (ArithmeticError, AttributeError, LookupError, TypeError, StopIteration, ValueError)
# Points of a spline; ezdxf divides each of its spans in at least as many.
_MOST_SPLINE = 20_000


class _Drawn(NamedTuple):
    """A shape in the coordinates of its block, and its layer; None is the layer of the insert."""

    shape: Any
    layer: str | None


class _Blocks:
    """The shapes of a document, block by block."""

    def __init__(self, document: Any, drawing: Drawing) -> None:
        self.document = document
        self.drawing = drawing
        self.copies = 0
        self.annotations = 0
        self.hidden = 0
        self._blocks: dict[str, list[_Drawn]] = {}
        self._open: list[str] = []
        self._off = {
            layer.dxf.name.lower(): layer.is_frozen() for layer in document.layers
            if layer.is_off() or layer.is_frozen()
        }  # fmt: skip

    def shapes(self, entities: Iterable[Any]) -> Iterator[_Drawn]:
        """Yield the shapes of entities."""
        for entity in entities:
            kind = entity.dxftype()
            name = _layer_of(entity)
            layer = None if name == "0" and self._open else name
            if _has(entity, "invisible") or _has(entity, "paperspace"):
                self.hidden += 1
            elif kind in _ANNOTATIONS:
                self.annotations += 1
            elif kind in _HARMLESS:
                pass
            elif kind == "INSERT":
                yield from self._insert(entity, layer)
            elif layer is not None and layer.lower() in self._off:
                self.hidden += 1
            else:
                for shape in self._read(entity, kind, name):
                    if shape is not None:
                        yield _Drawn(shape, layer)

    def _read(self, entity: Any, kind: str, layer: str) -> Iterator[Any]:
        from ezdxf.lldxf.const import DXFError

        read = _READERS.get(kind)
        if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
            kind, read = "POLYLINE (a mesh)", None
        if read is None:
            self.drawing.unread(f"objects of kind {quote(kind, 30)}", (layer,))
            return
        try:
            yield from read(entity)
        except FormatError:
            raise
        except (DXFError, *_DAMAGE):
            self.drawing.unread(f"objects of kind {kind} that are damaged", (layer,))

    def _insert(self, insert: Any, layer: str | None) -> Iterator[_Drawn]:
        """Yield the shapes of a block where it is inserted."""
        name = str(insert.dxf.get("name", ""))
        if layer is not None and self._off.get(layer.lower()):
            # A frozen insert is hidden with all that is in it.
            self.hidden += 1
            return
        block = self.document.blocks.get(name)
        if block is None:
            self.drawing.unread("inserts of blocks that are not in the file", (layer or "0",))
            return
        if block.block is not None and block.block.dxf.get("flags", 0) & 12:
            self.drawing.unread("references to other files", (layer or "0",))
            return
        if insert.has_extension_dict and "ACAD_FILTER" in insert.get_extension_dict():
            self.drawing.unread("clips of blocks", (layer or "0",))
        shapes = self._block(name, block)
        rows, columns = (
            max(int(insert.dxf.get(key, 1)), 1) for key in ("row_count", "column_count")
        )
        if rows * columns * max(len(shapes), 1) > _MOST_COPIES:
            raise too_large()
        for row in range(rows):
            for column in range(columns):
                shift = (
                    column * insert.dxf.get("column_spacing", 0.0),
                    row * insert.dxf.get("row_spacing", 0.0),
                )
                yield from self._copies(insert, layer, shapes, shift, block.block)

    def _copies(
        self,
        insert: Any,
        layer: str | None,
        shapes: list[_Drawn],
        shift: tuple[float, float],
        block: Any,
    ) -> Iterator[_Drawn]:
        self.copies += len(shapes)
        if self.copies > _MOST_COPIES:
            raise too_large()
        if not shapes:
            return
        matrix = _insert_matrix(insert, block, shift)
        finite(matrix)
        moved = shapely.transform(
            np.array([drawn.shape for drawn in shapes], object),
            lambda xy: xy @ matrix[:2, :2] + matrix[2, :2],
        )
        hides = layer is not None and layer.lower() in self._off
        for shape, drawn in zip(moved, shapes, strict=True):
            if drawn.layer is None and hides:
                self.hidden += 1
            else:
                yield _Drawn(shape, drawn.layer or layer)

    def _block(self, name: str, block: Any) -> list[_Drawn]:
        if name not in self._blocks:
            if name in self._open or len(self._open) > _MOST_DEPTH:
                raise FormatError(
                    "nested-too-deep",
                    "block {name!q} is inserted into itself, or blocks are nested deeper than {most}",
                    "explode it",
                    name=name[:40],
                    most=_MOST_DEPTH,
                )
            self._open.append(name)
            found: list[_Drawn] = []
            for drawn in self.shapes(block):
                found.append(drawn)
                if len(found) > _MOST_COPIES:
                    raise too_large()
            self._open.pop()
            self._blocks[name] = found
        return self._blocks[name]


def _layer_of(entity: Any) -> str:
    """Return the layer of an entity, also of one of an unknown kind."""
    if entity.dxf.is_supported("layer"):
        return str(entity.dxf.get("layer", "0"))
    tags = (tag for part in entity.xtags.subclasses for tag in part)
    return next((str(tag.value) for tag in tags if tag.code == 8), "0")


def _has(entity: Any, flag: str) -> bool:
    return bool(entity.dxf.is_supported(flag) and entity.dxf.get(flag, 0))


def _insert_matrix(insert: Any, block: Any, shift: tuple[float, float]) -> Floats:
    """Return the transform of a block's x and y, as a matrix for rows (x, y, 1)."""
    base = block.dxf.get("base_point", (0, 0, 0)) if block is not None else (0, 0, 0)
    sx, sy = (float(insert.dxf.get(key, 1.0)) or 1.0 for key in ("xscale", "yscale"))
    turn = math.radians(float(insert.dxf.get("rotation", 0.0)))
    quarters = float(insert.dxf.get("rotation", 0.0)) / 90.0
    cos, sin = math.cos(turn), math.sin(turn)
    if quarters.is_integer():
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
    matrix = np.array([[sx * cos, sx * sin], [-sy * sin, sy * cos]])
    at = np.array([float(value) for value in insert.dxf.get("insert", (0, 0, 0))][:2])
    at = at + np.array([shift[0] * cos - shift[1] * sin, shift[0] * sin + shift[1] * cos])
    offset = at - np.array([float(base[0]), float(base[1])]) @ matrix
    z = float(insert.dxf.get("extrusion", (0, 0, 1))[2])
    if z < 0:
        # A block that is seen from below is mirrored.
        flip = np.array([-1.0, 1.0])
        matrix, offset = matrix * flip, offset * flip
    return np.vstack([matrix, offset])


# Entities


def _curve(entity: Any) -> Iterator[Any]:
    kind = entity.dxftype()
    if kind in ("CIRCLE", "ARC"):
        begin, end = (
            (0.0, 360.0) if kind == "CIRCLE" else (entity.dxf.start_angle, entity.dxf.end_angle)
        )
        sweep = (end - begin) % 360.0 or 360.0
        points = arc_points(
            (float(entity.dxf.center[0]), float(entity.dxf.center[1])),
            (abs(float(entity.dxf.radius)),) * 2,
            0.0,
            math.radians(begin),
            math.radians(sweep),
        )
        yield _line(_seen(points, entity), is_closed=kind == "CIRCLE")
        return
    if kind == "LINE":
        yield _line([tuple(entity.dxf.start)[:2], tuple(entity.dxf.end)[:2]])
        return
    from ezdxf import path

    yield _line(_flat(path.make_path(entity)))


def _seen(points: Floats, entity: Any) -> Floats:
    """Return points of an entity's own plane as seen from above."""
    z = float(entity.dxf.get("extrusion", (0, 0, 1))[2])
    return points * np.array([-1.0, 1.0]) if z < 0 else points


def _flat(one: Any) -> Floats:
    """Return the points of a path of ezdxf, to a share of its own size."""
    size = 0.0
    ends = np.array([tuple(point)[:2] for point in one.control_vertices()])
    if len(ends) > _MOST_SPLINE:
        raise too_large()
    if len(ends):
        size = float(np.ptp(ends, axis=0).max())
    if not math.isfinite(size):
        raise ValueError("not finite")
    points = [
        tuple(point)[:2] for point in one.flattening(max(size / (4 * TURN**1.5), 1e-9), TURN // 16)
    ]
    return np.array(points, np.float64).reshape(-1, 2)


def _line(points: Any, *, is_closed: bool = False) -> Any:
    rows = finite(np.asarray(points, np.float64).reshape(-1, 2))
    if len(rows) < 2:
        return None
    if is_closed:
        rows = np.vstack([rows, rows[:1]])
    return shapely.LineString(rows)


def _polyline(entity: Any) -> Iterator[Any]:
    """Yield a polyline with its bulges and widths."""
    if entity.dxftype() == "POLYLINE" and (entity.is_3d_polyline or entity.dxf.flags & 6):
        from ezdxf import path

        # In space, or with a curve through its corners.
        yield _line(_flat(path.make_path(entity)))
        return
    rows = np.array(_vertices(entity), np.float64).reshape(-1, 5)
    is_closed = bool(entity.is_closed if entity.dxftype() == "POLYLINE" else entity.closed)
    if len(rows) < 2:
        return
    corners = [rows[:1, :2]]
    widths: list[Any] = [np.zeros((1, 2))]
    for at in range(len(rows) if is_closed else len(rows) - 1):
        here, there = rows[at], rows[(at + 1) % len(rows)]
        points = _bulged(here[:2], there[:2], here[4])
        corners.append(points)
        share = np.arange(1, len(points) + 1) / len(points)
        through = here[2] + (here[3] - here[2]) * share
        widths.append(np.stack([through - (here[3] - here[2]) / len(points), through], axis=1))
    line = finite(_seen(np.vstack(corners), entity))
    width = np.vstack(widths)[1:]
    if not width.any():
        yield shapely.LineString(line)
    elif np.ptp(width) == 0:
        shape = (
            shapely.LinearRing(line[:-1])
            if is_closed and len(line) > 3
            else shapely.LineString(line)
        )
        check_crossings([shape])
        yield shapely.buffer(shape, width[0, 0] / 2, cap_style="flat", join_style="mitre")
    else:
        yield from _tapered(line, width)


def _vertices(entity: Any) -> list[Any]:
    """Return x, y, width at its begin and end, and bulge of each vertex."""
    if entity.dxftype() == "LWPOLYLINE":
        whole = float(entity.dxf.get("const_width", 0.0))
        rows = [list(row) for row in entity.get_points("xyseb")]
        return [[x, y, s or whole, e or whole, b] for x, y, s, e, b in rows]
    begin, end = (
        float(entity.dxf.get(key, 0.0)) for key in ("default_start_width", "default_end_width")
    )
    return [
        [
            vertex.dxf.location[0], vertex.dxf.location[1], vertex.dxf.get("start_width", begin),
            vertex.dxf.get("end_width", end), vertex.dxf.get("bulge", 0.0),
        ]
        for vertex in entity.vertices if not vertex.dxf.get("flags", 0) & 16
    ]  # fmt: skip


def _bulged(begin: Floats, end: Floats, bulge: float) -> Floats:
    """Return the points after the first of a segment; the bulge is tan(angle / 4)."""
    if bulge == 0.0 or (begin == end).all():
        return end[None, :]
    angle = 4 * math.atan(bulge)
    chord = end - begin
    radius = math.hypot(*chord) / (2 * math.sin(angle / 2))
    normal = np.array([-chord[1], chord[0]]) / math.hypot(*chord)
    centre = (begin + end) / 2 + normal * radius * math.cos(angle / 2)
    first = math.atan2(*(begin - centre)[::-1])
    points = arc_points((centre[0], centre[1]), (abs(radius),) * 2, 0.0, first, angle)
    points[-1] = end
    return points[1:]


def _tapered(line: Floats, width: Floats) -> Iterator[Any]:
    for at in range(len(line) - 1):
        along = line[at + 1] - line[at]
        length = math.hypot(*along)
        if length == 0 or not width[at].any():
            continue
        side = np.array([-along[1], along[0]]) / length / 2
        begin, end = side * width[at, 0], side * width[at, 1]
        area = filled(
            [
                np.array(
                    [line[at] + begin, line[at + 1] + end, line[at + 1] - end, line[at] - begin]
                )
            ],
            even_odd=True,
        )
        if area is not None:
            yield area


def _surface(entity: Any) -> Iterator[Any]:
    corners = [tuple(entity.dxf.get(f"vtx{at}", entity.dxf.get("vtx2")))[:2] for at in range(4)]
    if entity.dxftype() != "3DFACE":
        # The third and fourth corners of a solid are crossed.
        corners = [corners[0], corners[1], corners[3], corners[2]]
    points = np.array(corners, np.float64)
    if entity.dxftype() != "3DFACE":
        points = _seen(points, entity)
    area = filled([points], even_odd=False)
    yield _line(points, is_closed=True) if area is None else area


def _hatch(entity: Any) -> Iterator[Any]:
    from ezdxf import path

    rings = [_flat(one) for one in path.from_hatch(entity)]
    yield filled([ring for ring in rings if len(ring) > 2], even_odd=True)


def _parts(entity: Any) -> Iterator[Any]:
    """Yield the lines of an entity that is made of others."""
    for part in entity.virtual_entities():
        read = _READERS.get(part.dxftype())
        if read is not None and read is not _parts:
            yield from read(part)


_READERS: dict[str, Callable[[Any], Iterator[Any]]] = {
    **dict.fromkeys(_CURVES, _curve),
    **dict.fromkeys(_SURFACES, _surface),
    "LWPOLYLINE": _polyline,
    "POLYLINE": _polyline,
    "HATCH": _hatch,
    "MPOLYGON": _hatch,
    "MLINE": _parts,
}


def read_dxf_drawing(path: Path, options: DrawingOptions, most_bytes: int) -> ForeignMap:
    """Read a DXF file, as text or binary.

    Args:
        path: The file.
        options: Layers, unit and cells.
        most_bytes: Largest file.

    Raises:
        FormatError: If ezdxf is missing, or it is not DXF, or has no walls.
    """
    document, repairs = _document(read_bounded(path, most_bytes))
    report_unread("repairs that removed or changed damaged objects", repairs)
    drawing = Drawing(guesses=(1.0, 0.001))
    number = int(document.header.get("$INSUNITS", 0))
    if number in _UNITS:
        drawing.unit = _UNITS[number]
        drawing.unit_from = f"$INSUNITS, which is {_UNIT_NAMES.get(number, number)}"
    blocks = _Blocks(document, drawing)
    for drawn in blocks.shapes(document.modelspace()):
        drawing.add(drawn.shape, (drawn.layer or "0",))
    others = sum(1 for layout in document.layouts if layout.is_any_paperspace and len(layout))
    said = Counter(
        {
            "texts and dimensions": blocks.annotations,
            "objects that are hidden, or on layers that are off or frozen": blocks.hidden,
            "sheets of paper space": others,
        }
    )
    words = [f"{what} ({count})" for what, count in said.items() if count]
    if words:
        drawing.notes.append(f"not obstacles: {', '.join(words)}")
    return drawing.map(options)


def _document(data: bytes) -> tuple[Any, int]:
    """Return the document, and the number of repairs that it needed."""
    try:
        from ezdxf import recover
        from ezdxf.document import Drawing as Document
        from ezdxf.filemanagement import dxf_stream_info
        from ezdxf.lldxf.const import DXFError
        from ezdxf.lldxf.tagger import binary_tags_loader
    except ImportError as error:
        raise FormatError(
            "missing-package",
            "DXF is read by ezdxf, which is not installed",
            "python -m pip install 'worldgen[dxf]'",
        ) from error
    if data[:2] == b"AC" and data[:6].isalnum() and b"SECTION" not in data[:200]:
        raise FormatError("unsupported", "is DWG, not DXF", "save it as DXF in the CAD program")
    if b"SECTION" not in data and not data.startswith(b"AutoCAD Binary DXF"):
        raise FormatError("not-dxf", "is not DXF: it has no SECTION", "save it as DXF again")
    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    try:
        if data.startswith(b"AutoCAD Binary DXF"):
            return Document.load(binary_tags_loader(data)), 0
        try:
            info = dxf_stream_info(_lines(data, "utf-8"))
            return Document.read(_lines(data, info.encoding)), 0
        except (DXFError, *_DAMAGE):
            # This removes what is damaged.
            document, repairs = recover.read(io.BytesIO(data))
            return document, len(repairs.errors) + len(repairs.fixes)
    except (DXFError, OSError, *_DAMAGE, RecursionError) as error:
        raise FormatError(
            "not-dxf",
            "is not DXF: {reason}",
            "save it as DXF again, R2000 or later",
            reason=" ".join(str(error).split())[:80] or type(error).__name__,
        ) from error


def _lines(data: bytes, encoding: str) -> io.StringIO:
    """Return a file's text, also that with the ends of lines of Windows, as ``open`` does."""
    return io.StringIO(data.decode(encoding, "surrogateescape"), newline=None)
