"""The manifest of a set: one line of JSON for each of its worlds."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta

from worldgen.domain import MASK64
from worldgen.errors import FormatError
from worldgen.files.json_file import converted, faulty_field, plain
from worldgen.plugins.trust import NameInFile, note_names
from worldgen.world import Value

FORMAT = "worldgen-set 1"
MANIFEST = "manifest.jsonl"

# Limit on the bytes of a line, as for a .grid file's header.
_LONGEST = 1 << 20

# Types of a line's keys; if a value has another type, the description completes the message.
_Text = Annotated[str, Meta(description="must be text")]
_Flag = Annotated[bool, Meta(description="must be true or false")]
_Table = Annotated[Mapping[str, Any], Meta(description="must be an object")]
# msgspec compares with bounds of 64 bits with a sign; a seed can be larger, see ``_check``.
_Seed = Annotated[int, Meta(ge=0, description=f"must be a whole number of 0 to {MASK64}")]
_MOST = (1 << 63) - 1
_Whole = Annotated[int, Meta(ge=0, le=_MOST, description=f"must be a whole number of 0 to {_MOST}")]
_Count = Annotated[int, Meta(ge=1, le=_MOST, description=f"must be a whole number of 1 to {_MOST}")]
_Hex = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z", description="must be 64 hex digits")]
_Ends = Annotated[tuple[int | float, ...], Meta(description="must be a list of numbers")]
# A name with another separator could write outside the set's folder.
_File = Annotated[
    str,
    Meta(
        pattern=r"^(?:[0-9]{1,12}/)?[A-Za-z0-9_-][A-Za-z0-9._-]{0,200}\.grid\Z",
        description="is not the name of a world's file in a set, such as maze-7.grid or "
        "0012/maze-7.grid",
    ),
]


class ManifestHeader(msgspec.Struct, frozen=True):
    """The first line: the request.

    Args:
        family: Name of the family.
        version: Its version.
        params: All its parameters; for a search, those with fixed values.
        seed: Seed of the first world, or of the search.
        count: Worlds in the finished set.
        metrics: True if each world is measured.
        worldgen: Version of worldgen that made the set.
        constraint: The constraint that the worlds satisfy; empty if their seeds are consecutive.
        strata: Edges of the strata of difficulty that the worlds are spread over, ascending; empty
            if there are none.
    """

    family: _Text
    version: _Whole
    params: _Table
    seed: _Seed
    count: _Count
    metrics: _Flag
    worldgen: _Text
    constraint: _Text = ""
    strata: _Ends = ()

    def line(self) -> bytes:
        """Return the line, with its line end."""
        head = {
            "format": FORMAT,
            "worldgen": self.worldgen,
            "family": self.family,
            "version": self.version,
        }
        asked = {
            "seed": self.seed,
            "count": self.count,
            "params": _sorted(self.params),
            "metrics": self.metrics,
        }
        searched = {"constraint": self.constraint} if self.constraint else {}
        strata = {"strata": list(self.strata)} if self.strata else {}
        return _line({**head, **asked, **searched, **strata})


class ManifestEntry(msgspec.Struct, frozen=True, omit_defaults=True):
    """The line of a world.

    Args:
        file: Name of its file in the set.
        family: Name of the family.
        version: Its version.
        seed: Seed.
        params: All parameters, including those of the first line.
        digest: The world's id, 64 hex digits.
        sha256: SHA-256 of the file, 64 hex digits.
        size: Length of the file, bytes.
        metrics: Metrics of the world, as stored in its file.
        stratum: Lower and upper end of its stratum of difficulty; empty if the set has none.
    """

    file: _File
    family: _Text
    version: _Whole
    seed: _Seed
    params: _Table
    digest: _Hex
    sha256: _Hex
    size: _Whole = msgspec.field(name="bytes")
    metrics: _Table
    stratum: _Ends = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the keys and values of the line, with all parameters."""
        return {**plain(self), "params": _sorted(self.params), "metrics": _sorted(self.metrics)}

    def line(self, header: ManifestHeader) -> bytes:
        """Return the line, with its line end.

        It has only those parameters that differ from the first line's.
        """
        own = _differing(self.params, header) if self.family == header.family else self.params
        return _line({**self.as_dict(), "params": _sorted(own)})


L = TypeVar("L", ManifestHeader, ManifestEntry)


@dataclass(frozen=True)
class Manifest:
    """A manifest read from a file.

    Args:
        header: Its first line, parsed.
        first: Its first line, byte for byte.
        entries: The worlds, in order.
        lines: The worlds' lines, byte for byte, in the same order.
    """

    header: ManifestHeader
    first: bytes
    entries: list[ManifestEntry]
    lines: list[bytes]

    @property
    def finished(self) -> bool:
        """True if every world has its line."""
        return len(self.entries) >= self.header.count


def parse_manifest(lines: Iterable[bytes], source: str) -> Manifest:
    """Read a manifest; an incomplete last line, left by an interruption, is ignored.

    Args:
        lines: The lines, with their ends.
        source: The file's name in messages.

    Raises:
        FormatError: If a complete line is invalid, with its number.
    """
    reader = _whole_lines(lines, source)
    # The header is on the first line, and every later line is checked against it.
    first = next(reader, None)
    if first is None:
        raise FormatError(
            "empty", "is empty; a manifest begins with a line about the set", source=source
        )
    header = _header(first, source)
    entries = []
    kept = []
    files = set()
    for number, line in enumerate(reader, 2):
        entry = _entry(line, header, number, source)
        # Two entries of one name would overwrite each other's file.
        if entry.file in files:
            raise FormatError(
                "twice",
                "{file} is listed twice",
                "each file must have one line",
                file=entry.file,
                line=number,
                source=source,
            )
        files.add(entry.file)
        entries.append(entry)
        kept.append(line)
    # A file with more lines than its header states was concatenated or edited.
    if len(entries) > header.count:
        raise FormatError(
            "wrong-count",
            "{worlds} worlds, but the first line promises {said}",
            "correct one of them",
            worlds=len(entries),
            said=header.count,
            source=source,
        )
    return Manifest(header, first, entries, kept)


def read_manifest(path: Path) -> Manifest:
    """Read the manifest in a file.

    Raises:
        FormatError: If it cannot be read, or isn't a manifest.
    """
    try:
        with path.open("rb") as stream:
            return parse_manifest(iter(lambda: stream.readline(_LONGEST + 1), b""), str(path))
    except OSError as error:
        raise FormatError.unreadable(path, error) from error


def _whole_lines(lines: Iterable[bytes], source: str) -> Iterator[bytes]:
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST:
            raise FormatError(
                "too-large",
                "a line of more than {most} bytes",
                "use a manifest",
                most=_LONGEST,
                line=number,
                source=source,
            )
        if line.endswith(b"\n"):
            yield line


def _object(line: bytes, number: int, source: str) -> dict[str, Any]:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError) as error:
        reason = error.msg if isinstance(error, json.JSONDecodeError) else type(error).__name__
        raise FormatError(
            "not-json",
            "not a line of JSON: {reason}",
            "use a manifest",
            reason=reason,
            line=number,
            source=source,
        ) from error
    if not isinstance(found, dict):
        raise FormatError(
            "not-json",
            "not a JSON object; each line of a manifest must be one",
            line=number,
            source=source,
        )
    return found


def _header(line: bytes, source: str) -> ManifestHeader:
    """Read the first line."""
    found = _object(line, 1, source)
    # Check the format first: without it, no other message would make sense.
    if found.get("format") != FORMAT:
        rule = f'must be "{FORMAT}"; is this the manifest of a set, or of a later version?'
        raise _wrong(found, "format", rule, line=1, source=source)
    header = _content(found, ManifestHeader, line=1, source=source)
    _check(found, "strata", header.strata, header.seed, line=1, source=source)
    note_names([header.family, header.params], source)
    return msgspec.structs.replace(header, family=NameInFile(header.family))


def _entry(line: bytes, header: ManifestHeader, number: int, source: str) -> ManifestEntry:
    """Read a world's line; it has all parameters, or those that differ from the set's.

    Older sets store all of them.
    """
    found = _object(line, number, source)
    entry = _content(found, ManifestEntry, line=number, source=source)
    _check(found, "stratum", entry.stratum, entry.seed, line=number, source=source)
    if entry.family != header.family:
        note_names([entry.family, entry.params], source)
        return msgspec.structs.replace(entry, family=NameInFile(entry.family))
    # Share the set's parameters, because a set may have 100,000 worlds.
    own = _differing(entry.params, header)
    note_names(own, source)
    params = {**header.params, **own} if own else header.params
    return msgspec.structs.replace(entry, family=header.family, params=params)


def _content(found: Mapping[str, Any], kind: type[L], **place: Any) -> L:
    """Return the content of a line in the form that its type declares.

    Raises:
        FormatError: If a key is missing or wrong; the message names the first one.
    """
    try:
        return converted(found, kind)
    except ValueError as error:
        field = faulty_field(found, kind)
        if field is None:
            raise
        rule = field.type.__metadata__[0].description
        raise _wrong(found, field.encode_name, rule, **place) from error


def _check(
    found: Mapping[str, Any], key: str, ends: tuple[float, ...], seed: int, **place: Any
) -> None:
    """Check what a type cannot declare: the largest seed, and that the ends of strata ascend."""
    if seed > MASK64:
        raise _wrong(found, "seed", f"must be at most {MASK64}", **place)
    if any(a >= b for a, b in itertools.pairwise(ends)) or len(ends) == 1:
        raise _wrong(found, key, "must ascend, from the lower end to the upper", **place)


def _wrong(found: Mapping[str, Any], key: str, rule: str, **place: Any) -> FormatError:
    is_there = key in found
    return FormatError(
        "wrong-value" if is_there else "missing-key",
        "{key} {value} {rule}" if is_there else "{key} is missing; it {rule}",
        key=key,
        value=json.dumps(found[key])[:80] if is_there else None,
        rule=rule,
        **place,
    )


def _line(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _differing(params: Mapping[str, Value], header: ManifestHeader) -> dict[str, Value]:
    """Return parameters that differ from the first line; 1 differs from 1.0, and 0.0 from -0.0."""
    rest = header.params
    return {
        name: value
        for name, value in params.items()
        if name not in rest or repr(rest[name]) != repr(value)
    }


def _sorted(values: Mapping[str, Any]) -> dict[str, Any]:
    return dict(sorted(values.items()))
