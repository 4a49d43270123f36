"""Defaults of options from ``[tool.worldgen]`` of the project's ``pyproject.toml``.

See docs/howto/campaigns.md.
"""

from __future__ import annotations

import functools
import os
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import click

from worldgen.cli.output import note
from worldgen.errors import InvalidParameter
from worldgen.files.whole import expanded
from worldgen.plugins.trust import owners, trusts_everything
from worldgen.support.progress import say_once

FILE = "pyproject.toml"
# Options that name code in a file, such as ./robot.py:Robot, besides those of type path.
_CODE = ("controller", "families", "oracles")
# The option of compare, which takes several in one value, separated by commas.
_SEVERAL = "controllers"
# At most one of these can be given; one on the command line overrides the others' configured
# values.
_EITHER = (
    ("budget", "units"),
    ("scheduler", "workers"),
    ("world", "families"),
    ("world", "strategies"),
    ("begin", "families"),
)
_IN_A_FILE = re.compile(
    r"(?P<kind>(lib:)?)(?P<file>[^:+=]+\.(py|toml|so|dylib|dll))(?P<rest>([:+=].*)?)", re.DOTALL
)


class _Project(NamedTuple):
    """The file that configures a project, and its table."""

    file: Path
    table: Mapping[str, Any]


def configured(
    parameters: Collection[click.Parameter],
    path: tuple[str, ...],
    given: Collection[str],
    known: Collection[str],
) -> dict[str, Any]:
    """Return the defaults that the project's file sets for a command's options, by parameter name.

    Args:
        parameters: Parameters of the command.
        path: The command's name, after the names of its groups: ``("corpus", "show")``.
        given: Names of the parameters that the command line gives.
        known: Names of all commands.

    Raises:
        InvalidParameter: If the file cannot be read, or names a command or an option that does not
            exist.
    """
    project = _project(Path.cwd())
    if project is None:
        return {}
    table: Any = project.table
    for name, value in table.items():
        # A typo in the file must not be ignored silently.
        if not isinstance(value, dict):
            raise InvalidParameter(
                "not-in-a-table",
                "{file}: {name!r} is in [tool.worldgen] itself",
                "write it into a command's table, such as [tool.worldgen.run]",
                file=project.file,
                name=name,
            )
        if name not in known and not name.endswith(".toml") and ":" not in name:
            raise InvalidParameter(
                "unknown-name",
                "{file}: [tool.worldgen.{name}] is not a command",
                "known: {known!l}",
                file=project.file,
                name=name,
                known=sorted(known),
            )
    for name in path:
        table = table.get(name, {})
        if not isinstance(table, dict):
            return {}
    where = f"{project.file}: [tool.worldgen.{'.'.join(path)}]"
    values = dict(
        _value_of(parameters, key, value, project.file.parent, where)
        for key, value in table.items()
    )
    # Users in a subfolder may not know that this file applies.
    if values and project.file.parent != Path.cwd():
        note(f"settings of {path[0]} from {os.path.relpath(project.file)}")
    # A command-line option replaces configured ones that exclude it.
    crowded_out = {
        name
        for pair in _EITHER
        for name in pair
        if any(other in given for other in pair if other != name)
    }
    return {name: value for name, value in values.items() if name not in crowded_out}


def named_in_settings() -> tuple[Path, list[str]]:
    """Return the project's folder, and every text in its settings that may name code.

    The settings of one command count for all commands.
    """
    here = Path.cwd()
    try:
        project = _project(here)
    except InvalidParameter:  # the command itself reports it
        project = None
    if project is None:
        return here, []
    folder = project.file.parent
    return folder, [_code_from_here(text, folder) for text in _texts_in(project.table)]


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


def _value_of(
    parameters: Collection[click.Parameter], key: str, value: object, folder: Path, where: str
) -> tuple[str, Any]:
    """Return the parameter's name, and its value in the form used on the command line."""
    # Options are written in the file as on the command line, without the dashes.
    options = {
        flag.removeprefix("--"): option
        for option in parameters
        if isinstance(option, click.Option)
        for flag in option.opts
        if flag.startswith("--")
    }
    option = options.get(key.replace("_", "-"))
    if option is None or option.name is None:
        raise InvalidParameter(
            "unknown-name",
            "{where} {option}: there is no such option",
            "known: {known!l}",
            where=where,
            option=key,
            known=sorted(options),
        )
    values = value if isinstance(value, list) else [value]
    if isinstance(value, list) and not option.multiple:
        raise InvalidParameter(
            "several-values",
            "{where} {option}: this option takes one value",
            "write {option} = ...",
            where=where,
            option=key,
        )
    if any(not isinstance(one, str | int | float) for one in values):
        raise InvalidParameter(
            "wrong-type",
            "{where} {option}: write text, a number, or true or false",
            where=where,
            option=key,
        )
    if option.is_flag != all(isinstance(one, bool) for one in values):
        expected = "true or false" if option.is_flag else "text or a number"
        raise InvalidParameter(
            "wrong-type",
            "{where} {option}: write {expected}",
            where=where,
            option=key,
            expected=expected,
        )
    # Relative paths are relative to the file, not to the current folder.
    if isinstance(option.type, click.Path):
        values = [_from_here(str(one), folder) for one in values]
    elif option.name in _CODE:
        values = [_code_from_here(str(one), folder) for one in values]
    elif option.name == _SEVERAL:
        values = [
            ",".join(_code_from_here(part, folder) for part in str(one).split(","))
            for one in values
        ]
    return option.name, values if option.multiple else values[0]


def _from_here(path: str, folder: Path) -> str:
    """Return a path from the file relative to the working directory.

    If that is the file's own folder, the path is unchanged.
    """
    there = expanded(path)
    if there.is_absolute():
        return str(there)
    return path if folder == Path.cwd() else os.path.relpath(folder / there)


def _code_from_here(text: str, folder: Path) -> str:
    found = _IN_A_FILE.fullmatch(text)
    if found is None:
        return text
    return found["kind"] + _from_here(found["file"], folder) + found["rest"]


def _project(folder: Path) -> _Project | None:
    """Return the nearest file at or above a folder that has our table."""
    return _project_of(folder, trusts_everything())


@functools.cache
def _project_of(folder: Path, any_owner: bool) -> _Project | None:
    for place in (folder, *folder.parents):
        file = place / FILE
        try:
            text = file.read_text("utf-8")
        except (OSError, UnicodeDecodeError):
            continue
        if "worldgen" not in text:
            continue
        if not any_owner and not _has_same_owner(file):
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
            return _Project(file, table)
    return None


def _has_same_owner(file: Path) -> bool:
    """Return True if nobody else could have put this file here, because its code is run."""
    trusted = owners()
    if trusted is None:
        return True
    # Another user's link to a file of ours counts too, because code is looked up next to the link.
    return file.lstat().st_uid in trusted and file.stat().st_uid in trusted
