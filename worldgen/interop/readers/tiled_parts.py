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
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError
from worldgen.interop.account import NamedParts, account_for, parse_json
from worldgen.interop.format.foreign_map import check_sides
from worldgen.interop.readers.xml_tree import XmlElement, parse_xml
from worldgen.support.arrays import Ints
from worldgen.support.plain_text import quote

TiledPart: TypeAlias = NamedParts
# The upper bits tell how a tile is flipped and turned.
_TILE = 0x0FFFFFFF
_MOST_LAYERS = 10_000
# Tiles of a chunk; Tiled's own have 256.
_MOST_CHUNK = 1 << 20
# zlib and gzip are recognised by their headers.
_WINDOW = 47
# Objects and points in an XML file; each becomes some kilobytes.
_WHOLE = frozenset({
    "width", "height", "tilewidth", "tileheight", "firstgid", "tilecount", "columns", "gid", "id", "x", "y",
    "offsetx", "offsety", "rotation", "infinite", "visible", "locked", "opacity", "margin", "spacing",
})  # fmt: skip


def parse_tiled(data: bytes) -> TiledPart:
    """Return the map after checking its kind, in the form of JSON also if it is XML.

    Raises:
        FormatError: If it isn't JSON or XML, isn't a map, or doesn't have square tiles in rows and
            columns.
    """
    parsed = parse_part(data)
    if not isinstance(parsed.get("layers"), list):
        raise FormatError(
            "unknown-format",
            "is JSON without layers; the only JSON maps that can be read are Tiled's",
            "use a map that Tiled saved, not a tileset or world",
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


def parse_part(data: bytes) -> TiledPart:
    """Return a file of Tiled, a map or a set of tiles, in the form of JSON.

    Raises:
        FormatError: If it is neither JSON nor XML.
    """
    if data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        root = parse_xml(data, plain_entities=True)
        # What the conversion does not know is in the result, and is accounted for there.
        return account_for(_converted(root))
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
    if not isinstance(parsed, NamedParts):
        raise FormatError("unknown-format", "is JSON without keys", "use a map that Tiled saved")
    return parsed


_LAYERS = {
    "layer": "tilelayer",
    "objectgroup": "objectgroup",
    "imagelayer": "imagelayer",
    "group": "group",
}


def _converted(element: XmlElement) -> TiledPart:
    """Return an XML element as Tiled writes it in JSON."""
    pairs: dict[str, Any] = {
        name: _value(name, str(element.attributes.peek(name))) for name in element.attributes
    }
    lists: dict[str, list[Any]] = {"layers": []} if element.name in ("map", "group") else {}
    for child in element.children:
        name = child.name
        if name in _LAYERS and element.name in ("map", "group"):
            lists["layers"].append(
                NamedParts([("type", _LAYERS[name]), *_items(_converted(child), "type")])
            )
        elif name == "properties":
            pairs[name] = [_property(one) for one in child.children]
        elif name == "data":
            pairs |= _tile_data(child)
        elif name in ("polygon", "polyline"):
            pairs[name] = _points(child)
        elif name in ("ellipse", "point", "capsule"):
            pairs[name] = True
        elif name in ("object", "tile", "tileset"):
            lists.setdefault(f"{name}s", []).append(_converted(child))
        elif name == "image":
            pairs["image"] = str(child.attributes.peek("source", ""))
        else:
            pairs[name] = _converted(child)
    if element.name == "objectgroup":
        lists.setdefault("objects", [])
    return NamedParts([*pairs.items(), *lists.items()])


def _items(part: TiledPart, without: str) -> list[tuple[str, Any]]:
    return [(name, part.peek(name)) for name in part if name != without]


def _value(name: str, text: str) -> Any:
    """Return an attribute's value with the type that it has in JSON."""
    if name not in _WHOLE:
        return text
    with contextlib.suppress(ValueError):
        return bool(int(text)) if name in ("infinite", "visible", "locked") else int(text)
    with contextlib.suppress(ValueError):
        return float(text)
    return text


def _property(element: XmlElement) -> TiledPart:
    kind = str(element.attributes.peek("type", "string"))
    text = element.attributes.peek("value")
    value: Any = element.text if text is None else str(text)
    with contextlib.suppress(ValueError):
        if kind == "bool":
            value = value == "true"
        elif kind in ("int", "float"):
            value = float(value)
    name = str(element.attributes.peek("name", ""))
    return NamedParts([("name", name), ("type", kind), ("value", value)])


def _points(element: XmlElement) -> list[TiledPart]:
    found = []
    for word in str(element.attributes.peek("points", "")).split():
        x, _, y = word.partition(",")
        try:
            found.append(NamedParts([("x", float(x)), ("y", float(y))]))
        except ValueError as error:
            raise FormatError(
                "not-a-number",
                "a point is {word!q}",
                "write x,y",
                word=word[:40],
                line=element.line,
            ) from error
    return found


def _tile_data(element: XmlElement) -> dict[str, Any]:
    """Return the tiles of a layer or a chunk: numbers, or the packed text."""
    encoding = str(element.attributes.peek("encoding", ""))
    found: dict[str, Any] = {
        name: str(element.attributes.peek(name))
        for name in ("encoding", "compression")
        if name in element.attributes and encoding != "csv"
    }
    chunks = list(element.all("chunk"))
    if chunks:
        found["chunks"] = [
            NamedParts(
                [
                    *(
                        (name, _value(name, str(chunk.attributes.peek(name))))
                        for name in chunk.attributes
                    ),
                    ("data", _numbers(chunk, encoding)),
                ]
            )
            for chunk in chunks
        ]
    else:
        found["data"] = _numbers(element, encoding)
    return found


def _numbers(element: XmlElement, encoding: str) -> Any:
    if encoding == "csv":
        words = element.text.replace("\n", " ").split(",")
        return [int(word) if word.strip().isdigit() else -1 for word in words if word.strip()]
    if encoding:
        return element.text.strip()
    words = [str(tile.attributes.peek("gid", "0")) for tile in element.all("tile")]
    return [int(word) if word.isdigit() else -1 for word in words]


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


@dataclass(frozen=True)
class TiledLayer:
    """A layer with what it has from the groups around it.

    Args:
        part: The layer.
        names: Its name, and those of its groups.
        shift: Its offset, pixels to the right and down.
        solid: True or False if a property says whether it is a wall; else None.
    """

    part: TiledPart
    names: tuple[str, ...]
    shift: tuple[float, float]
    solid: bool | None = None

    @property
    def kind(self) -> str:
        """Tilelayer, objectgroup, imagelayer or group."""
        return str(self.part.peek("type", ""))

    @property
    def name(self) -> str:
        """Its own name."""
        return self.names[0]


def all_layers(parsed: TiledPart) -> list[TiledLayer]:
    """Return layers in drawing order, those in groups too, without the groups.

    Raises:
        FormatError: If there are too many, or one isn't a layer.
    """
    waiting: list[tuple[Any, tuple[str, ...], tuple[float, float], bool | None]] = [
        (one, (), (0.0, 0.0), None) for one in reversed(parsed["layers"])
    ]
    found: list[TiledLayer] = []
    count = 0
    while waiting:
        layer, names, shift, solid = waiting.pop()
        count += 1
        if not isinstance(layer, NamedParts) or count > _MOST_LAYERS:
            raise FormatError(
                "too-many-layers",
                "a layer is not an object, or there are more than {most}",
                "save it again",
                most=_MOST_LAYERS,
            )
        offset = numbers_of(layer, "offsetx", "offsety")
        own = TiledLayer(
            layer,
            (name_of(layer), *names),
            (shift[0] + offset.get("offsetx", 0.0), shift[1] + offset.get("offsety", 0.0)),
            solid if is_solid(layer) is None else is_solid(layer),
        )
        if own.kind == "group" and isinstance(layer.peek("layers"), list):
            waiting.extend(
                (one, own.names, own.shift, own.solid) for one in reversed(layer["layers"])
            )
        else:
            found.append(own)
    return found


SOLID_WORDS = (
    "wall", "walls", "solid", "collides", "collide", "collision", "collisions", "collidable", "obstacle", "obstacles",
    "blocked", "blocking",
)  # fmt: skip
"""Names of layers, classes and properties of what stops a robot."""


def is_solid(part: TiledPart) -> bool | None:
    """Return what a part's properties or class say about being a wall; None if nothing."""
    for key in ("class", "type"):
        if str(part.peek(key, "")).lower() in SOLID_WORDS:
            return True
    properties = part.peek("properties")
    for one in properties if isinstance(properties, list) else ():
        if isinstance(one, dict):
            name, value = str(dict.get(one, "name")).lower(), dict.get(one, "value")
            if name in SOLID_WORDS and isinstance(value, bool):
                return value
            if name in SOLID_WORDS and str(value).lower() in (
                "true",
                "1",
                "yes",
                "false",
                "0",
                "no",
            ):
                return str(value).lower() in ("true", "1", "yes")
    return None


def name_of(layer: TiledPart) -> str:
    """Return a layer's name, without taking it."""
    return str(layer.peek("name", ""))


@dataclass
class TileGrid:
    """The tiles of a layer.

    Args:
        numbers: (height, width) uint32, top row first: numbers of tiles, 0 where there is none.
        flips: (height, width) uint32: 4 if mirrored left to right, 2 upside down, 1 along the
            diagonal, first.
        left: Column of the first tile in the map.
        top: Row of the first tile in the map.
    """

    numbers: npt.NDArray[np.uint32]
    flips: npt.NDArray[np.uint32]
    left: int = 0
    top: int = 0


def tile_grid(layer: TiledPart, width: int, height: int) -> TileGrid:
    """Return the tiles of a layer of a map of this size, or of its chunks.

    Raises:
        FormatError: If the layer has another size, or its data does not unpack to that many
            numbers.
    """
    name = f"layer {quote(name_of(layer))}"
    if isinstance(layer.peek("chunks"), list):
        return _chunked(layer, name)
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
    return _grid_of(_gids(layer, layer.get("data"), width, height, name))


def _grid_of(gids: npt.NDArray[np.uint32], left: int = 0, top: int = 0) -> TileGrid:
    return TileGrid(gids & np.uint32(_TILE), gids >> np.uint32(29), left, top)


def _chunked(layer: TiledPart, name: str) -> TileGrid:
    """Return the smallest grid that has all tiles of the chunks."""
    for key in ("width", "height", "startx", "starty"):
        layer.get(key)
    parts = []
    for chunk in layer["chunks"]:
        if not isinstance(chunk, NamedParts):
            raise FormatError(
                "wrong-type", "a chunk of {name} is not an object", "save it again", name=name
            )
        x, y = chunk.get("x"), chunk.get("y")
        width, height = (checked_number(chunk, key) for key in ("width", "height"))
        plain = all(isinstance(value, int) and abs(value) <= 10_000_000 for value in (x, y))
        if not plain or width * height > _MOST_CHUNK:
            raise FormatError(
                "not-a-number",
                "a chunk of {name} is at ({x!q}, {y!q}), with {width} x {height} tiles",
                "save it again",
                name=name, x=str(x)[:20], y=str(y)[:20], width=width, height=height,
            )  # fmt: skip
        gids = _gids(layer, chunk.get("data"), width, height, name)
        rows, columns = np.nonzero(gids)
        if len(rows):
            box = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
            parts.append((x + int(columns.min()), y + int(rows.min()), gids[box]))
    if not parts:
        return _grid_of(np.zeros((0, 0), np.uint32))
    left, top = min(part[0] for part in parts), min(part[1] for part in parts)
    right = max(x + gids.shape[1] for x, _, gids in parts)
    low = max(y + gids.shape[0] for _, y, gids in parts)
    check_sides(right - left, low - top)
    whole = np.zeros((low - top, right - left), np.uint32)
    for x, y, gids in parts:
        whole[y - top : y - top + gids.shape[0], x - left : x - left + gids.shape[1]] = gids
    return _grid_of(whole, left, top)


def _gids(
    layer: TiledPart, data: object, width: int, height: int, name: str
) -> npt.NDArray[np.uint32]:
    if isinstance(data, str):
        numbers: Any = np.frombuffer(_unpacked(layer, data, 4 * width * height, name), "<u4")
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
    gids: npt.NDArray[np.uint32] = (numbers & 0xFFFFFFFF).astype(np.uint32)
    return gids.reshape(height, width)


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
    unpack_zstd = _zstandard() if kind == "zstd" else None
    if kind not in ("none", "zlib", "gzip") and unpack_zstd is None:
        raise FormatError(
            "unsupported",
            "{name} is compressed with {compression!q}",
            "save it in Tiled as CSV or zlib, or install zstandard",
            name=name,
            compression=str(kind),
        )
    try:
        packed = base64.b64decode("".join(text.split()), validate=True)
        if unpack_zstd is not None:
            return unpack_zstd(packed, size)
        if kind == "none":
            return packed[: size + 4]
        unpacker = zlib.decompressobj(_WINDOW)
        # Never unpack more than a map of that size contains.
        data = unpacker.decompress(packed, size + 1)
    except (binascii.Error, zlib.error, ValueError, EOFError) as error:
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


def _zstandard() -> Callable[[bytes, int], bytes] | None:
    """Return a function that unpacks zstd up to a size; None if no package does."""
    try:
        import zstandard
    except ImportError:
        return None

    def unpack(packed: bytes, size: int) -> bytes:
        try:
            with zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(
                packed
            ) as stream:
                data = bytes(stream.read(size + 1))
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from error
        return data[: len(data) // 4 * 4] if len(data) <= size else data[: size + 4]

    return unpack


def first_object(
    layers: list[TiledLayer], names: Collection[str]
) -> tuple[TiledPart, TiledLayer] | None:
    """Return the first object with one of these names, classes or types, ignoring case.

    Further ones are other places for a robot.
    """
    found = [
        (part, layer) for layer in layers for part in objects_of(layer)
        if any(str(part.peek(key, "")).lower() in names for key in ("name", "class", "type"))
    ]  # fmt: skip
    for part, _ in found:
        part.pass_over()
    return found[0] if found else None


def objects_of(layer: TiledLayer) -> list[TiledPart]:
    """Return the objects of a layer of objects, without taking them."""
    objects = layer.part.peek("objects")
    if layer.kind != "objectgroup" or not isinstance(objects, list):
        return []
    return [part for part in objects if isinstance(part, NamedParts)]


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
