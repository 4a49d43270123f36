"""``worldgen FAMILY``: a command made of a family's own parameters."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from worldgen.cli.output import draw_seed, emit_json, force_option, json_option, note, seed_option
from worldgen.errors import OutputError, WorldgenError

if TYPE_CHECKING:
    from worldgen.family import Family, Parameter
    from worldgen.world import Value, Witness, World

__all__ = ["family_command"]


@functools.cache
def family_command(name: str) -> click.Command:
    """The command that generates worlds of one family.

    Raises:
        InvalidParameter: If no family is called so.
    """
    from worldgen.family import FAMILIES

    made_by = FAMILIES.get(name)

    def command(
        seed: int | None, count: int, out: Path | None, metrics: bool, force: bool, as_json: bool, **params: Any
    ) -> None:
        if count == 1:
            _make_one(made_by, draw_seed(seed), params, out, metrics=metrics, force=force, as_json=as_json)
        elif out is None:
            raise click.UsageError(f"--count {count} writes {count} files; name a folder for them with --out")
        else:
            _make_many(made_by, draw_seed(seed), count, params, out, metrics=metrics, force=force, as_json=as_json)

    command.__doc__ = made_by.description
    for decorate in (json_option, force_option, _metrics_option, _out_option, _count_option, seed_option):
        command = decorate(command)
    for parameter in reversed(made_by.parameters):
        command = _option(parameter)(command)
    return click.command(name)(command)


_count_option = click.option(
    "--count", type=click.IntRange(1), default=1, show_default=True, help="Number of worlds, of rising seeds."
)
_out_option = click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="File to write, .grid or .grid.gz; for more than one world, a folder. Without it, the world goes to stdout.",
)
_metrics_option = click.option(
    "--metrics/--no-metrics", default=True, show_default=True, help="Measure each world, into its file's header."
)


def _option(parameter: Parameter) -> Any:
    words = parameter.name.replace("_", "-")
    flags = f"--{words}/--no-{words}" if isinstance(parameter.default, bool) else f"--{words}"
    kind = click.Choice(parameter.choices) if parameter.choices else type(parameter.default)
    return click.option(
        flags, parameter.name, type=kind, default=parameter.default, show_default=True, help=parameter.help
    )


def _make_one(
    made_by: Family, seed: int, params: dict[str, Value], out: Path | None, *, metrics: bool, force: bool, as_json: bool
) -> None:
    from worldgen.grid_file import dumps, write_world

    world = _made(made_by, seed, params, metrics=metrics)
    if out is not None:
        write_world(world, out, force=force)
    elif not as_json:
        click.echo(dumps(world).decode(), nl=False)
    result = _result(world, out)
    note(
        (f"{out}: " if out is not None else "") + f"{made_by.name} {world.width} x {world.height} cells, "
        f"witness {result['witness_length']:.4g} m in {result['witness_time']:.4g} s, seed {seed}"
    )
    if as_json:
        emit_json({**_identity(made_by, seed, params), **result})


def _make_many(
    made_by: Family,
    first: int,
    count: int,
    params: dict[str, Value],
    folder: Path,
    *,
    metrics: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Writes worlds of rising seeds; what is written stays, whatever ends the work."""
    from worldgen.grid_file import write_world

    seeds = [(first + k) % 2**64 for k in range(count)]
    files = [folder / f"{made_by.name}-{seed}.grid" for seed in seeds]
    _check_free(folder, files, force=force)
    results: list[dict[str, Any]] = []
    try:
        with _progress(count) as advance:
            for seed, file in zip(seeds, files, strict=True):
                world = _made(made_by, seed, params, metrics=metrics)
                _make_folder(folder)
                write_world(world, file, force=force)
                results.append({"seed": seed, **_result(world, file)})
                advance()
    except (KeyboardInterrupt, WorldgenError):
        note(f"{folder}: {len(results)} of {count} worlds are written")
        raise
    note(f"{folder}: {count} worlds of {made_by.name}, seeds {seeds[0]} to {seeds[-1]}")
    if as_json:
        emit_json({**_identity(made_by, first, params), "count": count, "files": results})


def _identity(made_by: Family, seed: int, params: dict[str, Value]) -> dict[str, Any]:
    return {"family": made_by.name, "version": made_by.version, "seed": seed, "params": made_by.complete(params)}


def _made(made_by: Family, seed: int, params: dict[str, Value], *, metrics: bool) -> World:
    from worldgen.generation import generate

    world = generate(made_by, seed, **params)
    if not metrics:
        return world
    from worldgen.difficulty import with_metrics

    return with_metrics(world)


def _result(world: World, file: Path | None) -> dict[str, Any]:
    from worldgen.grid_file import world_digest

    witness = cast("Witness", world.certificate)  # generate() gives no world without one
    return {
        "file": None if file is None else str(file),
        "digest": world_digest(world),
        "witness_length": witness.length,
        "witness_time": witness.duration,
    }


def _check_free(folder: Path, files: Sequence[Path], *, force: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder} is a file; name a folder for more than one world")
    if not force:
        for file in files:
            if file.exists():
                raise OutputError(f"{file} is there already; give --force to overwrite it, or another folder")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be made: {error.strerror or error}; choose another place") from error


@contextmanager
def _progress(count: int) -> Iterator[Callable[[], None]]:
    """Gives what to call after each world; a bar on stderr where that is a terminal."""
    if not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("worlds", total=count)
        yield lambda: progress.advance(task)
