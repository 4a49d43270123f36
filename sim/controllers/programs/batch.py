"""Drive many robots with one program at the same time.

A program may offer this in its first answer; this module reads the offer and the lines that follow.
``docs/reference/controllers.md`` specifies the protocol.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.controllers.base import Observation
from sim.controllers.programs.program import invalid_answer
from sim.kernels import layout
from worldgen.support.arrays import Floats, Ints

MOST_ROBOTS = 1_024
"""Limit on the robots that are driven at the same time; their commands fit into one line."""

_COLUMNS: dict[str, int | slice] = {
    **{name: k for k, name in enumerate(Observation._fields[: layout.OBS_SIZE])},
    "beams": slice(layout.OBS_SIZE, -layout.OBS_TAIL),
    "goal_heading": layout.OBS_GOAL_HEADING,
    "tilt": layout.OBS_TILT,
    "tilt_heading": layout.OBS_TILT_HEADING,
}
_KEYS = {"speed", "turn_rate", "used_random"}
_encode = json.JSONEncoder(allow_nan=False, check_circular=False, separators=(",", ":")).encode


@dataclass(frozen=True)
class Offer:
    """A program's offer to drive many robots.

    Args:
        robots: Number of robots that it can drive at the same time, at least 1.
        senses: The fields of an observation that it needs.
    """

    robots: int
    senses: tuple[str, ...]


def read_offer(given: Any, answer: bytes) -> Offer:
    """Read the offer in a first answer.

    Args:
        given: The value of ``"batch"``.
        answer: The whole answer, to quote if it is not valid.

    Raises:
        ControllerError: If it is not an offer.
    """
    offer = given if isinstance(given, dict) else {}
    robots = offer.get("robots")
    senses = offer.get("senses", list(_COLUMNS))
    known = isinstance(senses, list) and all(
        isinstance(name, str) and name in _COLUMNS for name in senses
    )
    if (
        type(robots) is not int
        or robots < 1
        or not known
        or not offer.keys() <= {"robots", "senses"}
    ):
        raise invalid_answer("batch is not an offer", answer)
    return Offer(min(robots, MOST_ROBOTS), tuple(senses))


def reset_batch_line(version: int, robots: int) -> bytes:
    """Return the line that begins a batch."""
    return json_line({"worldgen": version, "batch": {"robots": robots}})


def batch_line(offer: Offer, robots: Ints, fresh: Ints, seen: Floats) -> bytes:
    """Return the line with the observations of some robots of a batch.

    Args:
        offer: The program's offer.
        robots: (n,) numbers of the robots.
        fresh: Numbers of the robots that begin an episode.
        seen: (n, OBS_SIZE + beams + OBS_TAIL) the robots' observations.
    """
    message: dict[str, Any] = {"robots": robots.tolist(), "reset": fresh.tolist()}
    for name in offer.senses:
        column = seen[:, _COLUMNS[name]]
        # As for a single robot, a goal without a heading and a level floor are not mentioned.
        if name == "goal_heading" and np.isnan(column).all():
            continue
        if name in ("tilt", "tilt_heading") and not seen[:, layout.OBS_TILT].any():
            continue
        message[name] = (column != 0.0).tolist() if name == "bump" else column.tolist()
    return json_line(message)


def fill_commands(answer: bytes, command: Floats) -> None:
    """Read the answer to a line of a batch.

    Args:
        answer: One line of JSON.
        command: (n, CMD_SIZE), filled in.

    Raises:
        ControllerError: If it does not hold a command for each robot.
    """
    # Each column must have one entry per robot; the try also catches anything of another form.
    try:
        found = json.loads(answer)
        speed = found["speed"]
        turn_rate = found["turn_rate"]
        used_random = found.get("used_random", [False] * len(command))
        columns = (speed, turn_rate, used_random)
        if not found.keys() <= _KEYS or not all(_fits(column, len(command)) for column in columns):
            raise TypeError("columns")
        numbers = np.array((speed, turn_rate), np.float64)
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError):
        raise invalid_answer("no commands for a batch", answer) from None
    if not np.isfinite(numbers).all() or not all(isinstance(used, bool) for used in used_random):
        raise invalid_answer("no commands for a batch", answer)
    command[:, layout.CMD_SPEED] = numbers[0]
    command[:, layout.CMD_TURN_RATE] = numbers[1]
    command[:, layout.CMD_DRAW] = used_random


def _fits(column: object, count: int) -> bool:
    """Return True for a list of that length without strings, which numpy would convert."""
    return (
        isinstance(column, list)
        and len(column) == count
        and not any(isinstance(one, str) for one in column)
    )


def json_line(message: Mapping[str, Any]) -> bytes:
    """Return a message as a line of JSON.

    Numbers read back to the same bits; nan and infinity become null.
    """
    try:
        text = _encode(message)
    except ValueError:  # nan or infinity, which JSON does not have
        text = _encode(_finite(message))
    return text.encode() + b"\n"


def _finite(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
