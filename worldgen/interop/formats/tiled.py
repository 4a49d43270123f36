"""Tiled's maps as JSON (``.tmj``): a layer of tiles for the walls, start and target as objects.

Source: the documentation of Tiled, "JSON Map Format" and "Global Tile IDs".
"""

from __future__ import annotations

import base64
import json
import math
import re
import zlib
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from worldgen.domain import CELL_SIZES
from worldgen.errors import Note
from worldgen.family import check_between
from worldgen.interop.format import PLAIN_FACTS, Destination, Exported, Format
from worldgen.interop.format.foreign_map import GRID_AGENT, ForeignMap, ForeignRobot, read_bounded
from worldgen.interop.readers.grey_image import png_bytes
from worldgen.interop.readers.tiled_parts import (
    TiledLayer,
    TiledPart,
    all_layers,
    checked_number,
    first_object,
    numbers_of,
    parse_tiled,
)
from worldgen.lattice import exact, in_cells
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

if TYPE_CHECKING:
    from worldgen.interop.readers.tiled_walls import TiledWalls

# A side of a tile.
_PIXELS = 16
# Parsed JSON takes up to about thirty times the file's size.
_MOST_BYTES = 16 << 20
# Limit on cells written as numbers; a longer list would take megabytes.
_MOST_LISTED = 1_000_000
_STARTS = ("start", "spawn", "robot")
_TARGETS = ("target", "goal", "end", "finish")
# Pixels and degrees: a smaller change comes from another program's rounding, not from an edit.
_MOVED = 1e-3


def read_tiled(
    path: Path, *, layer: str = "", free: str = "", cell_size: float = 0.0, detail: int = 1
) -> ForeignMap:
    """Read a map of square tiles, with layers of tiles and of objects.

    A cell is solid if a layer of walls has a tile there, or if an object or a shape with which a
    tile collides reaches into it. The start is an object called start, spawn or robot; the target
    is one called target, goal, end or finish.

    Args:
        path: The file, JSON or XML; its tiles are numbers or base64, optionally packed.
        layer: Names of the layers of walls, with commas between them; * stands for any letters. If
            omitted, those whose name, class or property is walls, solid, collision or the like;
            otherwise the only tile layer.
        free: Names of layers that are no walls, such as doors, in the same form.
        cell_size: Side of a tile, m; 0 means the map's own, otherwise 0.1.
        detail: Number of cells along a tile's side, for objects smaller than tiles.

    Raises:
        FormatError: If it is not such a map, or its layers of walls are ambiguous.
        InvalidParameter: If an option is out of range.
    """
    from worldgen.interop.readers.tiled_walls import TiledWalls

    # Parse the map, and find the walls.
    check_between("detail", detail, 1, 64)
    parsed = parse_tiled(read_bounded(path, _MOST_BYTES))
    layers = all_layers(parsed)
    found = TiledWalls(parsed, layers, path, layer, free, (*_STARTS, *_TARGETS))
    walls = found.solid(detail)
    # The map may have its own scale.
    said = numbers_of(parsed)
    size = cell_size or said.get("cell_size") or DEFAULT_CELL_SIZE
    check_between("cell_size", size / detail, *CELL_SIZES, "m")
    notes: list[str] = [*_walls_notes(found), *dict.fromkeys(found.notes)]
    if not cell_size and "cell_size" not in said:
        notes.append(
            Note(
                "no-scale",
                "the map has no scale; a tile counts as {cell_size:g} m",
                "--cell-size says another",
                at_terminal=True,
                cell_size=size,
            )
        )
    # Find the start and the target among the objects.
    scale = exact(size) / checked_number(parsed, "tilewidth")
    left, top = (tiles * exact(size) for tiles in found.shift)
    frame = _Frame(scale, left, top + found.height * exact(size))
    start = first_object(layers, _STARTS)
    target = first_object(layers, _TARGETS)
    robot = ForeignRobot(
        None if start is None else _start(*start, frame),
        None if target is None else _target(*target, frame),
        _above_0(said, "robot_radius"),
        _above_0(said, "robot_speed"),
    )
    params: dict[str, Value] = {"layer": ",".join(found.used)} if found.used else {}
    if detail > 1:
        params["detail"] = detail
    return ForeignMap(
        walls, float(exact(size) / detail), params, tuple(notes), _warnings(walls),
        robots=(robot,), origin=(said.get("origin_x", 0.0), said.get("origin_y", 0.0)),
    )  # fmt: skip


class _Frame(NamedTuple):
    """How pixels become metres: the size of one, and the place of the map's upper left corner."""

    scale: Fraction
    left: Fraction
    top: Fraction


def _walls_notes(found: TiledWalls) -> Iterator[str]:
    if found.used:
        names = ", ".join(map(repr, found.used))
        which = "layer" if len(found.used) == 1 else "layers"
        verb = "has" if len(found.used) == 1 else "have"
        what = "tiles or objects" if found.shapes else "a tile"
        yield f"solid is where {which} {names} {verb} {what}"
    else:
        yield "solid is where tiles or objects say that they collide"


def _warnings(walls: np.ndarray[Any, Any]) -> tuple[str, ...]:
    if walls.all():
        return (
            "every cell has a tile, so all are solid; if floors are tiles too, put the walls into a "
            "layer of their own and name it with --layer, or give the tiles that collide a shape in "
            "Tiled's collision editor",
        )
    return ()


def _above_0(said: Mapping[str, float], name: str) -> float | None:
    value = said.get(name)
    return value if value is not None and value > 0.0 else None


def _start(part: TiledPart, layer: TiledLayer, frame: _Frame) -> tuple[float, ...]:
    """Return the pose in the object's properties, unless it has been moved since."""
    shape = numbers_of(part, "x", "y", "width", "height", "rotation")
    said = numbers_of(part)
    heading = said.get("heading", 0.0)
    turned = shape.get("rotation", 0.0) + math.degrees(heading)
    if abs(math.remainder(turned, 360.0)) > _MOVED:
        heading = math.radians(math.remainder(-shape.get("rotation", 0.0), 360.0))
    return (*_point(shape, said, layer, frame), heading)


def _target(part: TiledPart, layer: TiledLayer, frame: _Frame) -> tuple[float, ...]:
    """Return the place and the radius in the same way; a point has no radius."""
    shape = numbers_of(part, "x", "y", "width", "height")
    said = numbers_of(part)
    centre = _point(shape, said, layer, frame)
    drawn = (exact(shape.get("width", 0.0)) + exact(shape.get("height", 0.0))) / 4
    radius = said.get("radius", 0.0)
    if abs(float(exact(radius) / frame.scale - drawn)) > _MOVED:
        radius = float(drawn * frame.scale)
    return (*centre, radius) if radius > 0.0 else centre


def _point(
    shape: Mapping[str, float], said: Mapping[str, float], layer: TiledLayer, frame: _Frame
) -> tuple[float, float]:
    """Return the centre of an object, m from the grid's lower-left corner, y up.

    In the file, pixels count down from the top.
    """
    x, y = (
        exact(shape.get(at, 0.0)) + exact(shape.get(by, 0.0)) / 2 + exact(shift)
        for at, by, shift in zip(("x", "y"), ("width", "height"), layer.shift, strict=True)
    )
    point = float(x * frame.scale - frame.left), float(frame.top - y * frame.scale)
    exactly = said.get("x", math.inf), said.get("y", math.inf)
    moved = max(abs(now - then) for now, then in zip(point, exactly, strict=True))
    return point if moved > _MOVED * float(frame.scale) else exactly


def write_tiled(world: World, destination: Destination) -> Exported:
    """Return a map with a layer of tiles and one of objects, and the picture of its one tile."""
    picture = destination.sibling_file("-tile.png")
    made = {
        "compressionlevel": -1, "height": world.height, "infinite": False,
        "layers": [_wall_layer(world), _object_layer(world)],
        "nextlayerid": 3, "nextobjectid": 3, "orientation": "orthogonal",
        "properties": _properties(
            cell_size=world.cell_size, origin_x=destination.origin[0], origin_y=destination.origin[1],
            robot_radius=world.robot_radius, robot_speed=world.robot_speed,
        ),
        "renderorder": "right-down", "tiledversion": "1.8.2", "tileheight": _PIXELS,
        "tilesets": [{
            "columns": 1, "firstgid": 1, "image": picture, "imageheight": _PIXELS, "imagewidth": _PIXELS, "margin": 0,
            "name": "walls", "spacing": 0, "tilecount": 1, "tileheight": _PIXELS, "tilewidth": _PIXELS,
        }],
        "tilewidth": _PIXELS, "type": "map", "version": "1.8", "width": world.width,
    }  # fmt: skip
    text = json.dumps(made, indent=1, allow_nan=False)
    rows = flip_rows(world.walls).astype(int).tolist() if world.walls.size <= _MOST_LISTED else []
    text = text.replace('"@rows"', "[" + ",\n".join(json.dumps(row)[1:-1] for row in rows) + "]", 1)
    files = {destination.name: (text + "\n").encode()}
    files[picture] = png_bytes(np.full((_PIXELS, _PIXELS), 60, np.uint8))
    return Exported(files)


def _wall_layer(world: World) -> dict[str, object]:
    data: dict[str, object] = {"data": "@rows"}
    if world.walls.size > _MOST_LISTED:
        packed = zlib.compress(flip_rows(world.walls).astype("<u4").tobytes())
        data = {
            "compression": "zlib",
            "data": base64.b64encode(packed).decode(),
            "encoding": "base64",
        }
    return {
        **data, "height": world.height, "id": 1, "name": "walls", "opacity": 1, "type": "tilelayer",
        "visible": True, "width": world.width, "x": 0, "y": 0,
    }  # fmt: skip


def _object_layer(world: World) -> dict[str, object]:
    start = world.start
    target = world.target
    places = (start.x, start.y, target.x, target.y, target.radius)
    x, y, tx, ty, radius = (float(_PIXELS * in_cells(value, world.cell_size)) for value in places)
    top = _PIXELS * world.height
    common = {"name": "start", "type": "start", "visible": True}
    objects = [
        {
            "height": 0, "id": 1, **common, "point": True, "rotation": 0.0 - math.degrees(start.heading), "width": 0,
            "x": x, "y": top - y, "properties": _properties(heading=start.heading, x=start.x, y=start.y),
        },
        {
            "ellipse": True, "height": 2 * radius, "id": 2, **common, "name": "target", "type": "target", "rotation": 0,
            "width": 2 * radius, "x": tx - radius, "y": top - ty - radius,
            "properties": _properties(radius=target.radius, x=target.x, y=target.y),
        },
    ]  # fmt: skip
    return {
        "draworder": "topdown", "id": 2, "name": "places", "objects": objects, "opacity": 1, "type": "objectgroup",
        "visible": True, "x": 0, "y": 0,
    }  # fmt: skip


def _properties(**values: float) -> list[dict[str, object]]:
    return [{"name": name, "type": "float", "value": value} for name, value in values.items()]


# Offsets of layers are not here, because they move walls.
_HARMLESS = frozenset({
    "backgroundcolor", "class", "color", "compressionlevel", "draworder", "editorsettings", "export", "id",
    "locked", "name", "nextlayerid", "nextobjectid", "opacity", "properties", "renderorder", "tiledversion",
    "tintcolor", "type", "version", "visible", "layers/height", "layers/width", "layers/parallaxx",
    "layers/parallaxy", "parallaxoriginx", "parallaxoriginy",
})  # fmt: skip

tiled = Format(
    "tiled",
    "map of the editor Tiled, .tmj or .tmx",
    (".tmj", ".tmx", ".json"),
    re.compile(
        rb"(?s)\s*(?:<\?xml.*?)?<map[\s>]|\s*\{(?=.*\"(?:compressionlevel|infinite|tiledversion|tilewidth|nextlayerid|renderorder)\"\s*:)"
    ),
    read_tiled,
    write_tiled,
    holds=PLAIN_FACTS,
    client="Tiled",
    most_bytes=_MOST_BYTES,
    harmless=_HARMLESS,
    usual_robot=GRID_AGENT,
)
