"""Read files, plain or compressed, within a limit; write them completely or not at all."""

from __future__ import annotations

import gzip
import io
import zlib
from collections.abc import Iterable
from os import PathLike
from pathlib import Path, PurePosixPath

from worldgen.errors import FormatError, OutputError
from worldgen.files.archives import Member, archive_in, members
from worldgen.files.grid.reader import loads
from worldgen.files.grid.schema import EXPANSION_FLOOR, EXPANSION_RATIO, MAX_FILE_BYTES
from worldgen.files.grid.writer import dumps, pieces
from worldgen.files.whole import read_bytes, read_up_to, write_bytes
from worldgen.world import World

# zlib's own default, fixed so that equal worlds give equal files.
_COMPRESSION = 6


def read_world(path: str | PathLike[str]) -> World:
    """Read the world in a file; names ending in ``.gz`` are decompressed.

    Args:
        path: The file; for one in an archive, the archive's path followed by its own name,
            ``set.zip/maze-7.grid``.

    Raises:
        FormatError: If the file cannot be read, or isn't a ``.grid`` file; with the line if there
            is one.
    """
    return unpack(read_packed(Path(path)), str(path))


def read_packed(path: Path) -> bytes:
    """Return the bytes of a world's file, which may be compressed, as :func:`read_world` finds it.

    Raises:
        FormatError: If the file cannot be read.
    """
    place = archive_in(path)
    if place is None:
        return read_bytes(path, MAX_FILE_BYTES, "split the world")
    archive, name = place
    for member in members(archive):
        # tar writes ./w.grid for a folder that is packed as ``.``.
        if PurePosixPath(member.name).as_posix() == name:
            return member.read_all(_expansion_limit(member.packed), str(path))
    raise FormatError(
        "no-such-file",
        "holds no file {name!r}",
        "list its files to find the name",
        name=name,
        source=str(archive),
    )


def unpack(data: bytes, source: str) -> World:
    """Return the world in the bytes of a file, which are compressed if its name says so.

    Args:
        data: The file's bytes.
        source: Its name.

    Raises:
        FormatError: If it isn't a ``.grid`` file.
    """
    return loads(_expand(data, source) if _is_compressed(source) else data, source)


def unpack_world(member: Member, source: str) -> World:
    """Read the world in a file of an archive.

    Args:
        member: The file.
        source: Its name in messages.

    Raises:
        FormatError: If it cannot be read, or isn't a ``.grid`` file.
    """
    return unpack(member.read_all(_expansion_limit(member.packed), source), source)


def write_world(world: World, path: str | PathLike[str], *, force: bool = False) -> None:
    """Write the canonical text of a world; names ending in ``.gz`` are compressed.

    Args:
        world: The world.
        path: Path of the file.
        force: Whether to overwrite an existing file.

    Raises:
        InvalidWorld: If the format cannot express the world.
        OutputError: If the file exists, or cannot be written; no partial file is left behind.
    """
    if _is_compressed(str(path)):
        data, length = _compress(pieces(world))
        if length > _expansion_limit(len(data)):
            raise OutputError(
                "packed-too-tightly",
                "{path}: {length} bytes would be compressed beyond what reading allows",
                "write it without .gz",
                path=path,
                length=length,
            )
    else:
        data = dumps(world)
        length = len(data)
    if length > MAX_FILE_BYTES:
        raise OutputError(
            "too-large",
            "{path}: {length} bytes; a .grid file has at most {most}",
            "split the world",
            path=path,
            length=length,
            most=MAX_FILE_BYTES,
        )
    write_bytes(Path(path), data, force=force)


def _expansion_limit(compressed: int) -> int:
    """Return the bytes that a compressed file of this size may expand to."""
    return min(MAX_FILE_BYTES, max(EXPANSION_FLOOR, EXPANSION_RATIO * compressed))


def _is_compressed(name: str) -> bool:
    return name.lower().endswith(".gz")


def _compress(text: Iterable[bytes]) -> tuple[bytes, int]:
    """Return gzip data without name or time, so that equal worlds give equal files.

    Also return the length of the uncompressed data.
    """
    packed = io.BytesIO()
    length = 0
    with gzip.GzipFile(
        filename="", mode="wb", compresslevel=_COMPRESSION, fileobj=packed, mtime=0
    ) as stream:
        for piece in text:
            length += stream.write(piece)
    return packed.getvalue(), length


def _expand(data: bytes, source: str) -> bytes:
    # Never expand more than such a file may hold.
    limit = _expansion_limit(len(data))
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
            expanded = read_up_to(stream, limit)
    except EOFError as error:
        raise FormatError(
            "cut-short",
            "the gzip data ends too early; the file is truncated",
            "copy it again",
            source=source,
        ) from error
    except (OSError, zlib.error) as error:
        raise FormatError(
            "damaged-file",
            "not valid gzip data: {reason}",
            "copy the file again, or name it without .gz",
            reason=str(error),
            source=source,
        ) from error
    if expanded is None:
        raise FormatError(
            "too-large",
            "{bytes} compressed bytes expand to more than the limit of {most}",
            "unpack it by hand",
            bytes=len(data),
            most=limit,
            source=source,
        )
    return expanded
