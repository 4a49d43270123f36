"""Read the project's settings: ``[tool.worldgen]`` of the nearest ``pyproject.toml``."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from worldgen.errors import InvalidParameter
from worldgen.support.paths import expanded
from worldgen.support.progress import say_once

FILE = "pyproject.toml"
_IN_A_FILE = re.compile(
    r"(?P<kind>(lib:)?)(?P<file>[^:+=]+\.(py|toml|so|dylib|dll))(?P<rest>([:+=].*)?)", re.DOTALL
)


class ProjectFile(NamedTuple):
    """The file that configures a project, and its table."""

    file: Path
    table: Mapping[str, Any]


def named_in_settings(*, any_owner: bool = False) -> tuple[Path, list[str]]:
    """Return the project's folder, and every text in its settings that may name code.

    The settings of one command count for all commands.

    Args:
        any_owner: True to read another user's file as well.
    """
    here = Path.cwd()
    try:
        project = project_of(here, any_owner=any_owner)
    except InvalidParameter:  # the command itself reports it
        project = None
    if project is None:
        return here, []
    folder = project.file.parent
    return folder, [code_from_here(text, folder) for text in _texts_in(project.table)]


def _texts_in(value: object) -> Iterator[str]:
    """Yield all texts in a table, including the names of tables, each without its comma list."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield str(name)
            yield from _texts_in(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from _texts_in(inner)
    elif isinstance(value, str):
        yield value
        if "," in value:
            yield from (part.strip() for part in value.split(","))


def from_here(path: str, folder: Path) -> str:
    """Return a path from the file relative to the working directory.

    If that is the file's own folder, the path is unchanged.
    """
    there = expanded(path)
    if there.is_absolute():
        return str(there)
    return path if folder == Path.cwd() else os.path.relpath(folder / there)


def code_from_here(text: str, folder: Path) -> str:
    """Return a name of code from the file, with a relative path as :func:`from_here` gives it."""
    found = _IN_A_FILE.fullmatch(text)
    if found is None:
        return text
    return found["kind"] + from_here(found["file"], folder) + found["rest"]


def project_of(folder: Path, *, any_owner: bool = False) -> ProjectFile | None:
    """Return the nearest file at or above a folder that has our table.

    Args:
        folder: The folder.
        any_owner: True to read another user's file as well.

    Raises:
        InvalidParameter: If it is not TOML.
    """
    for place in (folder, *folder.parents):
        file = place / FILE
        try:
            text = file.read_text("utf-8")
        except (OSError, UnicodeDecodeError):
            continue
        if "worldgen" not in text:
            continue
        if not any_owner and not has_trusted_owner(file):
            # Even an error in it must not affect our user; otherwise anybody could block every
            # command with a file in /tmp.
            if "tool.worldgen" in text:
                say_once(
                    f"{file} belongs to another user and is not read, because it names code to "
                    "run; use --trust to read it, or copy its [tool.worldgen] into a file in your "
                    "own folder"
                )
                return None
            continue
        try:
            table = tomllib.loads(text).get("tool", {}).get("worldgen")
        except tomllib.TOMLDecodeError as error:
            if "[tool.worldgen" in text:
                raise InvalidParameter(
                    "not-toml",
                    "{file} is not TOML: {reason}",
                    "mend it",
                    file=file,
                    reason=str(error),
                ) from None
            continue
        if isinstance(table, dict):
            return ProjectFile(file, table)
    return None


def has_trusted_owner(file: Path) -> bool:
    """Return True if nobody else could have put this file here, because its code is run."""
    trusted = owners()
    if trusted is None:
        return True
    # Another user's link to a file of ours counts too, because code is looked up next to the link.
    return file.lstat().st_uid in trusted and file.stat().st_uid in trusted


def owners() -> frozenset[int] | None:
    """Return the users whose files this user trusts; None where files have no owners.

    These are the user and root, and for root under sudo the user who called it.
    """
    if not hasattr(os, "geteuid"):
        return None
    user = os.geteuid()
    caller = os.environ.get("SUDO_UID", "") if user == 0 else ""
    return frozenset((0, user, *([int(caller)] if caller.isdecimal() else [])))
