"""Answer a wrong command: what came, the rule, and the corrected command."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

import click

from worldgen.cli.command_parts import (
    CommandParts,
    accepted_command,
    flag_of,
    meant_option,
    missing_files,
    options_for,
)
from worldgen.cli.mending import accepts, corrected, corrected_value
from worldgen.cli.usage import ExtraWords, UnknownCommand
from worldgen.domain import DECIMAL
from worldgen.errors import WorldgenError
from worldgen.support.plain_text import stacked


def answer(error: click.UsageError, group: click.Group, words: Sequence[str]) -> str:
    """Return the answer to a wrong command: its fault, and a command that click accepts.

    Args:
        error: The fault that click found first.
        group: The whole program.
        words: The words after the program's name.
    """
    path = "worldgen" if error.ctx is None else error.ctx.command_path
    suggested = corrected(error, group, words)
    if isinstance(error, UnknownCommand):
        fault = _unknown(error, words, suggested)
    elif error.ctx is None:
        fault = error.format_message()
    else:
        command = CommandParts(error.ctx, words)
        # A file that does not exist comes before anything that click finds.
        missing = [] if "--help" in (suggested or ()) else missing_files(command)
        accepted = None if suggested is None else accepted_command(group, suggested)
        # Unless it is a file to write.
        if missing and not (accepted is not None and accepted.writes(missing[0])):
            sentence = f"{path}: there is no file or folder {missing[0]!r}; check the path"
            lines = [sentence]
            # What is wrong with other words is worth a line, what they lack is not.
            if not isinstance(error, click.MissingParameter):
                lines.append(f"{path}: {_described(error, command)}")
            if accepted is not None and missing[0] not in missing_files(accepted):
                lines.append(f"  {_line(accepted.words())}")
            return stacked(lines)
        fault = _described(error, command)
    line = f"{path} --help" if suggested is None else _line(suggested)
    return stacked((f"{path}: {fault}", f"  {line}"))


def answer_named(error: WorldgenError, group: click.Group, words: Sequence[str]) -> str:
    """Return the corrected command for a value that a command refused; empty if unknown."""
    suggested = corrected_value(error, group, words)
    return _line(suggested) if suggested else ""


def _line(words: Sequence[str]) -> str:
    return shlex.join(["worldgen", *words])


def _unknown(error: UnknownCommand, words: Sequence[str], suggested: Sequence[str] | None) -> str:
    at = words.index(error.name)
    meant = "" if suggested is None else "".join(suggested[at : at + 1])
    hint = f"did you mean {meant!r}?" if meant else "--help lists the commands"
    return f"{error.message}; {hint}"


def _described(error: click.UsageError, command: CommandParts) -> str:
    """Return the fault in words: what came, and the rule."""
    if isinstance(error, ExtraWords):
        return _unexpected(error, command)
    if isinstance(error, click.NoSuchOption):
        # The others are dropped, too, so they are named.
        unknown = (one.flag for one in command.parts if one.flag and one.option is None)
        others = [one for one in unknown if not meant_option(command, one.lstrip("-"))]
        also = [one for one in dict.fromkeys(others) if one != error.option_name]
        return error.message + (f", nor {' or '.join(also)}" if also else "")
    if isinstance(error, click.MissingParameter) and error.param is not None:
        name = _shown(error.param, command)
        reason = f"; {error.message}" if error.message else ""
        return f"{name} is missing{reason}"
    if isinstance(error, click.BadOptionUsage):
        option = command.written(error.option_name)
        takes_none = option is None or option.is_flag or option.count
        return error.message if takes_none else f"{error.option_name} needs a value"
    if isinstance(error, click.BadParameter) and error.param is not None:
        return f"{_shown(error.param, command)}: {_value_fault(error, error.param, command)}"
    return error.format_message()


def _value_fault(
    error: click.BadParameter, parameter: click.Parameter, command: CommandParts
) -> str:
    kind = parameter.type
    is_whole = isinstance(kind, click.types.IntParamType)
    given = (part.value for part in command.parts if part.option is parameter and part.value)
    refused = next((one for one in given if not accepts(parameter, one, command.context)), None)
    # A value from the project's settings is not among the words.
    if refused is not None and (is_whole or isinstance(kind, click.types.FloatParamType)):
        is_number = DECIMAL.fullmatch(refused) and (refused.lstrip("+-").isdigit() or not is_whole)
        shown = refused if is_number else repr(refused)
        noun = "whole number" if is_whole else "number"
        low = getattr(kind, "min", None)
        high = getattr(kind, "max", None)
        limits = f" from {low} to {high}" if None not in (low, high) else ""
        if low is not None and high is None:
            limits = (
                f" above {low:g}" if getattr(kind, "min_open", False) else f" of at least {low:g}"
            )
        return f"{shown} is not a {noun}{limits}"
    return error.message.rstrip(".")


def _unexpected(error: ExtraWords, command: CommandParts) -> str:
    quoted = " ".join(map(repr, error.words))
    for text in error.words:
        name, equals, value = text.partition("=")
        named = command.option(name.replace("_", "-")) if equals else None
        if named is not None:
            return f"{text!r} is not expected here; write {flag_of(named)} {shlex.quote(value)}"
        option = next(options_for(command, text), None)
        if option is not None:
            return f"{text!r} is not expected here; write {flag_of(option)} {shlex.quote(text)}"
    names = " ".join(one.make_metavar(command.context) for one in command.arguments)
    return f"{quoted} is not expected here; it takes " + (
        f"only {names}" if names else "only options"
    )


def _shown(parameter: click.Parameter, command: CommandParts) -> str:
    if isinstance(parameter, click.Option):
        return flag_of(parameter)
    return parameter.make_metavar(command.context)
