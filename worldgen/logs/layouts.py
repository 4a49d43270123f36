"""Tables without a header: those whose columns follow from their number and their kinds.

Source: the trajectory format of the RGB-D benchmark of the Technical University of Munich, and the
definitions of ROS 2's messages, whose fields ``ros2 topic echo --csv`` prints in order.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from worldgen.errors import FormatError
from worldgen.logs.columns import Column, ambiguous
from worldgen.logs.table import number_of
from worldgen.logs.units import is_date

_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_STAMP = ("sec", "nanosec", "frame")
_NAMES = {"sec": "t", "psi": "yaw"}
# Race lines count headings from the x or the y axis, so these keep their name.
_LABELS = {"psi": "psi"}
_ECHO = "ros2 topic echo --csv of"
_NUMBERED = re.compile(r"poses\[?\d+\]?\.pose\.(position|orientation)\.([xyzw])$")
_PREFIX = {"position": "", "orientation": "q"}
_TEXTS = ("frame", "child", "array")
# Shares by which a race line's numbers may differ from what its points say.
_ROUNDED = 0.02


@dataclass(frozen=True)
class Layout:
    """What the columns of a table without a header are.

    Args:
        name: As users call such files.
        fields: A quantity of :data:`~worldgen.logs.columns.QUANTITIES` for each column, ``frame``
            and ``child`` for names of frames, ``array`` for an array that was left out, and any
            other word for a number that doesn't count.
        is_path: True if each line is a message with all poses of a path.
    """

    name: str
    fields: tuple[str, ...]
    is_path: bool = False

    def fits(self, fields: Sequence[str]) -> bool:
        """Return True if a line can be one of this table."""
        if len(fields) != len(self.fields):
            return False
        numbers = list(map(number_of, fields))
        is_text = [kind in _TEXTS for kind in self.fields]
        if [number is None for number in numbers] != is_text:
            return False
        turns = [
            math.hypot(*(numbers[at + part] or 0.0 for part in range(4)))
            for at, kind in enumerate(self.fields)
            if kind == "qx"
        ]
        # Messages without a heading have a quaternion of zeros.
        allowed = (1.0, 0.0) if any(is_text) else (1.0,)
        return all(any(abs(turn - length) < 0.01 for length in allowed) for turn in turns)

    @property
    def is_message(self) -> bool:
        """True if ROS wrote it, which always puts the parts of a quaternion in the same order."""
        return self.name.startswith(_ECHO)

    @property
    def frames(self) -> list[int]:
        """The places of the names of frames, of which a log has only one each."""
        return [at for at, kind in enumerate(self.fields) if kind in ("frame", "child")]

    @property
    def columns(self) -> dict[str, Column]:
        """The columns by quantity."""
        units = {"sec": "s", "nanosec": "ns", "t": "", "psi": "rad"}
        return {
            _NAMES.get(kind, kind): Column(
                place, _LABELS.get(kind, str(place + 1)), units.get(kind, "m")
            )
            for place, kind in enumerate(self.fields)
            if kind in ("t", "sec", "nanosec", "x", "y", "psi", "qx", "qy", "qz", "qw")
        }


def _csv(message: str, fields: Sequence[str]) -> Layout:
    return Layout(f"{_ECHO} {message}", tuple(fields))


def _layouts() -> tuple[Layout, ...]:
    covariance = ("",) * 36
    twist = ("",) * 6
    found = [
        Layout("TUM", ("t", *_POSE)),
        Layout("poses", _POSE),
        Layout("x y", ("x", "y")),
        _csv("PoseStamped", (*_STAMP, *_POSE)),
        _csv("TransformStamped", (*_STAMP, "child", *_POSE)),
        _csv("PointStamped", (*_STAMP, "x", "y", "z")),
    ]
    # `--no-arr` prints a word instead of each array.
    for array in (covariance, ("array",)):
        found += [
            _csv("PoseWithCovarianceStamped", (*_STAMP, *_POSE, *array)),
            _csv("Odometry", (*_STAMP, "child", *_POSE, *array, *twist, *array)),
            _csv("PoseWithCovariance", (*_POSE, *array)),
        ]
    return tuple(found)


LAYOUTS = _layouts()


def layout_of(rows: Sequence[Sequence[str]]) -> Layout | None:
    """Return the layout of a table without a header by some of its lines, or None.

    Raises:
        FormatError: If it is a path that was cut short.
    """
    for layout in LAYOUTS:
        if all(map(layout.fits, rows)):
            return layout
    if all(len(row) == 3 and is_date(number_of(row[0]) or 0.0) for row in rows):
        return Layout("t x y", ("t", "x", "y"))
    if _is_race_line(rows):
        return Layout(
            "a race line (s; x; y; psi; kappa; vx; ax)", ("", "x", "y", "psi", "", "", "")
        )
    return path_of(rows[-1])


def _is_race_line(rows: Sequence[Sequence[str]]) -> bool:
    """Return True if lines are s, x, y, psi, kappa, vx and ax, because their numbers say so.

    s is the distance along the points, and ax the change of vx over it. At 1 m/s s could also be the
    time.

    Source: A. Heilmeier et al., "Minimum curvature trajectory planning and control for an
        autonomous race car", Vehicle System Dynamics, 2019, whose program writes such files.
    """
    numbers = [[number_of(field) for field in row] for row in rows]
    if len(rows) < 3 or any(len(row) != 7 or None in row for row in numbers):
        return False
    lines: list[list[float]] = [[value or 0.0 for value in row] for row in numbers]
    for (s, x, y, _, _, v, a), (s2, x2, y2, _, _, v2, _) in itertools.pairwise(lines):
        length = s2 - s
        gained = 0.5 * (v2 * v2 - v * v)
        if not (
            length > 0.0
            and abs(math.hypot(x2 - x, y2 - y) - length) <= _ROUNDED * length
            and abs(a * length - gained) <= _ROUNDED * max(abs(gained), v * v)
        ):
            return False
    return lines[0][0] == 0.0 and all(abs(row[5] - 1.0) > _ROUNDED for row in lines)


def path_of(fields: Sequence[str]) -> Layout | None:
    """Return the layout of a path, which has any number of poses, each with a stamp, or None.

    Raises:
        FormatError: If it was cut short.
    """
    poses, rest = divmod(len(fields) - len(_STAMP), len(_STAMP) + len(_POSE))
    if list(fields[-1:]) == ["..."] and rest == 1:
        raise FormatError(
            "line-too-short",
            "ros2 topic echo cut the path after {poses} poses",
            "print it again with --full-length",
            at_terminal=True,
            poses=poses,
        )
    if poses < 1 or rest:
        return None
    path = Layout(f"{_ECHO} Path", _STAMP + (_STAMP + _POSE) * poses, is_path=True)
    return path if path.fits(fields) else None


def named_path(names: Sequence[str]) -> Layout | None:
    """Return the layout of a table whose lines are paths, by the names of its columns, or None.

    ``rostopic echo -p`` numbers the poses: ``field.poses0.pose.position.x``.
    """
    parts = [_NUMBERED.search(name) for name in names]
    fields = tuple(f"{_PREFIX[part[1]]}{part[2]}" if part else "" for part in parts)
    return (
        Layout("rostopic echo -p of Path", fields, is_path=True) if fields.count("x") > 1 else None
    )


def unknown_layout(count: int, line: int) -> FormatError:
    """Return the error for a table without a header whose columns may be several things."""
    problem = f"there is no header, and {count} columns may be anything"
    ways = {
        3: ("t=1,x=2,y=3", "x=1,y=2,yaw=3"),
        4: ("t=1,x=2,y=3,yaw=4", "x=1,y=2,yaw=3"),
        12: ("x=4,y=8", "x=4,y=12"),  # rows of matrices, the second with y down
    }.get(count)
    if ways is not None:
        error = ambiguous(problem, ways)
    else:
        error = FormatError(
            "ambiguous-columns",
            "{problem}",
            "count them from 1 and say which they are, as in --columns t=1,x=2,y=3",
            at_terminal=True,
            problem=problem,
        )
    error.line = line
    return error
