"""Read the parts of a Tiled map.

Layers, tiles, objects and properties are all checked before they are used.
"""

from __future__ import annotations

import base64
import binascii
import contextlib
import json
import math
import zlib
from collections.abc import Collection, Iterator
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError
from worldgen.interop.account import NamedParts, parse_json, report_unread
from worldgen.support.arrays import Ints
from worldgen.support.plain_text import quote

TiledPart: TypeAlias = NamedParts
# The upper bits tell how a tile is flipped and turned.
_TILE = 0x0FFFFFFF
_MOST_LAYERS = 10_000
# zlib and gzip are recognised by their headers.
_WINDOW = 47
_FLOORS = ("floor", "floors", "ground", "background", "terrain", "grass")
_COMMON_NAMES = ("walls", "wall", "collision", "collisions", "obstacles", "solid")


def parse_tiled(data: bytes) -> TiledPart:
    """Return the map after checking its kind.

    Raises:
        FormatError: If it isn't JSON, isn't a map, is infinite, or doesn't have square tiles in rows
            and columns.
    """
    try:
        parsed = parse_json(data)
    except FormatError:
        raise
    except UnicodeDecodeError as error:
        raise FormatError("not-utf8", "is not UTF-8 text", "save it from Tiled as JSON") from error
    except json.JSONDecodeError as error:
        raise FormatError(
            "not-json",
            "is not JSON: {reason}",
            "save it from Tiled as JSON (.tmj)",
            reason=error.msg,
            line=error.lineno,
        ) from error
    # Nested too deeply, or a number with thousands of digits.
    except (RecursionError, ValueError) as error:
        raise FormatError(
            "wrong-form", "is not a map in the form that Tiled writes", "save it from Tiled again"
        ) from error
    if not isinstance(parsed, NamedParts) or not isinstance(parsed.get("layers"), list):
        raise FormatError(
            "unknown-format",
            "is JSON without layers; the only JSON maps that can be read are Tiled's",
            "use a map that Tiled saved, not a tileset or world",
        )
    if parsed.get("infinite") is True:
        raise FormatError(
            "endless-map", "is an infinite map", "clear Infinite in Tiled's Map Properties"
        )
    kind = parsed.get("orientation", "orthogonal")
    if kind != "orthogonal":
        raise FormatError(
            "unsupported",
            "its orientation is {orientation!q}; only orthogonal maps can become worlds",
            "draw it again as an orthogonal map",
            orientation=str(kind),
        )
    tile = [checked_number(parsed, key) for key in ("tilewidth", "tileheight")]
    if tile[0] != tile[1] or tile[0] < 1:
        raise FormatError(
            "not-square",
            "tiles of {width} x {height} pixels; a cell must be square",
            "make both sides equal in Map Properties",
            width=tile[0],
            height=tile[1],
        )
    return parsed


def checked_number(part: TiledPart, key: str) -> int:
    """Return a whole number from 0 to a million.

    Raises:
        FormatError: If it is missing or something else.
    """
    value = part.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= 1_000_000:
        raise FormatError(
            "not-a-number",
            "{key} is {value!q}, which is not a whole number of 0 or more",
            "save it again",
            key=key,
            value=json.dumps(value),
        )
    return value


def all_layers(parsed: TiledPart) -> list[TiledPart]:
    """Return layers in drawing order, those in groups too; only groups are taken.

    Raises:
        FormatError: If there are too many, or one isn't a layer.
    """
    waiting: list[Any] = list(reversed(parsed["layers"]))
    found: list[TiledPart] = []
    while waiting:
        layer = waiting.pop()
        if not isinstance(layer, NamedParts) or len(found) >= _MOST_LAYERS:
            raise FormatError(
                "too-many-layers",
                "a layer is not an object, or there are more than {most}",
                "save it again",
                most=_MOST_LAYERS,
            )
        found.append(layer)
        if isinstance(layer.peek("layers"), list):
            waiting.extend(reversed(layer["layers"]))
    return found


def tile_layer(layers: list[TiledPart], name: str) -> TiledPart:
    """Return the layer of walls: the named one, otherwise one called walls, or the only one.

    Raises:
        FormatError: If there is none, or the choice is ambiguous.
    """
    tiles = [layer for layer in layers if layer.peek("type") == "tilelayer"]
    if name:
        found = [layer for layer in tiles if name_of(layer) == name]
    else:
        found = [layer for layer in tiles if name_of(layer).lower() in _COMMON_NAMES][:1] or tiles
    if len(found) != 1:
        raise FormatError(
            "layer-missing" if name else "ambiguous-layer",
            "there is no layer {name!q}; layers of tiles: {known!l:none}"
            if name
            else "it is unclear which layer has the walls; layers of tiles: {known!l:none}",
            "name it with --from tiled+layer=NAME",
            at_terminal=True,
            name=name,
            known=[quote(name_of(layer)) for layer in tiles[:20]],
        )
    return found[0]


def name_of(layer: TiledPart) -> str:
    """Return a layer's name, without taking it."""
    return str(layer.peek("name", ""))


def report_other_tiles(
    layers: list[TiledPart], walls: TiledPart, is_wall: npt.NDArray[np.bool_]
) -> None:
    """Report the other layers of tiles, unless they are empty or floors.

    A floor is called one, and has a tile in every cell without a wall: a few tiles of "terrain" may
    be a cliff.
    """
    height, width = is_wall.shape
    for layer in layers:
        if layer.peek("type") != "tilelayer" or layer is walls:
            continue
        matters = True
        with contextlib.suppress(FormatError):
            has_tile = tile_numbers(layer, width, height) != 0
            is_floor = name_of(layer).lower() in _FLOORS and bool(has_tile[~is_wall].all())
            matters = bool(has_tile.any()) and not is_floor
        report_unread(f"layers of tiles besides {quote(name_of(walls))}", matters)
        layer.pass_over()


def report_large_tiles(parsed: TiledPart) -> None:
    """Report sets of tiles that are drawn beyond their cells.

    A tile in the layer of walls makes its whole cell solid, whatever is drawn or collides in it, so
    nothing else in a set matters.
    """
    sets = parsed.get("tilesets")
    side = checked_number(parsed, "tilewidth")
    for one in sets if isinstance(sets, list) else ():
        if isinstance(one, NamedParts):
            sides = (one.get("tilewidth", side), one.get("tileheight", side))
            is_larger = any(isinstance(value, int) and value > side for value in sides)
            report_unread(
                "tilesets whose tiles reach beyond their cells",
                is_larger or bool(one.get("tileoffset")),
            )
            one.pass_over()


def tile_numbers(layer: TiledPart, width: int, height: int) -> npt.NDArray[np.uint32]:
    """Return the numbers of tiles, (height, width), top row first, 0 where there is none.

    Flips are ignored.

    Raises:
        FormatError: If the layer has another size, or its data does not unpack to that many
            numbers.
    """
    name = f"layer {quote(name_of(layer))}"
    size = layer.get("width", width), layer.get("height", height)
    if size != (width, height):
        raise FormatError(
            "wrong-size",
            "{name} has {layer_width} x {layer_height} cells, but the map has {width} x {height}",
            "save it again",
            name=name,
            layer_width=size[0],
            layer_height=size[1],
            width=width,
            height=height,
        )
    data = layer.get("data")
    if isinstance(data, str):
        numbers = np.frombuffer(_unpacked(layer, data, 4 * width * height, name), "<u4")
    else:
        numbers = _listed(data, name)
    if len(numbers) != width * height:
        raise FormatError(
            "wrong-length",
            "{name} has {cells} cells; {width} x {height} are {needed}",
            "save it again",
            name=name,
            cells=len(numbers),
            width=width,
            height=height,
            needed=width * height,
        )
    return (numbers & _TILE).astype(np.uint32).reshape(height, width)


def _listed(data: object, name: str) -> Ints:
    numbers = np.array([])
    if isinstance(data, list) and not any(isinstance(value, list) for value in data[:1]):
        with contextlib.suppress(ValueError, OverflowError):
            numbers = np.array(data)
    if (
        numbers.ndim != 1
        or numbers.dtype.kind not in "iu"
        or (len(numbers) and int(numbers.min()) < 0)
    ):
        raise FormatError(
            "wrong-type",
            "the data of {name} is not a list of tile numbers",
            "save it again",
            name=name,
        )
    return numbers.astype(np.int64)


def _unpacked(layer: TiledPart, text: str, size: int, name: str) -> bytes:
    if layer.get("encoding", "base64") != "base64":
        raise FormatError(
            "unsupported",
            "{name} has the encoding {encoding!q}",
            "save it as CSV",
            name=name,
            encoding=str(layer["encoding"]),
        )
    kind = layer.get("compression") or "none"
    if kind not in ("none", "zlib", "gzip"):
        raise FormatError(
            "unsupported",
            "{name} is compressed with {compression!q}",
            "save it in Tiled as CSV or zlib",
            name=name,
            compression=str(kind),
        )
    try:
        packed = base64.b64decode(text, validate=True)
        if kind == "none":
            return packed[: size + 4]
        unpacker = zlib.decompressobj(_WINDOW)
        # Never unpack more than a map of that size contains.
        data = unpacker.decompress(packed, size + 1)
    except (binascii.Error, zlib.error, ValueError) as error:
        raise FormatError(
            "damaged-file",
            "{name} cannot be unpacked: {reason}",
            "save it again",
            name=name,
            reason=str(error),
        ) from error
    if len(data) > size or not unpacker.eof:
        raise FormatError(
            "damaged-file",
            "{name} does not unpack to {size} bytes; it is damaged, save it again",
            name=name,
            size=size,
        )
    return data[: len(data) // 4 * 4]


def first_object(layers: list[TiledPart], names: Collection[str]) -> TiledPart | None:
    """Return the first object with one of these names, classes or types, ignoring case.

    Further ones are other places for a robot.
    """
    found = [
        part for part in _objects(layers)
        if any(str(part.peek(key, "")).lower() in names for key in ("name", "class", "type"))
    ]  # fmt: skip
    for part in found:
        part.pass_over()
    return found[0] if found else None


def pass_over_marks(layers: list[TiledPart]) -> None:
    """Take the layers of objects, and pass over objects without an area: points and texts."""
    for layer in layers:
        if layer.peek("type") == "objectgroup":
            layer.get("objects")
    for part in _objects(layers):
        if part.peek("point") is True or part.peek("text"):
            part.pass_over()


def _objects(layers: list[TiledPart]) -> Iterator[TiledPart]:
    for layer in layers:
        objects = layer.peek("objects")
        if layer.peek("type") == "objectgroup" and isinstance(objects, list):
            yield from (part for part in objects if isinstance(part, NamedParts))


def numbers_of(part: TiledPart, *keys: str) -> dict[str, float]:
    """Return finite numbers of a part by those keys.

    If it has none of them, use its custom properties of these names.
    """
    if keys:
        pairs = [(key, part.get(key)) for key in keys]
    else:
        properties = part.get("properties")
        named = (
            [each for each in properties if isinstance(each, dict)]
            if isinstance(properties, list)
            else []
        )
        pairs = [(str(each.get("name")), each.get("value")) for each in named]
    plain = [
        (key, value)
        for key, value in pairs
        if isinstance(value, int | float) and not isinstance(value, bool)
    ]
    return {
        key: float(value) for key, value in plain if abs(value) < 1e300 and math.isfinite(value)
    }
