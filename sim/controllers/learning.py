"""Keep the numbers that a controller has learned in a file, between runs.

``learned:./taught.json`` is a controller: the trained one. It starts every run with these numbers
and keeps learning.
"""

from __future__ import annotations

import functools
import json
import stat
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import msgspec
from msgspec import Meta

from worldgen.errors import InvalidParameter
from worldgen.files.json_file import converted, faulty_field
from worldgen.support.arrays import Floats
from worldgen.support.paths import expanded

LEARNED = "learned"
"""The option that gives a controller the numbers of such a file: ``mine.py:Mine+learned=FILE``."""
_PREFIX = f"{LEARNED}:"

# Limit on a file's size in bytes, far above the size of the largest memory.
_MOST_BYTES = 1 << 26


@dataclass(frozen=True)
class Learning:
    """The part of a controller's memory that it learns.

    Args:
        first: Index of the first number that it learns; the others belong to one run.
        count: Number of numbers that it learns.
        explore: Index of the number with the share of random decisions, in thousandths; -1 if it
            has none. Such a controller draws random numbers while it is trained.
        arrives: Changes a memory (m,) after a run in which the robot arrived; ``None`` if nothing
            remains to be learned then.
        whole: Whether all of the numbers are whole and none is below 0.
    """

    first: int
    count: int
    explore: int = -1
    arrives: Callable[[Floats], None] | None = None
    whole: bool = False

    @property
    def places(self) -> slice:
        """Where in the memory the numbers are."""
        return slice(self.first, self.first + self.count)


class Episodes(NamedTuple):
    """A point of a learning curve.

    Args:
        episodes: Episodes of training before it.
        reached: Number of worlds in which the controller now arrives, without exploring.
        worlds: Total number of worlds.
        steps: Total steps of those runs.
    """

    episodes: int
    reached: int
    worlds: int
    steps: int


class Learned(NamedTuple):
    """Contents of such a file.

    Args:
        controller: Name of the controller that learned it.
        numbers: The numbers, in the order of its memory.
        curve: The learning curve.
    """

    controller: str
    numbers: tuple[float, ...]
    curve: tuple[Episodes, ...]


class _LearnedFile(msgspec.Struct):
    """The form of such a file; a description is the reason for refusing a file without it."""

    format: Annotated[
        Literal["worldgen-learned"], Meta(description="its format is not 'worldgen-learned'")
    ]
    version: Annotated[Literal[1], Meta(description="its version is not 1")]
    controller: Annotated[str, Meta(description="it names no controller")]
    # A float64 distinguishes all whole numbers below 2**53.
    numbers: Annotated[
        tuple[Annotated[float, Meta(gt=-(2.0**53), lt=2.0**53)], ...],
        Meta(description="its numbers are not a list of finite numbers below 2**53"),
    ]
    curve: Annotated[
        tuple[Episodes, ...],
        Meta(description="its curve is not a list of points of four whole numbers"),
    ]


def is_learned_name(name: str) -> bool:
    """Return True if a controller's name refers to a file of learned numbers."""
    return name.startswith(_PREFIX)


def learned_file(name: str) -> Path:
    """Return the file in a controller's name."""
    return expanded(name.removeprefix(_PREFIX))


def learned_text(learned: Learned) -> str:
    """Return the text of a file; the same for the same numbers."""
    numbers = [int(one) if one == int(one) else one for one in learned.numbers]
    head = {
        "format": "worldgen-learned",
        "version": 1,
        "controller": learned.controller,
        "curve": [list(point) for point in learned.curve],
        "numbers": numbers,
    }
    return json.dumps(head, separators=(",", ":")) + "\n"


def read_learned(path: Path) -> Learned:
    """Read a file of learned numbers.

    Raises:
        InvalidParameter: If the file does not exist or holds anything else.
    """
    try:
        facts = path.stat()
    except OSError as error:
        raise InvalidParameter(
            "no-such-file",
            "{path} cannot be read ({reason})",
            "write it: worldgen train worlds/ --controller q-learner --out {path}",
            at_terminal=True,
            path=str(path),
            reason=error.strerror or str(error),
        ) from error
    # A device or a pipe may never end.
    if not stat.S_ISREG(facts.st_mode):
        raise _not_learned(path, "it is not a plain file")
    if facts.st_size > _MOST_BYTES:
        raise _not_learned(path, f"it has {facts.st_size} bytes")
    return _read(path, facts.st_mtime_ns, facts.st_size)


@functools.lru_cache(maxsize=16)
def _read(path: Path, _modified: int, _size: int) -> Learned:
    """Read a file again only if it has changed; a campaign requests its controller in each run."""
    try:
        content = json.loads(path.read_text("utf-8"))
    except OSError as error:
        raise _not_learned(path, error.strerror or str(error)) from error
    except (ValueError, RecursionError) as error:
        raise _not_learned(path, "it is not JSON") from error
    if not isinstance(content, dict):
        raise _not_learned(path, "it is not a JSON object")
    try:
        found = converted(content, _LearnedFile)
    except ValueError as error:
        field = faulty_field(content, _LearnedFile)
        reason = str(error) if field is None else field.type.__metadata__[0].description
        raise _not_learned(path, reason) from error
    # Such a file names what learned it, not another file.
    if is_learned_name(found.controller):
        raise _not_learned(path, "it names no controller")
    return Learned(found.controller, found.numbers, found.curve)


def _not_learned(path: Path, reason: str) -> InvalidParameter:
    return InvalidParameter(
        "not-learned",
        "{path} is not a file of learned numbers: {reason}",
        "choose a file that `worldgen train` wrote",
        at_terminal=True,
        path=str(path),
        reason=reason,
    )
