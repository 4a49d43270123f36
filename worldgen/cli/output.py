"""What every command shares: safe writing, JSON, options that mean the same everywhere."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import click

from worldgen.errors import OutputError

__all__ = ["draw_seed", "emit_json", "force_option", "json_option", "note", "seed_option", "write_bytes"]

F = TypeVar("F", bound=Callable[..., Any])

force_option: Callable[[F], F] = click.option("--force", is_flag=True, help="Overwrite what is there.")
json_option: Callable[[F], F] = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
seed_option: Callable[[F], F] = click.option(
    "--seed", type=click.IntRange(0, 2**64 - 1), help="Seed of all chance, 64 bits; drawn and printed if left out."
)


def note(message: str) -> None:
    """A message for the person at the terminal: stderr, so that stdout stays data."""
    click.echo(message, err=True)


def emit_json(result: Mapping[str, Any]) -> None:
    """Prints one JSON object on stdout; infinities and nan become null."""
    click.echo(json.dumps(_finite(result), allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
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
    note(f"seed {drawn}")
    return drawn


def write_bytes(path: Path, data: bytes, *, force: bool) -> None:
    """Writes a file whole or not at all.

    Raises:
        OutputError: If the file is there and ``force`` is not set, its folder is missing, or the disk
            is full or not writable; nothing is left half written.
    """
    if path.is_dir():
        raise OutputError(f"{path} is a folder; name a file in it")
    if path.exists() and not force:
        raise OutputError(f"{path} is there already; give --force to overwrite it, or another name")
    if not path.parent.is_dir():
        raise OutputError(f"{path}: the folder {path.parent} does not exist; make it first")
    if path.exists() and not path.is_file():  # a device or pipe cannot be replaced
        path.write_bytes(data)
        return
    temporary = None
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(path)
        temporary = None
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
