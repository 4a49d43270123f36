"""Solve MovingAI problems, to check the published lengths of shortest octile paths."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np

from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop.format.foreign_map import without_file
from worldgen.interop.formats.movingai import (
    GROUND,
    TREES,
    WATER,
    Problems,
    read_problems,
    read_terrain,
    scenario_contents,
)
from worldgen.interop.geometry.octile import octile_lengths
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools, Bytes, Floats
from worldgen.support.plain_text import Styled, aligned, counted, stacked

# Files of "version 1.0" write two decimals: half of the last one, and rounding.
_TWO_DECIMALS = 0.0051
# Files of "version 1" write six digits or more, summed in floating point: a fraction of the length.
_SIX_DIGITS = 1e-5
# Size of the largest map to solve, cells; the graph takes 250 bytes per cell.
_MOST_CELLS = 8_000_000
# Files with faults that the text lists; CSV and JSON list all of them.
_MOST_LINES = 20


@dataclass(frozen=True)
class ScenarioReport:
    """The result of checking one scenario file on one map.

    Args:
        scenario: Path of the scenario file.
        map: Path of the map; empty if no map of that name was found.
        problems: Number of problems in the file, or drawn from it.
        agree: Problems whose shortest path has the published length.
        no_path: Problems among those without a path, published with length 0.
        differ: Problems whose shortest path has another length.
        unreachable: Problems without a path that are published with a length.
        misfit: Problems not solved, because they were made for a map of another size.
        scaled: Problems solved on a map scaled to their size.
        worst: Largest difference from a published length that agrees, cells.
        fault: A sentence about the first problem that does not agree, or about the file.
    """

    scenario: str
    map: str
    problems: int = 0
    agree: int = 0
    no_path: int = 0
    differ: int = 0
    unreachable: int = 0
    misfit: int = 0
    scaled: int = 0
    worst: float = 0.0
    fault: str = ""


@dataclass(frozen=True)
class ScenarioFiles:
    """Scenario files, each with the maps of its name.

    Args:
        pairs: A scenario file and its maps: none, one, or several of that name in different
            folders.
        refused: A report for each file that is not a scenario file.
    """

    pairs: tuple[tuple[Path, tuple[Path, ...]], ...]
    refused: tuple[ScenarioReport, ...]

    def __len__(self) -> int:
        return len(self.pairs)


def find_scenarios(paths: Sequence[Path]) -> ScenarioFiles:
    """Find the ``.scen`` files among files and folders, and the ``.map`` files that they name.

    Args:
        paths: Files, and folders, which are searched with their subfolders.

    Raises:
        InvalidParameter: If there is no scenario file, or a path is missing.
    """
    # Collect scenario files and maps.
    maps: dict[str, list[Path]] = {}
    scenarios: dict[Path, None] = {}
    for path in paths:
        if not path.exists():
            raise InvalidParameter(
                "no-such-file",
                "{path} does not exist",
                "name scenario files, maps, or folders of them",
                path=path,
            )
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.suffix.lower() == ".scen":
                scenarios[file] = None
            elif file.suffix.lower() == ".map":
                found = maps.setdefault(file.name, [])
                found += [file] if file not in found else []
    if not scenarios:
        named = ", ".join(map(str, paths))
        raise InvalidParameter(
            "no-map-found",
            "{paths}: there is no scenario file",
            "name files that end in .scen, or a folder that contains them",
            paths=named,
        )
    # Find each scenario's map by the name in the file.
    pairs = []
    refused = []
    for file in scenarios:
        try:
            pairs.append((file, tuple(maps.get(scenario_contents(file)[0], ()))))
        except FormatError as error:
            refused.append(ScenarioReport(str(file), "", fault=without_file(error)))
    return ScenarioFiles(tuple(pairs), tuple(refused))


def check_scenario(
    scenario: Path, maps: Sequence[Path], *, rows: int | None = None, seed: int = 0
) -> Iterator[ScenarioReport]:
    """Solve a file's problems on every map with its map's name and size.

    If none has that size, scale the maps with its name to it.

    Args:
        scenario: The ``.scen`` file.
        maps: Maps with the name in the file.
        rows: Number of problems to draw; all of them if omitted.
        seed: Seed of the draw.
    """
    try:
        problems = _drawn(read_problems(scenario), rows, seed, scenario.name)
    except FormatError as error:
        yield ScenarioReport(str(scenario), "", fault=without_file(error))
        return
    if not maps:
        fault = f"the maps do not include {problems.map_name}; add its folder to the command"
        yield ScenarioReport(
            str(scenario), "", len(problems.published), misfit=len(problems.published), fault=fault
        )
    read = [_terrain(path) for path in maps]
    fitting = [
        not isinstance(terrain, str) and terrain.shape[::-1] == problems.size for terrain in read
    ]
    for path, terrain, fits in zip(maps, read, fitting, strict=True):
        if isinstance(terrain, str):
            yield ScenarioReport(str(scenario), str(path), len(problems.published), fault=terrain)
        elif fits or not any(fitting):
            yield _solve(scenario, path, problems, terrain)


def _terrain(path: Path) -> Bytes | str:
    """Return the map, or a sentence with the reason why it cannot be read."""
    try:
        return read_terrain(path)
    except FormatError as error:
        return without_file(error)


def _drawn(problems: Problems, rows: int | None, seed: int, name: str) -> Problems:
    count = len(problems.published)
    if rows is None or rows >= count:
        return problems
    order = list(range(count))
    RandomStream(seed).child("scenarios", name).shuffle(order)
    kept = np.array(sorted(order[:rows]), np.int64)
    starts = problems.starts[kept]
    goals = problems.goals[kept]
    published = problems.published[kept]
    return replace(problems, starts=starts, goals=goals, published=published)


def _solve(scenario: Path, path: Path, problems: Problems, terrain: Bytes) -> ScenarioReport:
    height, width = terrain.shape
    count = len(problems.published)
    report = ScenarioReport(str(scenario), str(path), count)
    if problems.size == (height, width) != (width, height):  # swapped sides are not a scale
        fault = (
            f"made for {height} x {width} cells, but the map has {width} x {height}; swap the two "
            f"in one of the files"
        )
        return replace(report, misfit=count, fault=fault)
    if max(width * height, problems.size[0] * problems.size[1]) > _MOST_CELLS:
        return replace(
            report, misfit=count, fault=f"more than {_MOST_CELLS} cells, the limit for solving"
        )
    if problems.size != (width, height):
        terrain = _scaled(terrain, *problems.size)
        report = replace(report, scaled=count)
    return _compared(report, problems, _lengths(terrain, problems))


def _scaled(terrain: Bytes, width: int, height: int) -> Bytes:
    """Return the map in another size, scaled as the benchmark does it.

    Cell x of the new map is cell x * old // new of the old one.
    """
    rows = np.arange(height) * terrain.shape[0] // height
    columns = np.arange(width) * terrain.shape[1] // width
    return np.ascontiguousarray(terrain[np.ix_(rows, columns)])


def _lengths(terrain: Bytes, problems: Problems) -> Floats:
    """Return the (n,) lengths of shortest paths, each on the terrain that its problem begins on.

    Infinity if there is no path.
    """
    starts = problems.starts
    goals = problems.goals
    found = np.full(len(starts), np.inf)
    begins = terrain[starts[:, 1], starts[:, 0]]
    for kind in (GROUND, WATER, TREES):
        here = begins == kind
        if here.any():
            found[here] = octile_lengths(
                terrain != kind, starts[here], goals[here], problems.published[here]
            )
    return found


def _compared(report: ScenarioReport, problems: Problems, lengths: Floats) -> ScenarioReport:
    published = problems.published
    blocked = np.isinf(lengths)
    ours = np.where(blocked, 0.0, lengths)
    difference = np.abs(ours - published)
    near = difference <= (
        _TWO_DECIMALS if problems.version == "1.0" else np.maximum(_SIX_DIGITS * published, 1e-6)
    )
    agree = near & (~blocked | (published == 0.0))
    wrong = np.flatnonzero(~agree)
    return replace(
        report,
        agree=int(agree.sum()),
        no_path=int((agree & blocked).sum()),
        differ=int((~agree & ~blocked).sum()),
        unreachable=int((~agree & blocked).sum()),
        worst=float(difference[agree & ~blocked].max(initial=0.0)),
        fault=_fault(problems, int(wrong[0]), ours, blocked) if len(wrong) else "",
    )


def _fault(problems: Problems, row: int, ours: Floats, blocked: Bools) -> str:
    start, goal = (tuple(map(int, cells[row])) for cells in (problems.starts, problems.goals))
    came = "there is no path" if blocked[row] else f"the shortest path has {ours[row]:.10g} cells"
    told = f"the published length is {problems.published[row]:.10g} cells"
    return (
        f"from {start} to {goal} {came}, {told}; this is not the map that the problems were made "
        "for"
    )


def total(reports: Sequence[ScenarioReport]) -> dict[str, int | float]:
    """Return the sums over all reports, the largest ``worst``, and the counts of maps and files."""
    counts = ("problems", "agree", "no_path", "differ", "unreachable", "misfit", "scaled")
    sums: dict[str, int | float] = {
        name: sum(getattr(report, name) for report in reports) for name in counts
    }
    sums["worst"] = max((report.worst for report in reports), default=0.0)
    sums["maps"] = len({report.map for report in reports if report.map})
    sums["files"] = len({report.scenario for report in reports})
    return sums


def as_csv(reports: Sequence[ScenarioReport]) -> str:
    """Return a CSV row for each file and map; its columns are :class:`ScenarioReport`'s fields."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([field.name for field in fields(ScenarioReport)])
    table.writerows(asdict(report).values() for report in reports)
    return text.getvalue()


def as_text(reports: Sequence[ScenarioReport]) -> Styled:
    """Return the sums, and a line for each file in which a problem does not agree."""
    sums = total(reports)
    scaled = f", {sums['scaled']} on maps scaled to their sizes" if sums["scaled"] else ""
    lines = [
        f"{counted(int(sums['problems']), 'problem')} in {counted(int(sums['files']), 'file')} "
        f"on {counted(int(sums['maps']), 'map')}{scaled}",
        "",
        aligned(
            [
                ["shortest path as published", str(sums["agree"])],
                ["  of these, no path, published as 0", str(sums["no_path"])],
                ["another length", str(sums["differ"])],
                ["no path, but one is published", str(sums["unreachable"])],
                ["skipped: no map of that size", str(sums["misfit"])],
                ["largest difference that rounding explains", f"{sums['worst']:.6f}"],
            ],
            right=[1],
        ),
    ]
    faults = [report for report in reports if report.fault]
    for report in faults[:_MOST_LINES]:
        on = f" on {report.map}" if report.map else ""
        lines.append(
            f"{report.scenario}{on}: {report.agree} of {report.problems} agree; {report.fault}"
        )
    if len(faults) > _MOST_LINES:
        lines.append(f"{len(faults) - _MOST_LINES} more files do not fully agree; --csv lists them")
    return stacked([*lines, ""])
