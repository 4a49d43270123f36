"""Answer a wrong command: what came, the rule, and the corrected command.

Click reports one fault of a command at a time. Here each fault is mended, and the command is parsed
again, until click accepts it. So a suggested command is always a valid one. The values that are
missing come from the examples at the end of the command's help.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import re
import shlex
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from worldgen.cli.names import CONTROLLER, NameKind, kind_of, names_in_one
from worldgen.cli.usage import ExtraWords, GivenTwice, Instead, UnknownCommand
from worldgen.errors import WorldgenError
from worldgen.support.known_names import nearest
from worldgen.support.plain_text import stacked

# Faults of one command that are mended; a command with more of them is not worth a guess.
_MOST_FAULTS = 12
_MOST_FILES = 50  # Python files in which a class is looked for
_LONGEST = 2000  # characters of a command that is mended
# Spellings from other tools, the most likely meaning first.
_OTHER_WORDS = {
    "c": ("controller",), "robot": ("controller",), "policy": ("controller",),
    "algorithm": ("controller",), "m": ("motion",), "model": ("motion",),
    "o": ("out", "picture"), "output": ("out", "picture"), "output-dir": ("out",),
    "dir": ("out",), "folder": ("out",), "file": ("out",), "save": ("out", "picture"),
    "out": ("picture",),
    "png": ("picture",), "svg": ("picture",), "html": ("picture", "report"),
    "image": ("picture",), "plot": ("picture",), "gif": ("picture",),
    "n": ("count", "units", "seeds", "examples", "steps"),
    "num": ("count", "units", "seeds"), "number": ("count", "units"),
    "iterations": ("units", "steps"), "runs": ("units", "seeds"), "trials": ("units", "seeds"),
    "j": ("workers",), "jobs": ("workers",), "threads": ("workers",), "processes": ("workers",),
    "s": ("seed",), "t": ("budget", "steps"), "time": ("budget",), "timeout": ("budget",),
    "time-limit": ("budget",), "duration": ("budget",), "max-steps": ("steps",),
    "dt": ("time-step",), "step-size": ("time-step",), "world": ("family", "from"),
    "width": ("size",), "height": ("size",), "f": ("force", "family"), "overwrite": ("force",),
    "y": ("force",), "format": ("to", "from"), "type": ("to", "kind"), "lang": ("kind",),
    "language": ("kind",), "r": ("radius", "robot-radius"), "env": ("family",),
    "v": ("version",), "h": ("help",),
}  # fmt: skip
_COMMANDS = {
    "generate": "", "gen": "", "make": "", "new": "", "create": "", "add": "",
    "simulate": "run", "sim": "run", "exec": "run", "start": "run",
    "play": "studio", "gui": "studio", "ui": "studio", "serve": "studio", "web": "studio",
    "test": "fuzz", "search": "fuzz", "check": "verify", "validate": "verify",
    "view": "show", "draw": "show", "plot": "show", "render": "show", "cat": "show",
    "convert": "export", "ls": "list", "rm": "prune", "minimize": "shrink", "minimise": "shrink",
    "rerun": "replay", "list": "families", "benchmark": "compare", "bench": "compare",
}  # fmt: skip
"""Commands of other tools; an empty one is dropped: `worldgen generate maze`."""
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"\A(\s*[+-]?\d+),(\d+)(?![\d,])")
_UNITS = {"k": 1e3, "cm": 1e-2, "mm": 1e-3, "ms": 1e-3, "min": 60.0, "h": 3600.0}
_PREFIXES = ("cmd:", "lib:", "learned:")
_PLAIN_NAME = re.compile(r"[\w-]+")
_PICTURES = (".png", ".svg", ".html", ".gif")


def answer(error: click.UsageError, group: click.Group, words: Sequence[str]) -> str:
    """Return the answer to a wrong command: its fault, and a command that click accepts.

    Args:
        error: The fault that click found first.
        group: The whole program.
        words: The words after the program's name.
    """
    path = "worldgen" if error.ctx is None else error.ctx.command_path
    suggested = corrected(error, group, words)
    # A file that does not exist comes before anything that click finds.
    if error.ctx is not None and not isinstance(error, UnknownCommand):
        missing = _missing_files(_Command(error.ctx, words))
        if missing and "--help" not in (suggested or ()):
            sentence = f"{path}: there is no file or folder {missing[0]!r}; check the path"
            accepted = None if suggested is None else _accepted(group, suggested)
            if accepted is None or missing[0] in _missing_files(accepted):
                return stacked((sentence,))
            return stacked((sentence, f"  {shlex.join(['worldgen', *accepted.words()])}"))
    command = f"{path} --help" if suggested is None else shlex.join(["worldgen", *suggested])
    return stacked((f"{path}: {_described(error, words, suggested)}", f"  {command}"))


def _accepted(group: click.Group, words: Sequence[str]) -> _Command | None:
    """Take a command apart; None if click does not accept it, or it asks for help."""
    try:
        return _Command(_parsed(group, words), words)
    except (click.ClickException, click.exceptions.Exit, WorldgenError):
        return None


def _missing_files(command: _Command) -> list[str]:
    """Return the files that a command is to read and that do not exist."""
    missing = []
    for part in command.parts:
        if part.option is None or not part.value:
            continue
        if kind_of(command.command, part.option) is CONTROLLER:
            missing.append(_missing_part(part.value))
        elif part.option.name in _READ and _is_missing(part.value):
            missing.append(part.value)
    # The word after an unknown option is likely to be its value.
    texts = [
        part.value or ""
        for before, part in itertools.pairwise((None, *command.parts))
        if not part.flag
        and not (before is not None and before.flag and before.option is None and not before.value)
    ]
    for argument, text in zip(_repeated(command.arguments), texts, strict=False):
        # A word may also be the value of an option without its name.
        homes = (one for one in _homes(command, text) if one.name not in _WRITTEN)
        is_read = isinstance(argument.type, click.Path) and argument.required
        if is_read and _is_missing(text) and not any(homes):
            missing.append(text)
    return [file for file in missing if file]


def _repeated(arguments: Sequence[click.Argument]) -> Iterator[click.Argument]:
    """Return the argument of each word in turn."""
    for argument in arguments:
        yield from itertools.repeat(argument) if argument.nargs < 0 else (argument,)


def _missing_part(name: str) -> str:
    """Return the file in a controller's name if it does not exist; empty if it does."""
    bare = name.partition("+")[0]
    prefix = next((one for one in _PREFIXES if bare.startswith(one)), "")
    file = bare.removeprefix(prefix)
    if prefix == "cmd:":
        with contextlib.suppress(ValueError):
            file = next(iter(shlex.split(file)), "")
    elif not prefix and ".py:" in file:
        file = file.rpartition(":")[0]
    is_path = "/" in file or (prefix not in ("", "cmd:")) or file.endswith(".py")
    return file if is_path and ":" not in file and _is_missing(file) else ""


def _is_missing(text: str) -> bool:
    """Return True if a path leads nowhere, neither to a file nor into an archive."""
    if not text or text == "-" or set(text) & set("*?["):
        return False
    try:
        path = Path(text)
        return not path.exists() and not any(one.is_file() for one in path.parents)
    except (OSError, ValueError):
        return False


def answer_named(error: WorldgenError, group: click.Group, words: Sequence[str]) -> str:
    """Return the corrected command for a value that a command refused; empty if unknown.

    The error says what to write instead: its facts hold the text that came as ``name`` and the
    right one as ``near``, or the bounds of a number. A file is its ``source`` or ``path``.
    """
    changed = _clamped(error, group, words) or _renamed(error, group, list(words))
    if changed is None or changed == list(words):
        return ""
    fault = first_fault(group, changed)
    suggested = changed if fault is None else corrected(fault, group, changed)
    return shlex.join(["worldgen", *suggested]) if suggested else ""


def _renamed(error: WorldgenError, group: click.Group, words: list[str]) -> list[str] | None:
    facts = error.facts
    came = facts.get("name")
    meant = facts.get("near")
    if error.code in _FILE_CODES:
        came = str(getattr(error, "source", None) or facts.get("source") or facts.get("path") or "")
        command = _accepted(group, words)
        suffixes = () if command is None else command.suffixes()
        meant = _other_file(came, error.code, suffixes) if came else ""
    if isinstance(came, str) and "," in came and words[:1] == ["run"]:
        return ["compare", *words[1:]]
    if not (isinstance(came, str) and isinstance(meant, str) and came and meant) or ":" in came:
        return _polished(group, words)
    # Only whole names are replaced, not parts of longer ones.
    pattern = re.compile(rf"(?<![\w./-]){re.escape(came)}(?![\w-])")
    return [pattern.sub(lambda _: meant, word) for word in words]


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
        command = _accepted(group, words)
        option = None if command is None else command.written(flag)
        usual = () if command is None or option is None else _usual(command, option)
        text = next((one for one in usual if float(one) > 0), "1")
    end = at + (1 if "=" in words[at] else 2)
    return [*words[:at], flag, text, *words[end:]]


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
        return [*_Command(error.ctx, words).head, "--help"]
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


def first_fault(group: click.Group, words: Sequence[str]) -> click.UsageError | None:
    """Return the first fault that click finds in a command, without running it; None if none."""
    try:
        _parsed(group, words)
    except click.UsageError as error:
        return error
    except click.exceptions.Exit:
        return None
    # A family or a recipe that does not exist, or a project's file with a mistake.
    except (WorldgenError, click.ClickException) as error:
        return click.UsageError(str(error))
    return None


def _parsed(group: click.Group, words: Sequence[str]) -> click.Context:
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


def _polished(group: click.Group, words: Sequence[str]) -> list[str]:
    """Return an accepted command with the names that its values most likely mean."""
    command = _accepted(group, words)
    if command is None:
        return list(words)
    for part in command.parts:
        kind = None if part.option is None else kind_of(command.command, part.option)
        if kind is not None and part.value:
            part.value = _better_name(kind, part.value)
        elif (
            part.option is not None and part.option.name in _READ and _is_missing(part.value or "")
        ):
            part.value = _other_file(part.value or "", "no-such-file", (".grid",)) or part.value
    texts = [part for part in command.parts if not part.flag]
    for argument, part in zip(command.arguments, texts, strict=False):
        kind = kind_of(command.command, argument)
        if kind is not None:
            part.value = _better_name(kind, part.value or "")
    for part in texts:
        if part.value and isinstance(_argument_of(command, part, texts).type, click.Path):
            _mend_path(command, part)
    return command.words() if first_fault(group, command.words()) is None else list(words)


def _argument_of(command: _Command, part: _Part, texts: list[_Part]) -> click.Argument:
    at = next(k for k, one in enumerate(texts) if one is part)
    return command.arguments[min(at, len(command.arguments) - 1)]


def _mend_path(command: _Command, part: _Part) -> None:
    """Replace a path that does not exist by the one that was meant, or by an option."""
    text = part.value or ""
    if Path(text).exists():
        return
    needed = sum(one.required for one in command.arguments)
    option = next(_homes(command, text), None) if _word_count(command) > needed else None
    is_plain = _NUMBER.fullmatch(text) or not Path(text).suffix
    if option is not None and option.name not in _WRITTEN and is_plain:
        command.parts.remove(part)
        command.add(option, text)
        return
    part.value = _other_file(text, "no-such-file", command.suffixes()) or text
    # A name that no file has: `run maze`.
    example = command.example(command.arguments[0])
    if part.value == text and not Path(text).suffix and "/" not in text and example:
        part.value = example if Path(example).exists() else text


def _better_name(kind: NameKind, text: str) -> str:
    """Return what a value that names nothing most likely means, or the value itself."""
    # Names that exist, and those with a prefix, are left alone.
    name, plus, options = text.partition("+")
    if name in kind.names() or name.startswith((*_PREFIXES, "behaviours")):
        return text
    place, colon, attribute = name.rpartition(":")
    # mine.py, mine:Robot and ./mine.py:robot are classes in a file; so is a class alone.
    if name.endswith(".py"):
        place = name
        attribute = ""
    elif colon and place.isidentifier() and Path(f"{place}.py").is_file():
        place = f"./{place}.py"
    # Look the class up in the file, and the file among its neighbours.
    if place.endswith(".py"):
        file = Path(place) if Path(place).is_file() else Path(_other_file(place, "no-such-file"))
        defined = kind.in_file(file) if file.suffix == ".py" else []
        if attribute not in defined:
            attribute = nearest(attribute, defined) or "".join(defined[:1])
        spelt = place if file == Path(place) else str(file)
        dot = "./" if place.startswith("./") and not spelt.startswith("./") else ""
        found = f"{dot}{spelt}:{attribute}" if attribute else ""
    # Any other file is a program.
    elif kind is CONTROLLER and Path(name).is_file():
        found = f"cmd:{name}" if "/" in name else f"cmd:./{name}"
    else:
        defined_here = _in_files(kind) if _PLAIN_NAME.fullmatch(name) else {}
        alike = [one for one in defined_here if one.casefold() == name.casefold()]
        # A class may differ in case only; any other name is more likely to be a built-in one.
        meant = name if name in alike else "".join(alike[:1])
        near = meant or nearest(name, kind.names()) or nearest(name, defined_here)
        found = defined_here.get(near, near)
    return f"{found}{plus}{options}" if found else text


@dataclass
class _Part:
    """A part of a command: an option with its value, or a word.

    Args:
        option: The option; None for a word, and for an option that does not exist.
        flag: The option as it was written; empty for a word.
        value: Its value, or the word; None without one.
    """

    option: click.Option | None
    flag: str = ""
    value: str | None = None

    def words(self) -> list[str]:
        if not self.flag:
            return [self.value or ""]
        return [self.flag] if self.value is None else [self.flag, self.value]


class _Command:
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
        return [*self.head, *(word for part in self.parts for word in part.words())]

    def option(self, name: str) -> click.Option | None:
        """Return the option with this name, without dashes."""
        return self._by_flag.get(f"--{name}")

    def written(self, flag: str) -> click.Option | None:
        """Return the option that is written like this."""
        return self._by_flag.get(flag)

    def has(self, option: click.Option) -> bool:
        return any(part.option is option for part in self.parts)

    def add(self, option: click.Option, value: str | None) -> None:
        self.parts.append(_Part(option, _flag_of(option), value))

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
            return _here(kind, value)
        # Use a file that exists to read, and one that does not exist to write.
        is_written = isinstance(parameter, click.Option) and parameter.name in _WRITTEN
        if is_written:
            return _unused(value)
        if isinstance(parameter.type, click.Path) and not Path(value).exists():
            suffix = Path(value).suffix
            if suffix:
                return next((str(one) for one in sorted(Path().glob(f"*{suffix}"))), value)
        return value

    def suffixes(self) -> set[str]:
        """Return the suffixes of the files that the examples read."""
        read = {one.name for one in self.arguments if isinstance(one.type, click.Path)}
        read.update(_READ)
        values = (one[name] for one in self._examples for name in read & one.keys())
        return {Path(value).suffix for value in values} - {""}

    def _taken_apart(self, words: Sequence[str]) -> Iterator[_Part]:
        rest = list(words)
        # Words first, as click sees them.
        while rest:
            word = rest.pop(0)
            if word == "--":
                yield from (_Part(None, "", one) for one in rest)
                return
            if not word.startswith("-") or word == "-" or _NUMBER.fullmatch(word):
                yield _Part(None, "", word)
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
                yield _Part(option, flag, value)
            elif option is not None and not option.is_flag and not option.count and rest:
                yield _Part(option, flag, rest.pop(0))
            else:
                yield _Part(option, flag)

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


_READ = ("against", "baseline", "begin", "resume", "scen", "world")
_WRITTEN = ("out", "picture", "trace", "report", "csv", "curve", "summary", "junit", "sarif")


def _mended(error: click.UsageError, words: Sequence[str]) -> list[str] | None:
    """Return a command without one of its faults; None if it cannot be mended."""
    if error.ctx is None:
        return None
    if isinstance(error, UnknownCommand):
        return _other_command(error, words)
    # Take the command apart, and mend the one fault that click reported.
    command = _Command(error.ctx, words)
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


def _other_command(error: UnknownCommand, words: Sequence[str]) -> list[str] | None:
    at = words.index(error.name)
    before = list(words[:at])
    after = list(words[at + 1 :])
    name = error.name.casefold()
    # These are options of the program.
    if not before and name in ("help", "version"):
        return [*after[:1], "--help"] if name == "help" else ["--version"]
    if error.name.endswith((".grid", ".grid.gz")) and not before:
        return ["show", error.name, *after]
    if error.name.endswith(".py") and not before:
        return ["run", "--controller", error.name, *after]
    other = _COMMANDS.get(name)
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


def _with_instead(command: _Command, error: Instead) -> list[str]:
    if error.meant:
        return [error.meant if word == error.came else word for word in command.words()]
    command.parts = [part for part in command.parts if part.flag != error.came]
    return command.words()


def _rename_option(command: _Command, flag: str) -> None:
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
    meant = _meant_option(command, name)
    at = command.parts.index(part)
    following = command.parts[at + 1] if at + 1 < len(command.parts) else None
    takes_word = part.value is None and following is not None and not following.flag
    if meant is None or (command.has(meant) and not meant.multiple):
        del command.parts[at]
        # Its value goes with it, unless the command needs that word.
        if takes_word and _word_count(command) > len(command.arguments):
            command.parts.remove(following)  # type: ignore[arg-type]
        return
    part.option = meant
    part.flag = _flag_of(meant)
    if meant.is_flag:
        part.value = None
    elif takes_word:
        part.value = following.value  # type: ignore[union-attr]
        command.parts.remove(following)  # type: ignore[arg-type]


def _meant_option(command: _Command, name: str) -> click.Option | None:
    key = name.casefold().replace("_", "-")
    for other in _OTHER_WORDS.get(key, ()):
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
    option = _meant_option(_Command(context, []), flag.lstrip("-"))
    return "" if option is None else _flag_of(option)


def _word_count(command: _Command) -> int:
    return sum(not part.flag for part in command.parts)


def _place_words(command: _Command, extra: Sequence[str]) -> None:
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
        option = next((one for one in _homes(command, text)), None)
        if option is not None:
            command.add(option, text)


def _homes(command: _Command, text: str) -> Iterator[click.Option]:
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
    if _NUMBER.fullmatch(text) or re.fullmatch(r"\d+[x,]\d+", text):
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


def _fill_in(command: _Command, parameter: click.Parameter | None) -> bool:
    """Give a missing option or argument a value: a word that fits it, or that of an example."""
    if isinstance(parameter, click.Option):
        # A word of the command may be the value.
        words = [part for part in command.parts if not part.flag and part.value]
        fitting = [
            part
            for part in words
            if parameter in _homes(command, part.value or "")
            and not (len(words) <= len(command.arguments) and Path(part.value or "").exists())
        ]
        needed = sum(one.required for one in command.arguments)
        if parameter.name in _WRITTEN and len(words) <= needed:
            fitting = []
        for part in fitting if parameter.multiple else fitting[-1:]:
            command.parts.remove(part)
            command.add(parameter, part.value)
        if fitting:
            return True
        usual = _usual(command, parameter)
        value = next((one for one in usual if _accepts(parameter, one, command.context)), None)
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
        command.parts.insert(places[-1] + 1 if places else at, _Part(None, "", value))
        return True
    return False


def _keep_one(command: _Command, option: click.Parameter) -> None:
    """Keep the last value of an option; several controllers are for another command."""
    parts = [part for part in command.parts if part.option is option]
    if command.head[-1:] == ["run"] and option.name == "controller":
        command.head[-1] = "compare"
        return
    for part in parts[:-1]:
        command.parts.remove(part)


def _give_value(command: _Command, flag: str) -> list[str] | None:
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


def _mend_value(command: _Command, parameter: click.Parameter, context: click.Context) -> bool:
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
            command.parts[at : at + 1] = [_Part(part.option, part.flag, one) for one in several]
            continue
        if _accepts(parameter, part.value, context):
            continue
        better = itertools.chain(_better(parameter, part.value), _usual(command, parameter))
        fitting = next((one for one in better if _accepts(parameter, one, context)), None)
        if fitting is None:
            return False
        part.value = fitting
    return True


def _usual(command: _Command, parameter: click.Parameter) -> Iterator[str]:
    """Return values that a parameter often has, the most useful first."""
    example = command.example(parameter)
    if example is not None:
        yield example
    kind = kind_of(command.command, parameter)
    if kind is not None:
        yield _built_in(kind)
    default = parameter.get_default(command.context)
    if isinstance(default, str | int | float) and not isinstance(default, bool):
        yield str(default)
    if isinstance(parameter.type, click.Choice):
        yield from map(str, parameter.type.choices)
    if isinstance(parameter.type, click.types.IntParamType | click.types.FloatParamType):
        limits = (getattr(parameter.type, name, None) for name in ("min", "max"))
        yield from ("1", *(f"{limit:g}" for limit in limits if limit is not None))


def _accepts(parameter: click.Parameter, text: str, context: click.Context) -> bool:
    """Return True if a parameter takes a value."""
    try:
        if parameter.nargs == 1:
            parameter.type.convert(text, parameter, context)
        if isinstance(parameter, click.Option) and parameter.callback and not parameter.is_eager:
            parameter.process_value(context, (text,) if parameter.multiple else text)
    except (click.UsageError, WorldgenError):
        return False
    return True


def _better(parameter: click.Parameter, text: str) -> list[str]:
    """Return what a refused value may have meant, the most likely first."""
    # A choice is misspelt.
    kind = parameter.type
    if isinstance(kind, click.Choice):
        near = nearest(text, map(str, kind.choices))
        return [near] if near else []
    if isinstance(kind, click.types.IntParamType) and text[:2].lower() == "0x":
        with contextlib.suppress(ValueError):
            return [str(int(text, 16))]
    # 0,1 is 0.1 where a number need not be whole.
    if not isinstance(kind, click.types.IntParamType):
        text = _DECIMAL_COMMA.sub(r"\1.\2", text)
    found = _NUMBER.search(text)
    if found is None:
        return []
    # Read the number and its unit, then keep it within its bounds.
    number = float(found[0])
    unit = re.match(r"\s*([a-zA-Z]+)", text[found.end() :])
    word = unit[1].casefold() if unit else ""
    if isinstance(kind, click.types.IntParamType | click.types.FloatParamType):
        value = number * (
            _UNITS.get(word, 1.0) if word in ("k", "cm", "mm", "ms", "min", "h") else 1.0
        )
        low = getattr(kind, "min", None)
        high = getattr(kind, "max", None)
        value = max(value, low) if low is not None else value
        value = min(value, high) if high is not None else value
        is_whole = isinstance(kind, click.types.IntParamType)
        return [str(int(value)) if is_whole else f"{value:g}"]
    # A duration.
    return [f"{found[0]}{word[:1]}", found[0]]


def _flag_of(option: click.Option) -> str:
    return next((flag for flag in option.opts if flag.startswith("--")), option.opts[0])


def _unused(name: str) -> str:
    """Return a name to write to, which does not exist yet."""
    stem = name.rstrip("/")
    slash = "/" if name.endswith("/") else ""
    path = Path(stem)
    number = 2
    while path.exists() and number < 100:
        path = Path(stem).with_name(f"{Path(stem).stem}-{number}{Path(stem).suffix}")
        number += 1
    return f"{path}{slash}"


def _other_file(name: str, code: str, suffixes: Iterable[str] = ()) -> str:
    """Return the file that was meant, or a free name; empty if there is none.

    Args:
        name: The file as it was written.
        code: Code of the error about it.
        suffixes: Suffixes of the files that the command reads.
    """
    path = Path(name)
    if code in ("file-exists", "not-a-folder"):
        return _unused(name)
    try:
        if path.is_dir():
            return next((str(one) for one in sorted(path.glob("*.grid"))), "")
        names = sorted(one.name for one in path.parent.iterdir() if not one.name.startswith("."))
    except (OSError, ValueError):
        return ""
    if f"{path.name}.grid" in names:
        return f"{name}.grid"
    # A file of another kind would be refused.
    same = {Path(one).stem: one for one in names if Path(one).suffix == path.suffix}
    readable = [one for one in names if Path(one).suffix in suffixes]
    near = same.get(nearest(path.stem, same)) or nearest(path.name, readable)
    return str(path.with_name(near)) if near else ""


def _here(kind: NameKind, text: str) -> str:
    """Return the names of an example that exist here, or a built-in one."""
    if text.startswith("behaviours"):
        return text
    better = (_better_name(kind, one) for one in text.split(","))
    existing = [one for one in better if _names_something(kind, one)]
    return ",".join(dict.fromkeys(existing)) or _built_in(kind)


def _names_something(kind: NameKind, text: str) -> bool:
    """Return True if a name is built in, or its file defines it."""
    name = text.partition("+")[0]
    file, _, attribute = name.rpartition(":")
    is_defined = file.endswith(".py") and attribute in kind.in_file(Path(file))
    is_program = name.startswith(_PREFIXES) and not _missing_part(name)
    return name in kind.names() or is_defined or is_program


def _built_in(kind: NameKind) -> str:
    """Return the name of one that exists everywhere."""
    return "turn-right" if kind is CONTROLLER else next(iter(kind.names()), "")


def _in_files(kind: NameKind) -> dict[str, str]:
    """Return the names that the Python files of this folder define, as one writes them."""
    files = itertools.islice(sorted(Path().glob("*.py")), _MOST_FILES)
    return {name: f"./{file}:{name}" for file in files for name in kind.in_file(file)}


def _described(
    error: click.UsageError, words: Sequence[str], suggested: Sequence[str] | None
) -> str:
    """Return the fault in words: what came, and the rule."""
    if isinstance(error, UnknownCommand):
        at = words.index(error.name)
        meant = "" if suggested is None else "".join(suggested[at : at + 1])
        hint = f"did you mean {meant!r}?" if meant else "--help lists the commands"
        return f"{error.message}; {hint}"
    if isinstance(error, ExtraWords):
        return _unexpected(error, words)
    if isinstance(error, click.NoSuchOption) and error.ctx is not None:
        # The others are dropped, too, so they are named.
        command = _Command(error.ctx, words)
        unknown = (one.flag for one in command.parts if one.flag and one.option is None)
        others = [one for one in unknown if not _meant_option(command, one.lstrip("-"))]
        also = [one for one in dict.fromkeys(others) if one != error.option_name]
        return error.message + (f", nor {' or '.join(also)}" if also else "")
    if isinstance(error, click.MissingParameter) and error.param is not None:
        name = _shown(error.param, error.ctx)
        reason = f"; {error.message}" if error.message else ""
        return f"{name} is missing{reason}"
    if isinstance(error, click.BadOptionUsage):
        return (
            f"{error.option_name} needs a value" if "requires" in error.message else error.message
        )
    if isinstance(error, click.BadParameter) and error.param is not None:
        return f"{_shown(error.param, error.ctx)}: {_value_fault(error)}"
    return error.format_message()


def _value_fault(error: click.BadParameter) -> str:
    kind = error.param.type if error.param is not None else None
    text = error.message.rstrip(".")
    came = re.match(r"'(?:[^'\\]|\\.)*'|\"[^\"]*\"|-?[\d.]+", text)
    if came is not None and isinstance(kind, click.types.IntParamType | click.types.FloatParamType):
        noun = "whole number" if isinstance(kind, click.types.IntParamType) else "number"
        low = getattr(kind, "min", None)
        high = getattr(kind, "max", None)
        limits = f" from {low} to {high}" if None not in (low, high) else ""
        limits = f" of at least {low}" if low is not None and high is None else limits
        return f"{came[0]} is not a {noun}{limits}"
    return text


def _unexpected(error: ExtraWords, words: Sequence[str]) -> str:
    quoted = " ".join(map(repr, error.words))
    if error.ctx is None:
        return f"{quoted} is not expected here"
    command = _Command(error.ctx, words)
    for text in error.words:
        name, equals, value = text.partition("=")
        named = command.option(name.replace("_", "-")) if equals else None
        if named is not None:
            return f"{text!r} is not expected here; write {_flag_of(named)} {shlex.quote(value)}"
        option = next(_homes(command, text), None)
        if option is not None:
            return f"{text!r} is not expected here; write {_flag_of(option)} {shlex.quote(text)}"
    names = " ".join(one.make_metavar(error.ctx) for one in command.arguments)
    return f"{quoted} is not expected here; it takes " + (
        f"only {names}" if names else "only options"
    )


def _shown(parameter: click.Parameter, context: click.Context | None) -> str:
    if isinstance(parameter, click.Option):
        return _flag_of(parameter)
    return "" if context is None else parameter.make_metavar(context)
