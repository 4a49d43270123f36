"""Read published tables of results, and measure how well a comparison agrees with them.

``docs/howto/compare.md`` describes the file. Only its columns world, controller and time are
required.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from sim.compare.comparison import Comparison, ComparisonCell, NamedWorld
from sim.options.run import RunOptions
from sim.scenario import Scenario, read_settings
from sim.verdict import FAILURES, UNENDED, Verdict
from worldgen.errors import FormatError, InvalidParameter
from worldgen.plugins.trust import NameInFile

_NEEDED = ("world", "controller", "time")
# Seconds; a longer time counts as a mistake.
_LONGEST = 1e9

# Fractions between which the middle 95 % of the seeds are.
_MIDDLE = (0.025, 0.975)
_VERDICTS = (Verdict.REACHED, "never", *FAILURES)


@dataclass(frozen=True)
class PublishedRow:
    """One line of a published table.

    Args:
        world: Name of the world in that table.
        controller: Name of the controller with its options, without motion model and time step.
        verdict: ``reached``, ``never``, or a verdict that is a failure.
        time: Time of arrival, s; ``None`` if nothing arrived.
        motion: Motion model; empty if the table does not give one.
        time_step: Duration of a step, s; ``None`` if the table does not give one.
        source: The source of the figure.
        note: The note in the table.
        folder: Folder of the worlds that the table is about; empty for any.
    """

    world: str
    controller: str
    verdict: str
    time: float | None
    motion: str = ""
    time_step: float | None = None
    source: str = ""
    note: str = ""
    folder: str = ""

    @property
    def never(self) -> bool:
        """True if the table reports that the robot did not arrive, and that no event ended its run."""
        return self.verdict in ("never", *UNENDED)

    @property
    def rank_time(self) -> float:
        """Time to rank by, s; ``inf`` if it did not arrive."""
        return self.time if self.verdict == Verdict.REACHED and self.time is not None else math.inf

    def is_of(self, world: NamedWorld) -> bool:
        """Return True if the figure is about this world."""
        return self.world in (world.name, world.stem) and self.folder in ("", world.folder)


@dataclass(frozen=True)
class Deviation:
    """The difference of our time from a published one; times in s.

    ``relative`` is (ours - theirs) / theirs.
    """

    world: str
    label: str
    ours: float
    theirs: float
    relative: float


@dataclass(frozen=True)
class Agreement:
    """How well a published table agrees with ours.

    Args:
        figures: Published figures by (row, column); a cell may have several.
        rankings: Number of worlds in which both rank the controllers in the same order, and of
            worlds with at least two figures.
        never: Number of cells in which both tables have "never", and of cells in which either has.
        within: Number of published times within the middle 95 % of our seeds, and of all times that
            can be compared in this way.
        largest: The cell without randomness whose time deviates most; of several figures, the
            nearest counts.
    """

    figures: Mapping[tuple[int, int], tuple[PublishedRow, ...]]
    rankings: tuple[int, int]
    never: tuple[int, int]
    within: tuple[int, int]
    largest: Deviation | None


def read_figures(text: str, source: str, folder: str = "") -> tuple[PublishedRow, ...]:
    """Read a published table.

    Args:
        text: Content of the CSV file.
        source: Its name, for messages.
        folder: Folder of the worlds that it is about; empty for any.

    Raises:
        FormatError: If it is not such a table; the error names the faulty line.
    """
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        header = [name.strip() for name in next(rows, [])]
        missing = [name for name in _NEEDED if header.count(name) != 1]
        if missing:
            raise FormatError(
                "columns-missing",
                "the first line does not name column {column!r} exactly once",
                "it needs {columns!l}",
                column=missing[0],
                columns=list(_NEEDED),
                line=1,
                source=source,
            )
        return tuple(
            _figure(header, row, rows.line_num, source, folder)
            for row in rows
            if any(map(str.strip, row))
        )
    except csv.Error as error:
        raise FormatError(
            "invalid-csv",
            "not CSV: {reason}",
            "write fields separated by commas",
            reason=str(error),
            line=rows.line_num,
            source=source,
        ) from None


def _figure(
    header: Sequence[str], row: Sequence[str], line: int, source: str, folder: str
) -> PublishedRow:
    if len(row) != len(header):
        raise FormatError(
            "wrong-count",
            "{count} fields, but the header has {wanted}",
            "use as many",
            count=len(row),
            wanted=len(header),
            line=line,
            source=source,
        )

    # Read the required columns. An empty time, or "never", means that the robot did not arrive.
    values = {name: text.strip() for name, text in zip(header, row, strict=True)}
    if not values["world"] or not values["controller"]:
        raise FormatError(
            "empty-name", "world or controller is empty", "name both", line=line, source=source
        )
    text = values["time"]
    verdict = values.get("verdict", "").lower()
    time = None if text.lower() in ("", "never") else _seconds("time", text, line, source)

    # The verdict may be omitted if the time implies it.
    if not verdict:
        verdict = "never" if time is None else Verdict.REACHED
    if verdict not in _VERDICTS:
        raise FormatError(
            "unknown-name",
            "verdict {verdict!r} is not one of {known!l}",
            verdict=verdict[:40],
            known=[str(one) for one in _VERDICTS],
            line=line,
            source=source,
        )
    if verdict == Verdict.REACHED and time is None:
        raise FormatError(
            "time-missing",
            "the verdict is reached, but there is no time",
            "use seconds, or the verdict never",
            line=line,
            source=source,
        )
    if verdict != Verdict.REACHED:
        # A time in such a line belongs to the few runs that arrived anyway.
        time = None

    # Options in the controller's name take precedence over the columns of the table.
    controller, motion, step = _scenario(values["controller"], values.get("motion", ""))
    if values.get("time_step"):
        step = _seconds("time_step", values["time_step"], line, source)
    return PublishedRow(
        world=values["world"],
        controller=controller,
        verdict=verdict,
        time=time,
        motion=motion,
        time_step=step,
        source=values.get("source", ""),
        note=values.get("note", ""),
        folder=folder,
    )


def _scenario(text: str, motion: str) -> tuple[str, str, float | None]:
    """Return a controller, motion model and time step, in whichever form the table writes them."""
    try:
        controller, settings = read_settings(text, motion)
        found = Scenario(NameInFile(controller), RunOptions(**({"motion": motion} | settings)))
    except InvalidParameter:  # The table may contain controllers that do not exist here.
        return text, motion, None
    return found.label(), found.run.motion, settings.get("time_step")


def _seconds(name: str, text: str, line: int, source: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value <= _LONGEST:
        raise FormatError(
            "not-a-number",
            "{name} {value!r} is not a number of seconds, above 0 and up to {most:g}",
            "write a number of seconds, or never",
            name=name,
            value=text[:40],
            most=_LONGEST,
            line=line,
            source=source,
        )
    return value


def figures_of(
    figures: Iterable[PublishedRow], world: NamedWorld, scenario: Scenario
) -> tuple[PublishedRow, ...]:
    """Return the figures for one cell.

    These are the ones for its motion model and time step if there are any, else all of them.
    """
    name = scenario.label()
    found = [figure for figure in figures if figure.controller == name and figure.is_of(world)]
    found = [figure for figure in found if figure.motion in ("", scenario.run.motion)] or found
    found = [
        figure for figure in found if figure.time_step in (None, scenario.run.time_step)
    ] or found
    return tuple(found)


def relative(ours: float, theirs: float) -> float:
    """Return (ours - theirs) / theirs; ``inf`` if theirs is 0 and ours is not."""
    if theirs == 0.0:
        return 0.0 if ours == 0.0 else math.inf
    return (ours - theirs) / theirs


def agreement(comparison: Comparison, figures: Iterable[PublishedRow]) -> Agreement:
    """Return how well a published table agrees with ours."""
    known = tuple(figures)
    found: dict[tuple[int, int], tuple[PublishedRow, ...]] = {}
    for row, world in enumerate(comparison.worlds):
        for column, cell in enumerate(comparison.cells[row]):
            own = figures_of(known, world, cell.scenario)
            if own:
                found[row, column] = own
    pairs = [(comparison.cells[row][column], own) for (row, column), own in found.items()]
    return Agreement(
        found, _rankings(comparison, found), _never(pairs), _within(pairs), _largest(pairs)
    )


_Pairs = Sequence[tuple[ComparisonCell, tuple[PublishedRow, ...]]]


def _rankings(
    comparison: Comparison, found: Mapping[tuple[int, int], tuple[PublishedRow, ...]]
) -> tuple[int, int]:
    same = total = 0
    # A ranking needs at least two controllers with figures for the same world.
    for row, cells in enumerate(comparison.cells):
        columns = [column for column in range(len(cells)) if (row, column) in found]
        if len(columns) < 2:
            continue
        total += 1
        ours = _order([cells[column].rank_time for column in columns])
        same += ours == _order([_nearest(cells[column], found[row, column]) for column in columns])
    return same, total


def _nearest(cell: ComparisonCell, figures: Sequence[PublishedRow]) -> float:
    """Return the published time to rank by, s: of several, the one nearest to ours."""
    ours = cell.rank_time
    times = sorted(figure.rank_time for figure in figures)
    return min(
        times,
        key=lambda time: (
            0.0 if time == ours else abs(time - ours) if math.isfinite(ours) else -time
        ),
    )


def _order(times: Sequence[float]) -> list[int]:
    """Return each time's rank; ties share one."""
    places = sorted(set(times))
    return [places.index(time) for time in times]


def _never(pairs: _Pairs) -> tuple[int, int]:
    either = [
        (cell.is_unended, any(figure.never for figure in own))
        for cell, own in pairs
        if cell.is_unended or any(figure.never for figure in own)
    ]
    return sum(ours and theirs for ours, theirs in either), len(either)


def _within(pairs: _Pairs) -> tuple[int, int]:
    low, high = _MIDDLE
    inside = [
        cell.share_until(figure.time) >= low and cell.share_before(figure.time) <= high
        for cell, own in pairs
        if cell.random
        for figure in own
        if figure.time is not None
    ]
    return sum(inside), len(inside)


def _largest(pairs: _Pairs) -> Deviation | None:
    deviations = []
    for cell, own in pairs:
        ours = cell.time
        theirs = [figure.time for figure in own if figure.time is not None]
        # Random controllers and runs without arrival have no time to compare.
        if cell.random or ours is None or not theirs:
            continue
        nearest = min(theirs, key=lambda time: abs(relative(ours, time)))
        deviations.append(Deviation(cell.world, cell.label, ours, nearest, relative(ours, nearest)))
    return max(deviations, key=lambda deviation: abs(deviation.relative), default=None)
