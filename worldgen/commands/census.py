"""``worldgen census``: judge the maps and generators of other projects."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import (
    PATH,
    cell_size_option,
    draw_seed,
    emit_json,
    force_option,
    json_option,
    note,
    say,
    seed_option,
    unknown_option,
)
from worldgen.errors import InvalidParameter, OutputError
from worldgen.files.whole import write_bytes
from worldgen.support.plain_text import counted
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.interop.census import Census, CensusCase, CensusOptions
    from worldgen.interop.census.folders import FolderMaps
    from worldgen.interop.census.generators import GeneratedMaps
    from worldgen.world import World

EXAMPLES = (
    "\b\n  worldgen census maps/ --radius 0.2 --radius 0.3 --seed 1\n"
    "  worldgen census maps/ scenarios/ --pairs 5 --seed 1 --out grid-only/\n"
    "  worldgen census ./examples/census/mazelib_maps.py:maps --count 500 --seed 1 --option side=20"
)
# Limit on the characters of a map's name in a file name: at most 200 of its 255 bytes.
_LONGEST = 50


@click.command(epilog=EXAMPLES)
@click.argument("sources", metavar="SOURCE...", nargs=-1, required=True)
@click.option(
    "--radius",
    "radii",
    multiple=True,
    metavar="R",
    help="Radius of the robot: 0.3 in m, 0.7c in cells.  [default: 0.45c 0.7c 1c]",
)
@click.option(
    "--pairs",
    type=click.IntRange(1, 100_000),
    default=1,
    show_default=True,
    help="Questions per map, if the map has many problems or none.",
)
@click.option(
    "--clear-ends", is_flag=True, help="Draw starts and targets where the largest disc has room."
)
@click.option(
    "--count",
    type=click.IntRange(1),
    default=100,
    show_default=True,
    help="Maps to take from a generator.",
)
@click.option(
    "--option",
    "options",
    multiple=True,
    metavar="NAME=VALUE",
    help="Keyword argument of the generator.",
)
@cell_size_option
@unknown_option
@click.option(
    "--csv",
    "table",
    type=PATH,
    metavar="OUT",
    help="Write one line for each map, start, target and radius.",
)
@click.option(
    "--out",
    type=PATH,
    metavar="FOLDER",
    help="Folder for the worlds that only a point can cross, with their cuts.",
)
@seed_option
@json_option
@force_option
def census(
    sources: tuple[str, ...],
    radii: tuple[str, ...],
    pairs: int,
    clear_ends: bool,
    count: int,
    options: tuple[str, ...],
    cell_size: float | None,
    unknown: str | None,
    table: Path | None,
    out: Path | None,
    seed: int | None,
    as_json: bool,
    force: bool,
) -> None:
    """Count the maps whose target a robot of a given radius can reach.

    SOURCE is a map file, a folder of them, or a generator: ./file.py:function or
    package.module:function. Each answer is proved and the proof checked. docs/howto/census.md
    describes generators and the three outputs: table, CSV and JSON.
    """
    from worldgen.files.whole import check_output
    from worldgen.interop import census as library
    from worldgen.interop.census.case import DEFAULT_RADII

    # Refuse bad output before the work.
    asked = tuple(dict.fromkeys(library.Radius.parse(text) for text in radii)) or DEFAULT_RADII
    if table is not None:
        check_output(table, force)
    if out is not None:
        _check_folder(out, force=force)
    what = library.CensusOptions(asked, pairs, draw_seed(seed), clear_ends)
    # Take the census, saving worlds as they come.
    with working("taking a census") as work:
        maps = _maps(sources, what, count, options, cell_size, unknown)
        total = sum(map(len, maps))
        done = itertools.count(1)
        work.count(0, total, "maps")
        keep = None if out is None else _keeper(out, force=force)
        found = library.take_census(
            itertools.chain(*maps),
            what,
            each=keep,
            progress=lambda: work.count(next(done), total, "maps"),
        )
    # Print the table, then write the files.
    _check_any(found)
    if as_json:
        emit_json(library.as_json(found))
    else:
        say(library.as_text(found), nl=False)
    if table is not None:
        write_bytes(table, library.as_csv(found).encode(), force=force)
        note(f"wrote {table}")
    if out is not None:
        note(f"{out}: {sum(question.grid_only for question in found.questions)} worlds kept")
    _leave(found)


def _maps(
    sources: Sequence[str],
    what: CensusOptions,
    count: int,
    options: Sequence[str],
    cell_size: float | None,
    unknown: str | None,
) -> list[FolderMaps | GeneratedMaps]:
    """Return the maps of all sources: files and folders together.

    The order lets scenarios find their maps; generators come last.
    """
    from worldgen.domain import CELL_SIZES
    from worldgen.family import check_between
    from worldgen.interop.census import folder_maps, generated_maps
    from worldgen.world import DEFAULT_CELL_SIZE

    # Tell generators from files and folders.
    if cell_size is not None:
        check_between("cell_size", cell_size, *CELL_SIZES, "m")
    generators = [source for source in sources if ":" in source and not Path(source).exists()]
    paths = [Path(source) for source in sources if source not in generators]
    if options and not generators:
        raise InvalidParameter(
            "only-for-generators",
            "an option is for a generator, but none is named",
            "use one, such as ./file.py:function",
        )
    # Read the files and folders.
    found: list[FolderMaps | GeneratedMaps] = []
    if paths:
        asked = {
            name: value
            for name, value in (("cell_size", cell_size), ("unknown", unknown))
            if value is not None
        }
        files = folder_maps(paths, pairs=what.pairs, seed=what.seed, options=asked)
        if files.passed_over:
            note(f"{files.passed_over} other files are not maps")
        found.append(files)
    # Add the generators.
    given = dict(_option(text) for text in options)
    side = DEFAULT_CELL_SIZE if cell_size is None else cell_size
    for name in generators:
        found.append(
            generated_maps(name, count=count, seed=what.seed, options=given, cell_size=side)
        )
    return found


def _option(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise InvalidParameter(
            "wrong-form",
            "option={text!r} is not NAME=VALUE",
            "write it as in side=20",
            text=text[:40],
        )
    return name.replace("-", "_"), value


def _check_folder(folder: Path, *, force: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(
            "is-a-file",
            "{folder} is a file",
            "choose a folder for the worlds to keep",
            folder=folder,
        )
    if folder.is_dir() and any(folder.iterdir()) and not force:
        raise OutputError(
            "folder-not-empty",
            "{folder} is not empty",
            "use --force to write into it, or choose another folder",
            at_terminal=True,
            folder=folder,
        )


def _keeper(folder: Path, *, force: bool) -> Callable[[CensusCase, World], None]:
    """Return the function that writes the worlds that only a point can pass.

    Write each one immediately, so that it exists no matter how the census ends.
    """
    from worldgen.files.grid import write_world
    from worldgen.files.whole import refused_writes
    from worldgen.interop.census.take import once

    taken = Counter[str]()

    def keep(question: CensusCase, world: World) -> None:
        # Only maps whose grid path promises too much are of interest.
        if not question.grid_only:
            return
        name = once(_file_name(question), taken)
        with refused_writes(folder):
            folder.mkdir(parents=True, exist_ok=True)
        write_world(world, folder / f"{name}.grid", force=force)

    return keep


def _file_name(question: CensusCase) -> str:
    """Return a file's name without suffix; it states whether the disc had room at both ends."""
    plain = "".join(
        letter if letter.isalnum() or letter in "-_." else "-" for letter in question.map
    )
    kind = "parted" if question.room else "no-room"
    return f"{kind}-{plain[:_LONGEST]}-{question.pair}-r{question.radius:g}"


def _check_any(found: Census) -> None:
    """Refuse to print an empty table."""
    if found.questions or found.interrupted:
        return
    first = found.fault or (
        f"{found.refused[0].name}: {found.refused[0].reason}" if found.refused else "it gave none"
    )
    raise InvalidParameter(
        "no-map-found", "no map could be judged; the first reason: {reason}", reason=first
    )


def _leave(found: Census) -> None:
    if found.interrupted:
        note(f"interrupted after {counted(found.maps, 'map')}; the table covers these", always=True)
        raise click.exceptions.Exit(130)
    if found.fault:
        covered = f"the table covers the {counted(found.maps, 'map')} before it"
        note(f"worldgen: {found.fault}; {covered}", always=True)
        raise click.exceptions.Exit(2)
    if not all(question.proved for question in found.questions):
        raise click.exceptions.Exit(1)
