"""Read recorded trajectories and plans from tables of numbers, as many programs write them."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from worldgen.errors import FormatError, InvalidParameter
from worldgen.files.whole import decoded, read_stream, read_text
from worldgen.logs.bag import is_bag, read_bag
from worldgen.logs.columns import (
    TOPIC,
    Choice,
    Column,
    ambiguous,
    chosen_columns,
    find_columns,
    is_frame,
    is_sure,
    label_columns,
    no_column,
    parse_columns,
)
from worldgen.logs.layouts import Layout, layout_of, named_path, path_of, unknown_layout
from worldgen.logs.table import Table, number_of, split
from worldgen.logs.trajectory import Trajectory
from worldgen.logs.units import check_order, headings, metres, seconds
from worldgen.support.arrays import Floats, Ints
from worldgen.support.plain_text import counted

# A larger file is refused before it fills the memory.
_MOST_BYTES = 1 << 30
# What users call tables, by names that all of them have in their headers.
_KINDS: tuple[tuple[str, frozenset[str]], ...] = (
    ("TUM", frozenset(("tx", "ty", "qw"))),
    ("F1TENTH's line", frozenset(("x_m", "y_m"))),
    ("rostopic echo -p", frozenset(("time", "field.header.stamp"))),
)
_CHOSEN = "a table without a header"
_TURNS = ("yaw", "qx", "qy", "qz", "qw")
# Lines by which a table without a header is recognised.
_ROWS = 20
# Columns of times that are compared: each one costs a reading of the whole table.
_MOST_TIMES = 16
# Durations in two columns of times that are the same one, as a ratio.
_SAME = 0.01
_OURS = "%worldgen-grid"
# Decimals of a place, m, that transforms leave.
_PLACES = 9


@dataclass(frozen=True)
class Log:
    """What a file of poses holds.

    Args:
        trajectories: By the robots' numbers, from 1. A file without a column ``robot`` has one, of
            the first robot or of the chosen one.
        read_as: What the file was taken for, in words; empty for our own columns t, x and y.
        in_map_frame: True if its places are known to be in the frame of a map, as those of a bag.
    """

    trajectories: Mapping[int, Trajectory]
    read_as: str = ""
    in_map_frame: bool = False


class _Recognised(NamedTuple):
    """How to read a table.

    Args:
        kind: What users call it; empty if only its names tell.
        ways: Columns by quantity, the likeliest first; they differ in their times only.
        layout: Its layout, if it has no header.
    """

    kind: str
    ways: Sequence[Mapping[str, Column]]
    layout: Layout | None = None


def read_log(
    path: Path,
    robots: int = 1,
    only: int | None = None,
    *,
    with_headings: bool = False,
    columns: str = "",
) -> Log:
    """Read trajectories from a table or a ROS bag, or from stdin if the path is ``-``.

    Args:
        path: The file, or the folder of a bag.
        robots: Number of robots in the world; in a world with one, a column ``robot`` is ignored.
        only: The robot whose trajectory to read; all if omitted.
        with_headings: True to read headings, if the file has any.
        columns: Columns that the user chose, as in ``t=stamp:ms,x=px,y=py,yaw=4:deg``; the others
            are recognised. ``topic=/odom`` chooses a topic of a bag.

    Raises:
        FormatError: If it cannot be read, is not a trajectory, or may be several things.
        InvalidParameter: If ``columns`` has another form.
    """
    if str(path) == "-":
        source = "stdin"
        text = decoded(read_stream(sys.stdin.buffer, source, _MOST_BYTES), source)
    elif is_bag(path):
        return _of_bag(path, only or 1, columns)
    else:
        source = str(path)
        text = read_text(path, _MOST_BYTES)
    return parse_log(text, source, robots, only, with_headings=with_headings, columns=columns)


def _of_bag(path: Path, robot: int, columns: str) -> Log:
    """Return the poses of a bag in the frame of its map."""
    chosen = parse_columns(columns) if columns else {}
    if chosen.keys() - {TOPIC}:
        raise InvalidParameter(
            "conflict",
            "{path} is a bag, which has topics and no columns",
            "choose one as in --columns topic=/odom, or omit it",
            at_terminal=True,
            path=path.name,
        )
    bag = read_bag(path)
    try:
        source, track = bag.poses_in(bag.map_frame, chosen.get(TOPIC, ("", ""))[0])
        times = track.times - (track.times[0] if len(track.times) else 0.0)
        # Chains of transforms leave errors of rounding that exact comparisons would see.
        own = (times, track.x.round(_PLACES), track.y.round(_PLACES), track.yaw)
        fault = Trajectory.fault(*own)
        if fault is not None:
            raise FormatError.of(fault[1])
    except FormatError as error:
        error.source = error.source or str(path)
        raise
    found = {robot: Trajectory(*own)}
    return Log(found, describe_log("a bag", found, remark=f"from {source}"), in_map_frame=True)


def parse_log(
    text: str,
    source: str,
    robots: int = 1,
    only: int | None = None,
    *,
    with_headings: bool = False,
    columns: str = "",
) -> Log:
    """Read trajectories from text, as :func:`read_log` does from a file.

    Args:
        text: A table of numbers, with or without a header. Without times, it is a plan. Empty lines
            and comments are ignored.
        source: The file's name, for messages.
        robots: As for :func:`read_log`, and so are the rest.
        only: The same.
        with_headings: The same.
        columns: The same.

    Raises:
        FormatError: If it is not a trajectory; the error names the faulty line.
        InvalidParameter: If ``columns`` has another form.
    """
    chosen = parse_columns(columns) if columns else {}
    try:
        # Numbers that overflow are refused with their line, as every infinite number.
        with np.errstate(all="ignore"):
            return _parsed(text, chosen, robots, only, with_headings=with_headings)
    except FormatError as error:
        error.source = error.source or source
        # The corrected command adds to the columns that were chosen.
        if "needs" in error.facts and columns:
            for name in ("way", "other"):
                if name in error.facts:
                    error.facts[name] = f"{columns},{error.facts[name]}"
            error.facts["needs"] = [f"--columns={error.facts['way']}"]
        raise


def _parsed(
    text: str, chosen: Choice, robots: int, only: int | None, *, with_headings: bool
) -> Log:
    if text.startswith(_OURS):
        raise FormatError(
            "not-a-log",
            "this is a world, not a log",
            "name the world first and then the log, as in worldgen audit w.grid log.csv",
            at_terminal=True,
        )
    table = Table.of(text)
    kind, ways, layout = _recognised(table, chosen)
    if layout is not None and layout.is_path:
        found = {only or 1: _last_path(table, layout)}
        return Log(found, describe_log(kind, found))
    ignored = (*(() if with_headings else _TURNS), *(() if robots > 1 else ("robot",)))
    values, places = _values(table, ways, ignored)

    # Divide the samples among the robots, and bring their numbers to s, m and rad.
    owners = values.pop("robot", None)
    samples = (
        {only or 1: np.arange(len(values["x"]))}
        if owners is None
        else _samples(owners, robots, only, table)
    )
    x = metres(values["x"], places["x"])
    y = metres(values["y"], places["y"])
    times, unit, date = None, "", 0.0
    if "t" in values:
        rows = next(iter(samples.values()))
        times, unit, date = seconds(values["t"], values.get("nanosec"), places["t"], x, y, rows)
    turned, remark = None, ""
    if "yaw" in values or {"qz", "qw"} <= values.keys():
        is_by_place = layout is not None and not layout.is_message and "yaw" not in values
        if is_by_place and not chosen.keys() & set(_TURNS):
            check_order(values, places)
        turned, remark = headings(values, places, x, y, list(samples.values()))

    if times is None and not kind and "t" not in chosen:
        remark = "; ".join(filter(None, (remark, _unread_times(table, places))))

    # A fault in the numbers has the line of its sample.
    found = {}
    for robot, rows in samples.items():
        own = (
            np.arange(len(rows), dtype=np.float64) if times is None else times[rows],
            x[rows],
            y[rows],
            None if turned is None else turned[rows],
        )
        fault = Trajectory.fault(*own)
        if fault is not None:
            sample, message = fault
            line = table.line_of(int(rows[sample])) if sample >= 0 else None
            if owners is not None:
                message = message.behind("robot {robot}: ", robot=robot)
            raise FormatError.of(message, line=line)
        found[robot] = Trajectory(*own, is_plan=times is None)
    is_ours = all(places[name].name.lower() == name for name in ("t", "x", "y") if name in places)
    if not kind and is_ours and unit in ("", "s") and not date and not remark:
        return Log(found)
    return Log(found, describe_log(kind or _described(places, unit), found, date, remark))


def _unread_times(table: Table, places: Mapping[str, Column]) -> str:
    """Return a remark if the first column of a plan may be times with an unknown name."""
    if any(column.place == 0 for column in places.values()):
        return ""
    try:
        steps = np.diff(table.numbers({"t": 0})["t"])
    except FormatError:
        return ""
    # Ones are the steps of line numbers.
    if not len(steps) or not (steps > 0.0).all() or (steps == 1.0).all():
        return ""
    return "column 1 rises from line to line: choose --columns t=1 if it holds the times"


def _described(places: Mapping[str, Column], unit: str) -> str:
    """Return what is read from which column."""
    said = [f"{name} from {places[name].name}" for name in ("x", "y", "yaw") if name in places]
    if "nanosec" in places:
        said.insert(0, f"t from {places['t'].name} and {places['nanosec'].name}")
    elif "t" in places:
        said.insert(0, f"t from {places['t'].name} in {unit}")
    return f"a table ({', '.join(said)})"


def describe_log(
    kind: str, found: Mapping[int, Trajectory], date: float = 0.0, remark: str = ""
) -> str:
    """Return what was read, such as ``TUM: 3 poses over 10 s``.

    Args:
        kind: What the file is.
        found: The trajectories by robot.
        date: s since 1970 from which the times count, or 0.
        remark: What else has to be known; empty if nothing.
    """
    count = counted(sum(len(own.x) for own in found.values()), "pose")
    ends = [(own.times[0], own.times[-1]) for own in found.values() if not own.is_plan]
    span = "without times, a plan"
    if ends:
        span = f"over {max(end for _, end in ends) - min(begin for begin, _ in ends):.6g} s"
    begun = f", counted from {date:.15g} s" if date else ""
    return f"{kind}: {count} {span}{begun}" + (f"; {remark}" if remark else "")


def _recognised(table: Table, chosen: Choice) -> _Recognised:
    """Recognise a table by its header, or by the number and the kinds of its columns.

    Raises:
        FormatError: If it may be several things, or nothing that is known.
    """
    # Names come first; a comment need not be a header.
    error: FormatError | None = None
    for line, names in table.names():
        path = named_path(names) if table.first else None
        if path is not None:
            return _Recognised(path.name, [{}], path)
        try:
            ways = find_columns(names, chosen, max(len(names), len(table.first)))
        except FormatError as fault:
            fault.line = line
            if fault.code == "ambiguous-columns":
                raise
            error = error or fault
            continue
        _check_width(table, names, line)
        _check_frames(table, [place for place, name in enumerate(names) if is_frame(name)])
        return _Recognised(_kind_of(names) if not chosen else "", ways)
    if not table.first and not table.headers:
        raise FormatError("too-few-samples", "the file is empty", "record a run first")
    # Programs may print a line of words before the first message of ROS, which has words in itself.
    layout = layout_of(table.rows(_ROWS)) if table.first else None
    is_message = layout is not None and (layout.frames or layout.is_path)
    if not table.first or (table.named and not is_message):
        raise error or no_column("x", [text for _, text in table.headers])

    own = chosen_columns(chosen, (), len(table.first))
    if "x" in own:
        return _Recognised(_CHOSEN, [own])
    if layout is None:
        raise unknown_layout(len(table.first), table.line + 1)
    if not layout.is_path:
        _check_frames(table, layout.frames)
    known = {name: column for name, column in layout.columns.items() if name not in chosen}
    return _Recognised(layout.name, [known | own], layout)


def _check_width(table: Table, names: Sequence[str], line: int) -> None:
    """Refuse samples with more fields than the header has names: nobody knows which is which."""
    extra = table.first[len(names) :]
    if any(extra):
        raise FormatError(
            "wrong-count",
            "the header has {names} names, and the first sample has {fields} fields",
            "name all columns; numbers with decimal commas need semicolons between them",
            names=len(names),
            fields=len(table.first),
            line=line,
        )


def _kind_of(names: Sequence[str]) -> str:
    known = {name.lower() for name in names}
    return next((kind for kind, needed in _KINDS if needed <= known), "")


def _check_frames(table: Table, places: Sequence[int]) -> None:
    """Refuse poses of several frames in one table, such as all of ROS's /tf."""
    for values in table.texts(places):
        frames = sorted(values)
        if len(frames) > 1:
            raise FormatError(
                "several-frames",
                "the poses are of several frames: {frames!l}",
                "write those of one to a file of its own",
                frames=frames[:8],
            )


def _values(
    table: Table, ways: Sequence[Mapping[str, Column]], ignored: Collection[str]
) -> tuple[dict[str, Floats], Mapping[str, Column]]:
    """Return the numbers of the table's columns, (n,) each, and the columns, by quantity."""
    way = ways[0] if len(ways) == 1 else _timed(table, ways)
    places = {name: column for name, column in way.items() if name not in ignored}
    return table.numbers({name: column.place for name, column in places.items()}), places


def _timed(table: Table, ways: Sequence[Mapping[str, Column]]) -> Mapping[str, Column]:
    """Return the way with the times of the poses, of several that have times.

    Raises:
        FormatError: If two columns of times differ in more than their units.
    """
    first: Mapping[str, Column] = ways[0]
    span: float | None = None
    for count, way in enumerate(ways):
        if count == _MOST_TIMES:
            raise _several_times(first, way)
        try:
            times = table.numbers({"t": way["t"].place})["t"]
        except FormatError:
            continue
        # A stamp that nobody set stays at 0.
        if len(times) > 1 and times.min() == times.max():
            continue
        other = float(np.ptp(times)) if len(times) else 0.0
        if span is None:
            first, span = way, other
            if is_sure(first["t"]):
                break
        elif not _differ_by_unit(span, other):
            raise _several_times(first, way)
    return first


def _several_times(way: Mapping[str, Column], other: Mapping[str, Column]) -> FormatError:
    own, rival = label_columns([way["t"], other["t"]])
    return ambiguous(f"the times may be in {own} or in {rival}", (f"t={own}", f"t={rival}"))


def _differ_by_unit(span: float, other: float) -> bool:
    if not (0.0 < span < math.inf and 0.0 < other < math.inf):
        return span == other
    thousands = math.log(span / other, 1000.0)
    return abs(thousands - round(thousands)) < _SAME


def _last_path(table: Table, layout: Layout) -> Trajectory:
    """Return the last plan of a table in which each line is one, with all its poses."""
    *_, (line, text) = table.lines()
    written = split(text, table.delimiter)
    own = layout if len(written) == len(layout.fields) else path_of(written)
    if own is None:
        raise FormatError(
            "line-too-short",
            "the last line is no whole path as the others are",
            "write the path that you mean to a file of its own",
            line=line,
        )
    numbers = np.array([number_of(field) or 0.0 for field in written])
    fields = np.array(own.fields)
    x, y = (numbers[fields == name] for name in ("x", "y"))
    turns = {name: numbers[fields == name] for name in _TURNS if name in own.fields}
    fault = Trajectory.fault(np.arange(len(x), dtype=np.float64), x, y)
    if fault is not None:
        raise FormatError.of(fault[1], line=line)
    is_whole = all(len(turn) == len(x) for turn in turns.values())
    if not (is_whole and {"qz", "qw"} <= turns.keys()):
        return Trajectory.plan(x, y)
    turned, _ = headings(turns, {}, x, y, ())
    return Trajectory.plan(x, y, None if np.isnan(turned).any() else turned)


def _samples(owners: Floats, robots: int, only: int | None, table: Table) -> dict[int, Ints]:
    """Return the rows of each robot's samples."""
    wrong = np.flatnonzero(~np.isin(owners, np.arange(1, robots + 1)))
    if len(wrong):
        raise FormatError(
            "out-of-range",
            "robot {robot:g} is not in the world, which has {robots}",
            "number the robots from 1, or use the world in which it was recorded",
            robot=float(owners[wrong[0]]),
            robots=robots,
            line=table.line_of(int(wrong[0])),
        )
    known = np.unique(owners).astype(int).tolist()
    if (only is not None and only not in known) or not known:
        raise FormatError(
            "too-few-samples",
            "the file has no samples of robot {robot}",
            "choose a robot that was recorded" if known else "record a run first",
            robot=only or 1,
        )
    wanted = known if only is None else [only]
    return {robot: np.flatnonzero(owners == robot) for robot in wanted}
