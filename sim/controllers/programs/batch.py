"""Drive many robots with one program at the same time.

A program may offer this in its first answer; this module reads the offer and the lines that follow.
``docs/reference/controllers.md`` specifies the protocol.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.controllers.base import Observation
from sim.controllers.controller_error import ControllerError
from sim.controllers.programs.program import shown
from sim.kernels import layout
from sim.verdict import Verdict
from worldgen.support.arrays import Floats, Ints

__all__ = ["MOST_ROBOTS", "Offer", "batch_line", "fill_commands", "read_offer", "reset_batch_line"]

MOST_ROBOTS = 1_024
"""Limit on the robots that are driven at the same time; their commands fit into one line."""

_COLUMNS = {name: k for k, name in enumerate(Observation._fields) if name != "neighbours"}
_KEYS = {"speed", "turn_rate", "used_random"}
_encode = json.JSONEncoder(allow_nan=False, check_circular=False, separators=(",", ":")).encode


@dataclass(frozen=True)
class Offer:
    """A program's offer to drive many robots.

    Args:
        robots: Number of robots that it can drive at the same time, at least 1.
        senses: The fields of an observation that it then needs.
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
        raise ControllerError(
            Verdict.INVALID_COMMAND,
            "batch is not an offer",
            {"rule": "batch-is-not-an-offer", "answer": shown(answer)},
        )
    return Offer(min(robots, MOST_ROBOTS), tuple(senses))


def reset_batch_line(version: int, robots: int) -> bytes:
    """Return the line that begins a batch."""
    return _encode({"worldgen": version, "batch": {"robots": robots}}).encode() + b"\n"


def batch_line(offer: Offer, robots: Ints, fresh: Ints, seen: Floats) -> bytes:
    """Return the line with the observations of some robots of a batch.

    Args:
        offer: The program's offer.
        robots: (n,) numbers of the robots.
        fresh: Numbers of those that begin an episode.
        seen: (n, OBS_SIZE + beams) the robots' observations.
    """
    message: dict[str, Any] = {"robots": robots.tolist(), "reset": fresh.tolist()}
    for name in offer.senses:
        column = seen[:, layout.OBS_SIZE :] if name == "beams" else seen[:, _COLUMNS[name]]
        message[name] = (column != 0.0).tolist() if name == "bump" else column.tolist()
    try:
        return _encode(message).encode() + b"\n"
    except ValueError:  # nan or infinity, which JSON does not have
        finite = {name: _finite(values) for name, values in message.items()}
        return _encode(finite).encode() + b"\n"


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
        raise _no_commands(answer) from None
    if not np.isfinite(numbers).all() or not all(isinstance(used, bool) for used in used_random):
        raise _no_commands(answer)
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


def _no_commands(answer: bytes) -> ControllerError:
    return ControllerError(
        Verdict.INVALID_COMMAND,
        "no commands for a batch",
        {"rule": "no-commands-for-a-batch", "answer": shown(answer)},
    )


def _finite(values: Sequence[Any]) -> list[Any]:
    """Return the same values, with None for numbers that are not finite."""
    return [
        _finite(value)
        if isinstance(value, list)
        else None
        if isinstance(value, float) and not math.isfinite(value)
        else value
        for value in values
    ]
