"""Poses in Gazebo's files, and the frames that they refer to.

Upright poses stay exact, so that walls along the axes fall on the lines of cells; tilted ones are in
floating point.

Source: the SDFormat specification 1.12, "Pose Frame Semantics".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from worldgen.domain import DECIMAL
from worldgen.errors import FormatError
from worldgen.interop.format import radians
from worldgen.interop.readers.xml_tree import XmlElement
from worldgen.support.arrays import Floats

Turn = tuple[tuple[float, float, float], ...]
Place = tuple[Fraction, Fraction, Fraction]

# Tolerance, rad; a body that rolls or pitches more is not upright.
_FLAT = 1e-6
# Tolerance, rad; people write 1.5708.
_NEAR_QUARTER = 1e-4
# Beyond this, m or rad, a float cannot tell cells apart.
_FURTHEST = 10**9
_AXES = range(3)


@dataclass(frozen=True)
class BodyPose:
    """A body's position and rotation.

    Args:
        x, y, z: m.
        yaw: rad, about z.
        tilt: The whole rotation as a matrix, if it is more than a yaw.
    """

    x: Fraction = Fraction(0)
    y: Fraction = Fraction(0)
    z: Fraction = Fraction(0)
    yaw: Fraction = Fraction(0)
    tilt: Turn | None = None

    @classmethod
    def of(cls, place: Place, turn: Turn) -> BodyPose:
        """Return a pose with this rotation; it is upright if the rotation is."""
        if turn[2][2] > 1 - _FLAT**2:
            return cls(*place, yaw=Fraction(math.atan2(turn[1][0], turn[0][0])))
        return cls(*place, tilt=turn)

    @classmethod
    def about(cls, place: Place, axis: tuple[float, float, float], angle: Fraction) -> BodyPose:
        """Return a pose turned about an axis, whose length does not matter unless it is 0."""
        x, y, z = (part / math.hypot(*axis) for part in axis)
        if math.hypot(x, y) < _FLAT:
            return cls(*place, yaw=angle if z > 0 else -angle)
        cos, sin = _cos_sin(float(angle))
        rest = 1 - cos
        turn = (
            (cos + rest * x * x, rest * x * y - sin * z, rest * x * z + sin * y),
            (rest * x * y + sin * z, cos + rest * y * y, rest * y * z - sin * x),
            (rest * x * z - sin * y, rest * y * z + sin * x, cos + rest * z * z),
        )
        return cls.of(place, turn)

    @property
    def turn(self) -> Turn:
        """The rotation as a matrix."""
        return self.tilt or _product("z", float(self.yaw))

    @property
    def place(self) -> Place:
        """The position, m."""
        return self.x, self.y, self.z

    def then(self, inner: BodyPose) -> BodyPose:
        """Chain this pose with one given in its frame."""
        if self.tilt is None and inner.tilt is None:
            cos, sin = map(Fraction, _cos_sin(float(self.yaw)))
            x = cos * inner.x - sin * inner.y
            y = sin * inner.x + cos * inner.y
            if cos and sin:
                # Digits beyond a float's would only grow from pose to pose.
                x, y = Fraction(float(x)), Fraction(float(y))
            return BodyPose(self.x + x, self.y + y, self.z + inner.z, self.yaw + inner.yaw)
        moved_by = [_along(row, inner.place) for row in self.turn]
        x, y, z = (a + Fraction(b) for a, b in zip(self.place, moved_by, strict=True))
        return BodyPose.of((x, y, z), _chained(self.turn, inner.turn))

    def inverse(self) -> BodyPose:
        """Return the pose that undoes this one."""
        back = tuple(zip(*self.turn, strict=True))
        if self.tilt is None:
            return BodyPose(yaw=-self.yaw).then(BodyPose(-self.x, -self.y, -self.z))
        x, y, z = (Fraction(-_along(row, self.place)) for row in back)
        return BodyPose.of((x, y, z), back)

    def moved(self, points: Floats) -> Floats:
        """Return points of the body, (n, 3), m, where the pose puts them."""
        # Each product is rounded, and then the sum, so that every machine gets the same bits.
        turn = np.array(self.turn)
        place = np.array([float(value) for value in self.place])
        moved: Floats = sum(points[:, [axis]] * turn[:, axis] for axis in _AXES) + place
        return moved


def _product(axes: str, *angles: float) -> Turn:
    """Return the rotation about these axes, the last one first."""
    whole: Turn = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for axis, angle in zip(axes, angles, strict=True):
        cos, sin = _cos_sin(angle)
        about: dict[str, Turn] = {
            "x": ((1.0, 0.0, 0.0), (0.0, cos, -sin), (0.0, sin, cos)),
            "y": ((cos, 0.0, sin), (0.0, 1.0, 0.0), (-sin, 0.0, cos)),
            "z": ((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)),
        }
        whole = _chained(whole, about[axis])
    return whole


def _cos_sin(angle: float) -> tuple[float, float]:
    """Return cosine and sine, of an angle near a quarter turn those of the quarter turn."""
    quarters = round(angle / (math.pi / 2))
    if abs(angle - quarters * math.pi / 2) < _NEAR_QUARTER:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarters % 4]
    return math.cos(angle), math.sin(angle)


def _chained(one: Turn, other: Turn) -> Turn:
    columns = tuple(zip(*other, strict=True))
    return tuple(
        (_along(row, columns[0]), _along(row, columns[1]), _along(row, columns[2])) for row in one
    )


def _along(one: Sequence[float | Fraction], other: Sequence[float | Fraction]) -> float:
    return sum(float(a) * float(b) for a, b in zip(one, other, strict=True))


def numbers(element: XmlElement, count: int) -> list[Fraction]:
    """Return the numbers of an element.

    Raises:
        FormatError: If there are more or fewer, or one is not a number of a usual size.
    """
    words = element.text.split()
    if any("${" in word or "$(" in word for word in words):
        raise FormatError(
            "unsupported",
            "{name} is an expression of xacro: {text!q}",
            "run `xacro` on the file first, and import what it prints",
            name=f"<{element.name}>",
            text=element.text.strip()[:80],
            line=element.line,
        )
    if len(words) != count or not all(map(DECIMAL.fullmatch, words)):
        raise _wrong_numbers(element, "wrong-count", "it has {count} numbers", count=count)
    found = [Fraction(word) for word in words]
    if any(abs(value) > _FURTHEST for value in found):
        rule = "its numbers are at most {most:g}"
        raise _wrong_numbers(element, "out-of-range", rule, most=_FURTHEST)
    return found


def _wrong_numbers(element: XmlElement, code: str, rule: str, **facts: Any) -> FormatError:
    return FormatError(
        code,
        "{name} is {text!q}",
        rule,
        name=f"<{element.name}>",
        text=element.text.strip()[:80],
        line=element.line,
        **facts,
    )


def own_pose(element: XmlElement) -> tuple[BodyPose, str, int]:
    """Return the pose in an element, the name of the frame that it is in, if any, and its line."""
    found = element.first("pose")
    if found is None:
        return BodyPose(), "", element.line
    frame = found.attributes.get("relative_to", "") or found.attributes.get("frame", "")
    return _read(found), frame, found.line


def _read(pose: XmlElement) -> BodyPose:
    style = pose.attributes.get("rotation_format", "euler_rpy")
    in_degrees = pose.attributes.get("degrees", "false").strip() in ("true", "1")
    if style == "quat_xyzw":
        x, y, z, *quaternion = numbers(pose, 7)
        return BodyPose.of((x, y, z), _of_quaternion([float(q) for q in quaternion], pose))
    if style != "euler_rpy":
        raise FormatError(
            "unsupported",
            "a pose in the rotation format {style!q}",
            "use euler_rpy or quat_xyzw",
            style=style,
            line=pose.line,
        )
    # An empty pose is the identity in Gazebo too.
    x, y, z, *angles = numbers(pose, 6) if pose.text.strip() else [Fraction(0)] * 6
    if in_degrees:
        angles = [Fraction(radians(angle)) for angle in angles]
    roll, pitch, yaw = (float(angle) for angle in angles)
    if all(abs(math.sin(angle)) < _FLAT and math.cos(angle) > 0 for angle in (roll, pitch)):
        return BodyPose(x, y, z, angles[2])
    return BodyPose.of((x, y, z), _product("zyx", yaw, pitch, roll))


def _of_quaternion(quaternion: list[float], pose: XmlElement) -> Turn:
    length = math.sqrt(sum(part * part for part in quaternion))
    if length < _FLAT:
        raise FormatError("out-of-range", "a quaternion of length 0", "use 0 0 0 1", line=pose.line)
    x, y, z, w = (part / length for part in quaternion)
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
