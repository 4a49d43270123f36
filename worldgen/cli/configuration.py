"""Defaults of options from ``[tool.worldgen]`` of the project's ``pyproject.toml``.

See docs/howto/settings.md.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path
from typing import Any

import click

from worldgen.cli.output import note
from worldgen.errors import InvalidParameter
from worldgen.plugins.project import code_from_here, from_here, project_of
from worldgen.plugins.trust import trusts_everything

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
    project = project_of(Path.cwd(), any_owner=trusts_everything())
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
        if name not in known and ":" not in name:
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
        values = [from_here(str(one), folder) for one in values]
    elif option.name in _CODE:
        values = [code_from_here(str(one), folder) for one in values]
    elif option.name == _SEVERAL:
        values = [
            ",".join(code_from_here(part, folder) for part in str(one).split(",")) for one in values
        ]
    return option.name, values if option.multiple else values[0]
