"""Store start, target and robot as words, in files that have room for words.

The words are keys of a table, a picture's text, or properties.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from worldgen.domain import DECIMAL
from worldgen.errors import InvalidParameter
from worldgen.interop.format import Destination, decimal, robot_kinds
from worldgen.interop.format.foreign_map import ForeignRobot
from worldgen.lattice import exact
from worldgen.robot_overrides import RobotOverrides
from worldgen.world import Pose, Robot, Target, World

# Words that describe a body, a car and a goal as the options do; a plain disc has none.
# Waypoints are places, and these files have no list of them; the target's radius comes with its place.
_ELSEWHERE = ("target_radius", "waypoints")
_KINDS = tuple(option.name for option in RobotOverrides.declared() if option.name not in _ELSEWHERE)
KEYS = {"start": 3, "target": 3, "robot_radius": 1, "robot_speed": 1, **dict.fromkeys(_KINDS, 1)}
"""Names of the facts, and the number of values of each."""


def place_words(world: World, destination: Destination) -> dict[str, list[str]]:
    """Return the words by the names of :data:`KEYS`.

    Numbers are exact decimals, m and rad; points are in the file's frame.
    """
    start = world.start
    target = world.target
    return {
        "start": [destination.x(start.x), destination.y(start.y), decimal(start.heading)],
        "target": [destination.x(target.x), destination.y(target.y), decimal(target.radius)],
        "robot_radius": [decimal(world.robot_radius)],
        "robot_speed": [decimal(world.robot_speed)],
        **{key: [word] for key, word in kind_words(world.robots[0]).items()},
    }


def read_places(words: Mapping[str, Sequence[str]], origin: tuple[float, float]) -> ForeignRobot:
    """Parse the output of :func:`place_words`; a world's numbers are restored bit for bit.

    Args:
        words: Any number of the words.
        origin: x and y, m, of the grid's lower-left corner in the file's frame.

    Returns:
        Arguments of :class:`~worldgen.interop.format.foreign_map.ForeignMap`: points from the
        grid's lower-left corner.

    Raises:
        InvalidParameter: If there are too few or too many numbers, one isn't a number, or a length
            isn't above 0.
    """
    found: dict[str, tuple[float, ...]] = {}
    # Parse each known word; a point is moved into the world's frame.
    for key, count in KEYS.items():
        if key not in words or key in _KINDS:
            continue
        if len(words[key]) != count:
            raise InvalidParameter(
                "wrong-count",
                "{key} has {values} values; it must be one number"
                if count == 1
                else "{key} has {values} values; it must have {count} numbers",
                key=key,
                values=len(words[key]),
                count=count,
            )
        shifts = (*origin, 0.0) if count == 3 else (0.0,)
        found[key] = tuple(
            from_decimal(word, shift) for word, shift in zip(words[key], shifts, strict=True)
        )
        if key != "start" and found[key][-1] <= 0.0:
            raise InvalidParameter(
                "not-positive",
                "{key} has a length of {length:g}; it must be above 0",
                key=key,
                length=found[key][-1],
            )
    radius = found.get("robot_radius", (None,))
    speed = found.get("robot_speed", (None,))
    kind = read_kind({key: " ".join(words[key]) for key in _KINDS if key in words})
    return kind._replace(
        start=found.get("start"), target=found.get("target"), radius=radius[0], speed=speed[0]
    )


def kind_words(robot: Robot) -> dict[str, str]:
    """Return a robot's body, drive and goal as words without blanks; none for a plain disc.

    A footprint has the form that Nav2's costmaps take.
    """
    words = {}
    if not robot.is_disc:
        corners = ",".join(f"[{decimal(x)},{decimal(y)}]" for x, y in robot.footprint)
        words["footprint"] = f"[{corners}]"
    drive = robot.drive
    if drive.is_car:
        words["drive"] = "car"
        words["turning_radius"] = decimal(drive.turning_radius)
        words["reverse"] = str(drive.reverse).lower()
        words["steering_rate"] = decimal(drive.steering_rate)
    goal = robot.target
    if goal.arrival != "touch":
        words["arrival"] = goal.arrival
        if goal.arrival == "stop":
            limits = (goal.arrival_speed, goal.arrival_turn_rate)
            words["arrival"] += "".join(f":{decimal(limit)}" for limit in limits)
    if goal.heading is not None:
        words["target_heading"] = f"{decimal(goal.heading)}:{decimal(goal.heading_tolerance)}"
    if goal.contact is not None:
        words["contact"] = goal.contact
    return words


def read_kind(words: Mapping[str, str]) -> ForeignRobot:
    """Parse the output of :func:`kind_words`.

    Raises:
        InvalidParameter: If a word has another form.
        InvalidWorld: If the footprint is not convex.
    """
    values: dict[str, Any] = dict(words)
    for key in ("turning_radius", "steering_rate"):
        if key in words:
            values[key] = from_decimal(words[key])
    if "reverse" in words:
        if words["reverse"] not in ("true", "false"):
            raise InvalidParameter(
                "wrong-form", "reverse is {word!q}", "write true or false", word=words["reverse"]
            )
        values["reverse"] = words["reverse"] == "true"
    plain = Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 1.0))
    return ForeignRobot(**robot_kinds(RobotOverrides.of(values).applied_to_robot(plain)))


def from_decimal(word: str, shift: float = 0.0) -> float:
    """Parse a number, minus a shift, rounded once.

    :func:`~worldgen.interop.format.decimal` wrote it.

    Raises:
        InvalidParameter: If it isn't a finite number.
    """
    if DECIMAL.fullmatch(word):
        try:
            return float(Fraction(word) - exact(shift))
        except OverflowError:
            pass
    raise InvalidParameter(
        "not-a-number", "{word!q} is not a finite number", "write one such as 0.05", word=word
    )
