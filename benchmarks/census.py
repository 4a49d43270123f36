"""Make the table of docs/notes/census.md: a census of other projects' generators and collections.

``python -m benchmarks.census --barn FOLDER --movingai FOLDER --arena FOLDER`` prints a Markdown
table; ``--json`` prints one object. Sources that are not installed or not given are skipped and
reported on stderr. Not all generators fit into one environment; ``--add`` adds the rows of an
earlier run elsewhere, from its ``--json``.

- Generators are those of benchmarks/generators, each in the version that its file names; another
  version is reported.
- ``--barn`` is jackal_helper/worlds/BARN of github.com/Daffan/the-barn-challenge,
- ``--movingai`` a folder with ``maps`` and ``scenarios`` of github.com/nathansttt/hog2,
- ``--arena`` is ``worlds`` of github.com/Arena-Rosnav/arena-simulation-setup.
"""

from __future__ import annotations

import importlib.metadata
import json
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from benchmarks.census_questions import ROWS as COUNTED
from benchmarks.census_questions import CensusCase, CensusOptions, Radius, counts, take_census
from benchmarks.foreign_maps import folder_maps, generated_maps
from benchmarks.grid_planners import InflationPlanners
from worldgen.reach import REACHABLE
from worldgen.support.intervals import interval_95
from worldgen.world import World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--count", "1", "--only", "none of them")

CELLS = tuple(Radius(cells, True) for cells in (0.45, 0.7, 1.0))
SEED = 1


@dataclass(frozen=True)
class Row:
    """A source, and the questions about it.

    Args:
        name: Name in the table.
        adapter: File of benchmarks/generators, for a generator.
        package: Package that pip installs for it, and the version used for the table.
        options: Keywords of the generator.
        folders: Folders of a collection; ``{movingai}`` stands for a given folder.
        radii: Radii of the robot.
        pairs: Starts and targets per map.
        clear_ends: True to draw them where the largest disc is clear.
    """

    name: str
    adapter: str = ""
    package: tuple[str, str] | None = None
    options: tuple[tuple[str, Any], ...] = ()
    folders: tuple[str, ...] = ()
    radii: tuple[Radius, ...] = CELLS
    pairs: int = 1
    clear_ends: bool = False


def _generators() -> Iterator[Row]:
    # Mazes and caves.
    mazelib = ("mazelib", "0.9.16")
    dataset = ("maze-dataset", "1.4.2")
    pogema = ("pogema", "1.4.0")
    for name in ("Prims", "CellularAutomaton"):
        yield Row(f"mazelib {name}", "mazelib_maps", mazelib, (("generator", name), ("side", 20)))
    yield Row(
        "maze-dataset gen_dfs",
        "maze_dataset_maps",
        dataset,
        (("generator", "gen_dfs"), ("side", 20)),
    )
    for p in (0.4, 0.6):
        options = (("generator", "gen_percolation"), ("side", 20), ("p", p))
        yield Row(f"maze-dataset gen_percolation, p {p}", "maze_dataset_maps", dataset, options)
    yield Row(
        "labmaze RandomMaze", "labmaze_maps", ("labmaze", "1.0.6"), (("side", 31), ("rooms", 6))
    )
    # Noise, grid worlds and simulators' maps.
    yield Row("tcod noise", "tcod_maps", ("tcod", "21.2.2"))
    yield Row("tcod noise, clear ends", "tcod_maps", ("tcod", "21.2.2"), clear_ends=True)
    for name in ("SimpleCrossingS11N5", "FourRooms"):
        options = (("environment", f"MiniGrid-{name}-v0"),)
        yield Row(f"MiniGrid {name}", "minigrid_maps", ("minigrid", "3.2.0"), options)
    options = (("environment", "Navix-SimpleCrossingS11N5-v0"),)
    yield Row("NAVIX SimpleCrossingS11N5", "navix_maps", ("navix", "0.7.4"), options)
    for density in (0.1, 0.3):
        yield Row(f"POGEMA, density {density}", "pogema_maps", pogema, (("density", density),))
    yield Row("IR-SIM Perlin", "irsim_maps", ("ir-sim", "2.12.0"))
    yield Row("IR-SIM Perlin, clear ends", "irsim_maps", ("ir-sim", "2.12.0"), clear_ends=True)


def _collections() -> Iterator[Row]:
    # Its generator keeps 0.375 m free, so 0.376 is the first radius that matters.
    metres = tuple(map(Radius, (0.35, 0.375, 0.376, 0.45)))
    yield Row("BARN, posts as squares", folders=("{barn}",), radii=metres)
    for name in ("mazes", "random", "rooms", "dao"):
        folders = (f"{{movingai}}/maps/{name}", f"{{movingai}}/scenarios/{name}")
        yield Row(f"MovingAI {name}", folders=folders)
    yield Row(
        "Arena-Rosnav maps",
        folders=("{arena}",),
        radii=tuple(map(Radius, (0.105, 0.22, 0.35))),
        pairs=5,
        clear_ends=True,
    )


ROWS = (*_generators(), *_collections())


def measure(row: Row, count: int, given: dict[str, str]) -> dict[str, Any]:
    """Return one row: figures, or ``skipped`` with the reason."""
    missing = _missing(row, given)
    if missing:
        return {"name": row.name, "skipped": missing}
    options = CensusOptions(row.radii, row.pairs, SEED, row.clear_ends)
    began = time.perf_counter()
    folders = [Path(part.format(**given)) for part in row.folders]
    maps: Any = folder_maps(folders, pairs=row.pairs, seed=SEED)
    if not folders:
        maps = generated_maps(row.adapter, count=count, seed=SEED, **dict(row.options))
    inflated = Inflated()
    try:
        census = take_census(maps, options, inflated.compare)
    # Installed, but it does not load.
    except ImportError as error:
        return {"name": row.name, "skipped": str(error)}
    sides = sorted({question.side for question in census.questions})
    return {
        "name": row.name,
        "maps": census.maps,
        "refused": len(census.refused),
        "sides": sides[:1] + sides[-1:],
        "seconds": time.perf_counter() - began,
        "radii": [_figures(radius, census.questions, inflated.wrong) for radius in options.radii],
    }


class Inflated:
    """Counts of maps on which planners on inflated walls are wrong about the disc."""

    def __init__(self) -> None:
        self.wrong = Counter[tuple[Radius, str]]()
        self._map = ""
        self._planners: InflationPlanners | None = None

    def compare(self, question: CensusCase, world: World) -> None:
        """Compare both planners with a proved answer."""
        # The questions about one map come one after another, so one map is kept.
        if self._planners is None or self._map != question.map:
            self._planners = InflationPlanners(world.walls)
            self._map = question.map
        if not question.proved:
            return
        reachable = question.result == REACHABLE
        for name, path in self._planners.answers(world)._asdict().items():
            if path != reachable:
                self.wrong[question.asked, f"{name}_wrong_{'yes' if path else 'no'}"] += 1


WRONG = ("costmap_wrong_yes", "costmap_wrong_no", "square_wrong_no")


def _figures(
    radius: Radius, questions: Sequence[CensusCase], wrong: Counter[tuple[Radius, str]]
) -> dict[str, Any]:
    asked = [question for question in questions if question.asked == radius]
    total = counts(asked)
    return {
        "radius": str(radius),
        "questions": len(asked),
        **{name: total[name] for name in COUNTED},
        **{name: wrong[radius, name] for name in WRONG},
        "prover_seconds": sum(question.seconds for question in asked),
    }


def _missing(row: Row, given: dict[str, str]) -> str:
    """Return why a row cannot be made, if it cannot."""
    for word in row.folders:
        name = word.removeprefix("{").partition("}")[0]
        if "{" in word and name not in given:
            return f"--{name} is not given"
    if row.package is None:
        return ""
    name, version = row.package
    try:
        found = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return f"{name} is not installed: pip install {name}=={version}"
    return (
        ""
        if found == version
        else f"{name} is {found}, the table is of {version}: pip install {name}=={version}"
    )


COLUMNS = (
    "reachable, 95 % interval",
    "no room",
    "4-grid only",
    "8-grid only",
    "costmap: wrong yes",
    "wrong no",
    "square: wrong no",
    "undecided",
)


def table(results: Sequence[dict[str, Any]]) -> str:
    """Return Markdown: a line per source and radius."""
    heads = ["source", "maps", "side", "radius", "questions", *COLUMNS]
    lines = [f"| {' | '.join(heads)} |", f"| --- | {' | '.join(['---:'] * (len(heads) - 1))} |"]
    for result in results:
        sides = " to ".join(str(side) for side in dict.fromkeys(result["sides"]))
        for index, one in enumerate(result["radii"]):
            first = [result["name"], str(result["maps"]), sides] if index == 0 else ["", "", ""]
            lines.append(
                f"| {' | '.join([*first, one['radius'], str(one['questions']), *_cells(one)])} |"
            )
    return "\n".join(lines)


def _cells(one: dict[str, Any]) -> list[str]:
    low, high = (100 * end for end in interval_95(one["reachable"], one["questions"]))
    share = 100 * one["reachable"] / one["questions"]
    return [
        f"{one['reachable']}, {share:.1f} % ({low:.1f} to {high:.1f})",
        str(one["no_room"]),
        f"{one['four_only']} ({one['four_parted']})",
        f"{one['eight_only']} ({one['eight_parted']})",
        *(str(one[name]) for name in (*WRONG, "undecided")),
    ]


@click.command()
@click.option("--count", default=200, show_default=True, help="Maps of each generator.")
@click.option("--only", multiple=True, help="Rows whose name begins so.")
@click.option("--barn", type=click.Path(exists=True))
@click.option("--movingai", type=click.Path(exists=True))
@click.option("--arena", type=click.Path(exists=True))
@click.option(
    "--add",
    type=click.Path(exists=True, path_type=Path),
    multiple=True,
    help="JSON of other environments.",
)
@click.option("--json", "as_json", is_flag=True)
def main(
    count: int, only: tuple[str, ...], add: tuple[Path, ...], as_json: bool, **folders: str | None
) -> None:
    """Judge every available source."""
    given = {name: folder for name, folder in folders.items() if folder is not None}
    # Rows measured on another machine are added as they are.
    added = {row["name"]: row for file in add for row in json.loads(file.read_text())["rows"]}
    results = []
    skipped = []
    for row in ROWS:
        if only and not row.name.startswith(only):
            continue
        try:
            result = added.get(row.name) or measure(row, count, given)
        except KeyboardInterrupt:
            click.echo(f"interrupted in {row.name}; what is whole is kept", err=True)
            break
        (skipped if "skipped" in result else results).append(result)
        click.echo(
            f"{row.name}: {result.get('skipped') or str(round(result['seconds'])) + ' s'}", err=True
        )
    click.echo(json.dumps({"rows": results, "skipped": skipped}) if as_json else table(results))
    # An absent file is not an error, unless nothing was measured.
    for result in skipped:
        click.echo(f"SKIPPED: {result['name']}: {result['skipped']}", err=True)
    sys.exit(1 if skipped and not results else 0)


if __name__ == "__main__":
    main()
