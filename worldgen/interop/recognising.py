"""Recognise a file's format, and read it together with its sidecar."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from worldgen.domain import CELL_SIZES
from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop.account import accounting
from worldgen.interop.format import FORMATS, Format
from worldgen.interop.format.foreign_map import ForeignMap, names_its_file, naming, read_bounded
from worldgen.interop.sidecar import Sidecar, read_sidecar, with_sidecar
from worldgen.parameters import split_options
from worldgen.parameters.bounds import check_between
from worldgen.world import Value

# Bytes read to recognise a file.
_HEAD = 4096
# Suffixes that other files also have.
_COMMON = (
    ".txt",
    ".yaml",
    ".yml",
    ".json",
    ".world",
    ".png",
    ".pgm",
    ".bmp",
    ".jpg",
    ".jpeg",
    ".tif",
    ".tiff",
    ".gz",
    ".stl",
    ".obj",
    ".glb",
    ".gltf",
)
_OURS = "worldgen.interop."
_BAG = "metadata.yaml"
_WAY_OUT = (
    "use the .grid file that it was made from, or a file of another format, as `worldgen formats` "
    "lists them; if it is one of these, name it with --from"
)


def readable_formats(*, plug_ins: bool = True) -> Iterator[Format]:
    """Return the readable formats by name, plug-in formats last."""
    points = FORMATS.entry_points()
    for ours in (True, False) if plug_ins else (True,):
        for name in sorted(points):
            if points[name].value.startswith(_OURS) == ours:
                known = FORMATS.get(name)
                if known.read is not None:
                    yield known


@names_its_file
def find_format(path: Path, name: str | None = None) -> Format:
    """Return a file's format: as given, or by its contents, or by its suffix.

    Raises:
        InvalidParameter: If no format has that name, or it can only be written.
        FormatError: If the file has no known format, or might have several.
    """
    # The user may have named the format.
    if name is not None:
        known = FORMATS.get(name)
        if known.read is None:
            raise InvalidParameter(
                "only-written",
                "{format} can be written but not read",
                "omit --from, or use a file of another format",
                at_terminal=True,
                format=known.name,
            )
        return known
    # Otherwise the contents decide.
    head = _head(path)
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise FormatError("not-utf8", "is text in UTF-16", "save it as UTF-8")
    found = _by_contents(path, head)
    if found:
        return _only(found)
    # Explain the files that look like maps but are not readable ones.
    if path.suffix.lower() == ".scen" or re.match(rb"version\s+1", head):
        raise FormatError(
            "no-map-found",
            "a scenario file has no map",
            "use the .map file, and name this one with --scen",
            at_terminal=True,
        )
    if re.search(rb"(?m)^\s*ros__parameters[ \t]*:", head):
        raise FormatError(
            "no-map-found",
            "has parameters of ROS nodes, and no map",
            "put it next to the map's YAML file, and import that: worldgen import map.yaml --from "
            "{option} --out w.grid",
            at_terminal=True,
            option=f"ros+params={path.name}",
        )
    for known in map(FORMATS.get, FORMATS.entry_points()):
        if known.read is None and known.magic and known.magic.match(head):
            raise FormatError(
                "only-written",
                "is {format} ({summary}), which can be written but not read",
                _WAY_OUT,
                format=known.name,
                summary=known.summary,
            )
    # As a last resort, the suffix decides.
    suffix = path.suffix.lower()
    by_name = [known for known in readable_formats() if suffix in known.suffixes]
    if by_name:
        return _only(by_name)
    formats = [(name, FORMATS.get(name)) for name in sorted(FORMATS.entry_points())]
    written = [name for name, known in formats if known.read is None and suffix in known.suffixes]
    if written:
        raise FormatError(
            "only-written",
            "ends in {suffix}, and {formats} can be written but not read",
            _WAY_OUT,
            at_terminal=True,
            suffix=suffix,
            formats=" and ".join(written),
        )
    raise FormatError(
        "unknown-format",
        "is not a map in a known format",
        "`worldgen formats` lists the known ones; if it is one of these, name it with --from",
        at_terminal=True,
    )


def _only(found: list[Format]) -> Format:
    if len(found) > 1:
        raise FormatError(
            "ambiguous-format",
            "might be in any of several formats: {known!l}",
            "choose one with --from",
            at_terminal=True,
            known=[known.name for known in found],
        )
    return found[0]


def _by_contents(path: Path, head: bytes) -> list[Format]:
    """Return the formats whose pattern matches, or those of them that also fit the suffix.

    Our formats come before plug-ins' formats.
    """
    found: list[Format] = []
    for plug_ins in (False, True):
        found = [
            known
            for known in readable_formats(plug_ins=plug_ins)
            if known.magic and known.magic.match(head)
        ]
        if found:
            break
    named = [known for known in found if path.suffix.lower() in known.suffixes]
    return named or found


def looks_like_a_map(path: Path) -> bool:
    """Return True if a file in a folder is worth reading as a map.

    Its contents decide, or a suffix that only maps have.
    """
    suffix = ".grid" if path.name.lower().endswith(".grid.gz") else path.suffix.lower()
    if suffix not in _COMMON and any(suffix in known.suffixes for known in readable_formats()):
        return True
    try:
        return bool(_by_contents(path, _head(path)))
    except FormatError:
        return False


def _head(path: Path) -> bytes:
    # A bag of ROS 2 is a folder, which this file describes.
    if path.is_dir() and (path / _BAG).is_file():
        path = path / _BAG
    try:
        if path.is_file():
            with path.open("rb") as stream:
                # Windows starts text files with it.
                return stream.read(_HEAD).removeprefix(b"\xef\xbb\xbf")
    except (OSError, ValueError):
        pass
    # Reading the file reports what is wrong with it.
    return read_bounded(path, _HEAD)


def read_map(
    path: Path, name: str | None = None, options: Mapping[str, Value | None] | None = None
) -> ForeignMap:
    """Read a map of any known format; the sidecar supplies what the file does not store.

    Args:
        path: The file.
        name: Format, optionally with ``+option=value``; recognised if omitted.
        options: Settings that the file leaves open; they take precedence over those in ``name``.

    Raises:
        FormatError: If the file or its sidecar breaks the format's rules, or is of an unknown
            format.
        InvalidParameter: If the format is unknown, or lacks an option.
    """
    found, sidecar = read_map_alone(path, name, options)
    return found if sidecar is None else with_sidecar(found, sidecar)


def read_map_alone(
    path: Path, name: str | None = None, options: Mapping[str, Value | None] | None = None
) -> tuple[ForeignMap, Sidecar | None]:
    """Read a map as :func:`read_map` does, but return its sidecar, if any, next to it.

    Only the sidecar's cell size is used.
    """
    format_name, worded = (None, {}) if name is None else split_options(name)
    known = find_format(path, format_name)
    given = known.accept({**worded, **(options or {})}, out=False)
    sidecar = read_sidecar(path)
    takes_cell_size = any(option.name == "cell_size" for option in known.read_options)
    if takes_cell_size and sidecar is not None and "cell_size" in sidecar.values:
        given.setdefault("cell_size", sidecar.values["cell_size"][0])
    cell_size = given.get("cell_size")
    if isinstance(cell_size, float):
        check_between("cell_size", cell_size, *CELL_SIZES, "m")
    with naming(path), accounting() as account:
        found = known.open(path, given)
    params: dict[str, Value] = {
        "format": known.name,
        "source": path.name,
        **_digest_of(path, found),
        **found.params,
    }
    unread = (*found.unread, *account.total(known.harmless))
    return replace(found, params=params, usual_robot=known.usual_robot, unread=unread), sidecar


def _digest_of(path: Path, found: ForeignMap) -> dict[str, Value]:
    """Return the file's digest, unless its reader knows it; a plug-in may read a folder."""
    if "sha256" in found.params or not path.is_file():
        return {}
    # A plug-in may read files of any size.
    with path.open("rb") as stream:
        return {"sha256": hashlib.file_digest(stream, "sha256").hexdigest()}
