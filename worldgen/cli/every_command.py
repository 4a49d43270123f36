"""Add the parts that every command has, no matter who wrote it.

This is ``--quiet`` and ``--verbose``, defaults from the project's ``pyproject.toml``, the
rejection of options that are given twice, and the exit code after files that could not be read.
"""

from __future__ import annotations

import weakref
from typing import Any

import click

from worldgen.cli.configuration import FILE, configured
from worldgen.cli.output import note, skipped_files
from worldgen.support.plain_text import joined, printed
from worldgen.support.progress import set_verbosity


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
        help="Print only results and errors, without progress or notes.",
    ),
    click.Option(
        ["-v", "--verbose"],
        is_flag=True,
        expose_value=False,
        callback=_be_verbose,
        help="Report when each slow step begins and ends.",
    ),
)

# Other spellings of --picture that people try.
_FOR_A_PICTURE = ("--html", "--image", "--out", "--plot", "--png", "--svg")
_EQUIPPED: weakref.WeakSet[click.Command] = weakref.WeakSet()


class _PlainContext(click.Context):
    """A context whose help is safe to print: it can hold the docstrings of a stranger's module."""

    def get_help(self) -> str:
        return printed(joined(super().get_help()))


def equip(command: click.Command) -> click.Command:
    """Add it to a command and its subcommands.

    A second call changes nothing.
    """
    command.context_class = _PlainContext
    if isinstance(command, click.Group):
        for below in command.commands.values():
            equip(below)
        return command
    if command not in _EQUIPPED:
        _EQUIPPED.add(command)
        _add_options(command)
        _watch_parser(command)
        _watch_files(command)
    return command


def _end_if_skipped(context: click.Context) -> None:
    if count := skipped_files(context):
        are = "file was" if count == 1 else "files were"
        note(f"worldgen: {count} {are} skipped, as said above", always=True)
        raise SystemExit(2)


def _watch_files(command: click.Command) -> None:
    """End with code 2 a command that had to skip a file, whatever the other files show."""
    invoke = command.invoke

    def watched(ctx: click.Context) -> Any:
        try:
            value = invoke(ctx)
        except (SystemExit, click.exceptions.Exit) as stop:
            code = stop.code if isinstance(stop, SystemExit) else stop.exit_code
            if code in (0, 1):
                _end_if_skipped(ctx)
            raise
        _end_if_skipped(ctx)
        return value

    command.invoke = watched  # type: ignore[method-assign]


def _add_options(command: click.Command) -> None:
    """Let the command accept our options too; its own ``params`` stay unchanged."""
    get_params = command.get_params
    taken = {
        flag
        for parameter in command.params
        for flag in (*parameter.opts, *parameter.secondary_opts)
    }
    ours = [option for option in QUIET_AND_VERBOSE if taken.isdisjoint(option.opts)]

    def with_ours(context: click.Context) -> list[click.Parameter]:
        found = get_params(context)
        # click adds --help after them.
        own = len(command.params)
        return [*found[:own], *ours, *found[own:]]

    command.get_params = with_ours  # type: ignore[method-assign, assignment]


def _watch_parser(command: click.Command) -> None:
    """Check the arguments before click does, because click would take the last of two values."""
    make_parser = command.make_parser

    # The parser is wrapped because click applies defaults before a command can see what was given.
    def strict_parser(context: click.Context) -> Any:
        parser = make_parser(context)
        parse_args = parser.parse_args

        def parse(args: list[str]) -> Any:
            try:
                opts, rest, order = parse_args(args)
            except click.NoSuchOption as error:
                message = _no_such_option(error.option_name, command.get_params(context))
                raise click.UsageError(message, context) from None
            _refuse_repetition(order, context)
            if not context.resilient_parsing:
                given = {parameter.name for parameter in order if parameter.name is not None}
                context.default_map = _defaults(command, context, given, aloud="verbose" in opts)
            return opts, rest, order

        parser.parse_args = parse  # type: ignore[method-assign]
        return parser

    command.make_parser = strict_parser  # type: ignore[method-assign, assignment]


def _no_such_option(flag: str, parameters: list[click.Parameter]) -> str:
    """Return the message about an unknown option, with the one that was probably meant.

    click compares names with their dashes, which makes ``--out`` look like ``--quiet``.
    """
    import difflib

    names = [one.removeprefix("--") for part in parameters for one in part.opts if "--" in one]
    if flag in _FOR_A_PICTURE and "picture" in names:
        return f"No such option {flag!r}; to draw, write --picture OUT"
    close = difflib.get_close_matches(flag.lstrip("-"), names, 1)
    return f"No such option {flag!r}" + (f"; did you mean --{close[0]}?" if close else "")


def _refuse_repetition(order: list[click.Parameter], context: click.Context) -> None:
    seen: set[str | None] = set()
    for parameter in order:
        if parameter.name in seen and _has_one_value(parameter):
            flag = next(
                (name for name in parameter.opts if name.startswith("--")), parameter.opts[0]
            )
            several = "; worldgen compare runs several" if flag == "--controller" else ""
            raise click.UsageError(f"{flag} is given twice; give it once{several}", context)
        seen.add(parameter.name)


def _defaults(
    command: click.Command, context: click.Context, given: set[str], *, aloud: bool
) -> dict[str, Any]:
    """Return the settings in the project's file for the command; ``--verbose`` prints them."""
    group = context.find_root().command
    names: list[str] = []
    at: click.Context | None = context
    # Walk up to the group, whose name is not part of the path.
    while at is not None and at.parent is not None:
        names.insert(0, at.info_name or "")
        at = at.parent
    path = tuple(names)
    if not isinstance(group, click.Group) or not path:
        return {}
    found = configured(command.get_params(context), path, given, group.list_commands(context))
    for name, value in found.items() if aloud else ():
        if name not in given:
            note(f"{FILE}: {name.replace('_', '-')} = {value}")
    return found


def _has_one_value(parameter: click.Parameter) -> bool:
    if not isinstance(parameter, click.Option) or parameter.multiple or parameter.count:
        return False
    # --json twice means the same.
    return not parameter.is_flag or bool(parameter.secondary_opts)
