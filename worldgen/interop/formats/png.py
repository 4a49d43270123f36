"""Pictures as maps: dark is solid. Ours also store scale, start, target and robot as PNG text."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from worldgen.domain import CELL_SIZES
from worldgen.errors import FormatError, InvalidParameter, Note
from worldgen.family import check_between
from worldgen.interop.format import HELD, Destination, Exported, Format, decimal
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot, read_bounded
from worldgen.interop.readers.grey_image import GreyImage, read_grey_image, walls_png
from worldgen.interop.readers.places_text import KEYS, from_decimal, place_words, read_places
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

# Keyword that identifies our own pictures; without it the other keywords are ignored.
_MARK = "worldgen"
_WHITE = 255
_SUFFIXES = (".png", ".pgm", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff")


def read_picture(
    path: Path,
    *,
    cell_size: float = 0.0,
    threshold: int = 128,
    background: Literal["free", "solid"] = "free",
) -> ForeignMap:
    """Read a picture whose dark pixels are solid cells.

    Args:
        path: PNG, PGM, BMP, JPEG or TIFF, of any depth; colours count by their luma (ITU-R BT.601).
        cell_size: Side of a pixel, m; 0 means the picture's own scale, otherwise 0.1.
        threshold: Grey, black 0 to white 255, from which a pixel is free.
        background: What transparent pixels become: free is white, solid is black.

    Raises:
        FormatError: If it is not such a picture, or its facts about start, target or robot are
            impossible.
        InvalidParameter: If an option is out of range.
    """
    # Read the picture and its text.
    check_between("threshold", threshold, 1, _WHITE)
    data = read_bounded(path)
    image = read_grey_image(data)
    walls, greys = _solid(image, threshold, background)
    clear = 0 if image.opaque is None else int(np.count_nonzero(~image.opaque))
    try:
        own_size, origin, robot = _said(image)
    except InvalidParameter as error:
        raise FormatError.of(error.message.behind("its text: ")) from error
    # Explain what the picture leaves open.
    notes = []
    if clear:
        notes.append(
            f"{clear:,} of {walls.size:,} pixels are transparent; they are laid on "
            f"{'white, which is free' if background == 'free' else 'black, which is solid'}; change "
            f"this with +background={'solid' if background == 'free' else 'free'}"
        )
    if greys:
        notes.append(
            f"{greys} of {walls.size} pixels are neither black nor white; those darker than "
            f"{threshold} of {_WHITE} are solid; change this with +threshold=N"
        )
    if own_size is None and not cell_size:
        notes.append(
            Note(
                "no-scale",
                "the picture has no scale; a pixel counts as {cell_size:g} m",
                "--cell-size says another",
                at_terminal=True,
                cell_size=DEFAULT_CELL_SIZE,
            )
        )
    for ending in (".yaml", ".yml"):
        if own_size is None and path.with_suffix(ending).is_file():
            notes.append(
                f"{path.with_suffix(ending).name} next to it may be the map that has scale and "
                f"origin"
            )
    params: dict[str, Value] = {"threshold": threshold, "background": background}
    return ForeignMap(
        flip_rows(walls), cell_size or own_size or DEFAULT_CELL_SIZE, params, tuple(notes),
        origin=origin, is_picture=True,
        robots=(robot,),
    )  # fmt: skip


def _solid(image: GreyImage, threshold: int, background: str) -> tuple[Bools, int]:
    """Return the solid pixels, top row first, and how many are neither black nor white."""
    values: npt.NDArray[np.integer[Any]] = image.values
    maximum = image.maximum
    # Lay the picture on its background, at 255 times the resolution.
    if image.alpha is not None:
        behind = 0 if background == "solid" else maximum
        values = (values.astype(np.int32) - behind) * image.alpha + 255 * behind
        maximum *= 255
    between = np.count_nonzero((values > 0) & (values < maximum))
    return values < -(-threshold * maximum // _WHITE), int(between)


def _said(image: GreyImage) -> tuple[float | None, tuple[float, float], ForeignRobot]:
    """Return the cell size, origin and places of our own picture; else None, 0 and none."""
    # Only a picture with our keyword may describe a world.
    text = image.text
    if _MARK not in text:
        return None, (0.0, 0.0), ForeignRobot()
    words = {key: text[key].split() for key in (*KEYS, "resolution", "origin") if key in text}
    size = words.pop("resolution", None)
    corner = words.pop("origin", ["0", "0"])
    if len(corner) != 2 or (size is not None and len(size) != 1):
        raise InvalidParameter(
            "wrong-form",
            "resolution must be one number and origin two",
            "save the picture again from worldgen",
        )
    # Check the numbers, because anybody can edit the text.
    cell_size = None if size is None else from_decimal(size[0])
    if cell_size is not None:
        check_between("resolution", cell_size, *CELL_SIZES, "m")
    origin = (from_decimal(corner[0]), from_decimal(corner[1]))
    return cell_size, origin, read_places(words, origin)


def write_png(world: World, destination: Destination) -> Exported:
    """Return a grey picture, one pixel per cell, black for solid, with its facts in ``tEXt``.

    Raises:
        InvalidParameter: If its suffix belongs to another kind of picture.
    """
    if destination.name.lower().endswith(_SUFFIXES[1:]):
        raise InvalidParameter(
            "wrong-suffix",
            "{name} is not the name of a PNG",
            "give it the ending .png, or use --to ros to write a .yaml with a .pgm",
            at_terminal=True,
            name=destination.name,
        )
    text = {_MARK: "1", "resolution": decimal(world.cell_size)}
    text["origin"] = " ".join(decimal(shift) for shift in destination.origin)
    text |= {key: " ".join(words) for key, words in place_words(world, destination).items()}
    return Exported({destination.name: walls_png(world.walls, text)})


# A picture is a map only if it contains the keyword.
png = Format(
    "png",
    "picture, dark is solid, .png, .pgm, .bmp, .jpg or .tif",
    _SUFFIXES,
    re.compile(rb"(?s)\x89PNG\r\n\x1a\n.{4}IHDR.{21}tEXtworldgen\0"),
    read_picture,
    write_png,
    holds=frozenset(HELD) - {"waypoints"},
    client="any program that opens pictures",
)
