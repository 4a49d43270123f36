"""Bring the numbers of a log to s, m and rad, by the units in its names or by their size."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from worldgen.errors import FormatError
from worldgen.logs.columns import ANGLE_UNITS, LENGTH_UNITS, TIME_UNITS, Column, ambiguous
from worldgen.support.arrays import Floats, Ints

# s since 1970: dates of logs are between 1973 and 2128, so their size says their unit.
_DATES = (1e8, 5e9)
# Units of times that aren't dates, by the usual distance of two samples in them. Seconds come
# first: up to 10 s between samples are usual.
_PERIODS = (("s", 10.0), ("ms", 1e4), ("us", 1e7), ("ns", 1e11))
# m/s. In these ranges of its speed by seconds, a robot was surely logged in seconds, or surely in
# milliseconds: it would otherwise drive faster than 50 m/s, or slower than 2 cm/s.
_IN_SECONDS = 0.05
_IN_MILLISECONDS = (5e-5, 0.02)
# ms between samples from which on they may be in milliseconds: a robot is hardly logged more often.
_OFTEN = 1.0
# How well headings fit the directions of the moves if they are headings: 0.64 by chance, 1 at best.
_FITS = 0.9
# Parts of a quaternion below this are 0, and robots that lie in more of their samples lie.
_FLAT = 0.05
_SOME = 0.1
# What is lost of a perfect fit if headings are 8 degrees off.
_OFF = 0.01
# Degrees, and rad that a heading turns at least if its moves tell from where it counts.
_WHOLE = 360.0
_TURNING = 0.1
# Our own column, which is in rad unless all tells otherwise; other names are asked about.
_OURS = "heading"


def seconds(
    times: Floats, rest: Floats | None, column: Column, x: Floats, y: Floats, rows: Ints
) -> tuple[Floats, str, float]:
    """Return times in seconds, their unit, and the date, s since 1970, that they count from.

    Times that are dates count from the first one, because a world begins at 0 s.

    Args:
        times: (n,) as they are in the file.
        rest: (n,) nanoseconds to add, if they have a column of their own.
        column: The column's name and unit.
        x: (n,) m, positions at these times.
        y: (n,) m.
        rows: (k,) the samples of one robot.

    Raises:
        FormatError: If nobody can tell which unit they are in.
    """
    if not len(rows) or not np.isfinite(times).all():
        return times, column.unit or "s", 0.0
    own = times[rows]
    unit = column.unit if column.unit in TIME_UNITS else _unit_of(own, column, x[rows], y[rows])
    factor = TIME_UNITS[unit]
    first = float(times[0]) if _is_date(float(times[0]) * factor) else 0.0
    # Subtract first: a float64 has a date to a quarter of a microsecond.
    counted = times - first if first else times
    counted = counted * factor if factor != 1.0 else counted
    date = first * factor
    if rest is not None:
        begin = float(rest[0]) if first else 0.0
        counted = counted + (rest - begin) * 1e-9
        date += begin * 1e-9
    return counted, _plain(unit), date


def _plain(unit: str) -> str:
    return next(name for name in ("s", "ms", "us", "ns") if TIME_UNITS[name] == TIME_UNITS[unit])


def is_date(time: float) -> bool:
    """Return True if a number is a date in one of the units of times: after 1973."""
    return any(_is_date(time * factor) for factor in (1.0, 1e-3, 1e-6, 1e-9))


def _is_date(time: float) -> bool:
    return _DATES[0] <= time < _DATES[1]


def _unit_of(times: Floats, column: Column, x: Floats, y: Floats) -> str:
    """Return the unit of times whose column names none."""
    steps = np.diff(times)
    steps = steps[steps > 0.0]
    period = float(np.median(steps)) if len(steps) else 0.0
    for unit, _ in _PERIODS:
        if _is_date(float(times[0]) * TIME_UNITS[unit]) and period * TIME_UNITS[unit] < 1e5:
            return unit
    if period < _OFTEN:
        return "s"
    unit = next((unit for unit, most in _PERIODS if period < most), "ns")
    speed = float(np.hypot(np.diff(x), np.diff(y)).sum()) / float(steps.sum())
    if not 0.0 < speed < _IN_SECONDS:
        return "s"
    if unit in ("s", "ms") and speed < _IN_MILLISECONDS[0]:
        return "s"
    if unit == "s" and speed >= _IN_MILLISECONDS[1]:
        return "s"
    # People write fractions of seconds, and whole numbers of anything smaller.
    is_whole = bool((times == np.floor(times)).all())
    if is_whole and unit != "s" and (unit != "ms" or speed < _IN_MILLISECONDS[1]):
        return unit
    other = "ms" if unit == "s" else unit
    faster = speed / TIME_UNITS[other]
    raise ambiguous(
        f"{column.name} may be in s, {speed:.2g} m/s on average, or in {other}, {faster:.2g} m/s",
        (f"t={column.name}:{other}", f"t={column.name}:s"),
    )


def metres(values: Floats, column: Column) -> Floats:
    """Return positions in metres."""
    factor = LENGTH_UNITS.get(column.unit, 1.0)
    return values if factor == 1.0 else values * factor


def headings(
    values: Mapping[str, Floats],
    places: Mapping[str, Column],
    x: Floats,
    y: Floats,
    robots: Sequence[Ints],
) -> tuple[Floats, str]:
    """Return headings in rad, counter-clockwise from the x axis.

    Args:
        values: (n,) by quantity: ``yaw``, or ``qz``, ``qw`` and perhaps ``qx`` and ``qy``.
        places: The columns that they are from.
        x: (n,) m, positions.
        y: (n,) m.
        robots: (k,) the samples of each robot.

    Raises:
        FormatError: If nobody can tell whether they are in rad.

    Returns:
        (n,) rad, nan where a quaternion is 0, and a remark if they were not in rad or not counted
        from the x axis; empty otherwise.
    """
    if "yaw" in values:
        yaw = values["yaw"]
        # The robot that turned furthest tells most.
        rows = max(robots, key=lambda own: np.abs(yaw[own]).max(initial=0.0))
        factor, offset, remark = _conversion(yaw[rows], places["yaw"], x[rows], y[rows])
        return yaw * factor + offset, remark
    zero = np.zeros(len(x))
    qx, qy, qz, qw = (values.get(name, zero) for name in ("qx", "qy", "qz", "qw"))
    remark = ""
    if _lies(qx, qy, qz, qw):
        remark = (
            "the quaternions say that the robot lies on its side or its back, as a camera may; its "
            "heading is where its x axis points, seen from above"
        )
    turned = np.arctan2(2.0 * (qw * qz + qx * qy), qw**2 + qx**2 - qy**2 - qz**2)
    return np.where(qx**2 + qy**2 + qz**2 + qw**2 > 0.0, turned, np.nan), remark


def check_order(values: Mapping[str, Floats], places: Mapping[str, Column]) -> None:
    """Refuse quaternions that are x, y, z, w only by their places, if w, x, y, z is as likely.

    Args:
        values: (n,) by quantity: ``qx``, ``qy``, ``qz`` and ``qw``.
        places: The columns that they are from.

    Raises:
        FormatError: If nobody can tell which they are.
    """
    order = ("qx", "qy", "qz", "qw")
    qx, qy, qz, qw = (values[name] for name in order)
    # Robots on a floor turn about z only, so the two parts in the middle are 0 in the other order.
    is_other = max(np.abs(part).max(initial=0.0) for part in (qy, qz)) < _FLAT
    if not (is_other and np.abs(qx).max(initial=0.0) > _FLAT) and not _lies(qx, qy, qz, qw):
        return
    numbers = [places[name].place + 1 for name in order]
    ways = [
        ",".join(f"{name}={number}" for name, number in zip(names, numbers, strict=True))
        for names in (("qw", "qx", "qy", "qz"), order)
    ]
    raise ambiguous(
        f"the quaternions in columns {numbers[0]} to {numbers[-1]} may be w, x, y, z, or x, y, z, w of "
        "a robot that lies on its side or its back",
        (ways[0], ways[1]),
    )


def _lies(qx: Floats, qy: Floats, qz: Floats, qw: Floats) -> bool:
    """Return True if a robot's z axis is more than 60 degrees off the vertical in some samples."""
    size = qx**2 + qy**2 + qz**2 + qw**2
    upright = size - 2.0 * (qx**2 + qy**2)
    lying = (size > 0.0) & (upright < 0.5 * size)
    return bool(np.count_nonzero(lying) > _SOME * len(qx))


def _conversion(yaw: Floats, column: Column, x: Floats, y: Floats) -> tuple[float, float, str]:
    """Return what headings are times, and then plus, to be in rad from the x axis, and a remark.

    The directions of the moves tell what isn't said about them.

    Raises:
        FormatError: If nobody can tell whether they are in rad.
    """
    remark = ""
    if column.unit:
        is_degrees = ANGLE_UNITS[column.unit] != 1.0
    else:
        is_degrees, remark = _are_degrees(yaw, column, x, y)
    remark = f"{column.name} in degrees" if is_degrees else remark
    factor = ANGLE_UNITS["deg"] if is_degrees else 1.0
    yaw = yaw * factor
    if _fit(yaw, x, y) >= _FITS:
        return factor, 0.0, remark
    # Race lines of the Technical University of Munich count psi from the y axis.
    if "psi" in column.name.lower() and _fit(yaw + math.pi / 2.0, x, y) >= _FITS:
        return factor, math.pi / 2.0, f"{column.name} counted from the y axis"
    if _range(yaw) > _TURNING and _fit(math.pi / 2.0 - yaw, x, y) >= _FITS:
        compass = (
            f"{column.name} fits the moves as a compass's, clockwise from the y axis; it was read "
            "counter-clockwise from the x axis: convert it if it is a compass's"
        )
        remark = f"{remark}; {compass}" if remark else compass
    return factor, 0.0, remark


def _range(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if len(known) else 0.0


def _are_degrees(yaw: Floats, column: Column, x: Floats, y: Floats) -> tuple[bool, str]:
    """Return True if angles without a unit are in degrees, and a remark if they may be.

    Raises:
        FormatError: If nobody can tell.
    """
    known = yaw[np.isfinite(yaw)]
    if not len(known):
        return False, ""
    in_degrees = f"choose --columns yaw={column.name}:deg if it is in degrees"
    largest = float(np.abs(known).max())
    radians, degrees = _fit(yaw, x, y), _fit(yaw * ANGLE_UNITS["deg"], x, y)
    if largest <= 2.0 * math.pi:
        # Degrees are as small on a drive almost along the x axis.
        if degrees < _FITS or 1.0 - radians <= max(_OFF, 4.0 * (1.0 - degrees)):
            return False, ""
        if column.name.lower() == _OURS:
            return False, f"{column.name} in rad, although degrees fit the moves; {in_degrees}"
        raise _either(column)

    # Larger ones are rad only if they were counted on for several turns.
    steps = np.abs(np.diff(known))
    furthest = float(steps.max(initial=0.0))
    is_counted = abs(float(known[0])) <= 2.0 * math.pi and furthest <= math.pi
    if degrees >= _FITS and degrees > radians:
        return True, ""
    # Headings that never change fit by chance.
    if radians >= _FITS and (is_counted or (degrees < _FITS and _range(yaw) > _TURNING)):
        return False, ""
    if largest <= _WHOLE and furthest >= 0.5 * _WHOLE:
        return True, ""
    if is_counted and column.name.lower() == _OURS:
        return False, f"{column.name} in rad, counted on for several turns; {in_degrees}"
    raise _either(column)


def _either(column: Column) -> FormatError:
    return ambiguous(
        f"{column.name} may be in rad or in degrees",
        (f"yaw={column.name}:deg", f"yaw={column.name}:rad"),
    )


def _fit(yaw: Floats, x: Floats, y: Floats) -> float:
    """Return how well headings are the directions of the moves, forwards or backwards, 1 at best."""
    dx, dy = np.diff(x), np.diff(y)
    moves = (np.hypot(dx, dy) > 1e-6) & np.isfinite(yaw[:-1])
    if not moves.any():
        return 0.0
    return float(np.mean(np.abs(np.cos(np.arctan2(dy[moves], dx[moves]) - yaw[:-1][moves]))))
