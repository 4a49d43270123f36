"""Decide whose code runs: the only rule for modules, programs, and shared libraries.

A world, a corpus, a campaign's folder or a set may come from anybody, and names the code that it
needs. That code runs only if it is

1. registered: built in, or an entry point of an installed package,
2. named on this command line, or passed as an argument by a Python caller,
3. named in the project's settings, in any table ``[tool.worldgen.COMMAND]``, or
4. what this user has run from the command line before: the same file, or the same program in the
   same folder.

The places where code is imported, loaded or started call :func:`check_code`, so a command that
forgets the rule refuses rather than runs. ``SECURITY.md`` describes the rule for users.
"""

from __future__ import annotations

import contextlib
import importlib.machinery
import importlib.util
import json
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from worldgen.errors import InvalidParameter
from worldgen.parameters import split_headed, without_class_options
from worldgen.plugins.project import has_trusted_owner, named_in_settings, owners
from worldgen.support.paths import expanded
from worldgen.support.plain_text import shown

_HERE = Path(__file__).resolve().parents[2]
# Modules of ours that hold controllers, oracles and families, so that naming one is harmless.
_OURS = (
    "sim.controllers.",
    "fuzz.faults.",
    "fuzz.oracles.",
    "fuzz.watchdogs.",
    "worldgen.families.",
)
_MODULE = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)*")
_LEARNED = re.compile(r"\+learned=([^+]+)")
# Characters of a name in a message.
_LONGEST = 400
# Kinds of keys whose code is a file. The kind tells what happens to it: what was read as data
# must not be loaded as a library later.
_FILES = ("file", "library", "data")
# Characters of a text whose names are noted for messages; a longer one is hardly a name.
_MOST_NAME = 4096
# Bytes of the list of code that was run before.
_MOST_BYTES = 1 << 22
_LIST = "code-that-was-run"


class CodeNotTrusted(InvalidParameter):
    """A file names code that the rule does not allow."""


class NameInFile(str):
    """A name of code that was read from a file, so no caller of ours has chosen it."""

    __slots__ = ()

    def __reduce__(self) -> tuple[type[NameInFile], tuple[str]]:
        return NameInFile, (str(self),)


@dataclass
class _Trust:
    """What this process may run.

    Args:
        is_command: True in a command and its workers, where everything needs a reason. Elsewhere
            the caller is a Python program, and only what a file has named needs one.
        all: True under ``--trust``.
        admitted: The keys of code that may run; True if it is remembered for later commands.
        folders: Folders whose files are trusted, such as pytest's rootdir.
        ask: Asks the user; None if nobody can answer.
        command: The command line with ``--trust`` added; empty if it is unknown.
        refused: The sentences about code that was refused, by its key.
        said: Those of them that the user has seen.
    """

    is_command: bool = False
    all: bool = False
    admitted: dict[str, bool] = field(default_factory=dict)
    folders: tuple[str, ...] = ()
    ask: Callable[[str], bool] | None = None
    command: str = ""
    refused: dict[str, str] = field(default_factory=dict)
    said: set[str] = field(default_factory=set)


_trust = _Trust()
_A_LONG_NAME = "long name"
# By key and by text, the file that named the code.
_named_in: dict[str, str] = {}


def check_code(name: str) -> None:
    """Raise an error if the code with this name must not run, after asking the user if possible.

    Args:
        name: ``module:name``, ``./file.py:name``, ``cmd:PROGRAM``, ``lib:./file.so:name``, or
            ``learned:FILE``.

    Raises:
        CodeNotTrusted: If no reason of the rule applies.
    """
    for key in _keys(name):
        if not _may_run(key, name):
            _ask(key, name)


def may_run(name: str) -> bool:
    """Return True if the code with this name may run, without asking the user."""
    return all(not _is_missing(key) and _may_run(key, name) for key in _keys(name))


def admit(*texts: str) -> None:
    """Let code run in this process, because a user or a caller named it.

    Args:
        texts: Names with any options, or comma-separated lists of them; other texts do nothing.
    """
    for text in texts:
        for key in _keys_in(text):
            _trust.admitted.setdefault(key, False)


def admit_typed(values: Iterable[object], command: str) -> None:
    """Let code run because it was named on the command line, and remember it once it runs.

    Args:
        values: The values of the command's parameters, as typed.
        command: The command line with ``--trust`` added, for messages.
    """
    if not _trust.is_command:
        return
    _trust.command = command or _trust.command
    for value in values:
        for text in value if isinstance(value, list | tuple) else (value,):
            for key in _keys_in(text) if isinstance(text, str) else ():
                _trust.admitted[key] = True


def admit_argument(*names: object) -> None:
    """Let code run because a Python caller passed its name.

    Every public function that takes a name calls this. Commands admit what was typed instead, so in
    a command this does nothing, and neither does it for a :class:`NameInFile`.
    """
    if not _trust.is_command:
        admit(*(name for name in names if type(name) is str))


def same_origin(name: str, text: str) -> str:
    """Return a part of a name, or another spelling of it; from a file if the name is."""
    return NameInFile(text) if isinstance(name, NameInFile) else text


def trust_everything() -> None:
    """Let all code run until the command ends, as ``--trust`` does."""
    if _trust.is_command:
        _trust.all = True


def trusts_everything() -> bool:
    """Return True under ``--trust``."""
    return _trust.all


def note_names(value: object, source: str | None) -> None:
    """Note every name of code in a value that was read from a file.

    Args:
        value: A text, or a table or list that may contain some.
        source: The file, for messages.
    """
    if isinstance(value, Mapping):
        for one in value.values():
            note_names(one, source)
    elif isinstance(value, list | tuple):
        for one in value:
            note_names(one, source)
    elif isinstance(value, str) and (":" in value or "+" in value):
        # A file with such a long name is not an honest one: after it, everything needs a reason.
        keys = _keys_in(value) if len(value) < _MOST_NAME else [_A_LONG_NAME]
        for key in (_place(value), *keys, *map(_tail, keys)):
            # The latest, because a command reads and runs one file after another.
            _named_in[key] = source or "a file"


@contextlib.contextmanager
def command_rule(ask: Callable[[str], bool] | None) -> Iterator[dict[str, str]]:
    """Apply the rule of commands: all code needs a reason.

    Args:
        ask: Asks the user a question; None if nobody is there to answer.

    Yields:
        The sentences about refused code, by its key; they are added as code is refused.
    """
    global _trust  # noqa: PLW0603 - one rule for the process
    before = _trust
    # A process that was restricted before keeps the names that it was given.
    admitted = dict(before.admitted) if before.is_command else {}
    _trust = _Trust(is_command=True, admitted=admitted, folders=before.folders, ask=ask)
    try:
        yield _trust.refused
    finally:
        _trust = before


def note_said(text: str) -> None:
    """Note which sentences about refused code a text that is printed contains."""
    _trust.said.update(one for one in _trust.refused.values() if one in text)


def unsaid() -> list[str]:
    """Return the sentences about refused code that the user has not seen."""
    return [one for one in _trust.refused.values() if one not in _trust.said]


def restrict(names: Iterable[str]) -> None:
    """Apply the rule of commands from now on, in a process that serves others.

    Args:
        names: Names that the user gave at the start.
    """
    _trust.is_command = True
    admit(*names)


@dataclass(frozen=True)
class Inherited:
    """What a new process of ours may run: the same as this one, without questions.

    It is evaluated when a process starts, so that answers to questions count.
    """

    def __reduce__(self) -> tuple[Callable[..., Inherited], tuple[object, ...]]:
        admitted = dict.fromkeys(_trust.admitted, False)
        folders = (*_trust.folders, *_pytest_root())
        state = replace(
            _trust, admitted=admitted, folders=folders, ask=None, refused={}, said=set()
        )
        return _inherit, (state, dict(_named_in))


def _inherit(state: _Trust, named_in: dict[str, str]) -> Inherited:
    global _trust  # noqa: PLW0603 - as above
    _trust = state
    _named_in.update(named_in)
    return Inherited()


# What a name refers to


def _keys(name: str) -> list[str]:
    """Return what identifies the code: its file, or the program and its folder.

    The same file has one key, whatever it is called: as a module, by a link, or from elsewhere.
    """
    program = split_headed(name, "cmd")
    if program is not None:
        return [_program_key(program[1], str(Path.cwd()))]
    if name.startswith("lib:"):
        return [_file_key(name.removeprefix("lib:").rpartition(":")[0], "library")]
    if name.startswith("learned:"):
        return [_file_key(name.removeprefix("learned:"), "data")]
    found = [_file_key(file.strip(), "data") for file in _LEARNED.findall(name)]
    # What follows a name may be options or part of the name, so both readings need a reason.
    for text in dict.fromkeys((without_class_options(name), name)):
        place, colon, _ = text.rpartition(":")
        if place.endswith(".py"):
            found.append(_file_key(place))
        elif colon and place:
            found += _module_keys(place)
    return found


def _module_keys(place: str) -> list[str]:
    if _is_ours(place):
        return []
    file = file_of_module(place)
    return [f"module {place}" if file is None else _file_key(file)]


def _keys_in(text: str) -> list[str]:
    """Return the keys of all code that a text as typed may mean."""
    listed = split_headed(text, "behaviours")
    words = (text if listed is None else listed[1]).split(",")
    names = [text, *words]
    # The command line of a program may contain commas, and another controller may follow it.
    for first in range(len(words)):
        if split_headed(words[first].strip(), "cmd") is not None:
            names += [",".join(words[first:last]) for last in range(first + 2, len(words) + 1)]
    # A number follows an oracle's name, and a value its option.
    names += [part for word in words for part in (word.rpartition("=")[0], word.partition("=")[2])]
    return [key for name in names for key in _keys(name.strip())]


def _place(name: str) -> str:
    return without_class_options(name).rpartition(":")[0] or name


def _file_key(path: str | Path, kind: str = "file") -> str:
    try:
        return f"{kind} {os.path.realpath(expanded(path))}"
    except (OSError, ValueError):  # such as a NUL in the name
        return f"{kind} {path}"


def _program_key(command: str, folder: str) -> str:
    with contextlib.suppress(ValueError):  # an open quote, which starting it reports
        command = shlex.join(shlex.split(command))
    return f"program {json.dumps([os.path.realpath(folder), command])}"


def _is_ours(module: str) -> bool:
    """Return True for a module of ours with controllers, oracles or families."""
    if not _MODULE.fullmatch(module) or not f"{module}.".startswith(_OURS):
        return False
    place = _HERE.joinpath(*module.split("."))
    return place.with_suffix(".py").is_file() or (place / "__init__.py").is_file()


def file_of_module(name: str) -> Path | None:
    """Return the file that importing a module would run, without running anything.

    ``importlib.util.find_spec`` imports the packages above a module, so the path is walked here.
    """
    top, *below = name.split(".")
    try:
        spec = importlib.util.find_spec(top)
        for part in below:
            places = None if spec is None else spec.submodule_search_locations
            if places is None:
                return None
            # Its own name alone: a folder without __init__.py would look for its parent's module.
            spec = importlib.machinery.PathFinder.find_spec(part, list(places))
    except (ImportError, ValueError, AttributeError):
        return None
    return Path(spec.origin) if spec is not None and spec.has_location and spec.origin else None


# The reasons


def _may_run(key: str, name: str) -> bool:
    """Return True if a reason of the rule applies to the code."""
    if _trust.all:
        return True
    if key in _trust.admitted:
        if _trust.admitted[key]:
            _trust.admitted[key] = False
            _remember(key)
        return True
    source = _named_in.get(key) or _named_in.get(_place(name))
    has_reason = (
        # What no file has named is from the Python caller.
        not (_trust.is_command or _was_in_a_file(key, name))
        or _is_missing(key)
        or _in_trusted_folder(key, source)
        or key in _keys_of_settings()
        or (key in _remembered() and _has_trusted_owner(key))
    )
    if has_reason and not _is_missing(key):
        _trust.admitted[key] = False
    return has_reason


def _was_in_a_file(key: str, name: str) -> bool:
    """Return True if a file that this process has read may have named the code.

    The name of the file decides, wherever it is: the caller may have changed folder since.
    """
    if isinstance(name, NameInFile) or _A_LONG_NAME in _named_in:
        return True
    return key in _named_in or _tail(key) in _named_in


def _tail(key: str) -> str:
    """Return what is the same about a key in every folder."""
    kind, _, place = key.partition(" ")
    tail = json.loads(place)[1] if kind == "program" else Path(place).name
    return f"{kind} in any folder: {tail}"


def _is_missing(key: str) -> bool:
    """Return True if there is no file to run, which loading it reports better."""
    kind, _, place = key.partition(" ")
    return kind in _FILES and not os.path.lexists(place)


def _in_trusted_folder(key: str, source: str | None) -> bool:
    folders = (*_trust.folders, *_pytest_root())
    if not folders:
        return False
    kind, _, place = key.partition(" ")
    files = [place] if kind in _FILES else []
    files += [] if source is None else [os.path.realpath(source)]
    return any(Path(file).is_relative_to(folder) for file in files for folder in folders)


def _pytest_root() -> tuple[str, ...]:
    """Return pytest's rootdir, if this process is pytest; one that it started doesn't inherit it."""
    process, _, folder = os.environ.get("WORLDGEN_PYTEST_ROOT", "").partition(":")
    return (os.path.realpath(folder),) if process == str(os.getpid()) else ()


def _keys_of_settings() -> set[str]:
    """Return the keys of the code that the project's settings name, for any command."""
    folder, names = named_in_settings(any_owner=_trust.all)
    found = {key for name in names for key in _keys_in(name) if not key.startswith("program ")}
    programs = [name for name in names if split_headed(name, "cmd") is not None]
    for name in programs:
        command = name.partition(":")[2]
        # In a folder below the project, a relative path may be another file.
        if folder == Path.cwd() or not _has_relative_file(command):
            found.add(_program_key(command, str(Path.cwd())))
    return found


def _has_relative_file(command: str) -> bool:
    return any(os.path.lexists(word) for word in _words(command) if not Path(word).is_absolute())


# Code that was run before


def list_file() -> Path | None:
    """Return the file that lists what this user has run; None if there is no place for it."""
    usual = {"win32": "~/AppData/Local", "darwin": "~/Library/Application Support"}
    chosen = os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_STATE_HOME", "")
    # The standard for these folders says to ignore a relative path.
    is_chosen = Path(chosen).is_absolute()
    folder = expanded(chosen if is_chosen else usual.get(sys.platform, "~/.local/state"))
    return folder / "worldgen" / _LIST if folder.is_absolute() else None


def _remembered() -> set[str]:
    """Return the keys of what this user has run from the command line."""
    path = list_file()
    try:
        if path is None or not has_trusted_owner(path) or path.stat().st_size > _MOST_BYTES:
            return set()
        # Nobody else may add to it.
        if owners() is not None and path.stat().st_mode & 0o022:
            return set()
        return set(path.read_text("utf-8").splitlines())
    except (OSError, ValueError):
        return set()


def _remember(key: str) -> None:
    """Add a key to the list; without a place for it, nothing is remembered."""
    path = list_file()
    if path is None or "\n" in key or key in _remembered():
        return
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        # One write at the end of the file, so that commands at the same time do not mix.
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        try:
            os.write(handle, f"{key}\n".encode())
        finally:
            os.close(handle)
    except (OSError, ValueError):  # ValueError: half of a surrogate pair in a name
        return


def _words(command: str) -> list[str]:
    try:
        return shlex.split(command)
    except ValueError:  # an open quote
        return []


def _has_trusted_owner(key: str) -> bool:
    """Return True unless another user has put the file there."""
    kind, _, place = key.partition(" ")
    files = [Path(place)] if kind in _FILES else []
    if kind == "program":
        folder, command = json.loads(place)
        files = [Path(folder, word) for word in _words(command)]
    try:
        return all(has_trusted_owner(file) for file in files if kind in _FILES or file.is_file())
    except (OSError, ValueError):  # ValueError: a NUL in a word
        return False


# Refusing


def _shortened(name: str) -> str:
    """Return a name for a message; one that is cut says so, because its end may be what matters."""
    more = len(name) - _LONGEST
    return shown(name) if more <= 0 else f"{shown(name[:_LONGEST])}... ({more} more characters)"


def _ask(key: str, name: str) -> None:
    """Ask the user about code that has no reason to run.

    Raises:
        CodeNotTrusted: If nobody can answer, or the answer is no.
    """
    source = shown(_named_in.get(key) or _named_in.get(_place(name)) or "a file")
    kind, _, place = key.partition(" ")
    what = shown(json.loads(place)[1] if kind == "program" else place)
    verbs = {"program": "Start the program", "module": "Import the module", "data": "Read"}
    verb = verbs.get(kind, "Run")
    # One question about each piece of code, however many files name it.
    question = (
        f"{source} names {_shortened(name)}, which is code that you have not run before. "
        f"{verb} {what}?"
    )
    if _trust.ask is not None and key not in _trust.refused and _trust.ask(question):
        _trust.admitted[key] = False
        _remember(key)
        return

    # A command's first error names the command that works.
    if _trust.is_command and key in _trust.refused:
        raise CodeNotTrusted(
            "code-not-allowed",
            "'{name}' is not run: it is code that you have not run from the command line before",
            "--trust runs it",
            at_terminal=True,
            name=_shortened(name),
        )
    if not _trust.is_command:
        error = CodeNotTrusted(
            "code-not-allowed",
            "{source} names '{name}', which is not run: only the file names it",
            "if you trust it, pass its name as an argument or to worldgen.plugins.trust.admit(), "
            "or run it once with worldgen run",
            at_terminal=True,
            source=source,
            name=_shortened(name),
        )
    elif key in _remembered():
        error = CodeNotTrusted(
            "code-not-allowed",
            "{source} names '{name}', which is not run: {what} belongs to another user now",
            "if you trust it, type: {command}",
            source=source,
            name=_shortened(name),
            what=what,
            command=_trust.command,
        )
    else:
        error = CodeNotTrusted(
            "code-not-allowed",
            "{source} names '{name}', which is not run: it is code that you have not run from the "
            "command line before",
            "if you trust it, type: {command}",
            source=source,
            name=_shortened(name),
            command=_trust.command,
        )
    _trust.refused.setdefault(key, str(error))
    raise error
