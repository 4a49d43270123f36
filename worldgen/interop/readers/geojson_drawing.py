"""Read GeoJSON as a drawing: in metres, or in degrees that become metres east and north.

Source: RFC 7946, 2016; the ellipsoid is that of WGS 84.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from worldgen.errors import FormatError
from worldgen.interop.account import NamedParts, damage, parse_json
from worldgen.interop.format.foreign_map import ForeignMap, read_bounded
from worldgen.interop.geometry.drawing import DEGREES, NO_LAYER, Drawing, filled
from worldgen.interop.geometry.drawing_options import DrawingOptions
from worldgen.interop.readers.plan_facts import own_map, own_plan
from worldgen.support.plain_text import counted

_MOST_DEPTH = 16
_AXIS = 6378137.0
_SQUARED = 0.00669437999014
# Degrees; a plan in degrees is smaller, a plan in metres larger.
_LARGEST_PLAN = 0.1
# What IMDF, OpenStreetMap, our own files and others call a feature's kind.
_KINDS = (
    "layer", "Layer", "kind", "category", "feature_type", "indoor", "type", "class", "name", "level",
    "barrier", "building", "SubClasses", "room",
)  # fmt: skip
_MARKS = ("start", "target", "change")
# Properties of an edge of Nav2's route graphs.
_EDGE = frozenset(("startid", "endid"))
_LINES = frozenset(("LineString", "MultiLineString"))


def read_geojson_drawing(path: Path, options: DrawingOptions, most_bytes: int) -> ForeignMap:
    """Read features, a geometry, or a collection of them.

    Args:
        path: The file.
        options: Layers, unit and cells; the unit may also be deg.
        most_bytes: Largest file.

    Raises:
        FormatError: If it is not GeoJSON, or has no walls.
    """
    document = _parsed(read_bounded(path, most_bytes))
    own = own_plan(document.get("worldgen")) if "worldgen" in document else None
    drawing = Drawing()
    edges = 0
    try:
        for geometry, layers in _geometries(document, ()):
            if own is not None and set(layers) & {*_MARKS, "border"}:
                geometry.pass_over()
            elif (
                not options.layer
                and geometry["type"] in _LINES
                and {name.partition("=")[0] for name in layers} >= _EDGE
            ):
                geometry.pass_over()
                edges += 1
            else:
                for shape in _shapes(geometry):
                    drawing.add(shape, layers)
    except FormatError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(
            "damaged-file", "is not GeoJSON: {reason}", "save it again", reason=damage(error)
        ) from error
    if own is not None:
        return own_map(drawing, options, own)
    if edges and not drawing.parts:
        raise FormatError(
            "no-walls",
            "is a route graph of Nav2: robots drive along its {edges} edges, and it has no walls",
            "import the map that it belongs to",
            edges=edges,
        )
    if edges:
        drawing.notes.append(
            f"not walls, as robots drive along them: {counted(edges, 'edge')} of a route graph"
        )
    if not drawing.parts:
        return drawing.map(options)
    if _is_in_degrees(document, drawing, options):
        _project(drawing)
        options = replace(options, unit="")
    else:
        drawing.unit, drawing.unit_from = 1.0, "the coordinates, which are no degrees"
    return drawing.map(options)


def _parsed(data: bytes) -> NamedParts:
    try:
        document = parse_json(data.removeprefix(b"\xef\xbb\xbf"))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise FormatError(
            "not-json", "is not JSON: {reason}", "save it again", reason=str(error)[:80]
        ) from error
    except (RecursionError, ValueError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(
            "wrong-form", "is not GeoJSON: it is nested too deep", "save it again"
        ) from error
    if not isinstance(document, NamedParts) or document.get("type") not in _TYPES:
        raise FormatError(
            "unknown-format",
            "is JSON, but not GeoJSON, whose type is FeatureCollection, Feature or a geometry",
            "export it as GeoJSON",
        )
    return document


_SIMPLE = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon")
_TYPES = ("FeatureCollection", "Feature", "GeometryCollection", *_SIMPLE)


def _geometries(
    thing: Any, layers: tuple[str, ...], depth: int = 0
) -> Iterator[tuple[NamedParts, tuple[str, ...]]]:
    """Yield the geometries of a document, with the names of their features."""
    if thing is None:
        return
    if depth > _MOST_DEPTH:
        raise FormatError("nested-too-deep", "has collections nested too deep", "flatten them")
    kind = thing["type"]
    if kind == "FeatureCollection":
        for feature in thing["features"]:
            yield from _geometries(feature, layers, depth + 1)
    elif kind == "Feature":
        names = (*_names(thing), *layers)
        yield from _geometries(thing.get("geometry"), names, depth + 1)
    elif kind == "GeometryCollection":
        for part in thing["geometries"]:
            yield from _geometries(part, layers, depth + 1)
    elif kind in _SIMPLE:
        yield thing, layers
    else:
        raise FormatError(
            "unsupported",
            "has a geometry of type {kind!q}; GeoJSON has {known!l}",
            "export it as GeoJSON",
            kind=str(kind)[:40],
            known=list(_SIMPLE),
        )


def _names(feature: NamedParts) -> tuple[str, ...]:
    """Return the names by which a feature can be chosen: its kinds, and key=value of each word."""
    names = []
    properties = feature.get("properties")
    if isinstance(properties, NamedParts):
        properties.pass_over()
        plain = {
            key: str(value)[:80]
            for key, value in properties.items()
            if isinstance(value, str | int | float) and value != ""
        }
        names += [plain[key] for key in _KINDS if key in plain and not _is_number(plain[key])]
        names += [f"{key}={value}" for key, value in plain.items()]
    kind = feature.get("feature_type")
    kinds = [kind] if isinstance(kind, str) else []
    return (*(kinds or [name for name in names if "=" not in name][:1] or [NO_LAYER]), *names)


def _is_number(text: str) -> bool:
    return text.lstrip("-").replace(".", "", 1).isdigit()


def _shapes(geometry: NamedParts) -> Iterator[Any]:
    kind = geometry["type"]
    coordinates = geometry["coordinates"]
    if kind in ("Point", "MultiPoint") or not coordinates:
        # A point has no area.
        return
    for one in coordinates if kind.startswith("Multi") else [coordinates]:
        shape = _line(one) if kind.endswith("LineString") else _polygon(one)
        if shape is not None:
            yield shape


def _line(rows: Any) -> Any:
    points = _points(rows)
    return shapely.LineString(points) if len(points) > 1 else None


def _polygon(rows: Any) -> Any:
    rings = [_points(ring) for ring in rows]
    outline = filled(rings[:1], even_odd=True)
    holes = filled(rings[1:], even_odd=False)
    return outline if outline is None or holes is None else shapely.difference(outline, holes)


def _points(rows: Any) -> Any:
    points = np.array([[row[0], row[1]] for row in rows])
    if points.dtype.kind not in "iuf":
        raise ValueError("a coordinate is not a number")
    points = points.astype(np.float64).reshape(-1, 2)
    if not np.isfinite(points).all():
        raise ValueError("a coordinate is not a finite number")
    return points


def _is_in_degrees(document: NamedParts, drawing: Drawing, options: DrawingOptions) -> bool:
    """Decide whether coordinates are degrees: by the user, the file, or their size."""
    crs = json.dumps(document.get("crs"))
    if options.unit:
        return options.unit.strip().lower() == DEGREES
    if "crs" in document and ("CRS84" in crs or "4326" in crs):
        return True
    if "EPSG" in crs:
        return False
    left, low, right, high = shapely.total_bounds(np.array([part.shape for part in drawing.parts]))
    fits = -180 <= left <= right <= 180 and -90 <= low <= high <= 90
    return bool(fits and max(right - left, high - low) < _LARGEST_PLAN)


def _project(drawing: Drawing) -> None:
    """Turn degrees into metres east and north of the drawing's south-west corner."""
    shapes = np.array([part.shape for part in drawing.parts])
    left, low, right, high = shapely.total_bounds(shapes)
    if not (-180 <= left <= right <= 180 and -90 < low <= high < 90):
        raise FormatError(
            "out-of-range",
            "has coordinates beyond 180 degrees east or 90 degrees north",
            "use --unit m if they are metres",
            at_terminal=True,
        )
    middle = math.radians((low + high) / 2)
    bent = 1 - _SQUARED * math.sin(middle) ** 2
    east = math.radians(1) * _AXIS / math.sqrt(bent) * math.cos(middle)
    north = math.radians(1) * _AXIS * (1 - _SQUARED) / bent**1.5
    moved = shapely.transform(shapes, lambda xy: (xy - (left, low)) * (east, north))
    drawing.parts = [
        part._replace(shape=shape) for part, shape in zip(drawing.parts, moved, strict=True)
    ]
    drawing.unit, drawing.unit_from = 1.0, "the coordinates, which are degrees"
    drawing.notes.append(
        f"coordinates are degrees; (0, 0) is {low:.8g} north, {left:.8g} east, and the map is in "
        f"metres from there"
    )
