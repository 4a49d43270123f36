"""Find out what the columns of a table hold, by their names.

The tables of words below are all that is known about names: a name is split into words, and each
word says what its column may hold, or rules something out.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple, TypeAlias

from worldgen.errors import FormatError, InvalidParameter
from worldgen.support.plain_text import quote

TIME_UNITS: Mapping[str, float] = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "usec", "usecs", "micros", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(
        ("ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecs", "nanosecond", "nanoseconds"), 1e-9
    ),
}
LENGTH_UNITS: Mapping[str, float] = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("cm", "centimeter", "centimeters"), 1e-2),
    **dict.fromkeys(("mm", "millimeter", "millimeters"), 1e-3),
}
ANGLE_UNITS: Mapping[str, float] = {
    **dict.fromkeys(("rad", "rads", "radian", "radians"), 1.0),
    **dict.fromkeys(("deg", "degs", "degree", "degrees", "°"), 0.017453292519943295),
}

# Units that are not read, as words at the end of a name: they say what a number is not.
_OTHER_UNITS = frozenset((
    "km", "ft", "feet", "foot", "in", "inch", "inches", "yd", "yards", "mi", "miles", "dm",
    "min", "mins", "minute", "minutes", "h", "hr", "hrs", "hour", "hours", "day", "days",
    "grad", "gon", "mrad", "turns", "revs",
))  # fmt: skip
# In brackets, these say which clock or frame it is, not which unit.
_NO_UNITS = frozenset(("utc", "gmt", "unix", "epoch", "posix", "ros", "sim", "iso", "local", "gps"))

TOPIC = "topic"
QUANTITIES = ("t", "nanosec", "x", "y", "yaw", "qx", "qy", "qz", "qw", "robot", TOPIC)
"""What a column may hold: ``t`` in s or another unit, ``nanosec`` to add to it, a quaternion.

A bag has topics in place of columns.
"""
Choice: TypeAlias = Mapping[str, tuple[str, str]]
"""For each quantity that the user chose, the column's name or number, and its unit or nothing."""
_NO_COLUMN = "none"
_UNITS: Mapping[str, Mapping[str, float]] = {
    "t": TIME_UNITS, "nanosec": TIME_UNITS, "x": LENGTH_UNITS, "y": LENGTH_UNITS,
    "yaw": ANGLE_UNITS,
}  # fmt: skip

_TIMES = frozenset((
    "t", "ts", "time", "timestamp", "stamp", "clock", "elapsed", "epoch", "zeit", "zeitstempel",
    "temps", "tiempo", "tempo", "czas", "tid", "время", "时间", "時間", "时间戳", "時刻", "시간",
))  # fmt: skip
_NO_TIMES = frozenset((
    "dt", "delta", "diff", "delay", "timeout", "duration", "cpu", "compute", "computation",
    "planning", "lap", "lag", "remaining", "zone", "frame", "count", "runtime", "lifetime", "last",
    "next", "step", "timestep", "uncertainty",
))  # fmt: skip
_POSITIONS = frozenset((
    "position", "pos", "pose", "translation", "trans", "p", "t", "loc", "location", "coord",
    "coords", "coordinate", "coordinates", "point",
))  # fmt: skip
# A column with one of these words holds something else than the robot's position or heading.
_NO_PLACES = frozenset((
    "v", "a", "vel", "velocity", "speed", "twist", "linear", "angular", "acc", "accel", "acceleration",
    "gyro", "omega", "rate", "dot", "force", "torque", "wrench", "imu", "mag", "cov", "covariance",
    "std", "stddev", "sigma", "var", "variance", "err", "error", "delta", "diff", "gradient",
    "normal", "size", "scale", "bias", "pixel", "px", "image", "scan", "steer", "steering",
    "min", "max",
))  # fmt: skip
# These are positions, but hardly the robot's: they count if there are no others.
_OTHERS = frozenset((
    "goal", "target", "ref", "reference", "desired", "des", "cmd", "command", "setpoint",
    "waypoint", "next", "lookahead", "start", "initial", "init", "obstacle", "obs", "human",
    "person", "ped", "pedestrian", "other", "camera", "cam", "lidar", "laser", "landmark",
))  # fmt: skip
# Of these, the first are surely not the robot's, and the second surely are.
_NOT_ROBOTS = frozenset((
    "goal", "obstacle", "obs", "human", "person", "ped", "pedestrian", "camera", "cam", "lidar",
    "laser", "landmark",
))  # fmt: skip
_OWNERS = frozenset(("robot", "base", "ego", "agent"))
_ROTATIONS = frozenset(("q", "quat", "quaternion", "orientation", "ori", "rotation", "rot"))
# The likeliest first.
_HEADINGS = ("heading", "yaw", "theta", "psi", "hdg", "th", "orientation", "angle", "phi")
_AXES: Mapping[str, str] = {"easting": "x", "northing": "y", **{axis: axis for axis in "xyzw"}}

_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|°|[^\W\d_A-Za-z]+")
# Opening brackets inside would make the search quadratic.
_IN_BRACKETS = re.compile(r"[\[(]([^\[\]()]*)[\])]")
_CONTEXT = (
    "t|p|pos|pose|position|trans|translation|loc|coord|point|robot|base|odom|map|world|utm|"
    "q|quat|ori|rot|orientation|quaternion"
)
_FUSED = re.compile(rf"({_CONTEXT})([xyzw])|([xyzw])({_CONTEXT})")
_SPELLED = str.maketrans(
    {"θ": "theta", "ψ": "psi", "µ": "u", "μ": "u", "Δ": "delta ", "δ": "delta "}
)


class Column(NamedTuple):
    """A column of a table: its place from 0, its name, and the unit that is known of it."""

    place: int
    name: str
    unit: str = ""


@dataclass(frozen=True)
class Name:
    """A column's name as words, in lower case, and its unit if it names one."""

    column: Column
    words: tuple[str, ...]

    @classmethod
    def of(cls, place: int, text: str) -> Name:
        """Split a name into words: ``pose_posX [m]`` into pose, pos and x, and its unit, m."""
        plain = text.translate(_SPELLED)
        inside = _IN_BRACKETS.search(plain)
        unit = inside[1].strip().lower() if inside else ""
        unit = "" if unit in _NO_UNITS else unit
        words = [word.lower() for word in _WORDS.findall(_IN_BRACKETS.sub(" ", plain))]
        if not unit and words:
            # A single s, m or t is a name.
            every = (TIME_UNITS, LENGTH_UNITS, ANGLE_UNITS, _OTHER_UNITS)
            is_unit = any(words[-1] in units for units in every)
            if is_unit and (len(words) > 1 or len(words[0]) > 1):
                unit = words.pop()
        split: list[str] = []
        for word in words:
            fused = _FUSED.fullmatch(word)
            split += [part for part in fused.groups() if part] if fused else [word]
        return cls(Column(place, text, unit), tuple(split))

    @property
    def axis(self) -> str:
        """Which of x, y, z and w the column belongs to; empty unless it is one."""
        axes = [_AXES[word] for word in self.words if word in _AXES]
        return axes[0] if len(axes) == 1 else ""

    @property
    def stem(self) -> tuple[str, ...]:
        """The words with ``*`` for the axis: columns with equal stems belong together."""
        return tuple("*" if word in _AXES else word for word in self.words)

    def has(self, words: Collection[str]) -> bool:
        """Return True if one of the words is in the name."""
        return any(word in words for word in self.words)

    @property
    def is_time(self) -> bool:
        """True if the column may hold times."""
        return self.column.unit in ("", *TIME_UNITS) and self.names_time

    @property
    def names_time(self) -> bool:
        """True if the column may hold times by its words, whatever its unit is."""
        if self.axis or self.has(_NO_TIMES):
            return False
        if not self.words:
            return self.column.unit in TIME_UNITS
        ends = ("time", "times", "stamp", "stamps")
        return self.has(_TIMES) or any(word.endswith(ends) for word in self.words)

    @property
    def is_place(self) -> bool:
        """True if the column may hold an x or a y."""
        return self.column.unit in ("", *LENGTH_UNITS) and self.names_place

    @property
    def names_place(self) -> bool:
        """True if the column may hold an x or a y by its words, whatever its unit is."""
        return self.axis in ("x", "y") and not self.has(_NO_PLACES | _ROTATIONS)

    @property
    def is_rotation(self) -> bool:
        """True if the column may hold a part of a quaternion."""
        return bool(self.axis) and self.has(_ROTATIONS) and not self.has(_NO_PLACES)

    @property
    def is_heading(self) -> bool:
        """True if the column may hold a heading."""
        unit_fits = self.column.unit in ("", *ANGLE_UNITS)
        return unit_fits and not self.axis and self.has(_HEADINGS) and not self.has(_NO_PLACES)


def parse_columns(text: str) -> Choice:
    """Parse ``t=stamp:ms,x=px,y=py``: quantities, each with a name or a number and its unit.

    Raises:
        InvalidParameter: If a part has another form.
    """
    found: dict[str, tuple[str, str]] = {}
    for part in text.split(","):
        key, equals, value = part.partition("=")
        key = key.strip().lower()
        name, _, unit = value.strip().rpartition(":")
        if not name or unit.lower() not in _UNITS.get(key, {}):
            name, unit = value.strip(), ""
        if not equals or not name or key not in QUANTITIES:
            raise InvalidParameter(
                "wrong-form",
                "columns: {part!q} is not QUANTITY=COLUMN",
                "name columns, or count them from 1, as in t=stamp:ms,x=px,y=py,yaw=4:deg; "
                "quantities are {known!l}",
                part=part.strip(),
                known=list(QUANTITIES),
            )
        found[key] = (name, unit.lower())
    missing = [axis for axis in "xy" if ("x" in found or "y" in found) and axis not in found]
    if missing:
        raise InvalidParameter(
            "missing-key", "columns: {missing!l} missing", "name both x and y", missing=missing
        )
    return found


def chosen_columns(chosen: Choice, names: Sequence[str], count: int) -> dict[str, Column]:
    """Return the columns that the user chose.

    Args:
        chosen: As from :func:`parse_columns`.
        names: Names of the columns; empty in a table without a header.
        count: Number of columns.

    Raises:
        FormatError: If there is no such column.
    """
    shown = quote(", ".join(names), 200)
    lower = [name.lower() for name in names]
    found = {}
    for quantity, (name, unit) in chosen.items():
        if name.lower() == _NO_COLUMN and name.lower() not in lower:
            continue
        if lower.count(name.lower()) == 1:
            place = lower.index(name.lower())
            label = names[place]
        elif name.isdecimal() and len(name) < 10 and 1 <= int(name) <= count:
            place = int(name) - 1
            label = name
        else:
            raise FormatError(
                "columns-missing",
                "no column {name!q} for {quantity}",
                "the columns are {shown}" if names else "count them from 1; the last is {count}",
                name=name,
                quantity=quantity,
                count=count,
                shown=shown,
            )
        own = Name.of(place, names[place]).column.unit if place < len(names) else ""
        units = _UNITS.get(quantity, {})
        if units and own and not unit and own not in units:
            raise _unknown_unit({quantity: Column(place, names[place], own)})
        found[quantity] = Column(place, label, unit or (own if units else ""))
    return found


def find_columns(names: Sequence[str], chosen: Choice, count: int) -> list[dict[str, Column]]:
    """Find the columns by their names.

    Args:
        names: The names in a header.
        chosen: What the user said about columns, as from :func:`parse_columns`.
        count: Number of columns.

    Returns:
        Ways to read the table, which differ in their times only, the likeliest first: columns by
        quantity. Without a column ``t`` it is a plan.

    Raises:
        FormatError: If there are no positions, or several that may be meant.
    """
    known = [Name.of(place, text.strip()) for place, text in enumerate(names)]
    own = chosen_columns(chosen, names, count)
    if "x" in own:
        x = Name.of(own["x"].place, own["x"].name)
        places = {}
    else:
        x, y = _position(known)
        places = {"x": x.column, "y": y.column}
    if not chosen.keys() & {"yaw", "qz", "qw"}:
        places |= _heading(known, x)
    robots = [name.column for name in known if name.words == ("robot",)]
    places |= {"robot": robots[0]} if len(robots) == 1 else {}
    times = [{}] if "t" in chosen else _times(known) or [{}]
    return [places | time | own for time in times]


def _position(known: Sequence[Name]) -> tuple[Name, Name]:
    """Return the two names of the robot's position."""
    by_stem: dict[tuple[str, ...], dict[str, list[Name]]] = {}
    for name in known:
        if name.is_place:
            by_stem.setdefault(name.stem, {}).setdefault(name.axis, []).append(name)
    pairs = [(found["x"], found["y"]) for found in by_stem.values() if len(found) == 2]
    if not pairs:
        other = {name.axis: name.column for name in known if name.names_place}
        if len(other) == 2 and other["x"].unit not in ("", *LENGTH_UNITS):
            raise _unknown_unit({axis: other[axis] for axis in "xy"})
        missing = [axis for axis in "xy" if not any(axis in found for found in by_stem.values())]
        names = [name.column.name for name in known]
        raise no_column(missing[0] if missing else "y", names)
    best = min(_rank(xs[0]) for xs, _ in pairs)
    likely = [(xs, ys) for xs, ys in pairs if _rank(xs[0]) == best]
    if best == 0:
        # Plain x and y are hardly another thing's, unless other names claim the robot's.
        likely += [(xs, ys) for xs, ys in pairs if 0 < _rank(xs[0]) < 3 and xs[0].has(_OWNERS)]
    # The message names three pairs at most, and there are as many as columns squared.
    every = list(islice(((x, y) for xs, ys in likely for x in xs for y in ys), 3))
    if len(every) > 1:
        xs = label_columns([x.column for x, _ in every])
        ys = label_columns([y.column for _, y in every])
        shown = [f"columns {x} and {y}" for x, y in zip(xs, ys, strict=True)]
        first, second = (f"x={x},y={y}" for x, y in zip(xs[:2], ys[:2], strict=True))
        raise ambiguous(f"the positions may be in {' or in '.join(shown)}", (first, second))
    x, y = every[0]
    if x.has(_NOT_ROBOTS):
        raise FormatError(
            "ambiguous-columns",
            "the only positions, {x!q} and {y!q}, are hardly the robot's",
            "if they are, choose them with --columns {way}",
            at_terminal=True,
            x=x.column.name,
            y=y.column.name,
            needs=[f"--columns=x={x.column.name},y={y.column.name}"],
            way=f"x={x.column.name},y={y.column.name}",
        )
    return x, y


def _rank(name: Name) -> int:
    """Return how likely it is that a column holds the robot's position; 0 is the likeliest."""
    if name.stem == ("*",):
        return 0
    if name.has(_OTHERS):
        return 3
    return 1 if name.has(_POSITIONS) else 2


def _times(known: Sequence[Name]) -> list[dict[str, Column]]:
    """Return the columns that may be the times, the likeliest first, seconds with nanoseconds."""
    found: list[dict[str, Column]] = []
    taken: set[int] = set()
    times = [name for name in known if name.is_time]
    if not times:
        for name in known:
            if name.names_time:
                raise _unknown_unit({"t": name.column})
    nanoseconds: dict[tuple[str, ...], Column] = {}
    for name in times:
        if TIME_UNITS.get(name.column.unit) == 1e-9:
            nanoseconds.setdefault(name.words, name.column)
    for name in times:
        if name.column.place in taken:
            continue
        own = {"t": name.column}
        # A stamp's seconds and nanoseconds have the same name but for the unit.
        if TIME_UNITS.get(name.column.unit) == 1.0 and name.words in nanoseconds:
            own["nanosec"] = nanoseconds[name.words]
            taken.add(own["nanosec"].place)
        found.append(own)
    kept = [own for own in found if "nanosec" in own or own["t"].place not in taken]
    return sorted(kept, key=lambda own: not is_sure(own["t"]))


def _heading(known: Sequence[Name], x: Name) -> dict[str, Column]:
    """Return the columns of the heading that belongs to a position: an angle or a quaternion."""

    def shared(words: Iterable[str]) -> int:
        return len(set(words) & set(x.words))

    angles = [name for name in known if name.is_heading and not name.has(_OTHERS)]
    if angles:

        def order(name: Name) -> tuple[int, int]:
            first = min(_HEADINGS.index(word) for word in name.words if word in _HEADINGS)
            return -shared(name.words), first

        return {"yaw": min(angles, key=order).column}
    rotations: dict[tuple[str, ...], dict[str, Column]] = {}
    for name in known:
        if name.is_rotation:
            rotations.setdefault(name.stem, {})[f"q{name.axis}"] = name.column
    complete = {stem: own for stem, own in rotations.items() if own.keys() >= {"qz", "qw"}}
    if not complete:
        return {}
    return complete[max(complete, key=lambda stem: (not set(stem) & _OTHERS, shared(stem)))]


def label_columns(columns: Sequence[Column]) -> list[str]:
    """Return what ``--columns`` calls columns: of several with a name, only the number tells which."""
    places: dict[str, set[int]] = {}
    for column in columns:
        places.setdefault(column.name.lower(), set()).add(column.place)
    return [
        column.name if len(places[column.name.lower()]) == 1 else str(column.place + 1)
        for column in columns
    ]


def _unknown_unit(columns: Mapping[str, Column]) -> FormatError:
    """Return the error for columns, by quantity, of which the first has a unit that isn't read."""
    quantity, column = next(iter(columns.items()))
    factors = {factor: unit for unit, factor in reversed(list(_UNITS[quantity].items()))}
    known = list(reversed(factors.values()))
    ways = (f"{name}={own.place + 1}:{known[0]}" for name, own in columns.items())
    return FormatError(
        "unknown-unit",
        "column {name!q} has the unit {unit!r}, which is not read; those of {quantity} are {known!l}",
        "convert the numbers and the name, or say which unit it is, as in --columns {way}",
        at_terminal=True,
        name=column.name,
        unit=column.unit,
        quantity=quantity,
        known=known,
        way=",".join(ways),
    )


def no_column(axis: str, names: Sequence[str]) -> FormatError:
    """Return the error for a header without positions."""
    return FormatError(
        "columns-missing",
        "the header ({shown}) has no column {axis!r}",
        "name columns t, x and y, or only x and y for a plan without times, or say which they are, as "
        "in --columns t=stamp,x=east,y=north",
        at_terminal=True,
        shown=", ".join(names)[:80],
        axis=axis,
    )


def ambiguous(problem: str, ways: tuple[str, str]) -> FormatError:
    """Return the error for columns that can be understood in several ways.

    Args:
        problem: The ways in words.
        ways: Two values of ``--columns`` that choose among them.
    """
    return FormatError(
        "ambiguous-columns",
        "{problem}",
        "choose with --columns {way} or --columns {other}",
        at_terminal=True,
        problem=problem,
        needs=[f"--columns={ways[0]}"],
        way=ways[0],
        other=ways[1],
    )


def is_frame(name: str) -> bool:
    """Return True if a column holds the names of frames, such as ``field.header.frame_id``."""
    return Name.of(0, name).words[-2:] == ("frame", "id")


def is_sure(column: Column) -> bool:
    """Return True if no other column of times can be meant: our own t, or a message's stamp.

    A stamp says when the pose was measured; another column, when the message was received.
    """
    words = Name.of(column.place, column.name).words
    return words == ("t",) or {"header", "stamp"} <= set(words)
