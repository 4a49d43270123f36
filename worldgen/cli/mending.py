"""Mend a wrong command until click accepts it.

Click reports one fault of a command at a time. Here each fault is mended, and the command is parsed
again, until click accepts it. So a suggested command is always a valid one. The values that are
missing come from the examples at the end of the command's help.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from worldgen.cli.command_parts import (
    READ,
    WRITTEN,
    CommandPart,
    CommandParts,
    accepted_command,
    argument_of,
    first_fault,
    flag_of,
    meant_option,
    options_for,
    word_count,
)
from worldgen.cli.meant import (
    COMMANDS,
    NAMED,
    better_names,
    better_values,
    built_in,
    is_missing,
    other_file,
)
from worldgen.cli.names import kind_of, names_in_one
from worldgen.cli.usage import ExtraWords, GivenTwice, Instead, UnknownCommand
from worldgen.domain import DECIMAL
from worldgen.errors import WorldgenError
from worldgen.parameters.known_names import nearest

# Faults of one command that are mended; a command with more of them is not worth a guess.
_MOST_FAULTS = 12

_LONGEST = 2000  # characters of a command that is mended

_FILE_CODES = ("no-such-file", "is-a-folder", "file-exists", "not-a-folder")


def corrected(
    error: click.UsageError, group: click.Group, words: Sequence[str]
) -> list[str] | None:
    """Return the words of a command that click accepts; None if no guess is worth showing."""
    tried: set[tuple[str, ...]] = {tuple(words)}
    current = list(words)
    fault: click.UsageError | None = error
    if sum(map(len, words)) > _LONGEST:
        return None
    if "help" in words[1:] and error.ctx is not None and not Path("help").exists():
        return [*CommandParts(error.ctx, words).head, "--help"]
    for _ in range(_MOST_FAULTS):
        if fault is None:
            break
        mended = _mended(fault, current)
        if mended is None or tuple(mended) in tried:
            return None
        current = mended
        tried.add(tuple(current))
        fault = first_fault(group, current)
    return _polished(group, current) if fault is None else None


def _mended(error: click.UsageError, words: Sequence[str]) -> list[str] | None:
    """Return a command without one of its faults; None if it cannot be mended."""
    if error.ctx is None:
        return None
    if isinstance(error, UnknownCommand):
        return _other_command(error, words)
    # Take the command apart, and mend the one fault that click reported.
    command = CommandParts(error.ctx, words)
    if isinstance(error, Instead):
        return _with_instead(command, error)
    if isinstance(error, ExtraWords):
        _place_words(command, error.words)
    elif isinstance(error, click.NoSuchOption):
        after = _after_command(error, words)
        if after is not None:
            return after
        _rename_option(command, error.option_name)
    # Some faults cannot be mended.
    elif isinstance(error, click.MissingParameter):
        if not _fill_in(command, error.param):
            return None
    elif isinstance(error, GivenTwice):
        _keep_one(command, error.option)
    elif isinstance(error, click.BadOptionUsage):
        return _give_value(command, error.option_name)
    elif isinstance(error, click.BadParameter) and error.param is not None:
        if not _mend_value(command, error.param, error.ctx):
            return None
    else:
        return None
    return command.words()


def corrected_value(
    error: WorldgenError, group: click.Group, words: Sequence[str]
) -> list[str] | None:
    """Return the words of a command without the value that it refused; None if unknown.

    The error says what to write instead: its facts hold the text that came as ``name`` and the
    right one as ``near``, the bounds of a number, or the options that the command ``needs``. A file
    is its ``source`` or ``path``.
    """
    changed = (
        _clamped(error, group, words)
        or _completed(error, group, words)
        or _renamed(error, group, list(words))
    )
    if changed is None or changed == list(words):
        return None
    fault = first_fault(group, changed)
    return _polished(group, changed) if fault is None else corrected(fault, group, changed)


def _renamed(error: WorldgenError, group: click.Group, words: list[str]) -> list[str] | None:
    facts = error.facts
    came = facts.get("name")
    meant = facts.get("near")
    if error.code in _FILE_CODES:
        came = str(getattr(error, "source", None) or facts.get("source") or facts.get("path") or "")
        command = accepted_command(group, words)
        suffixes = () if command is None else command.suffixes()
        meant = other_file(came, error.code, suffixes) if came else ""
    if isinstance(came, str) and "," in came and _is_controller(came, group, words):
        return ["compare", *words[1:]]
    # Classes in files are mended like other names, unless the error is about a whole value.
    if not (isinstance(came, str) and isinstance(meant, str) and came and meant):
        return _polished(group, words)
    if ":" in came and came not in words:
        return _polished(group, words)
    # What is misspelt in a file is only the part after its place.
    place = facts.get("place")
    if place and came == f"{place}:{facts.get('attribute')}":
        meant = f"{place}:{meant}"
    # Only whole names are replaced, not parts of longer ones.
    pattern = re.compile(rf"(?<![\w./-]){re.escape(came)}(?![\w/-])")
    return [pattern.sub(lambda _: meant, word) for word in words]


def _is_controller(text: str, group: click.Group, words: Sequence[str]) -> bool:
    """Return True if a text is the controller of a run."""
    command = accepted_command(group, words) if words[:1] == ["run"] else None
    parts = [] if command is None else command.parts
    return any(one.value == text and one.flag == "--controller" for one in parts)


def _clamped(error: WorldgenError, group: click.Group, words: Sequence[str]) -> list[str] | None:
    facts = error.facts
    name, value, low, high = (facts.get(one) for one in ("name", "value", "low", "high"))
    is_bound = error.code in ("out-of-range", "below-minimum")
    if not (is_bound and isinstance(name, str) and isinstance(value, int | float)):
        return None
    bound = low if isinstance(low, int | float) and value < low else high
    flag = f"--{name.replace('_', '-')}"
    at = next((k for k, word in enumerate(words) if word.partition("=")[0] == flag), None)
    if at is None or not isinstance(bound, int | float):
        return None
    text = f"{bound:g}" if isinstance(bound, float) else str(bound)
    # Zero itself may be too small, and a usual value never is.
    if bound == 0 and isinstance(value, float):
        command = accepted_command(group, words)
        option = None if command is None else command.written(flag)
        usual = () if command is None or option is None else _usual(command, option)
        text = next((one for one in usual if float(one) > 0), "1")
    end = at + (1 if "=" in words[at] else 2)
    return [*words[:at], flag, text, *words[end:]]


def _completed(error: WorldgenError, group: click.Group, words: Sequence[str]) -> list[str] | None:
    """Return the words with the options that the error's fact ``needs`` names; None without it."""
    command = accepted_command(group, words)
    needs = error.facts.get("needs")
    if command is None or not isinstance(needs, list):
        return None
    for need in needs:
        # --frame=map: this value, in place of another.
        flag, has_value, value = need.partition("=")
        option = command.written(flag)
        if has_value and option is not None:
            command.parts = [part for part in command.parts if part.option is not option]
            command.add(option, value)
        elif option is None or not (command.has(option) or _fill_in(command, option)):
            return None
    return command.words()


def _polished(group: click.Group, words: Sequence[str]) -> list[str]:
    """Return an accepted command with the names that its values most likely mean."""
    command = accepted_command(group, words)
    if command is None:
        return list(words)
    before = command.words()
    # Mend the values of options, then those of arguments, then paths.
    for part in command.parts:
        kind = None if part.option is None else kind_of(command.command, part.option)
        if kind is not None and part.value:
            part.value = better_names(kind, part.value)
        elif part.option is not None and part.option.name in READ and is_missing(part.value or ""):
            part.value = other_file(part.value or "", "no-such-file", (".grid",)) or part.value
    texts = [part for part in command.parts if not part.flag]
    for argument, part in zip(command.arguments, texts, strict=False):
        kind = kind_of(command.command, argument)
        if kind is not None:
            part.value = better_names(kind, part.value or "")
    for part in texts:
        if part.value and isinstance(argument_of(command, part, texts).type, click.Path):
            _mend_path(command, part)
    after = command.words()
    # The user's spelling stays if nothing changed, such as --size=60.
    is_better = after != before and first_fault(group, after) is None
    return after if is_better else list(words)


def _mend_path(command: CommandParts, part: CommandPart) -> None:
    """Replace a path that does not exist by the one that was meant, or by an option."""
    text = part.value or ""
    if Path(text).exists():
        return
    needed = sum(one.required for one in command.arguments)
    option = next(options_for(command, text), None) if word_count(command) > needed else None
    is_plain = DECIMAL.fullmatch(text) or not Path(text).suffix
    if option is not None and option.name not in WRITTEN and is_plain:
        command.parts.remove(part)
        command.add(option, text)
        return
    part.value = other_file(text, "no-such-file", command.suffixes()) or text
    # A name that no file has: `run maze`.
    example = command.example(command.arguments[0])
    if part.value == text and not Path(text).suffix and "/" not in text and example:
        part.value = example if Path(example).exists() else text


def _other_command(error: UnknownCommand, words: Sequence[str]) -> list[str] | None:
    at = words.index(error.name)
    before = list(words[:at])
    after = list(words[at + 1 :])
    name = error.name.casefold()
    # This is an option of the program.
    if not before and name == "version":
        return ["--version"]
    if error.name.endswith((".grid", ".grid.gz")) and not before:
        return ["show", error.name, *after]
    if error.name.endswith(".py") and not before:
        return ["run", "--controller", error.name, *after]
    other = COMMANDS.get(name)
    if other == "" and after and not before:
        return after
    if other in error.known:
        return [*before, str(other), *after]
    near = nearest(error.name, error.known)
    if near:
        return [*before, near, *after]
    # A group's most used command comes first in its help: corpus list.
    if before and "list" in error.known and Path(error.name).exists():
        return [*before, "list", error.name, *after]
    return None


def _after_command(error: click.NoSuchOption, words: Sequence[str]) -> list[str] | None:
    """Return the words with a command's options after its name; None if they are not before it."""
    group = error.ctx.command if error.ctx is not None else None
    if not isinstance(group, click.Group) or error.ctx is None:
        return None
    names = group.list_commands(error.ctx)
    at = next((k for k, word in enumerate(words) if word in names), 0)
    return [words[at], *words[at + 1 :], *words[:at]] if at else None


def _with_instead(command: CommandParts, error: Instead) -> list[str]:
    if error.meant:
        return [error.meant if word == error.came else word for word in command.words()]
    command.parts = [part for part in command.parts if part.flag != error.came]
    return command.words()


def _rename_option(command: CommandParts, flag: str) -> None:
    """Write an option that does not exist as the one that was meant, or drop it."""
    part = next(
        (one for one in command.parts if one.option is None and one.flag.startswith(flag)), None
    )
    if part is None:
        # click reads -version as -v -e ...
        part = next(
            (one for one in command.parts if one.flag[:1] == "-" and one.option is None), None
        )
    if part is None:
        return
    name = part.flag.lstrip("-").rstrip(":")
    # --size60 is --size 60.
    joined = re.fullmatch(r"([a-z][a-z-]*[a-z])(\d.*)", name)
    if joined is not None and part.value is None and command.option(joined[1]) is not None:
        name = joined[1]
        part.value = joined[2]
    meant = meant_option(command, name)
    at = command.parts.index(part)
    following = command.parts[at + 1] if at + 1 < len(command.parts) else None
    takes_word = part.value is None and following is not None and not following.flag
    if meant is None or (command.has(meant) and not meant.multiple):
        del command.parts[at]
        # Its value goes with it, unless the command needs that word.
        if takes_word and word_count(command) > len(command.arguments):
            command.parts.remove(following)  # type: ignore[arg-type]
        return
    part.option = meant
    part.flag = flag_of(meant)
    if meant.is_flag:
        part.value = None
    elif takes_word:
        part.value = following.value  # type: ignore[union-attr]
        command.parts.remove(following)  # type: ignore[arg-type]
    is_named = name.casefold() in NAMED.get(flag_of(meant).removeprefix("--"), ())
    if is_named and part.value is not None:
        part.value = f"{name.casefold()}={part.value}"


def _place_words(command: CommandParts, extra: Sequence[str]) -> None:
    """Turn words that no argument takes into values of options, or drop them."""
    for text in extra:
        part = next(one for one in reversed(command.parts) if not one.flag and one.value == text)
        before = command.parts[command.parts.index(part) - 1]
        command.parts.remove(part)
        # `--controller turn right` is one name, and `size=60` an option without its dashes.
        kind = None if before.option is None else kind_of(command.command, before.option)
        if kind is not None and f"{before.value}-{text}" in kind.names():
            before.value = f"{before.value}-{text}"
            continue
        name, equals, value = text.partition("=")
        named = command.option(name.replace("_", "-")) if equals else None
        if named is not None:
            if not command.has(named):
                command.add(named, value)
            continue
        option = next((one for one in options_for(command, text)), None)
        if option is not None:
            command.add(option, text)


def _fill_in(command: CommandParts, parameter: click.Parameter | None) -> bool:
    """Give a missing option or argument a value: a word that fits it, or that of an example."""
    if isinstance(parameter, click.Option):
        # A word of the command may be the value.
        words = [part for part in command.parts if not part.flag and part.value]
        fitting = [
            part
            for part in words
            if parameter in options_for(command, part.value or "")
            and not (len(words) <= len(command.arguments) and Path(part.value or "").exists())
        ]
        needed = sum(one.required for one in command.arguments)
        if parameter.name in WRITTEN and len(words) <= needed:
            fitting = []
        for part in fitting if parameter.multiple else fitting[-1:]:
            command.parts.remove(part)
            command.add(parameter, part.value)
        if fitting:
            return True
        usual = _usual(command, parameter)
        value = next((one for one in usual if accepts(parameter, one, command.context)), None)
        if value is None:
            return False
        command.add(parameter, value)
        return True
    if isinstance(parameter, click.Argument):
        value = command.example(parameter)
        if value is None:
            return False
        # After the words before it, so that it becomes this argument.
        at = next((k for k, one in enumerate(command.parts) if one.flag), len(command.parts))
        places = [k for k, one in enumerate(command.parts) if not one.flag]
        command.parts.insert(places[-1] + 1 if places else at, CommandPart(None, "", value))
        return True
    return False


def _keep_one(command: CommandParts, option: click.Parameter) -> None:
    """Keep the last value of an option; several controllers are for another command."""
    parts = [part for part in command.parts if part.option is option]
    if command.head[-1:] == ["run"] and option.name == "controller":
        command.head[-1] = "compare"
        return
    for part in parts[:-1]:
        command.parts.remove(part)


def _give_value(command: CommandParts, flag: str) -> list[str] | None:
    """Give a value to an option that has none, or take it from one that takes none."""
    option = command.written(flag)
    part = next((one for one in command.parts if one.option is option), None)
    if option is None or part is None:
        return None
    if option.is_flag:
        part.value = None
        return command.words()
    command.parts.remove(part)
    return command.words() if _fill_in(command, option) else None


def _mend_value(command: CommandParts, parameter: click.Parameter, context: click.Context) -> bool:
    """Replace the values that an option or argument refuses; return False if none fits."""
    for part in list(command.parts):
        is_its = part.option is parameter or (
            isinstance(parameter, click.Argument) and not part.flag
        )
        if not is_its or part.value is None:
            continue
        several = names_in_one(command.command, parameter, part.value)
        if several:
            at = command.parts.index(part)
            command.parts[at : at + 1] = [
                CommandPart(part.option, part.flag, one) for one in several
            ]
            continue
        if accepts(parameter, part.value, context):
            continue
        better = itertools.chain(better_values(parameter, part.value), _usual(command, parameter))
        fitting = next((one for one in better if accepts(parameter, one, context)), None)
        if fitting is None:
            return False
        part.value = fitting
    return True


def _usual(command: CommandParts, parameter: click.Parameter) -> Iterator[str]:
    """Return values that a parameter often has, the most useful first."""
    example = command.example(parameter)
    if example is not None:
        yield example
    kind = kind_of(command.command, parameter)
    if kind is not None:
        yield built_in(kind)
    default = parameter.get_default(command.context)
    if isinstance(default, str | int | float) and not isinstance(default, bool):
        yield str(default)
    if isinstance(parameter.type, click.Choice):
        yield from map(str, parameter.type.choices)
    if isinstance(parameter.type, click.types.IntParamType | click.types.FloatParamType):
        limits = (getattr(parameter.type, name, None) for name in ("min", "max"))
        yield from ("1", *(f"{limit:g}" for limit in limits if limit is not None))


def accepts(parameter: click.Parameter, text: str, context: click.Context) -> bool:
    """Return True if a parameter takes a value."""
    try:
        if parameter.nargs == 1:
            parameter.type.convert(text, parameter, context)
        if isinstance(parameter, click.Option) and parameter.callback and not parameter.is_eager:
            parameter.process_value(context, (text,) if parameter.multiple else text)
    except (click.UsageError, WorldgenError):
        return False
    return True
