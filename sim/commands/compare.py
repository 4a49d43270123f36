"""``worldgen compare``: compare controllers over worlds and seeds in one table."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import (
    PATH,
    SEED,
    check_out,
    emit_json,
    force_option,
    json_option,
    motion_option,
    note,
    say,
    skip_bad_file,
    steps_option,
    time_step_option,
    typed,
    write_out,
)
from worldgen.support.progress import working

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from sim.compare.comparison import Comparison, NamedWorld
    from sim.scenario import Scenario
    from worldgen.world import World

EXAMPLES = (
    "\b\n  worldgen compare worlds/ --controller turn-left,turn-right,./mine.py:Robot\n"
    "  worldgen compare worlds/ --controller thesis-1,thesis-1+repaired --motion stepped --picture "
    "sheet.png\n"
    "  worldgen compare worlds/ --controller turn-random --seeds 1000 --csv new.csv"
)


@click.command(epilog=EXAMPLES)
@click.argument("paths", type=PATH, nargs=-1, required=True, metavar="PATH...")
@click.option(
    "--controller",
    "controllers",
    multiple=True,
    required=True,
    metavar="A,B,C",
    help="Controllers to compare; see above. May be repeated.",
)
@motion_option
@time_step_option
@click.option(
    "--seeds",
    type=click.IntRange(1, 1_000_000),
    default=100,
    show_default=True,
    help="Number of seeds for each random controller.",
)
@click.option("--seed", type=SEED, default=0, show_default=True, help="First seed.")
@steps_option
@click.option(
    "--csv", "table", type=PATH, metavar="OUT", help="Write one line for each world and controller."
)
@click.option(
    "--picture", type=PATH, metavar="OUT.png", help="Draw all worlds with every controller's path."
)
@json_option
@force_option
def compare(
    paths: tuple[Path, ...],
    controllers: tuple[str, ...],
    motion: str,
    time_step: float | None,
    seeds: int,
    seed: int,
    steps: int | None,
    table: Path | None,
    picture: Path | None,
    as_json: bool,
    force: bool,
) -> None:
    """Run several controllers in many worlds and print one table.

    PATH is a .grid file or a folder of them. After a controller's name, +option=value varies its
    run, so bug2,bug2+time_step=0.03 compares two time steps. A random controller runs with many
    seeds. docs/howto/compare.md describes the table.
    """
    from sim.compare.comparison import compare as compare_worlds
    from sim.compare.picture import MAX_CONTROLLERS, draw_comparison
    from sim.compare.report import as_csv, as_text
    from sim.compare.report import as_json as plain
    from sim.scenario.unused import ineffective

    # Refuse bad output before the work.
    check_out("--picture", picture, ".png", force=force)
    check_out("--csv", table, force=force)
    from worldgen.support.paths import real_path

    if table is not None and picture is not None and real_path(table) == real_path(picture):
        raise click.UsageError(f"--csv and --picture both name {table}; use two names")
    # Read the controllers and the worlds.
    scenarios = _scenarios(controllers, motion, time_step, seed)
    if picture is not None and len(scenarios) > MAX_CONTROLLERS:
        raise click.UsageError(
            f"--picture can distinguish {MAX_CONTROLLERS} controllers, not {len(scenarios)}; name "
            f"fewer"
        )
    worlds = _worlds(paths)
    for sentence in ineffective(scenarios.values(), seeds=typed("seed", "seeds")):
        note(f"note: {sentence}")
    # Run everything.
    with working("comparing") as work:
        comparison = compare_worlds(worlds, scenarios, seeds=seeds, steps=steps, progress=work.say)
    _note_unreachable(comparison)
    # Print the table, then write the files.
    if as_json:
        emit_json(plain(comparison))
    else:
        say(as_text(comparison), nl=False)
    if table is not None:
        write_out(table, as_csv(comparison).encode(), force=force)
    if picture is not None:
        with working(f"drawing {picture}"):
            drawn = draw_comparison(comparison)
        write_out(picture, drawn, force=force)


def _scenarios(
    controllers: Sequence[str], motion: str, time_step: float | None, seed: int
) -> dict[str, Scenario]:
    """Return columns by label."""
    from sim.controllers.base import CompiledController
    from sim.controllers.catalogue import CONTROLLERS, names_in
    from sim.controllers.programs.process import ProcessController
    from sim.episode.try_out import try_out
    from sim.options.run import RunOptions
    from sim.scenario import Scenario
    from worldgen.errors import InvalidParameter

    duration = RunOptions.time_step if time_step is None else time_step
    found: dict[str, Scenario] = {}
    for text in (name for value in controllers for name in names_in(value)):
        number, is_assigned, name = text.partition("=")
        if is_assigned and number.strip().isdecimal():
            raise InvalidParameter(
                "assigned-robot",
                "{text!r} assigns a controller to one robot, but compare drives all robots of a "
                "world with the same controller",
                "use {name}; worldgen run can assign controllers",
                at_terminal=True,
                text=text,
                name=name,
            )
        scenario = Scenario.parse(text, motion=motion, time_step=duration, seed=seed)
        # Report a class that cannot work before the long work begins.
        if not isinstance(
            CONTROLLERS.get(scenario.controller), CompiledController | ProcessController
        ):
            try_out(scenario)
        # The label names the column, so it must be unique.
        label = scenario.label(motion, duration)
        if label in found:
            raise InvalidParameter(
                "twice",
                "controller {label!r} is named twice",
                "name each once, or vary it with +option",
                label=label,
            )
        found[label] = scenario
    return found


def _worlds(paths: Sequence[Path]) -> list[NamedWorld]:
    """Return the worlds of all files, with unique names."""
    from sim.compare.comparison import NamedWorld
    from worldgen.errors import InvalidParameter
    from worldgen.support.paths import real_path

    found = [named for path in paths for named in _read(path)]
    stems = Counter(_stem(file) for file, _ in found)
    resolved = Counter(real_path(file) for file, _ in found)
    worlds = []
    for file, world in found:
        if resolved[real_path(file)] > 1:
            raise InvalidParameter(
                "twice", "{file} is given twice", "give each world once", file=file
            )
        stem = _stem(file)
        name = stem if stems[stem] == 1 else str(file.with_name(stem))
        worlds.append(NamedWorld(name, world))
    return worlds


def _read(path: Path) -> Iterator[tuple[Path, World]]:
    """Return the worlds of an archive or a folder, or, if it has none, of its subfolders.

    A single file is also accepted.
    """
    from worldgen.files.worlds import is_world_file, read_worlds

    if path.is_dir():
        own = sorted(file for file in path.iterdir() if is_world_file(file.name) and file.is_file())
        if own:
            return read_worlds(own, skip_bad_file)
    return read_worlds([path], skip_bad_file)


def _stem(file: Path) -> str:
    name = file.name.removesuffix(".gz")
    return name.removesuffix(".grid") or name


def _note_unreachable(comparison: Comparison) -> None:
    """Report worlds in which no controller arrived, and that no controller is proved to solve."""
    from worldgen.reach.verifying import verify_world

    found: dict[str, list[str]] = {"blocked": [], "undecided": []}
    # Deciding a world can take as long as its runs, so skip worlds in which one arrives.
    with working("deciding whether the runs could have arrived"):
        for row, named in enumerate(comparison.worlds):
            is_counted = row not in comparison.blocked
            if not is_counted or any(cell.reached for cell in comparison.cells[row]):
                continue
            result = verify_world(named.world)["result"]
            if result in found:
                found[result].append(named.name)
    for result, words in (
        ("blocked", "no controller can arrive"),
        ("undecided", "it is undecided whether a controller can arrive"),
    ):
        names = found[result]
        if names:
            more = f" and {len(names) - 5} more" if len(names) > 5 else ""
            note(
                f"note: the failures include worlds in which {words}: {', '.join(names[:5])}{more}"
            )
