"""The walls of a Tiled map: tiles, shapes that collide, and objects.

Source: the documentation of Tiled, "TMX Map Format", "JSON Map Format" and "Global Tile IDs".
"""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from worldgen.errors import FormatError, InvalidWorld
from worldgen.interop.account import NamedParts, report_unread
from worldgen.interop.format.foreign_map import check_sides, read_bounded, sibling_file
from worldgen.interop.geometry.boxes import merged_boxes
from worldgen.interop.geometry.drawing import arc_points, filled
from worldgen.interop.geometry.raster import Raster, RasterBox
from worldgen.interop.readers.tiled_parts import (
    SOLID_WORDS,
    TiledLayer,
    TiledPart,
    TileGrid,
    checked_number,
    is_solid,
    name_of,
    numbers_of,
    objects_of,
    parse_part,
    tile_grid,
)
from worldgen.support.arrays import Bools, Floats
from worldgen.support.plain_text import quote

_FLOORS = ("floor", "floors", "ground", "background", "terrain", "grass")
_MOST_TILESET = 8 << 20
_MOST_SHAPES = 400_000
_FARTHEST = 1e9
_OUTLINES = ("polygon", "polyline", "ellipse", "capsule")


@dataclass
class _Tile:
    """What a set says about one of its tiles: the shapes that collide, pixels, and its size."""

    shapes: list[Any] = field(default_factory=list)
    solid: bool | None = None


@dataclass
class _TileSet:
    first: int
    width: float
    height: float
    name: str
    tiles: dict[int, _Tile] = field(default_factory=dict)
    missing: str = ""
    is_shifted: bool = False

    @property
    def says(self) -> bool:
        """True if the set says of any tile whether it is solid."""
        return any(tile.shapes or tile.solid is not None for tile in self.tiles.values())


class TiledWalls:
    """Finds the walls of a map.

    Args:
        parsed: The map.
        layers: Its layers.
        path: The map's file, next to which its sets of tiles are.
        layer: Patterns of the names of layers that are walls, separated by commas; may be empty.
        free: Patterns of the names of layers that are not.
        marks: Names of objects that are places, not obstacles.
    """

    def __init__(
        self,
        parsed: TiledPart,
        layers: list[TiledLayer],
        path: Path,
        layer: str,
        free: str,
        marks: tuple[str, ...],
    ) -> None:
        self.side = checked_number(parsed, "tilewidth")
        self.layers = layers
        self.layer = layer
        self.free = free
        self.marks = marks
        self.sets = _tile_sets(parsed, path, self.side)
        self.notes: list[str] = []
        self.used: list[str] = []
        self.shapes: list[Any] = []
        self.openings: list[Any] = []
        self._grids: dict[int, TileGrid] = {}
        self._size = self._extent(parsed)

    @property
    def shift(self) -> tuple[int, int]:
        """Column and row, of the map's own, of the upper left cell."""
        return self._size[0], self._size[1]

    @property
    def height(self) -> int:
        """Rows of the map."""
        return self._size[3]

    def _extent(self, parsed: TiledPart) -> tuple[int, int, int, int]:
        """Return the first column and row, width and height, in tiles."""
        if parsed.get("infinite") is not True:
            width, height = (checked_number(parsed, key) for key in ("width", "height"))
            check_sides(width, height)
            self._map = (width, height)
            return 0, 0, width, height
        for key in ("width", "height"):
            parsed.get(key)
        self._map = (0, 0)
        grids = [self.grid(one) for one in self.layers if one.kind == "tilelayer"]
        boxes = [
            (
                grid.left,
                grid.top,
                grid.left + grid.numbers.shape[1],
                grid.top + grid.numbers.shape[0],
            )
            for grid in grids
            if grid.numbers.size
        ]
        if not boxes:
            raise FormatError(
                "endless-map",
                "is an infinite map without a tile",
                "clear Infinite in Tiled's Map Properties",
            )
        left, top = (min(box[at] for box in boxes) for at in (0, 1))
        right, low = (max(box[at] for box in boxes) for at in (2, 3))
        check_sides(right - left, low - top)
        return left, top, right - left, low - top

    def grid(self, layer: TiledLayer) -> TileGrid:
        """Return the tiles of a layer."""
        if id(layer) not in self._grids:
            self._grids[id(layer)] = tile_grid(layer.part, *self._map)
        return self._grids[id(layer)]

    def solid(self, detail: int) -> Bools:
        """Return the solid cells, row 0 lowest, with so many cells to a tile's side.

        Raises:
            FormatError: If it is unclear which layers are walls, or there are too many cells.
        """
        walls = self._chosen()
        tiles: list[tuple[Bools, TiledLayer, TileGrid]] = []
        for layer in self.layers:
            is_wall = any(layer is one for one in walls)
            is_free = _matches(layer.names, self.free)
            if layer.kind == "tilelayer" and is_wall:
                tiles.append((self._wall_tiles(layer), layer, self.grid(layer)))
            elif layer.kind == "tilelayer":
                self._other_tiles(layer, walls, is_free)
            elif layer.kind == "objectgroup":
                self._objects(layer, is_wall=is_wall, is_free=is_free)
            elif is_free or (self.layer and not is_wall):
                layer.part.pass_over()
            else:
                kinds = {"imagelayer": "pictures in layers"}
                report_unread(kinds.get(layer.kind, f"layers of kind {quote(layer.kind, 30)}"))
                layer.part.pass_over()
        left, top, width, height = self._size
        cell = Fraction(self.side, detail)
        low = (top + height) * self.side

        def paint(raster: Raster) -> None:
            for is_tile, layer, grid in tiles:
                self._paint_tiles(raster, is_tile, layer, grid, cell)
            for shapes, clears in ((self.shapes, False), (self.openings, True)):
                if not shapes:
                    continue
                moved = shapely.transform(
                    np.array(shapes, object),
                    lambda xy: (xy - (left * self.side, low)) * (1 / float(cell), -1 / float(cell)),
                )
                if clears:
                    opened = Raster(width * detail, height * detail, cell)
                    opened.shapes(moved)
                    raster.solid &= ~opened.full
                else:
                    raster.shapes(moved)

        check_sides(width * detail, height * detail, remedy="use a smaller +detail")
        raster = Raster(width * detail, height * detail, cell)
        try:
            paint(raster)
        except InvalidWorld as error:
            raise FormatError.of(error.message) from error
        if self.shapes and raster.partly:
            self.notes.append(
                f"{raster.partly} of {np.count_nonzero(raster.solid)} solid cells are only partly "
                f"covered; +detail=4 makes cells of a quarter of a tile"
            )
        return raster.solid

    # Layers

    def _chosen(self) -> list[TiledLayer]:
        """Return the layers that are walls."""
        usable = [one for one in self.layers if one.kind in ("tilelayer", "objectgroup")]
        tiles = [one for one in usable if one.kind == "tilelayer"]
        if self.layer:
            for pattern in self.layer.split(","):
                if not any(_matches(one.names, pattern) for one in usable):
                    raise _unclear(usable, pattern.strip())
            found = [one for one in usable if _matches(one.names, self.layer)]
            others = [
                quote(one.name) for one in self.layers if not any(one is wall for wall in found)
            ]
            if others:
                self.notes.append(
                    f"no walls, as +layer does not name them: {', '.join(others[:20])}"
                )
        else:
            found = [
                one for one in usable
                if one.solid or (one.solid is None and any(name.lower() in SOLID_WORDS for name in one.names))
            ]  # fmt: skip
            found = [one for one in found if not _matches(one.names, self.free)]
            tiles = [
                one for one in tiles if not _matches(one.names, self.free) and one.solid is None
            ]
            if (
                not found
                and not any(each.says for each in self.sets)
                and not self._has_solid_objects(usable)
            ):
                if len(tiles) != 1:
                    raise _unclear(usable, "")
                found = tiles
        self.used = [one.name for one in found]
        return found

    def _has_solid_objects(self, layers: list[TiledLayer]) -> bool:
        return any(is_solid(part) for layer in layers for part in objects_of(layer))

    def _wall_tiles(self, layer: TiledLayer) -> Bools:
        """Return where a layer of walls has tiles; a tile makes its whole cell solid."""
        grid = self.grid(layer)
        for number in np.unique(grid.numbers[grid.numbers > 0]).tolist():
            found = self._set_of(number)
            if found is not None and (
                max(found.width, found.height) > self.side or found.is_shifted
            ):
                report_unread(
                    "tiles that reach beyond their cells", int((grid.numbers == number).sum())
                )
        is_tile: Bools = grid.numbers > 0
        layer.part.get("encoding")
        layer.part.get("compression")
        return is_tile

    def _other_tiles(self, layer: TiledLayer, walls: list[TiledLayer], is_free: bool) -> None:
        """Add the tiles of a layer that is no wall, if they collide, and report what is unclear."""
        decided = is_free or bool(self.layer) or layer.solid is False
        try:
            grid = self.grid(layer)
        except FormatError:
            if not decided:
                report_unread(f"layers of tiles besides {_listed(walls)}")
            layer.part.pass_over()
            return
        layer.part.pass_over()
        if is_free:
            self._open_tiles(layer, grid)
        if decided:
            return
        unknown = missing = 0
        for number in np.unique(grid.numbers[grid.numbers > 0]).tolist():
            found = self._set_of(number)
            places = np.argwhere(grid.numbers == number)
            if found is None or found.missing or not found.says:
                unknown += len(places)
                missing += len(places) if found is not None and found.missing else 0
                continue
            tile = found.tiles.get(number - found.first)
            if tile is None or tile.solid is False or not (tile.shapes or tile.solid):
                continue
            for row, column in places.tolist():
                self._add_tile(layer, grid, (row, column), found, tile)
        # A floor is called one, and has a tile in every cell without a wall.
        if unknown and (missing or not self._is_floor(layer, grid, walls)):
            report_unread(f"layers of tiles besides {_listed(walls)}")
            for each in self.sets:
                if each.missing and missing:
                    self.notes.append(each.missing)

    def _is_floor(self, layer: TiledLayer, grid: TileGrid, walls: list[TiledLayer]) -> bool:
        if layer.name.lower() not in _FLOORS:
            return False
        left, top, width, height = self._size
        free = np.ones((height, width), np.bool_)
        for wall in walls:
            if wall.kind == "tilelayer":
                other = self.grid(wall)
                rows, columns = np.nonzero(other.numbers)
                free[rows + other.top - top, columns + other.left - left] = False
        rows, columns = np.nonzero(grid.numbers)
        free[rows + grid.top - top, columns + grid.left - left] = False
        return not free.any()

    def _open_tiles(self, layer: TiledLayer, grid: TileGrid) -> None:
        for row, column in np.argwhere(grid.numbers > 0).tolist():
            x, y = self._corner(layer, grid, (row, column))
            self._keep(self.openings, shapely.box(x, y, x + self.side, y + self.side))

    def _corner(
        self, layer: TiledLayer, grid: TileGrid, at: tuple[int, int]
    ) -> tuple[float, float]:
        """Return the upper left corner of a cell, pixels."""
        return (grid.left + at[1]) * self.side + layer.shift[0], (
            grid.top + at[0]
        ) * self.side + layer.shift[1]

    def _add_tile(
        self, layer: TiledLayer, grid: TileGrid, at: tuple[int, int], found: _TileSet, tile: _Tile
    ) -> None:
        x, y = self._corner(layer, grid, at)
        # A large tile stands on the lower left corner of its cell.
        y += self.side - found.height
        whole = [] if tile.shapes else [shapely.box(0, 0, found.width, found.height)]
        for shape in tile.shapes or whole:
            turned = _flipped(shape, int(grid.flips[at]), found)
            self._keep(self.shapes, _moved(turned, x, y))

    def _paint_tiles(
        self, raster: Raster, is_tile: Bools, layer: TiledLayer, grid: TileGrid, cell: Fraction
    ) -> None:
        left, top, width, height = self._size
        if layer.shift == (0.0, 0.0):
            whole = np.zeros((height, width), np.bool_)
            row, column = grid.top - top, grid.left - left
            whole[row : row + is_tile.shape[0], column : column + is_tile.shape[1]] = is_tile
            raster.picture(whole[::-1], Fraction(self.side), Fraction(self.side))
            return
        x, y = (Fraction(value) for value in layer.shift)
        for begin, first, end, last in merged_boxes(is_tile).tolist():
            side = self.side
            raster.box(
                RasterBox(
                    (begin + grid.left - left) * side + x,
                    (height - (last + grid.top - top)) * side - y,
                    (end + grid.left - left) * side + x,
                    (height - (first + grid.top - top)) * side - y,
                )
            )

    # Objects

    def _objects(self, layer: TiledLayer, *, is_wall: bool, is_free: bool) -> None:
        layer.part.get("objects")
        decided = is_free or bool(self.layer) or layer.solid is False
        for part in objects_of(layer):
            words = {str(part.peek(key, "")).lower() for key in ("name", "class", "type")}
            is_mark = words & set(self.marks) or part.peek("point") is True or part.peek("text")
            own = is_solid(part)
            if is_mark or own is False:
                part.pass_over()
            elif "template" in part and part.peek("template"):
                if is_wall or own or not decided:
                    report_unread("objects from templates")
                part.pass_over()
            elif is_free:
                self._add_object(part, layer, self.openings)
            elif (
                is_wall
                or (own and not self.layer)
                or (part.peek("gid") and not decided and self._collides(part))
            ):
                self._add_object(part, layer, self.shapes)
            else:
                harmless = decided or _is_nothing(part)
                report_unread(f"objects in layer {quote(layer.name)}", 0 if harmless else 1)
                part.pass_over()
        others = set(layer.part) - {"objects"}
        for name in others & {"image", "data", "layers"}:
            report_unread(f"values of {name} in layers")

    def _collides(self, part: TiledPart) -> bool:
        """Return True if the set says that a tile that is an object collides or does not."""
        number = int(numbers_of(part, "gid").get("gid", 0)) & 0x0FFFFFFF
        found = self._set_of(number)
        return found is not None and found.says

    def _add_object(self, part: TiledPart, layer: TiledLayer, to: list[Any]) -> None:
        where = numbers_of(part, "x", "y")
        shift = where.get("x", 0.0) + layer.shift[0], where.get("y", 0.0) + layer.shift[1]
        angle = math.radians(numbers_of(part, "rotation").get("rotation", 0.0))
        for shape in self._of_object(part):
            to_map = _turned(shape, angle)
            self._keep(to, _moved(to_map, *shift))
        for name in ("id", "name", "type", "class", "visible", "properties", "gid", "opacity"):
            part.get(name)

    def _of_object(self, part: TiledPart) -> Iterator[Any]:
        """Yield the shapes of an object, pixels from its own point, before it is turned."""
        gid = part.get("gid")
        if not isinstance(gid, int) or isinstance(gid, bool) or gid <= 0:
            yield from plain_shapes(part)
            return
        size = numbers_of(part, "width", "height")
        found = self._set_of(gid & 0x0FFFFFFF)
        tile = None if found is None else found.tiles.get((gid & 0x0FFFFFFF) - found.first)
        width = size.get("width", found.width if found else float(self.side))
        height = size.get("height", found.height if found else float(self.side))
        if tile is not None and tile.solid is False:
            return
        if found is not None and found.says and tile is None:
            return
        # Its point is the lower left corner.
        if tile is None or not tile.shapes or found is None:
            yield shapely.box(0, -height, width, 0)
            return
        scale = width / found.width, height / found.height
        for shape in tile.shapes:
            turned = _flipped(shape, gid >> 29 & 6, found)
            yield shapely.transform(turned, lambda xy: xy * scale - (0, height))

    def _keep(self, to: list[Any], shape: Any) -> None:
        if shape is None or shape.is_empty:
            return
        if not all(abs(value) < _FARTHEST for value in shape.bounds) or len(to) >= _MOST_SHAPES:
            raise FormatError(
                "too-large",
                "has an object beyond {farthest:g} pixels, or more than {most:,} shapes",
                "delete it",
                farthest=_FARTHEST,
                most=_MOST_SHAPES,
            )
        to.append(shape)

    def _set_of(self, number: int) -> _TileSet | None:
        return next((one for one in reversed(self.sets) if one.first <= number), None)


def _unclear(layers: list[TiledLayer], name: str) -> FormatError:
    return FormatError(
        "layer-missing" if name else "ambiguous-layer",
        "there is no layer {name!q}; layers: {known!l:none}"
        if name
        else "it is unclear which layer has the walls; layers: {known!l:none}",
        "name them with --layer NAME,...",
        at_terminal=True,
        name=name,
        known=[quote(one.name) for one in layers[:20]],
    )


def _listed(walls: list[TiledLayer]) -> str:
    return ", ".join(quote(one.name) for one in walls[:5]) or "those that collide"


def _matches(names: tuple[str, ...], patterns: str) -> bool:
    wanted = [word.strip().lower() for word in patterns.split(",") if word.strip()]
    return any(fnmatch.fnmatchcase(name.lower(), one) for one in wanted for name in names)


def _is_nothing(part: TiledPart) -> bool:
    """Return True if an object has no extent."""
    if any(part.peek(name) for name in (*_OUTLINES, "gid", "template")):
        return False
    unknown = set(part) - {
        "id", "name", "type", "class", "x", "y", "width", "height", "rotation", "visible", "properties", "opacity",
    }  # fmt: skip
    return not (part.peek("width") or part.peek("height") or unknown)


def plain_shapes(part: TiledPart) -> Iterator[Any]:
    """Yield the shape of an object that is no tile, pixels from its own point."""
    size = numbers_of(part, "width", "height")
    width, height = max(size.get("width", 0.0), 0.0), max(size.get("height", 0.0), 0.0)
    for name in ("polygon", "polyline"):
        if part.peek(name):
            points = _corners(part.get(name))
            if len(points) > 2 and name == "polygon":
                area = filled([points], even_odd=False)
                yield shapely.LineString(points) if area is None else area
            elif len(points) > 1:
                yield shapely.LineString(points)
            return
    if part.get("ellipse") is True and width > 0 and height > 0:
        yield shapely.Polygon(
            arc_points((width / 2, height / 2), (width / 2, height / 2), 0.0, 0.0, math.tau)
        )
    elif part.get("capsule") is True and width > 0 and height > 0:
        radius = min(width, height) / 2
        line = shapely.LineString([(radius, radius), (width - radius, height - radius)])
        yield shapely.buffer(line, radius, quad_segs=64)
    elif width > 0 and height > 0:
        yield shapely.box(0, 0, width, height)
    elif width > 0 or height > 0:
        yield shapely.LineString([(0, 0), (width, height)])


def _corners(points: Any) -> Floats:
    rows = (
        [[one.get(key) for key in ("x", "y")] for one in points if isinstance(one, NamedParts)]
        if isinstance(points, list)
        else []
    )
    plain = all(
        isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _FARTHEST
        for row in rows
        for value in row
    )
    if not plain:
        raise FormatError("not-a-number", "a corner of an object is not two numbers", "delete it")
    return np.array(rows, np.float64).reshape(-1, 2)


def _moved(shape: Any, x: float, y: float) -> Any:
    return shapely.transform(shape, lambda xy: xy + np.array([x, y]))


def _turned(shape: Any, angle: float) -> Any:
    """Return a shape after a turn about its point; clockwise, as y points down."""
    if angle == 0.0:
        return shape
    quarters = angle / (math.pi / 2)
    cos, sin = math.cos(angle), math.sin(angle)
    if abs(quarters - round(quarters)) < 1e-9:
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    matrix = np.array([[cos, sin], [-sin, cos]])
    return shapely.transform(shape, lambda xy: xy @ matrix)


def _flipped(shape: Any, flips: int, found: _TileSet) -> Any:
    """Return a tile's shape as the flips of its number turn it: along the diagonal first."""
    if not flips:
        return shape
    width, height = found.width, found.height

    def turn(xy: Floats) -> Floats:
        if flips & 1:
            xy = xy[:, ::-1]
        if flips & 4:
            xy = xy * (-1, 1) + (width, 0)
        if flips & 2:
            xy = xy * (1, -1) + (0, height)
        return xy

    return shapely.transform(shape, turn)


def _tile_sets(parsed: TiledPart, path: Path, side: int) -> list[_TileSet]:
    """Return the sets of tiles in the order of their numbers; those beside the map too."""
    sets = parsed.get("tilesets")
    found = []
    for named in sets if isinstance(sets, list) else ():
        if not isinstance(named, NamedParts):
            continue
        number = named.get("firstgid", 1)
        first = number if isinstance(number, int) and not isinstance(number, bool) else 1
        source = named.get("source")
        one, missing = named, ""
        if isinstance(source, str) and source:
            try:
                beside = sibling_file(path, "tileset", source)
                one = parse_part(read_bounded(beside, _MOST_TILESET))
            except FormatError as error:
                missing = str(error.message)
        found.append(_tile_set(one, first, side, missing))
        named.pass_over()
        one.pass_over()
    return sorted(found, key=lambda each: each.first)


def _tile_set(part: TiledPart, first: int, side: int, missing: str) -> _TileSet:
    size = numbers_of(part, "tilewidth", "tileheight")
    made = _TileSet(
        first,
        size.get("tilewidth", float(side)) or float(side),
        size.get("tileheight", float(side)) or float(side),
        name_of(part),
        missing=missing,
    )
    offset = part.get("tileoffset")
    if isinstance(offset, NamedParts):
        made.is_shifted = any(numbers_of(offset, "x", "y").values())
    tiles = part.get("tiles")
    for one in tiles if isinstance(tiles, list) else ():
        number = one.get("id") if isinstance(one, NamedParts) else None
        if not isinstance(number, int):
            continue
        tile = made.tiles.setdefault(number, _Tile(solid=is_solid(one)))
        group = one.get("objectgroup")
        objects = group.get("objects") if isinstance(group, NamedParts) else None
        for each in objects if isinstance(objects, list) else ():
            if (
                not isinstance(each, NamedParts)
                or is_solid(each) is False
                or each.peek("point")
                or each.peek("text")
            ):
                continue
            where = numbers_of(each, "x", "y")
            angle = math.radians(numbers_of(each, "rotation").get("rotation", 0.0))
            tile.shapes += [
                _moved(_turned(shape, angle), where.get("x", 0.0), where.get("y", 0.0))
                for shape in plain_shapes(each)
            ]
    return made
