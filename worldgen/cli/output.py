"""Helpers shared by all commands: safe writing, JSON, and options that mean the same everywhere."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click
from click.core import ParameterSource

from worldgen.cli.usage import Instead
from worldgen.domain import MASK64
from worldgen.errors import FormatError
from worldgen.files.whole import check_output, write_bytes
from worldgen.plugins.trust import note_said
from worldgen.support.plain_text import aligned, alternatives, joined, printed
from worldgen.support.progress import is_quiet, no_progress, spoke
from worldgen.support.results import results

CONTROLLER_HELP = (
    "Name, package.module:name, ./file.py:name, or 'cmd:./program --flag'; +option=value varies "
    "the run (docs/reference/controllers.md)."
)

PATH = click.Path(path_type=Path)
SEED = click.IntRange(0, MASK64)

F = TypeVar("F", bound=Callable[..., Any])

force_option: Callable[[F], F] = click.option(
    "--force", is_flag=True, help="Overwrite existing files."
)
json_option: Callable[[F], F] = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object."
)
steps_option: Callable[[F], F] = click.option(
    "--steps", type=int, help="Budget in steps.  [default: 50 times the witness's time]"
)
time_step_option: Callable[[F], F] = click.option(
    "--time-step", type=float, help="Duration of a step, s.  [default: 0.015]"
)
motion_option: Callable[[F], F] = click.option(
    "--motion", default="swept", show_default=True, help="Motion model: swept, endpoint or stepped."
)
workers_option: Callable[[F], F] = click.option(
    "--workers", type=click.IntRange(1, 256), help="Number of processes.  [default: one per core]"
)
seed_option: Callable[[F], F] = click.option(
    "--seed",
    type=SEED,
    help="Seed of all random numbers, 64 bits; if omitted, a random seed is used and printed.",
)


class _NamedAlso(click.Option):
    """An option with additional names that scripts may use and help does not show."""

    def __init__(self, *args: Any, also: tuple[str, ...] = (), **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._shown = list(self.opts)
        self.opts = [*self.opts, *also]

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        with self._with_shown_names():
            return super().get_help_record(ctx)

    def get_error_hint(self, ctx: click.Context | None) -> str:
        with self._with_shown_names():
            return super().get_error_hint(ctx)

    @contextmanager
    def _with_shown_names(self) -> Iterator[None]:
        every = self.opts
        self.opts = self._shown
        try:
            yield
        finally:
            self.opts = every


def named_also(*names: str, also: str, **settings: Any) -> Callable[[F], F]:
    """Make an option that also accepts an earlier name, so that scripts keep working.

    Args:
        *names: Names, as for ``click.option``.
        also: The earlier name, hidden in help.
        **settings: Settings, as for ``click.option``.
    """
    return click.option(*names, cls=_NamedAlso, also=(also,), **settings)


def note(message: str, *, always: bool = False) -> None:
    """Print a message for the person at the terminal to stderr, since stdout is for data.

    Args:
        message: One line; :func:`~worldgen.support.plain_text.joined` makes a text of several.
        always: True to print it even under ``--quiet``, like errors and the seed.
    """
    if always or not is_quiet():
        spoke()
        note_said(message)
        click.echo(printed(message), err=True)  # noqa: TID251 - this is how to print


def is_at_terminal() -> bool:
    """Return True if a person can read a question and type an answer."""
    # A program that calls the command line may have put something simpler in their place.
    return all(getattr(stream, "isatty", bool)() for stream in (sys.stdin, sys.stderr))


def ask_user(question: str) -> bool:
    """Ask a question at the terminal; the answer is no unless the user types y."""
    with no_progress():
        return click.confirm(printed(question), err=True)


def say(text: str, *, nl: bool = True, color: bool | None = None) -> None:
    """Print a result to stdout, without control characters that came from outside.

    This is the only way for it to get there while a command runs.

    Args:
        text: One line, or a :class:`~worldgen.support.plain_text.Styled` text, which keeps its
            lines and colours.
        nl: False if the text ends its last line itself.
        color: Whether to keep colours; by default, if stdout is a terminal.
    """
    spoke()
    # Results in a pipe or a file are not seen at once.
    if results().isatty():
        note_said(text)
    _print(printed(text), nl=nl, color=color)


def _print(text: str, *, nl: bool = True, color: bool | None = None) -> None:
    """Print safe text to stdout; end the command with code 0 once its reader has enough."""
    try:
        click.echo(text, file=results(), nl=nl, color=color)  # noqa: TID251 - this is how to print
    except BrokenPipeError:
        # Writing to it again, as when Python ends, would also fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), results().fileno())
        raise click.exceptions.Exit(0) from None


def emit_data(text: str) -> None:
    """Print a file that the user asked for to stdout, byte for byte.

    On a terminal, which would obey a control character in it, it is printed as :func:`say` does.
    """
    if results().isatty():
        say(joined(text), nl=False)
        return
    spoke()
    _print(text, nl=False)


_SKIPPED = "worldgen.skipped"


def skip_bad_file(error: FormatError) -> None:
    """Name a file of a folder that cannot be read; the command continues, and ends with code 2.

    Commands pass this function to :func:`worldgen.files.worlds.walk`.
    """
    note(joined(f"worldgen: {error}"), always=True)
    meta = click.get_current_context().meta
    meta[_SKIPPED] = meta.get(_SKIPPED, 0) + 1


def skipped_files(context: click.Context) -> int:
    """Return the number of files that the command could not read."""
    count: int = context.meta.get(_SKIPPED, 0)
    return count


def check_out(option: str, out: Path | None, *suffixes: str, force: bool) -> None:
    """Refuse a file to write before the work for it begins.

    Args:
        option: The option that names it, such as ``--picture``.
        out: The file; ``None`` if it was not given.
        *suffixes: What its name may end with; anything if omitted.
        force: True if an existing file may be overwritten.

    Raises:
        click.UsageError: If its name ends otherwise.
        OutputError: If it exists, or cannot be written.
    """
    if out is None:
        return
    if suffixes and out.suffix not in suffixes:
        endings = alternatives(suffixes)
        message = f"{option} {out}: use a name that ends in {endings}"
        raise Instead(message, str(out), str(out.with_suffix(suffixes[0])))
    check_output(out, force)


def write_out(out: Path, data: bytes, *, force: bool) -> None:
    """Write a file that the user asked for, and say so."""
    write_bytes(out, data, force=force)
    note(f"wrote {out}")


def emit_json(result: Mapping[str, Any]) -> None:
    """Print one JSON object to stdout; infinities and NaN become null."""
    spoke()
    # JSON escapes every other character that a terminal or a CI service would obey.
    text = (
        json.dumps(_finite(result), allow_nan=False)
        .replace("##", "#\\u0023")
        .replace("\x7f", "\\u007f")
    )
    _print(text)


def emit_list(
    name: str, rows: Sequence[Mapping[str, Any]], columns: Mapping[str, str], *, as_json: bool
) -> None:
    """Print what a package offers under one name, as a table or as one JSON object.

    Args:
        name: Key of the JSON object, such as ``formats``.
        rows: The facts about each one.
        columns: The facts that the table shows, and its headings.
        as_json: Print the object, which has all facts.
    """
    if as_json:
        emit_json({name: rows})
        return
    table = [[str(row[fact]) for fact in columns] for row in rows]
    say(aligned([list(columns.values()), *table]))


def _finite(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def typed(*names: str) -> list[str]:
    """Return which of the command's parameters were typed, rather than configured or omitted."""
    source = click.get_current_context().get_parameter_source
    return [name for name in names if source(name) is ParameterSource.COMMANDLINE]


NO_DRAWN_SEEDS = "WORLDGEN_NO_DRAWN_SEEDS"
"""Environment variable; if it is set, a command without a seed is refused, as in our own tests."""


def draw_seed(seed: int | None) -> int:
    """Return the given seed, or a fresh one, which is printed so that the run can be repeated.

    Raises:
        UsageError: If seeds must not be drawn.
    """
    if seed is not None:
        return seed
    if os.environ.get(NO_DRAWN_SEEDS):
        raise click.UsageError(f"{NO_DRAWN_SEEDS} is set, so add --seed N")
    drawn = _fresh_seed()
    note(f"seed {drawn}", always=True)
    return drawn


def _fresh_seed() -> int:
    return int.from_bytes(os.urandom(8), "big")
