"""Store start, target and robot as words, in files that have room for words.

The words are keys of a table, a picture's text, or properties.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from worldgen.domain import DECIMAL
from worldgen.errors import InvalidParameter
from worldgen.interop.format import Destination, decimal
from worldgen.interop.format.foreign_map import ForeignRobot
from worldgen.lattice import exact
from worldgen.world import World

KEYS = {"start": 3, "target": 3, "robot_radius": 1, "robot_speed": 1}
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
        if key not in words:
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
    return ForeignRobot(found.get("start"), found.get("target"), radius[0], speed[0])


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
