"""Plans as GeoJSON features: read as a drawing, and written in local metres.

Source: H. Butler et al., "The GeoJSON Format", RFC 7946, 2016. The RFC only allows degrees on the
    globe (section 4), but older readers and all drawing programs accept local coordinates, so the
    file declares that it has them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from worldgen.interop.format import PLAIN_FACTS, Destination, Exported, Format, held_values
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap
from worldgen.interop.geometry.drawing_options import DrawingOptions
from worldgen.interop.geometry.placed_boxes import GridLines
from worldgen.interop.geometry.polygons import border_cells, cell_polygons
from worldgen.support.arrays import Bools
from worldgen.world import World

# Parsed JSON takes up to about thirty times the file's size.
MAX_GEOJSON_BYTES = 32 << 20


@dataclass(frozen=True)
class GeojsonOptions(DrawingOptions):
    """Options of a plan of features.

    Args:
        layer: Names of the features that are walls, with commas between them; * and ? stand for any
            letters. A feature's names are its kind or category, and key=value of each property. If
            omitted, all features.
        unit: m, cm, mm, in, ft, a number of metres, or deg for longitude and latitude; if omitted,
            the coordinates' size decides.
    """


def read_geojson(path: Path, options: GeojsonOptions) -> ForeignMap:
    """Read features: polygons and lines are walls, points are harmless.

    Raises:
        FormatError: If it is not GeoJSON, or has no walls.
        InvalidParameter: If an option is out of range.
    """
    from worldgen.interop.geometry.drawing import geometry_errors
    from worldgen.interop.readers.geojson_drawing import read_geojson_drawing

    with geometry_errors():
        return read_geojson_drawing(path, options, MAX_GEOJSON_BYTES)


def write_geojson(world: World, destination: Destination) -> Exported:
    """Return a feature collection.

    Its features are ``walls``, ``border``, ``start``, ``target``, and a ``change`` for every event.

    Raises:
        InvalidWorld: If the coordinates need more than 64 bits.
    """
    document = {
        "type": "FeatureCollection",
        "worldgen": {"frame": "local", "units": "m", **held_values(world, destination)},
        "features": list(_features(world, destination)),
    }
    return Exported({destination.name: _text(document)})


# Names, places and properties draw nothing.
_HARMLESS = frozenset({
    "bbox", "crs", "id", "name", "properties", "worldgen", "xy_coordinate_resolution", "description",
    "copyrightText", "timeStamp", "numberReturned", "numberMatched", "generator", "copyright", "timestamp",
    "title", "creationDate", "date_generated", "created_at", "version", "metadata", "totalFeatures",
})  # fmt: skip

geojson = Format(
    "geojson",
    "walls, places and changes as features, .geojson",
    (".geojson",),
    re.compile(
        rb'(?s)\s*\{.*"type"\s*:\s*"(?:FeatureCollection|Feature|GeometryCollection|(?:Multi)?(?:Polygon|LineString))"'
    ),
    read_geojson,
    write=write_geojson,
    holds=PLAIN_FACTS,
    changes=True,
    client="QGIS, GDAL, browsers",
    usual_robot=FLOOR_ROBOT,
    most_bytes=MAX_GEOJSON_BYTES,
    harmless=_HARMLESS,
    options=GeojsonOptions,
)


def _text(document: dict[str, Any]) -> bytes:
    """Return the document with one feature per line."""
    features = document.pop("features")
    head = json.dumps(document)[:-1]
    body = ",\n".join(json.dumps(feature) for feature in features)
    return f'{head}, "features": [\n{body}\n]}}\n'.encode()


def _features(world: World, destination: Destination) -> Iterator[dict[str, Any]]:
    lines = GridLines(world, destination)
    yield _feature("walls", "MultiPolygon", _multipolygon(world.walls, lines))
    ring = border_cells(world)
    if ring.any():
        yield _feature("border", "MultiPolygon", _multipolygon(ring, lines, -1))
    start = world.start
    target = world.target
    robot = {
        "heading": start.heading,
        "robot_radius": world.robot_radius,
        "robot_speed": world.robot_speed,
    }
    yield _feature("start", "Point", _point(start.x, start.y, destination), **robot)
    yield _feature("target", "Point", _point(target.x, target.y, destination), radius=target.radius)
    for event in world.timeline:
        said = {"time": event.time, "state": event.state.word, "cell": [event.ix, event.iy]}
        yield _feature("change", "Polygon", [_square(event.ix, event.iy, lines)], **said)


def _feature(kind: str, shape: str, coordinates: list[Any], **said: object) -> dict[str, Any]:
    geometry = {"type": shape, "coordinates": coordinates}
    return {"type": "Feature", "properties": {"kind": kind, **said}, "geometry": geometry}


def _point(x: float, y: float, destination: Destination) -> list[float]:
    return [float(destination.x(x)), float(destination.y(y))]


def _square(ix: int, iy: int, lines: GridLines) -> list[list[float]]:
    corners = ((ix, iy), (ix + 1, iy), (ix + 1, iy + 1), (ix, iy + 1), (ix, iy))
    return [[float(lines.x[x]), float(lines.y[y])] for x, y in corners]


def _multipolygon(solid: Bools, lines: GridLines, first: int = 0) -> list[Any]:
    """Return the coordinates of polygons, outlines counter-clockwise and holes clockwise.

    ``first`` is the index of the first cell.
    """
    return [
        [[[float(lines.x[x]), float(lines.y[y])] for x, y in [*ring, ring[0]]] for ring in polygon]
        for polygon in cell_polygons(solid, first)
    ]
