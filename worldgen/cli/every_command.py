"""Add the parts that every command has, no matter who wrote it.

This is ``--quiet``, ``--verbose`` and ``--trust``, the sections of its help, defaults from the
project's ``pyproject.toml``, the rejection of options that are given twice, the rule about whose
code runs, and the exit code after files that could not be read. Our own commands also keep stdout
for results.
"""

from __future__ import annotations

import shlex
import weakref
from collections.abc import Mapping
from types import MethodType
from typing import Any

import click

from worldgen.cli.configuration import configured
from worldgen.cli.help_sections import format_options
from worldgen.cli.names import NameKind, kind_of, names_in_one
from worldgen.cli.output import note, skipped_files
from worldgen.cli.usage import ExtraWords, GivenTwice, UnknownCommand
from worldgen.plugins.project import FILE
from worldgen.plugins.trust import admit_typed, trust_everything
from worldgen.support.plain_text import counted, joined, printed
from worldgen.support.progress import set_verbosity
from worldgen.support.results import only_results_on_stdout


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

TRUST = click.Option(
    ["--trust"],
    is_flag=True,
    expose_value=False,
    help="Run all code that the files name, even if you have not run it before (SECURITY.md).",
)

_EQUIPPED: weakref.WeakSet[click.Command] = weakref.WeakSet()


class _PlainContext(click.Context):
    """A context whose help is safe to print: it can hold the docstrings of a stranger's module."""

    def get_help(self) -> str:
        return printed(joined(super().get_help()))


def equip(command: click.Command, *, is_ours: bool) -> click.Command:
    """Add it to a command and its subcommands.

    A second call changes nothing.

    Args:
        command: The command.
        is_ours: True for a command of worldgen, which prints its results with
            :func:`worldgen.cli.output.say`. Whatever else is printed while it runs goes to stderr.
    """
    command.context_class = _PlainContext
    if isinstance(command, click.Group):
        if command not in _EQUIPPED:
            _EQUIPPED.add(command)
            _watch_names(command)
            watch_parser(command)
        for below in command.commands.values():
            equip(below, is_ours=is_ours)
        return command
    if command not in _EQUIPPED:
        _EQUIPPED.add(command)
        _add_options(command)
        command.format_options = MethodType(format_options, command)  # type: ignore[method-assign]
        watch_parser(command)
        _watch_files(command)
        _complete_names(command)
        if is_ours:
            _keep_results_apart(command)
    return command


def _keep_results_apart(command: click.Command) -> None:
    """Print nothing but results to stdout while the command runs."""
    invoke = command.invoke

    def invoke_apart(context: click.Context) -> Any:
        with only_results_on_stdout():
            return invoke(context)

    command.invoke = invoke_apart  # type: ignore[method-assign, assignment]


def _end_if_skipped(context: click.Context) -> None:
    if count := skipped_files(context):
        note(f"worldgen: {counted(count, 'file')} could not be read", always=True)
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
    every = (*QUIET_AND_VERBOSE, TRUST)
    ours = [option for option in every if taken.isdisjoint(option.opts)]

    def with_ours(context: click.Context) -> list[click.Parameter]:
        found = get_params(context)
        # click adds --help after them.
        own = len(command.params)
        return [*found[:own], *ours, *found[own:]]

    command.get_params = with_ours  # type: ignore[method-assign, assignment]


def _complete_names(command: click.Command) -> None:
    """Let shells complete the names that the command's options and arguments take."""
    for parameter in command.params:
        kind = kind_of(command, parameter)
        if kind is not None:

            def complete(context: click.Context, incomplete: str, kind: NameKind = kind) -> Any:
                from worldgen.cli.completion import complete_names

                return complete_names(kind, incomplete)

            parameter.shell_complete = complete  # type: ignore[method-assign, assignment]


def _watch_names(group: click.Group) -> None:
    """Report an unknown command of a group like one of the whole program."""
    resolve_command = group.resolve_command

    def strict(context: click.Context, args: list[str]) -> Any:
        if not args[0].startswith("-") and group.get_command(context, args[0]) is None:
            raise UnknownCommand(args[0], group.list_commands(context), context)
        return resolve_command(context, args)

    group.resolve_command = strict  # type: ignore[method-assign, assignment]


def watch_parser(command: click.Command) -> None:
    """Check the arguments before click does, because click would take the last of two values."""
    make_parser = command.make_parser

    # The parser is wrapped because click applies defaults before a command can see what was given.
    def strict_parser(context: click.Context) -> Any:
        parser = make_parser(context)
        parse_args = parser.parse_args

        def parse(args: list[str]) -> Any:
            typed = tuple(args)  # click takes words out of the list
            try:
                opts, rest, order = parse_args(list(args))
            except click.NoSuchOption as error:
                flag = _as_typed(error.option_name, typed)
                raise click.NoSuchOption(
                    flag, _no_such_option(flag, context), ctx=context
                ) from None
            except click.UsageError as error:
                error.ctx = error.ctx or context
                raise
            # Shell completion reads commands that are not complete yet.
            if not context.resilient_parsing:
                _refuse_repetition(order, context)
                _refuse_lists(command, opts, order, context)
                if rest and not context.allow_extra_args:
                    raise ExtraWords(rest, context)
                # What was typed may run, and only after that do the settings count.
                if opts.get("trust"):
                    trust_everything()
                admit_typed(opts.values(), _command_with_trust(context, args))
                given = {parameter.name for parameter in order if parameter.name is not None}
                context.default_map = _defaults(command, context, given, aloud="verbose" in opts)
            return opts, rest, order

        parser.parse_args = parse  # type: ignore[method-assign]
        return parser

    command.make_parser = strict_parser  # type: ignore[method-assign, assignment]


def _command_with_trust(context: click.Context, args: list[str]) -> str:
    """Return the command line with ``--trust``, which does not belong among a command's files."""
    return shlex.join(["worldgen", *_path(context), TRUST.opts[0], *args])


def _path(context: click.Context) -> tuple[str, ...]:
    """Return the command's name, after the names of its groups: ``("corpus", "show")``."""
    names: list[str] = []
    at: click.Context | None = context
    # Walk up to the group, whose name is not part of the path.
    while at is not None and at.parent is not None:
        names.insert(0, at.info_name or "")
        at = at.parent
    return tuple(names)


def _as_typed(flag: str, args: tuple[str, ...]) -> str:
    """Return the word in which click found an unknown option: it reads -help as -h -e -l -p."""
    if flag.startswith("--"):
        return flag
    long = (
        word for word in args if len(word) > 2 and word[0] == "-" != word[1] and flag[1:] in word
    )
    return next(long, flag)


def _refuse_lists(
    command: click.Command,
    opts: Mapping[str, Any],
    order: list[click.Parameter],
    context: click.Context,
) -> None:
    """Refuse ``--family maze,trap``, and say how to write it."""
    for option in dict.fromkeys(order):
        values = opts.get(option.name or "")
        for text in values if isinstance(values, list) else ():
            if isinstance(text, str) and names_in_one(command, option, text):
                message = f"{text!r} is several names; write the option once for each"
                raise click.BadParameter(message, context, option)


def _no_such_option(flag: str, context: click.Context) -> str:
    """Return the message about an unknown option, with the one that was probably meant."""
    from worldgen.cli.command_parts import meant_flag

    meant = meant_flag(context, flag)
    return f"there is no option {flag}" + (f"; did you mean {meant}?" if meant else "")


def _refuse_repetition(order: list[click.Parameter], context: click.Context) -> None:
    seen: set[str | None] = set()
    for parameter in order:
        if parameter.name in seen and _has_one_value(parameter):
            flag = next(
                (name for name in parameter.opts if name.startswith("--")), parameter.opts[0]
            )
            raise GivenTwice(parameter, flag, context)
        seen.add(parameter.name)


def _defaults(
    command: click.Command, context: click.Context, given: set[str], *, aloud: bool
) -> dict[str, Any]:
    """Return the settings in the project's file for the command; ``--verbose`` prints them."""
    group = context.find_root().command
    path = _path(context)
    if not isinstance(group, click.Group) or not path:
        return {}
    # A file cannot say that all files are trusted.
    options = [option for option in command.get_params(context) if option is not TRUST]
    found = configured(options, path, given, group.list_commands(context))
    for name, value in found.items() if aloud else ():
        if name not in given:
            note(f"{FILE}: {name.replace('_', '-')} = {value}")
    return found


def _has_one_value(parameter: click.Parameter) -> bool:
    if not isinstance(parameter, click.Option) or parameter.multiple or parameter.count:
        return False
    # --json twice means the same.
    return not parameter.is_flag or bool(parameter.secondary_opts)
