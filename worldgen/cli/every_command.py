"""What every command has, whoever wrote it: ``--quiet``, ``--verbose``, and no option given twice unnoticed."""

from __future__ import annotations

from typing import Any

import click

from worldgen.progress import set_verbosity

__all__ = ["QUIET_AND_VERBOSE", "equip"]


def _be_quiet(context: click.Context, option: click.Parameter, value: bool) -> None:
    if value:
        set_verbosity(-1)


def _be_verbose(context: click.Context, option: click.Parameter, value: bool) -> None:
    if value:
        set_verbosity(1)


QUIET_AND_VERBOSE: tuple[click.Option, ...] = (
    click.Option(
        ["-q", "--quiet"],
        is_flag=True,
        expose_value=False,
        callback=_be_quiet,
        help="Print results and errors only, no progress and no notes.",
    ),
    click.Option(
        ["-v", "--verbose"],
        is_flag=True,
        expose_value=False,
        callback=_be_verbose,
        help="Print each piece of slow work as it begins and ends.",
    ),
)


def equip(command: click.Command) -> click.Command:
    """Give a command, and the commands below it, what every command has; a second time changes nothing."""
    if isinstance(command, click.Group):
        for below in command.commands.values():
            equip(below)
        return command
    taken = {flag for parameter in command.params for flag in (*parameter.opts, *parameter.secondary_opts)}
    if not any(option in command.params for option in QUIET_AND_VERBOSE):
        command.params += [option for option in QUIET_AND_VERBOSE if taken.isdisjoint(option.opts)]
        _refuse_repetition(command)
    return command


def _refuse_repetition(command: click.Command) -> None:
    """Make the command refuse an option that takes one value and is given twice: click would take the last."""
    make_parser = command.make_parser

    def strict_parser(context: click.Context) -> Any:
        parser = make_parser(context)
        parse_args = parser.parse_args

        def parse(args: list[str]) -> Any:
            opts, rest, order = parse_args(args)
            seen: set[str | None] = set()
            for parameter in order:
                if parameter.name in seen and _has_one_value(parameter):
                    flag = max(parameter.opts, key=len)
                    raise click.UsageError(f"{flag} is given twice; give it once", context)
                seen.add(parameter.name)
            return opts, rest, order

        parser.parse_args = parse  # type: ignore[method-assign]
        return parser

    command.make_parser = strict_parser  # type: ignore[method-assign, assignment]


def _has_one_value(parameter: click.Parameter) -> bool:
    if not isinstance(parameter, click.Option) or parameter.multiple or parameter.count:
        return False
    return not parameter.is_flag or bool(parameter.secondary_opts)  # --json twice says the same thing
