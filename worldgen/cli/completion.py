"""Complete commands, options and names in bash, zsh and fish, through click.

``eval "$(_WORLDGEN_COMPLETE=bash_source worldgen)"`` switches it on. Each press of Tab runs the
program once, so nothing is imported but the command that is being typed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from click.shell_completion import (
    BashComplete,
    CompletionItem,
    FishComplete,
    ShellComplete,
    ZshComplete,
    add_completion_class,
)

from worldgen.cli.names import NameKind

# Python files that are searched for classes; more would make Tab slow.
_MOST_FILES = 40
# Words at which bash splits what is typed.
_BREAKS = ("=", ":")


def complete_names(kind: NameKind, incomplete: str) -> list[CompletionItem[str]]:
    """Return the names that begin as typed: registered ones, and classes in Python files."""
    names = [name for name in kind.names() if name.startswith(incomplete)]
    names += _names_in_files(kind, incomplete)
    # Names of a folder's files come once the folder is typed.
    if not names and kind.takes_files:
        return [CompletionItem(incomplete, type="dir")]
    return [CompletionItem(name) for name in names]


def _names_in_files(kind: NameKind, incomplete: str) -> list[str]:
    if not kind.takes_files:
        return []
    place, _, _ = incomplete.partition(":")
    head, slash, _ = place.rpartition("/")
    folder = Path(f"{head}{slash}" or ".").expanduser()
    try:
        files = sorted(one for one in folder.iterdir() if one.suffix == ".py")
    except (OSError, ValueError):
        return []
    # Without a folder both spellings work, and ./ is the documented one.
    spelt = f"{head}{slash}" if slash or incomplete else "./"
    written = [(f"{spelt}{file.name}", file) for file in files]
    fitting = [
        (text, file)
        for text, file in written
        if text.startswith(place) and (":" not in incomplete or text == place)
    ]
    found = [
        f"{text}:{name}" for text, file in fitting[:_MOST_FILES] for name in kind.in_file(file)
    ]
    return [name for name in found if name.startswith(incomplete)]


class _Bash(BashComplete):
    """Puts the words together that bash splits at ``=`` and ``:``."""

    _typed = ""

    def get_completion_args(self) -> tuple[list[str], str]:
        """Return the words before the cursor, and the one at the cursor."""
        before, last = super().get_completion_args()
        words: list[str] = []
        is_open = False
        for word in (*before, last):
            is_break = word in _BREAKS and words and (word == ":" or words[-1].startswith("--"))
            if is_break or is_open:
                words[-1] += word
            else:
                words.append(word)
            is_open = bool(is_break)
        incomplete = words.pop()
        # bash replaces only what follows its last break.
        if incomplete != last:
            value = incomplete.partition("=")[2] if incomplete.startswith("--") else incomplete
            self._typed = value.rpartition(":")[0] + ":" if ":" in value else ""
        return words, incomplete

    def format_completion(self, item: CompletionItem[Any]) -> str:
        """Return one completion as the shell's function expects it."""
        return f"{item.type},{item.value.removeprefix(self._typed)}"


class _WithOption(ShellComplete):
    """Repeats ``--option=`` before each value, because the shell replaces the whole word."""

    def get_completions(self, args: list[str], incomplete: str) -> list[CompletionItem[str]]:
        """Return the completions of the word at the cursor."""
        found = super().get_completions(args, incomplete)
        option, equals, _ = incomplete.partition("=")
        if not (equals and option.startswith("--")):
            return found
        return [
            CompletionItem(f"{option}={one.value}", one.type, one.help)
            if one.type == "plain"
            else one
            for one in found
        ]


class _Zsh(_WithOption, ZshComplete):
    pass


class _Fish(_WithOption, FishComplete):
    pass


def offer_completion() -> None:
    """Make click use these shells."""
    for shell in (_Bash, _Zsh, _Fish):
        add_completion_class(shell)
