"""What every command shares: safe writing, JSON, options that mean the same everywhere."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import click

from worldgen.files import write_bytes
from worldgen.plain_text import shown, shown_lines
from worldgen.progress import is_quiet, spoke

__all__ = [
    "CONTROLLER_HELP",
    "draw_seed",
    "emit_json",
    "force_option",
    "json_option",
    "note",
    "say",
    "seed_option",
    "shown",
    "write_bytes",
]

CONTROLLER_HELP = (
    "Name, package.module:name, ./file.py:name, or 'cmd:./program --flag'; +option=value varies the run "
    "(docs/controllers.md)."
)

F = TypeVar("F", bound=Callable[..., Any])

force_option: Callable[[F], F] = click.option("--force", is_flag=True, help="Overwrite what is there.")
json_option: Callable[[F], F] = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
seed_option: Callable[[F], F] = click.option(
    "--seed",
    type=click.IntRange(0, 2**64 - 1),
    help="Seed of all chance, 64 bits; drawn and printed if left out.",
)


def note(message: str, *, always: bool = False) -> None:
    """Print a message for the person at the terminal on stderr, so that stdout stays data.

    Args:
        message: One or more lines.
        always: Whether ``--quiet`` prints it too, as errors and the seed are.
    """
    if always or not is_quiet():
        spoke()
        click.echo(shown_lines(message), err=True)


def say(text: str, *, nl: bool = True, color: bool | None = None) -> None:
    """Print a result on stdout while slow work is under way: what shows progress makes room for it."""
    spoke()
    click.echo(text, nl=nl, color=color)


def emit_json(result: Mapping[str, Any]) -> None:
    """Print one JSON object on stdout; infinities and nan become null."""
    spoke()
    click.echo(json.dumps(_finite(result), allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def draw_seed(seed: int | None) -> int:
    """The given seed, or a fresh one, which is printed so that the run can be repeated."""
    if seed is not None:
        return seed
    drawn = int.from_bytes(os.urandom(8), "big")
    note(f"seed {drawn}", always=True)
    return drawn
