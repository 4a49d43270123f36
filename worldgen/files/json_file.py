"""Read and write JSON files whose form a type declares.

Files are written from the same type that reads them. Numbers can be bounded, texts restricted and
lists limited where the type declares them: ``Annotated[int, msgspec.Meta(ge=0)]``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import msgspec
from msgspec.structs import FieldInfo, fields

from worldgen.errors import FormatError
from worldgen.files.whole import read_text, write_bytes

T = TypeVar("T")


class _Version(msgspec.Struct):
    version: int


@dataclass(frozen=True)
class JsonFile(Generic[T]):
    """A kind of JSON file.

    Args:
        kind: Type of the content: a msgspec struct or a dataclass. Unknown keys are ignored.
        version: Version of the form, which is the file's first key.
        code: Code of the error if a file is not of this kind.
        problem: Template of its message, with ``{reason}``.
        remedy: The way out.
        at_terminal: Whether the way out needs a terminal.
    """

    kind: type[T]
    version: int
    code: str
    problem: str
    remedy: str
    at_terminal: bool = False

    def read(self, path: Path) -> T:
        """Return the content of a file.

        Raises:
            FormatError: If it cannot be read, or is not of this kind.
        """
        text = read_text(path)
        try:
            version = msgspec.json.decode(text, type=_Version).version
            if version != self.version:
                raise ValueError(
                    f"its version is {version}, but this program reads version {self.version}"
                )
            return msgspec.json.decode(text, type=self.kind)
        # A list can be nested too deeply for any reader.
        except (ValueError, RecursionError) as error:
            raise FormatError(
                self.code,
                self.problem,
                self.remedy,
                at_terminal=self.at_terminal,
                reason=str(error),
                source=str(path),
            ) from error

    def find(self, path: Path) -> T | None:
        """Return the content of a file, as :meth:`read` does, or None if there is no such file."""
        return self.read(path) if path.is_file() else None

    def write(self, path: Path, content: T) -> None:
        """Write a file, replacing an existing one.

        Raises:
            OutputError: If it cannot be written.
        """
        write_bytes(path, (json.dumps(self.table(content), indent=1) + "\n").encode(), force=True)

    def table(self, content: T) -> dict[str, Any]:
        """Return the content of a file, with its version, in JSON's types."""
        return {"version": self.version, **plain(content)}


def _plain_text(value: object) -> str:
    """Return a text of a class of ours, such as a name that a file gave, as a plain one."""
    if isinstance(value, str):
        return str(value)
    raise TypeError(f"{type(value).__name__} has no place in JSON")


def plain(content: Any) -> dict[str, Any]:
    """Return a struct or dataclass in JSON's types."""
    table: dict[str, Any] = msgspec.to_builtins(content, enc_hook=_plain_text)
    return table


def converted(value: object, kind: type[T]) -> T:
    """Return a value in JSON's types as a value of a declared type.

    Raises:
        ValueError: If a part is missing, of the wrong type, or out of range, with its place.
    """
    return msgspec.convert(value, kind)


def faulty_field(found: Mapping[str, Any], kind: type[msgspec.Struct]) -> FieldInfo | None:
    """Return the first field of a struct that an object lacks or has a wrong value for."""
    return next((field for field in fields(kind) if not _fits(found, field)), None)


def _fits(found: Mapping[str, Any], field: FieldInfo) -> bool:
    if field.encode_name not in found:
        return not field.required
    try:
        converted(found[field.encode_name], field.type)
    except ValueError:
        return False
    return True
