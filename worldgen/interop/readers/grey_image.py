"""Grey pictures of maps: PGM by our own reader, exact in every depth; the others by Pillow.

A picture is untrusted: the sizes in its header are checked before anything is allocated for them.
"""

from __future__ import annotations

import io
import re
import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt
from PIL import Image, PngImagePlugin, UnidentifiedImageError

from worldgen.errors import FormatError
from worldgen.interop.account import report_unread
from worldgen.interop.format.foreign_map import check_sides, digest, naming, read_bounded
from worldgen.support.arrays import Bools, Bytes
from worldgen.support.plain_text import quote
from worldgen.support.rows import flip_rows

_PILLOW_FORMATS = ("PNG", "BMP", "JPEG", "TIFF")
_PNG = b"\x89PNG\r\n\x1a\n"
# Chunks of a PNG: those that make its pixels, and those about colours, texts, sizes and times.
# Others belong to single programs, and may hold whole layers.
_CHUNKS = frozenset(
    b"IHDR PLTE IDAT IEND tRNS bKGD cHRM cICP cLLI mDCV gAMA hIST iCCP iTXt tEXt zTXt oFFs pCAL pHYs sBIT sCAL sPLT "
    b"sRGB sTER tIME eXIf dSIG vpAg caNv orNT iDOT".split()
)
# Tags of a TIFF: how it is turned, smaller pictures inside it, and layers of a drawing program.
_ORIENTATION = 274
_INNER_PICTURES = (330, 37724)
# One header field of a PGM: white space and comments (from # to the end of the line), then digits.
_FIELD = re.compile(rb"(?:\s|#[^\r\n]*+[\r\n])++([0-9]{1,9})")
_COMMENT = re.compile(rb"#[^\r\n]*+")
# The largest value, 65535.
_MAX_DIGITS = 5


@dataclass(frozen=True, eq=False)
class GreyImage:
    """A grey picture.

    Args:
        values: (height, width) uint8 or uint16, top row first, 0 black to ``maximum`` white.
        maximum: The value of white.
        alpha: (height, width) uint8 if the picture has transparency: 0 clear to 255 opaque.
        text: Text chunks of a PNG, by keyword.
    """

    values: npt.NDArray[np.uint8 | np.uint16]
    maximum: int = 255
    alpha: Bytes | None = None
    text: Mapping[str, str] = field(default_factory=dict)

    def report_transparent(self) -> None:
        """Report pixels that are not opaque as unread, for programs that have no rule for them."""
        if self.opaque is not None:
            report_unread("pixels with transparency", int(np.count_nonzero(~self.opaque)))

    @property
    def opaque(self) -> Bools | None:
        """A mask of transparency: True where not fully opaque."""
        return None if self.alpha is None else self.alpha == 255


def pgm_bytes(values: Bytes) -> bytes:
    """Return a binary PGM of greys, top row first.

    Its maximum is 255, because some loaders misread any other.
    """
    height, width = values.shape
    return b"P5\n%d %d\n255\n" % (width, height) + values.tobytes()


def png_bytes(values: Bytes, text: Mapping[str, str] | None = None) -> bytes:
    """Return a grey PNG.

    Args:
        values: (height, width), top row first.
        text: Text chunks, by keyword; written in this order, before the pixels.
    """
    said = PngImagePlugin.PngInfo()
    for keyword, words in (text or {}).items():
        said.add_text(keyword, words)
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(values)).save(stream, "PNG", pnginfo=said)
    return stream.getvalue()


def walls_png(solid: Bools, text: Mapping[str, str] | None = None) -> bytes:
    """Return a PNG of cells: solid black, free white.

    Args:
        solid: (height, width), row 0 the lowest y.
        text: As for :func:`png_bytes`.
    """
    return png_bytes(np.where(flip_rows(solid), np.uint8(0), np.uint8(255)), text)


def read_picture_file(path: Path) -> tuple[GreyImage, str]:
    """Return a picture that a map file names, and its digest."""
    data = read_bounded(path)
    with naming(path):
        return read_grey_image(data), digest(data)


def read_grey_image(data: bytes) -> GreyImage:
    """Decode a picture of a map.

    Args:
        data: PGM (P2 or P5), PNG, BMP, JPEG or TIFF; colours become grey by their luma (ITU-R
            BT.601).

    Raises:
        FormatError: If it is not one of these, damaged, or too large.
    """
    if data[:2] in (b"P2", b"P5"):
        return _read_pgm(data)
    return _read_with_pillow(data)


def _read_pgm(data: bytes) -> GreyImage:
    # Read the three numbers of the header.
    at = 2
    fields = []
    for name in ("width", "height", "maximum"):
        match = _FIELD.match(data, at)
        if match is None:
            came = quote((data[at : at + 40].split() or [b""])[0])
            raise FormatError(
                "wrong-form",
                "the PGM header has {came} in place of the {name}; after {magic!q} it "
                "has width, height and maximum as whole numbers",
                came=came,
                name=name,
                magic=data[:2],
                line=_line(data, at),
            )
        fields.append(int(match[1]))
        at = match.end()
    width, height, maximum = fields
    check_sides(width, height, line=_line(data, at))
    if not 0 < maximum < 65536:
        raise FormatError(
            "out-of-range",
            "maximum {maximum}; a PGM has 1 to 65535",
            "save it again",
            maximum=maximum,
            line=_line(data, at),
        )
    # Read the pixels, as text or as bytes.
    if data[:2] == b"P2":
        values = _plain_raster(data, at, width * height)
    else:
        values = _binary_raster(data, at, width * height, 1 if maximum < 256 else 2)
    if int(values.max()) > maximum:
        raise FormatError(
            "above-maximum",
            "a pixel is {pixel}, above the maximum {maximum}",
            "the file is damaged, save it again",
            pixel=int(values.max()),
            maximum=maximum,
        )
    grey = values.astype(np.uint8) if maximum < 256 else values.astype(np.uint16)
    return GreyImage(grey.reshape(height, width), maximum)


def _binary_raster(data: bytes, at: int, count: int, width: int) -> npt.NDArray[np.integer[Any]]:
    """Return pixels of ``width`` bytes, high byte first, after the blank that ends the header."""
    size = count * width
    rest = len(data) - at - 1
    if rest < size or not data[at : at + 1].isspace():
        raise FormatError(
            "wrong-length",
            "{bytes} bytes of pixels, but the header's sizes need {needed}; the file is "
            "truncated, copy it again",
            bytes=max(rest, 0),
            needed=size,
        )
    if data[at + 1 + size :].strip():
        raise FormatError(
            "wrong-length",
            "{excess} bytes more than the header's sizes need ({needed}); the file was changed, "
            "perhaps by copying it as text",
            "copy it as binary",
            excess=rest - size,
            needed=size,
        )
    return np.frombuffer(data, ">u1" if width == 1 else ">u2", count, at + 1)


def _plain_raster(data: bytes, at: int, count: int) -> npt.NDArray[np.integer[Any]]:
    """Return pixels given as decimal words.

    They are converted together, because Python objects would take 30 times the file's size.
    """
    # Find the words; anything but digits and blanks is a fault.
    text = _COMMENT.sub(b"", data[at:]) if data.find(b"#", at) >= 0 else data[at:]
    raw = np.frombuffer(text, np.uint8)
    is_digit = (raw >= ord("0")) & (raw <= ord("9"))
    is_space = (raw == ord(" ")) | ((raw >= 9) & (raw <= 13))
    if not (is_digit | is_space).all():
        _wrong_word(data, text, int(np.argmin(is_digit | is_space)))
    edges = np.flatnonzero(np.diff(is_digit.astype(np.int8), prepend=np.int8(0), append=np.int8(0)))
    begin = edges[::2]
    end = edges[1::2]
    if len(begin) != count:
        raise FormatError(
            "wrong-length",
            "{pixels} pixels, but the header's sizes need {needed}; the file is damaged, save it "
            "again",
            pixels=len(begin),
            needed=count,
        )
    # Convert all words together, digit by digit.
    lengths = end - begin
    if int(lengths.max()) > _MAX_DIGITS:
        _wrong_word(data, text, int(begin[int(np.argmax(lengths > _MAX_DIGITS))]))
    values = np.zeros(count, np.int32)
    for digit in range(int(lengths.max())):
        here = lengths > digit
        values[here] = values[here] * 10 + (raw[begin[here] + digit] - ord("0"))
    return values


def _wrong_word(data: bytes, text: bytes, at: int) -> NoReturn:
    # Comments were removed but line ends were not, so lines are counted from the end of both.
    line = data.count(b"\n") - text.count(b"\n", at) + 1
    word = quote(text[at : at + 40].split()[0] if text[at : at + 1].strip() else text[at : at + 1])
    raise FormatError(
        "not-a-pixel",
        "{word} is not a pixel; a plain PGM holds whole numbers up to its maximum",
        word=word,
        line=line,
    )


def _line(data: bytes, at: int) -> int:
    return data.count(b"\n", 0, at) + 1


def _read_with_pillow(data: bytes) -> GreyImage:
    try:
        with warnings.catch_warnings():
            # check_sides below rejects a decompression bomb before it is unpacked.
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data), formats=_PILLOW_FORMATS) as image:
                check_sides(*image.size)
                grey = _to_grey(image)
                report_unread("frames after the first", getattr(image, "n_frames", 1) - 1)
                _account_for_tags(image)
        if data.startswith(_PNG):
            _account_for_chunks(data)
        return grey
    except (FormatError, MemoryError):
        raise
    except Image.DecompressionBombError as error:
        raise FormatError(
            "too-large", "has more pixels than any map needs", "cut or shrink it"
        ) from error
    except UnidentifiedImageError as error:
        raise FormatError(
            "unknown-format", "is not a PGM, PNG, BMP, JPEG or TIFF picture", "convert it"
        ) from error
    # Pillow's decoders raise all kinds of exceptions on damaged files.
    except Exception as error:
        raise FormatError(
            "damaged-file",
            "is a damaged picture: {reason}",
            "save it again",
            reason=error or type(error).__name__,
        ) from error


def _account_for_chunks(data: bytes) -> None:
    """Report what a PNG holds besides its picture; Pillow has already checked its structure."""
    at = len(_PNG)
    kind = b""
    strange: Counter[bytes] = Counter()
    while kind != b"IEND" and at + 12 <= len(data):
        kind = data[at + 4 : at + 8]
        strange[kind] += kind not in _CHUNKS
        at += 12 + int.from_bytes(data[at : at + 4], "big")
    report_unread("chunks of the picture that only other programs know", strange.total())
    report_unread("bytes after the picture's end", len(data[at:].strip(b"\0\r\n")))


def _account_for_tags(image: Image.Image) -> None:
    """Report tags that turn a picture, which programs read differently, and pictures inside it."""
    tags = image.getexif()
    report_unread("orientations of the picture", tags.get(_ORIENTATION, 1) != 1)
    report_unread("layers in the picture", sum(tag in tags for tag in _INNER_PICTURES))


def _to_grey(image: Image.Image) -> GreyImage:
    image.load()
    text = {str(keyword): str(words) for keyword, words in getattr(image, "text", {}).items()}
    # 16-bit grey; convert("L") would clip it at 255.
    if image.mode.startswith("I"):
        return _deep_grey(image, text)
    if image.mode == "F":
        raise FormatError(
            "unsupported",
            "holds floating-point numbers, of which black and white are unknown",
            "save it with 8 or 16 bits per pixel",
        )
    alpha = None
    if "transparency" in image.info or image.mode.endswith(("A", "a")):
        image = image.convert("RGBA")
        alpha = np.asarray(image.getchannel("A"))
    return GreyImage(np.asarray(image.convert("L")), 255, alpha, text)


def _deep_grey(image: Image.Image, text: Mapping[str, str]) -> GreyImage:
    """Return a picture of 16 bits per pixel; one grey of a PNG may stand for transparency."""
    wide = np.asarray(image).astype(np.int64)
    if wide.min() < 0 or wide.max() > 65535:
        raise FormatError(
            "out-of-range",
            "has pixels from {least} to {most}; a grey has at most 16 bits",
            "save it with 8 or 16 bits per pixel",
            least=int(wide.min()),
            most=int(wide.max()),
        )
    clear = image.info.get("transparency")
    alpha = None if clear is None else np.where(wide == clear, 0, 255).astype(np.uint8)
    return GreyImage(wide.astype(np.uint16), 65535, alpha, text)
