"""Read the maps in files and folders, in every format that ``import`` accepts.

MovingAI maps use the problems of the scenario files next to them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.interop.census.case import CensusMap, Ends, Refused
from worldgen.interop.format.foreign_map import ForeignMap, without_file
from worldgen.interop.formats.movingai import read_scenario, scenario_contents
from worldgen.interop.recognising import find_format, looks_like_a_map, read_map
from worldgen.lattice import UNIT, lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.world import Pose, Target, Value


@dataclass(frozen=True)
class FolderMaps:
    """Maps that are read one at a time, as the caller iterates.

    Args:
        files: What to read, in order, with the name of each.
        scenarios: MovingAI scenario files by the name of the map that they are for, each with its
            number of problems.
        refused: Files that end in ``.scen`` but are not scenario files.
        passed_over: Number of files in folders that do not look like a map.
        pairs: Problems to take of a map's scenarios.
        seed: Seed of the draw.
        options: Options for reading the files, such as the cell size.
    """

    files: tuple[tuple[str, Path], ...]
    scenarios: Mapping[str, tuple[tuple[Path, int], ...]]
    refused: tuple[Refused, ...]
    passed_over: int
    pairs: int
    seed: int
    options: Mapping[str, Value] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.files)

    def __iter__(self) -> Iterator[CensusMap | Refused]:
        yield from self.refused
        for name, path in self.files:
            yield from self._read(name, path)

    def _read(self, name: str, path: Path) -> Iterator[CensusMap | Refused]:
        try:
            known = find_format(path)
            takes = {option.name for option in known.read_options}
            kept = {name: value for name, value in self.options.items() if name in takes}
            found = read_map(path, options=kept)
            if found.unread:
                raise FormatError(
                    "unread-obstacles",
                    "has obstacles that are not read: {obstacles}",
                    obstacles="; ".join(found.unread),
                )
            ends = _own_ends(found)
        except WorldgenError as error:
            yield Refused(name, without_file(error))
            return
        if not ends:
            try:
                ends = self._scenario_ends(name, path, found)
            # The map itself can still be judged.
            except WorldgenError as error:
                yield Refused(f"{name} (its scenarios)", without_file(error))
        yield CensusMap(name, found.walls, found.cell_size, ends, found.params, found.warnings)

    def _scenario_ends(self, name: str, path: Path, found: ForeignMap) -> tuple[Ends, ...]:
        """Return problems of the map's scenario files, drawn without repetition, in file order."""
        files = self.scenarios.get(path.name, ())
        rng = RandomStream(self.seed).child("census", name, "scenarios")
        left = list(range(sum(count for _, count in files)))
        rng.shuffle(left)
        ends = []
        for number in sorted(left[: self.pairs]):
            file, row = _problem(files, number)
            height, width = found.walls.shape
            problem = read_scenario(file, row, width, height, found.cell_size)
            half = lattice_to_metres(UNIT // 2, found.cell_size)
            ends.append(Ends(Pose(*problem.start), Target(*problem.goal, half)))
        return tuple(ends)


def folder_maps(
    paths: Sequence[Path],
    *,
    pairs: int = 1,
    seed: int = 0,
    options: Mapping[str, Value] | None = None,
) -> FolderMaps:
    """Find the maps in files and folders.

    Each file is read only when the result is iterated.

    Args:
        paths: Files, and folders, which are searched with their subfolders. In a folder a file
            counts by its contents or by its name's ending; a file named itself always counts.
        pairs: Number of problems to take from a map's scenario files, if it has any.
        seed: Seed of the draw.
        options: Settings that the files leave open; each applies to the formats that have it.

    Raises:
        InvalidParameter: If there is no map.
    """
    # Sort the files into maps and scenarios.
    files: dict[Path, str] = {}
    scenarios: dict[str, list[tuple[Path, int]]] = {}
    refused = []
    passed_over = 0
    for name, path, named in _walk(paths):
        if path.suffix.lower() == ".scen":
            try:
                map_name, count = scenario_contents(path)
                scenarios.setdefault(map_name, []).append((path, count))
            except FormatError as error:
                refused.append(Refused(name, without_file(error)))
        elif named or looks_like_a_map(path):
            files.setdefault(path, name)
        else:
            passed_over += 1
    if not files:
        raise InvalidParameter(
            "no-map-found",
            "{paths!l}: holds no map",
            "`worldgen formats` lists the formats that a map can have",
            at_terminal=True,
            paths=list(paths),
        )
    # Scenarios find their maps by name.
    by_map = {name: tuple(found) for name, found in scenarios.items()}
    named_files = tuple((name, path) for path, name in files.items())
    return FolderMaps(named_files, by_map, tuple(refused), passed_over, pairs, seed, options or {})


def _walk(paths: Sequence[Path]) -> Iterator[tuple[str, Path, bool]]:
    """Yield each file's name and path, and whether the user named the file itself.

    The files of a folder come in alphabetical order.
    """
    for path in paths:
        if path.is_dir():
            inside = (
                (file.relative_to(path).as_posix(), file)
                for file in path.rglob("*")
                if file.is_file()
            )
            yield from ((name, file, False) for name, file in sorted(inside))
        else:
            yield path.name, path, True


def _own_ends(found: ForeignMap) -> tuple[Ends, ...]:
    """Return the start and the target, if the format stores both."""
    if found.world is not None:
        if found.world.is_dynamic:
            raise InvalidParameter(
                "world-changes", "the world changes with time; a census judges static maps"
            )
        return (Ends(found.world.start, found.world.target),)
    if found.start is None or found.target is None:
        return ()
    height, width = (side * found.cell_size for side in found.walls.shape)
    if not (0.0 <= found.start[0] <= width and 0.0 <= found.start[1] <= height):
        # The thesis's program starts where a map of 3 x 3 cells has no free cell.
        return ()
    half = lattice_to_metres(UNIT // 2, found.cell_size)
    x, y, radius = (*found.target, half)[:3]
    return (Ends(Pose(*found.start), Target(x, y, radius)),)


def _problem(files: Sequence[tuple[Path, int]], number: int) -> tuple[Path, int]:
    """Return the file and the row, from 1, of a problem numbered across all files."""
    for file, count in files:
        if number < count:
            return file, number + 1
        number -= count
    raise IndexError(number)
