"""Facts about a stored failure without its world: controller, cause, size."""

from __future__ import annotations

import hashlib
import re
import shlex
from collections.abc import Container
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from fuzz.failure import Failure, stem_of
from fuzz.simplicity import FailureOrder
from sim.controllers import in_plain_place
from worldgen.errors import FormatError, InvalidParameter
from worldgen.world import World

HIDDEN = ("cause", "size", "signature")
"""Facts that no table shows."""

_MOST = 80  # characters of a name that come from the text itself
_DIGITS = 8  # hex digits of the digest that follows a shortened name


@dataclass(frozen=True)
class Facts:
    """Facts that a failure's text states, independent of where its file is.

    Args:
        controller: With its options, as commands take it; without motion model, time step and seed.
        motion: Name of the motion model.
        group: See :attr:`fuzz.failure.Failure.group`.
        cause: The recorded cause; empty if the record names none.
        signature: See :attr:`fuzz.failure.Failure.signature`.
        verdict: Recorded verdict.
        width: Width in cells.
        height: Height in cells.
        solid: Number of solid cells.
        events: Number of events that change a cell.
        shrinking: See :attr:`fuzz.failure.Failure.shrinking`.
        digest: See :attr:`fuzz.failure.Failure.digest`.
        size: See :attr:`fuzz.failure.Failure.size`.
    """

    controller: str
    motion: str
    group: str
    cause: str
    signature: str
    verdict: str
    width: int
    height: int
    solid: int
    events: int
    shrinking: str
    digest: str
    size: tuple[int, ...]

    @classmethod
    def of(cls, failure: Failure, source: str) -> Facts:
        """Return the facts of a failure.

        Args:
            failure: A failure read from a file.
            source: The file's name, for error messages.

        Raises:
            FormatError: If its record has options that this version does not know.
        """
        world = failure.world
        record = failure.record
        try:
            controller = failure.label
        except InvalidParameter as error:
            raise FormatError(
                "invalid-record",
                "the failure's record is not valid: {reason}",
                reason=str(error),
                source=source,
            ) from error
        return cls(
            controller=controller,
            motion=record.motion,
            group=failure.group,
            cause=failure.recorded_cause or "",
            signature=failure.signature,
            verdict=record.verdict,
            width=world.width,
            height=world.height,
            solid=world.solid_cells,
            events=len(world.timeline),
            shrinking=failure.shrinking.value,
            digest=failure.digest,
            size=failure.size,
        )

    @classmethod
    def in_world(cls, world: World, source: str) -> Facts | None:
        """Return the facts of the failure in a world's file; ``None`` if there isn't one."""
        failure = Failure.found_in(world)
        return None if failure is None else cls.of(failure, source)

    @property
    def key(self) -> tuple[str, str, str]:
        """The key by which failures are grouped: controller, motion model, cause."""
        return in_plain_place(self.controller), self.motion, self.group

    @property
    def order(self) -> FailureOrder:
        """See :attr:`fuzz.failure.Failure.order`."""
        return FailureOrder(self.size, self.digest)

    def describe_size(self) -> str:
        """Return the size, such as ``5x8, 12 solid``, with the number of events if not 0."""
        changes = f", {self.events} events" if self.events else ""
        return f"{self.width}x{self.height}, {self.solid} solid{changes}"


@dataclass(frozen=True)
class CorpusEntry:
    """A failure in a corpus.

    Args:
        path: Its file; in an archive, the archive's path followed by the name inside.
        facts: Facts that its text states.
        seen: Time of the file's last change, whole seconds since 1970, UTC; ``None`` in an archive.
    """

    path: Path
    facts: Facts
    seen: int | None = None

    @property
    def order(self) -> tuple[tuple[str, str, str], FailureOrder, str]:
        """Sort key: cause by cause, the simplest failure first; equal files by path."""
        return self.facts.key, self.facts.order, str(self.path)

    @property
    def first_seen(self) -> str:
        """Date and time, UTC, in ISO 8601 notation; empty if unknown."""
        if self.seen is None:
            return ""
        try:
            return datetime.fromtimestamp(self.seen, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        # Some file systems report dates outside the calendar.
        except (OSError, OverflowError, ValueError):
            return ""

    @property
    def replay_command(self) -> str:
        """The command that replays the failure."""
        return f"worldgen replay {shlex.quote(str(self.path))}"

    def as_dict(self) -> dict[str, Any]:
        """Return one row of a table: column names and values."""
        facts = asdict(self.facts)
        for name in HIDDEN:
            del facts[name]
        row = {"file": str(self.path)}
        row |= {("cause" if name == "group" else name): value for name, value in facts.items()}
        row["first_seen"] = self.first_seen
        return row


def name_of(facts: Facts, number: int = 1, names: Container[str] = ()) -> str:
    """Return a failure's file name, such as ``turn-right/swept/returns-to-a-wall``.

    It is a path without suffix, valid on every file system, and different for different causes.
    Further failures of the same cause get ``-2`` and so on appended.

    Args:
        facts: The failure.
        number: Its place among those of its cause, from 1.
        names: The names of the first failures of all causes, as this function returns them.
    """
    controller, motion, group = (_plain(word) for word in facts.key)
    return stem_of(f"{controller}/{motion}/{group}", number, names)


def _plain(text: str) -> str:
    """Return the text if it is a valid file name, else a shortened form and a digest."""
    plain = re.sub(r"[^A-Za-z0-9._+=-]+", "-", text).strip(".-")[:_MOST]
    if plain and plain == text:
        return text
    digest = hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:_DIGITS]
    return f"{plain}-{digest}" if plain else digest
