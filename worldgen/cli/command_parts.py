"""A command taken apart: its options with their values, its words, and the examples of its help."""

from __future__ import annotations

import contextlib
import io
import itertools
import re
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from worldgen.cli.meant import OTHER_WORDS, existing_names, is_missing, missing_part, unused
from worldgen.cli.names import CONTROLLER, kind_of
from worldgen.domain import DECIMAL
from worldgen.errors import WorldgenError
from worldgen.parameters.known_names import nearest

_PICTURES = (".png", ".svg", ".html", ".gif")

READ = ("against", "baseline", "begin", "resume", "scen", "world")
"""Names of the options whose files must exist."""
WRITTEN = ("out", "picture", "trace", "report", "csv", "curve", "summary", "junit", "sarif")
"""Names of the options whose files are made."""


@dataclass
class CommandPart:
    """A part of a command: an option with its value, or a word.

    Args:
        option: The option; None for a word, and for an option that does not exist.
        flag: The option as it was written; empty for a word.
        value: Its value, or the word; None without one.
    """

    option: click.Option | None
    flag: str = ""
    value: str | None = None

    @property
    def is_unknown(self) -> bool:
        """True for an option that does not exist, and has no value in the same word."""
        return bool(self.flag) and self.option is None and self.value is None

    def words(self) -> list[str]:
        """Return it as words of a command line."""
        if not self.flag:
            return [self.value or ""]
        return [self.flag] if self.value is None else [self.flag, self.value]


class CommandParts:
    """The words of a command, taken apart.

    Args:
        context: The command's context.
        words: All words after the program's name.
    """

    def __init__(self, context: click.Context, words: Sequence[str]) -> None:
        self.context = context
        self.command = context.command
        self.options = [
            one for one in self.command.get_params(context) if isinstance(one, click.Option)
        ]
        self.arguments = [
            one for one in self.command.get_params(context) if isinstance(one, click.Argument)
        ]
        self._by_flag = {
            flag: one for one in self.options for flag in (*one.opts, *one.secondary_opts)
        }
        # The names of the command and of its groups come first.
        depth = 0
        at: click.Context | None = context
        while at is not None and at.parent is not None:
            depth += 1
            at = at.parent
        end = 0
        while depth and end < len(words):
            depth -= not words[end].startswith("-")
            end += 1
        self.head = list(words[:end])
        self.parts = list(self._taken_apart(words[end:]))
        self._examples = list(self._shown_in_help())

    def words(self) -> list[str]:
        """Return the command line, without the program's name."""
        return [*self.head, *(word for part in self.parts for word in part.words())]

    def option(self, name: str) -> click.Option | None:
        """Return the option with this name, without dashes."""
        return self._by_flag.get(f"--{name}")

    def written(self, flag: str) -> click.Option | None:
        """Return the option that is written like this."""
        return self._by_flag.get(flag)

    def has(self, option: click.Option) -> bool:
        """Return True if the option is given."""
        return any(part.option is option for part in self.parts)

    def writes(self, file: str) -> bool:
        """Return True if the value of an option is this file, which is to be made."""
        written = (part for part in self.parts if part.option and part.option.name in WRITTEN)
        return any(part.value == file for part in written)

    def add(self, option: click.Option, value: str | None) -> None:
        """Give an option at the end."""
        self.parts.append(CommandPart(option, flag_of(option), value))

    def example(self, parameter: click.Parameter) -> str | None:
        """Return the value that the command's examples give to a parameter."""
        name = parameter.name or ""
        # The example that is most like this command comes first.
        given = {part.option.name for part in self.parts if part.option is not None}
        alike = max(
            (one for one in self._examples if name in one),
            key=lambda one: len(given & one.keys()),
            default=None,
        )
        if alike is None:
            return None
        value = alike[name]
        kind = kind_of(self.command, parameter)
        if kind is not None:
            return existing_names(kind, value)
        # Use a file that exists to read, and one that does not exist to write.
        is_written = isinstance(parameter, click.Option) and parameter.name in WRITTEN
        if is_written:
            return unused(value)
        if isinstance(parameter.type, click.Path) and not Path(value).exists():
            suffix = Path(value).suffix
            if suffix:
                return next((str(one) for one in sorted(Path().glob(f"*{suffix}"))), value)
        return value

    def suffixes(self) -> set[str]:
        """Return the suffixes of the files that the examples read."""
        read = {one.name for one in self.arguments if isinstance(one.type, click.Path)}
        read.update(READ)
        values = (one[name] for one in self._examples for name in read & one.keys())
        return {Path(value).suffix for value in values} - {""}

    def _taken_apart(self, words: Sequence[str]) -> Iterator[CommandPart]:
        rest = list(words)
        # Words first, as click sees them.
        while rest:
            word = rest.pop(0)
            if word == "--":
                yield from (CommandPart(None, "", one) for one in rest)
                return
            if not word.startswith("-") or word == "-" or DECIMAL.fullmatch(word):
                yield CommandPart(None, "", word)
                continue
            # Then options, whose value may be in the same word.
            flag, equals, value = word.partition("=")
            option = self.written(flag)
            if option is None and not flag.startswith("--") and len(flag) > 2:
                short = self.written(flag[:2])
                # -o3 is -o 3.
                if short is not None and not short.is_flag:
                    option = short
                    flag = flag[:2]
                    equals = "="
                    value = word[2:]
            if equals:
                yield CommandPart(option, flag, value)
            elif option is not None and _takes_value(option, rest):
                yield CommandPart(option, flag, rest.pop(0))
            else:
                yield CommandPart(option, flag)

    def _shown_in_help(self) -> Iterator[dict[str, str]]:
        """Return the values in each example at the end of the command's help."""
        depth = sum(not word.startswith("-") for word in self.head)
        for line in (self.command.epilog or "").splitlines():
            try:
                words = shlex.split(line)
            except ValueError:
                continue
            if words[:1] != ["worldgen"]:
                continue
            parts = list(self._taken_apart(words[1 + depth :]))
            texts = [part.value or "" for part in parts if not part.flag]
            names = [argument.name or "" for argument in self.arguments]
            yield {
                **dict(zip(names, texts, strict=False)),
                **{
                    part.option.name or "": part.value or ""
                    for part in parts
                    if part.option is not None
                },
            }


def _takes_value(option: click.Option, rest: Sequence[str]) -> bool:
    """Return True if the next word, as click sees it, is an option's value."""
    if option.is_flag or option.count or not rest:
        return False
    # Such as `--blocked`, which may have a value.
    may_stand_alone = isinstance(option.flag_value, float)
    return not (may_stand_alone and rest[0].startswith("-"))


def parsed(group: click.Group, words: Sequence[str]) -> click.Context:
    """Return the context of a command that is parsed, but not run."""
    nowhere = io.StringIO()
    # Parsing prints the help, and notes about the project's settings.
    with contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere):
        command: click.Command = group
        context = group.make_context("worldgen", list(words))
        while isinstance(command, click.Group):
            rest = [*context._protected_args, *context.args]
            name, found, rest = command.resolve_command(context, rest)
            if found is None:
                break
            command = found
            context = command.make_context(name, rest, parent=context)
    return context


def accepted_command(group: click.Group, words: Sequence[str]) -> CommandParts | None:
    """Take a command apart; None if click does not accept it, or it asks for help."""
    try:
        return CommandParts(parsed(group, words), words)
    except (click.ClickException, click.exceptions.Exit, WorldgenError):
        return None


def first_fault(group: click.Group, words: Sequence[str]) -> click.UsageError | None:
    """Return the first fault that click finds in a command, without running it; None if none."""
    try:
        parsed(group, words)
    except click.UsageError as error:
        return error
    except click.exceptions.Exit:
        return None
    # A family that does not exist, or a project's file with a mistake.
    except (WorldgenError, click.ClickException) as error:
        return click.UsageError(str(error))
    return None


def flag_of(option: click.Option) -> str:
    """Return the long spelling of an option if it has one."""
    return next((flag for flag in option.opts if flag.startswith("--")), option.opts[0])


def meant_option(command: CommandParts, name: str) -> click.Option | None:
    """Return the option that a name without dashes most likely means; None if none is near."""
    key = name.casefold().replace("_", "-")
    for other in OTHER_WORDS.get(key, ()):
        option = command.option(other)
        if option is not None and not (command.has(option) and not option.multiple):
            return option
    flags = {
        flag.removeprefix("--"): one
        for one in command.options
        for flag in (*one.opts, *one.secondary_opts)
        if flag.startswith("--")
    }
    near = nearest(key, flags) if len(key) > 1 else ""
    return flags.get(near)


def meant_flag(context: click.Context, flag: str) -> str:
    """Return the option of a command that a misspelt one means; empty if none is near."""
    option = meant_option(CommandParts(context, []), flag.lstrip("-"))
    return "" if option is None else flag_of(option)


def options_for(command: CommandParts, text: str) -> Iterator[click.Option]:
    """Return the options that may take a word, the most likely first."""
    # Names and choices fit only one option.
    free = [one for one in command.options if not command.has(one) or one.multiple]
    for option in free:
        kind = kind_of(command.command, option)
        if kind is not None and kind.is_named_by(text):
            yield option
    for option in free:
        if isinstance(option.type, click.Choice) and text in option.type.choices:
            yield option
    by_name = {one.name: one for one in free}
    # Numbers and files are recognised by their form.
    suffix = Path(text).suffix.lower()
    names = []
    if DECIMAL.fullmatch(text) or re.fullmatch(r"\d+[x,]\d+", text):
        names = ["size", "units", "radius"]
    elif suffix == ".py" and Path(text).exists():
        names = ["controller"]
    elif suffix == ".grid" and Path(text).exists():
        names = ["world"]
    elif suffix in _PICTURES:
        names = ["picture", "pictures", "out"]
    elif not Path(text).is_file():
        names = ["out"]
    yield from (by_name[name] for name in names if name in by_name)


def word_count(command: CommandParts) -> int:
    """Return how many words do not belong to an option."""
    return sum(not part.flag for part in command.parts)


def argument_of(
    command: CommandParts, part: CommandPart, texts: list[CommandPart]
) -> click.Argument:
    """Return the argument that takes a word, which is one of ``texts``."""
    at = next(k for k, one in enumerate(texts) if one is part)
    return command.arguments[min(at, len(command.arguments) - 1)]


def missing_files(command: CommandParts) -> list[str]:
    """Return the files that a command is to read and that do not exist."""
    missing: list[str] = []
    # The values of options, then the words.
    for part in command.parts:
        if part.option is None or not part.value:
            continue
        if kind_of(command.command, part.option) is CONTROLLER:
            missing.extend(map(missing_part, part.value.split(",")))
        elif part.option.name in READ and is_missing(part.value):
            missing.append(part.value)
    # The word after an unknown option is likely to be its value.
    texts = [
        part.value or ""
        for before, part in zip((None, *command.parts), command.parts, strict=False)
        if not part.flag and not (before is not None and before.is_unknown)
    ]
    for argument, text in zip(_repeated(command.arguments), texts, strict=False):
        # A word may also be the value of an option without its name.
        homes = (one for one in options_for(command, text) if one.name not in WRITTEN)
        is_read = isinstance(argument.type, click.Path) and argument.required
        if is_read and is_missing(text) and not any(homes):
            missing.append(text)
    return [file for file in missing if file]


def _repeated(arguments: Sequence[click.Argument]) -> Iterator[click.Argument]:
    """Return the argument of each word in turn."""
    for argument in arguments:
        yield from itertools.repeat(argument) if argument.nargs < 0 else (argument,)
