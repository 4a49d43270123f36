"""Find out which controller drives which robot of a world."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TypeVar

from worldgen.errors import InvalidParameter
from worldgen.support.plain_text import counted, quote

T = TypeVar("T")

_NUMBERED = re.compile(r"\s*(?P<number>\d{1,9})=(?P<controller>.+)", re.DOTALL)
_NEXT = re.compile(r",(?=\s*\d{1,9}=)")


def is_numbered(text: str) -> bool:
    """Return True if a text gives each robot its own controller, such as ``1=bug2,2=vfh``."""
    return _NUMBERED.fullmatch(text) is not None


def controllers_in(text: str, robots: int) -> list[str]:
    """Read one controller for all robots, or ``1=bug2,2=vfh``, as one text for each robot.

    Options follow each controller, as in ``1=bug2,2=vfh+beams=36``. A comma begins the next
    robot's controller only before a number and ``=``.

    Raises:
        InvalidParameter: If robots and controllers do not fit each other.
    """
    if not is_numbered(text):
        return assigned(text, robots)
    parts = _numbered_parts(text)
    # What follows a comma without a number belongs to a controller's name, such as a file's, unless
    # a robot is left without one.
    strays = [part for text in parts.values() for part in text.split(",")[1:]]
    if strays and len(parts) < robots:
        raise _unnumbered(strays[0])
    return assigned(parts, robots)


def _numbered_parts(text: str) -> dict[int, str]:
    """Read ``1=bug2,2=vfh`` as controllers by the robots' numbers.

    Raises:
        InvalidParameter: If a number comes twice, or a robot has no controller.
    """
    found: dict[int, str] = {}
    # Each part must have a number, and no number may occur twice.
    for part in _NEXT.split(text):
        numbered = _NUMBERED.fullmatch(part)
        if numbered is None:
            raise _unnumbered(part)
        number = int(numbered["number"])
        if number in found:
            raise InvalidParameter(
                "robot-named-twice",
                "robot {number} has two controllers, {one} and {other}",
                "give it one",
                number=number,
                one=quote(found[number]),
                other=quote(numbered["controller"]),
            )
        found[number] = numbered["controller"]
    return found


def _unnumbered(part: str) -> InvalidParameter:
    return InvalidParameter(
        "controller-unnumbered",
        "{part} does not name a robot and its controller",
        "write 1=bug2,2=vfh, or one controller for all robots",
        part=quote(part),
    )


def assigned(given: T | Mapping[int, T], robots: int) -> list[T]:
    """Return one controller for each robot.

    Args:
        given: One for all robots, or one for each robot's number, from 1.
        robots: How many robots there are.

    Raises:
        InvalidParameter: If a robot that does not exist is named, or one has no controller.
    """
    if not isinstance(given, Mapping):
        return [given] * robots
    wanted = range(1, robots + 1)
    there_are = f"the world has {counted(robots, 'robot')}"
    # The numbers must be those of the robots.
    for number in given:
        if number not in wanted:
            raise InvalidParameter(
                "no-such-robot",
                "a controller is named for robot {number}, and {there_are}",
                "number robots from 1",
                number=number,
                there_are=there_are,
            )
    missing = [number for number in wanted if number not in given]
    if missing:
        raise InvalidParameter(
            "robot-without-controller",
            "robot {number} has no controller, and {there_are}",
            "name one for each, such as {example}",
            number=missing[0],
            there_are=there_are,
            example=",".join(f"{number}=bug2" for number in wanted[:3]),
        )
    return [given[number] for number in wanted]
