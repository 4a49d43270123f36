"""Options of commands that are made from declared ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import click

from worldgen.cli.output import PATH
from worldgen.parameters import Parameter

F = TypeVar("F", bound=Callable[..., Any])


def declared_options(
    declared: Sequence[Parameter], notes: Mapping[str, str] | None = None
) -> Callable[[F], F]:
    """Give a command an option for each declared one: names, bounds, defaults and help.

    Omitted options are None, or an empty tuple.

    Args:
        declared: The options, in the order in which help shows them.
        notes: Different help for some of them, by name.
    """

    def decorated(command: F) -> F:
        for parameter in reversed(declared):
            command = _option(parameter, (notes or {}).get(parameter.name, parameter.help))(command)
        return command

    return decorated


def _option(parameter: Parameter, said: str) -> Callable[[F], F]:
    written = parameter.flag
    # A yes-or-no option can be turned off again, for example against a default of the project.
    if parameter.kind is bool:
        written = f"{written}/--no-{written.removeprefix('--')}"
    listed = parameter.kind is tuple
    usual = parameter.default if not listed and parameter.default not in (None, "") else None
    settings: dict[str, Any] = {"multiple": listed, "help": said}
    if usual is not None:
        settings |= {"default": usual, "show_default": True}
    elif not listed:
        settings["default"] = None
    if parameter.written.metavar:
        settings["metavar"] = parameter.written.metavar
    settings["type"] = _type(parameter)
    return click.option(written, parameter.name, **settings)


def _type(parameter: Parameter) -> Any:
    if parameter.written.path == "folder":
        return click.Path(file_okay=False)
    if parameter.written.path == "file":
        return PATH
    if parameter.choices:
        return click.Choice(parameter.choices)
    if parameter.bounds is not None:
        kind: Any = click.IntRange if parameter.kind is int else click.FloatRange
        bounds = parameter.bounds
        return kind(bounds.low, bounds.high, min_open=bounds.above)
    return parameter.item if parameter.kind is tuple else parameter.kind
