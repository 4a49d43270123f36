"""The manifest of a set: one line of JSON for each of its worlds."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from worldgen.errors import FormatError, Message
from worldgen.world import Value

__all__ = [
    "FORMAT",
    "MANIFEST",
    "Manifest",
    "ManifestEntry",
    "ManifestHeader",
    "parse_manifest",
    "read_manifest",
]

FORMAT = "worldgen-set 1"
MANIFEST = "manifest.jsonl"

# Limit on the bytes of a line, as for a .grid file's header.
_LONGEST = 1 << 20
_SAFE = re.compile(r"(?:[0-9]{1,12}/)?[A-Za-z0-9_-][A-Za-z0-9._-]{0,200}\.grid\Z")
_HEX = re.compile(r"[0-9a-f]{64}\Z")


@dataclass(frozen=True)
class ManifestHeader:
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

    family: str
    version: int
    params: Mapping[str, Value]
    seed: int
    count: int
    metrics: bool
    worldgen: str
    constraint: str = ""
    strata: tuple[float, ...] = ()

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


@dataclass(frozen=True)
class ManifestEntry:
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

    file: str
    family: str
    version: int
    seed: int
    params: Mapping[str, Value]
    digest: str
    sha256: str
    size: int
    metrics: Mapping[str, float] = field(default_factory=dict)
    stratum: tuple[float, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the keys and values of the line, with all parameters."""
        return {
            "file": self.file, "family": self.family, "version": self.version, "seed": self.seed,
            "params": _sorted(self.params), "digest": self.digest, "sha256": self.sha256, "bytes": self.size,
            "metrics": _sorted(self.metrics), **({"stratum": list(self.stratum)} if self.stratum else {}),
        }  # fmt: skip

    def line(self, header: ManifestHeader) -> bytes:
        """Return the line, with its line end.

        It has only those parameters that differ from the first line's.
        """
        own = _differing(self.params, header) if self.family == header.family else self.params
        return _line({**self.as_dict(), "params": _sorted(own)})


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
    header = _Fields(_object(first, 1, source), 1, source).header()
    entries = []
    kept = []
    files = set()
    for number, line in enumerate(reader, 2):
        entry = _Fields(_object(line, number, source), number, source).entry(header)
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
        message = Message(
            "wrong-count",
            "{worlds} worlds, but the first line counts {said}",
            "correct one of them",
            worlds=len(entries),
            said=header.count,
        )
        raise FormatError.of(message, source=source)
    return Manifest(header, first, entries, kept)


def read_manifest(path: Path) -> Manifest:
    """Read the manifest in a file.

    Raises:
        FormatError: If it cannot be read, or isn't a manifest.
    """
    try:
        with path.open("rb") as stream:
            return parse_manifest(iter(lambda: stream.readline(_LONGEST + 1), b""), str(path))
    except FileNotFoundError as error:
        raise FormatError(
            "no-such-file", "there is no such file", "check the name", source=str(path)
        ) from error
    except OSError as error:
        raise FormatError(
            "unreadable",
            "cannot be read: {reason}",
            reason=error.strerror or str(error),
            source=str(path),
        ) from error


def _whole_lines(lines: Iterable[bytes], source: str) -> Iterator[bytes]:
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST:
            raise FormatError(
                "too-large",
                "a line of more than {most} bytes",
                "give a manifest",
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
            "give a manifest",
            reason=reason,
            line=number,
            source=source,
        ) from error
    if not isinstance(found, dict):
        raise FormatError(
            "not-json",
            "not a JSON object; each line of a manifest is one",
            line=number,
            source=source,
        )
    return found


@dataclass(frozen=True)
class _Fields:
    """Takes the fields of one line and checks their types."""

    found: dict[str, Any]
    number: int
    source: str

    def header(self) -> ManifestHeader:
        """Return the header."""
        # Check the format first: without it, no other message would make sense.
        if self.found.get("format") != FORMAT:
            raise self._wrong(
                "format",
                f'must be "{FORMAT}"; is this the manifest of a set, or of a later version?',
            )
        metrics = self.found.get("metrics")
        if not isinstance(metrics, bool):
            raise self._wrong("metrics", "must be true or false")
        family = self._text("family")
        version = self._whole("version", 0, 2**63)
        params = self._table("params")
        seed = self._whole("seed", 0, 2**64 - 1)
        count = self._whole("count", 1, 2**63)
        # Older sets call it a wish.
        key = next((key for key in ("constraint", "wish") if key in self.found), "")
        constraint = self._text(key) if key else ""
        return ManifestHeader(
            family,
            version,
            params,
            seed,
            count,
            metrics,
            self._text("worldgen"),
            constraint,
            self._numbers("strata"),
        )

    def entry(self, header: ManifestHeader) -> ManifestEntry:
        """Return a world; its line has all parameters, or those that differ from the set's.

        Older sets store all of them.
        """
        file = self._text("file")
        # A name with a separator could write outside the set's folder.
        if not _SAFE.match(file):
            raise self._wrong(
                "file",
                "is not a name of a world's file in a set, such as maze-7.grid or 0012/maze-7.grid",
            )
        for key in ("digest", "sha256"):
            if not _HEX.match(self._text(key)):
                raise self._wrong(key, "must be 64 hex digits")
        found = self.found
        version = self._whole("version", 0, 2**63)
        seed = self._whole("seed", 0, 2**64 - 1)
        size = self._whole("bytes", 0, 2**63)
        metrics = self._table("metrics")
        family = self._text("family")
        # Worlds of the set's own family record only the parameters that differ from the header's.
        params = self._params(header) if family == header.family else self._table("params")
        return ManifestEntry(
            file,
            family,
            version,
            seed,
            params,
            found["digest"],
            found["sha256"],
            size,
            metrics,
            self._numbers("stratum"),
        )

    def _params(self, header: ManifestHeader) -> Mapping[str, Value]:
        """Return the set's parameters, which 100,000 worlds share, or a world's own added to them."""
        own = _differing(self._table("params"), header)
        return {**header.params, **own} if own else header.params

    def _text(self, key: str) -> str:
        value = self.found.get(key)
        if not isinstance(value, str):
            raise self._wrong(key, "must be text")
        return value

    def _whole(self, key: str, least: int, most: int) -> int:
        value = self.found.get(key)
        if type(value) is not int or not least <= value <= most:
            raise self._wrong(key, f"must be a whole number of {least} to {most}")
        return value

    def _table(self, key: str) -> dict[str, Any]:
        value = self.found.get(key)
        if not isinstance(value, dict):
            raise self._wrong(key, "must be an object")
        return value

    def _numbers(self, key: str) -> tuple[float, ...]:
        """Return ascending numbers, or none if the line has no such key."""
        value = self.found.get(key, [])
        if not isinstance(value, list) or not all(type(one) in (int, float) for one in value):
            raise self._wrong(key, "must be numbers in a list")
        if any(a >= b for a, b in itertools.pairwise(value)) or len(value) == 1:
            raise self._wrong(key, "must ascend, from the lower end to the upper")
        return tuple(value)

    def _wrong(self, key: str, rule: str) -> FormatError:
        is_there = key in self.found
        return FormatError(
            "wrong-value" if is_there else "missing-key",
            "{key} {value} {rule}" if is_there else "{key} is missing; it {rule}",
            key=key,
            value=json.dumps(self.found[key])[:80] if is_there else None,
            rule=rule,
            line=self.number,
            source=self.source,
        )


def _line(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _differing(params: Mapping[str, Value], header: ManifestHeader) -> dict[str, Value]:
    """Return parameters that differ from the first line's; 1 differs from 1.0, and 0.0 from -0.0."""
    rest = header.params
    return {
        name: value
        for name, value in params.items()
        if name not in rest or repr(rest[name]) != repr(value)
    }


def _sorted(values: Mapping[str, Any]) -> dict[str, Any]:
    return dict(sorted(values.items()))
