"""Read whole numbers from a Java serialisation stream.

``ObjectOutputStream.writeInt`` writes such streams.

Source: Java Object Serialization Specification, version 6, chapter 6, "Object Serialization Stream
    Protocol".
"""

from __future__ import annotations

from typing import NoReturn

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError

Ints = npt.NDArray[np.int32]

MAGIC = b"\xac\xed"
_VERSION = 5
_HEADER = MAGIC + _VERSION.to_bytes(2, "big")
# Records of raw bytes, with their length in one byte or in four.
_SHORT = 0x77
_LONG = 0x7A
# Bytes that ObjectOutputStream collects before it writes a record.
_BLOCK = 1024
_RECORDS = {
    0x70: "a null",
    0x71: "a reference",
    0x72: "a class description",
    0x73: "an object",
    0x74: "a string",
    0x75: "an array",
    0x76: "a class",
    0x78: "an end of block data",
    0x79: "a reset",
    0x7B: "an exception",
    0x7C: "a long string",
    0x7D: "a proxy class",
    0x7E: "an enum constant",
}


def read_ints(data: bytes) -> Ints:
    """Return the numbers of a stream that contains nothing else.

    Returns:
        (n,) int32.

    Raises:
        FormatError: If the header is different, a record isn't raw bytes, is empty or is cut short,
            or the bytes end within a number.
    """
    _check_header(data)
    # Join the records' bytes.
    payload = bytearray()
    at = len(_HEADER)
    while at < len(data):
        first, length = _record(data, at)
        if length == 0:
            raise FormatError(
                "empty-block",
                "byte {at}: an empty block; every block of a map holds numbers",
                at=at,
            )
        if length > len(data) - first:
            raise FormatError(
                "cut-short",
                "byte {at}: a block of {length} bytes, of which the file has {left}; it is "
                "truncated or damaged",
                "fetch it again",
                at=at,
                length=length,
                left=len(data) - first,
            )
        payload += data[first : first + length]
        at = first + length
    # They are numbers of four bytes each.
    if len(payload) % 4:
        raise FormatError(
            "cut-short",
            "{count} bytes of numbers; a number has 4, so the last one is truncated",
            "fetch the file again",
            count=len(payload),
        )
    return np.frombuffer(payload, ">i4").astype(np.int32)


def _check_header(data: bytes) -> None:
    if data[:2] != MAGIC[: len(data)] or not data:
        came = data[:2].hex(" ").upper() or "nothing"
        raise FormatError(
            "unknown-format",
            "begins with {came}, but a Java object stream begins with AC ED 00 05",
            "use a file that the program saved",
            came=came,
        )
    if len(data) < len(_HEADER):
        raise FormatError(
            "cut-short",
            "ends after {bytes} bytes, within the header AC ED 00 05",
            "fetch it again",
            bytes=len(data),
        )
    version = int.from_bytes(data[2:4], "big")
    if version != _VERSION:
        raise FormatError(
            "unknown-version",
            "version {version} of Java's object stream; the only known version is {known}",
            "fetch the file again",
            version=version,
            known=_VERSION,
        )


def _record(data: bytes, at: int) -> tuple[int, int]:
    """Return where the bytes of a record begin, and their number."""
    kind = data[at]
    if kind not in (_SHORT, _LONG):
        _refuse_record(kind, at)
    first = at + (2 if kind == _SHORT else 5)
    if first > len(data):
        raise FormatError(
            "cut-short", "byte {at}: ends within a block's length", "fetch the file again", at=at
        )
    return first, int.from_bytes(data[at + 1 : first], "big")


def _refuse_record(kind: int, at: int) -> NoReturn:
    what = _RECORDS.get(kind, "not a record of Java")
    raise FormatError(
        "not-numbers",
        "byte {at}: {kind:02X} is {what}; a map holds only bare numbers (records 77 and 7A)",
        "use a file that the program's map editor saved",
        at=at,
        kind=kind,
        what=what,
    )


def write_ints(values: npt.NDArray[np.integer]) -> bytes:
    """Return the stream as ``ObjectOutputStream`` writes it, byte for byte.

    It consists of full blocks, then the rest.

    Args:
        values: Numbers of at most 32 bits, in the order of writing.
    """
    payload = values.astype(">i4").tobytes()
    stream = bytearray(_HEADER)
    for at in range(0, len(payload), _BLOCK):
        block = payload[at : at + _BLOCK]
        short = len(block) <= 255
        stream.append(_SHORT if short else _LONG)
        stream += len(block).to_bytes(1 if short else 4, "big") + block
    return bytes(stream)


def stream_bytes(count: int) -> int:
    """Return the largest size of a stream that holds ``count`` numbers in full blocks."""
    return len(_HEADER) + 4 * count + 5 * (4 * count // _BLOCK + 1)
