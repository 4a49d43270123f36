"""Bring the numbers of a log to s, m and rad, by the units in its names or by their size."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

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
# How well headings fit the directions of the moves if they are headings: 0.64 by chance, 1 at best.
_FITS = 0.9
# Columns that are in rad unless all tells otherwise: our own names.
_OURS = ("heading", "yaw", "theta")


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
    # People write fractions of seconds, and whole numbers of anything smaller.
    if not period or not (times == np.floor(times)).all():
        return "s"
    unit = next((unit for unit, most in _PERIODS if period < most), "ns")
    speed = float(np.hypot(np.diff(x), np.diff(y)).sum()) / float(steps.sum())
    if unit == "s" or speed >= _IN_SECONDS or not speed:
        return "s"
    if unit != "ms" or _IN_MILLISECONDS[0] <= speed < _IN_MILLISECONDS[1]:
        return unit
    if speed < _IN_MILLISECONDS[0]:
        return "s"
    raise ambiguous(
        f"{column.name} may be in s, {speed:.2g} m/s on average, or in ms, {1000 * speed:.2g} m/s",
        (f"t={column.name}:ms", f"t={column.name}:s"),
    )


def metres(values: Floats, column: Column) -> Floats:
    """Return positions in metres."""
    factor = LENGTH_UNITS.get(column.unit, 1.0)
    return values if factor == 1.0 else values * factor


def headings(
    values: Mapping[str, Floats], places: Mapping[str, Column], x: Floats, y: Floats
) -> tuple[Floats, str]:
    """Return headings in rad, counter-clockwise from the x axis.

    Args:
        values: (n,) by quantity: ``yaw``, or ``qz``, ``qw`` and perhaps ``qx`` and ``qy``.
        places: The columns that they are from.
        x: (n,) m, positions.
        y: (n,) m.

    Raises:
        FormatError: If nobody can tell whether they are in rad.

    Returns:
        (n,) rad, nan where a quaternion is 0, and a remark if they were not in rad or not counted
        from the x axis; empty otherwise.
    """
    if "yaw" in values:
        return _angles(values["yaw"], places["yaw"], x, y)
    zero = np.zeros(len(x))
    qx, qy, qz, qw = (values.get(name, zero) for name in ("qx", "qy", "qz", "qw"))
    turned = np.arctan2(2.0 * (qw * qz + qx * qy), qw**2 + qx**2 - qy**2 - qz**2)
    return np.where(qx**2 + qy**2 + qz**2 + qw**2 > 0.0, turned, np.nan), ""


def _angles(yaw: Floats, column: Column, x: Floats, y: Floats) -> tuple[Floats, str]:
    """Return headings in rad. The directions of the moves tell what isn't said about them.

    Raises:
        FormatError: If nobody can tell whether they are in rad.
    """
    degrees = yaw * ANGLE_UNITS["deg"]
    if column.unit:
        is_degrees = ANGLE_UNITS[column.unit] != 1.0
    else:
        # Small numbers are rad; larger ones may be rad, too, that were counted on for several turns.
        is_large = bool(np.nanmax(np.abs(yaw), initial=0.0) > 2.0 * math.pi)
        in_radians = is_large and _fit(yaw, x, y) >= _FITS
        is_degrees = is_large and not in_radians and _fit(degrees, x, y) >= _FITS
        if is_large and not in_radians and not is_degrees and column.name.lower() not in _OURS:
            raise ambiguous(
                f"{column.name} may be in rad or in degrees",
                (f"yaw={column.name}:deg", f"yaw={column.name}:rad"),
            )
    remark = f"{column.name} in degrees" if is_degrees else ""
    yaw = degrees if is_degrees else yaw
    # Race lines of the Technical University of Munich count psi from the y axis.
    if "psi" in column.name.lower():
        turned = yaw + math.pi / 2.0
        if _fit(yaw, x, y) < _FITS <= _fit(turned, x, y):
            return turned, f"{column.name} counted from the y axis"
    return yaw, remark


def _fit(yaw: Floats, x: Floats, y: Floats) -> float:
    """Return how well headings are the directions of the moves, forwards or backwards, 1 at best."""
    dx, dy = np.diff(x), np.diff(y)
    moves = (np.hypot(dx, dy) > 1e-6) & np.isfinite(yaw[:-1])
    if not moves.any():
        return 0.0
    return float(np.mean(np.abs(np.cos(np.arctan2(dy[moves], dx[moves]) - yaw[:-1][moves]))))
