"""What is said of a failure without its world: whose it is, of what class, how large."""

from __future__ import annotations

import hashlib
import shlex
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from fuzz.failure import Failure
from sim.controllers import in_plain_place
from worldgen.errors import FormatError, InvalidParameter
from worldgen.world import World

__all__ = ["CorpusEntry", "Facts"]


@dataclass(frozen=True)
class Facts:
    """What a failure's text says, wherever it lies.

    Args:
        controller: With its options, as commands take it; without motion model, time step and seed.
        motion: Name of the motion model.
        kind: The class.
        verdict: One of the vocabulary's.
        width: Cells.
        height: Cells.
        solid: Solid cells.
        events: Changes of cells.
        digest: SHA-256, in hex, of the canonical text.
        size: As :attr:`fuzz.failure.Failure.size` has it.
    """

    controller: str
    motion: str
    kind: str
    verdict: str
    width: int
    height: int
    solid: int
    events: int
    digest: str
    size: tuple[int, ...]

    @classmethod
    def of(cls, failure: Failure, source: str) -> Facts:
        """Return the facts of a failure.

        Args:
            failure: From a file.
            source: The file's name for the message.

        Raises:
            FormatError: If its record names options that are unknown here.
        """
        world = failure.world
        record = failure.record
        try:
            controller = failure.label
        except InvalidParameter as error:
            raise FormatError(
                "invalid-record",
                "the failure's record does not fit: {reason}",
                reason=str(error),
                source=source,
            ) from error
        return cls(
            controller=controller,
            motion=record.motion,
            kind=failure.bucket,
            verdict=record.verdict,
            width=world.width,
            height=world.height,
            solid=world.solid_cells,
            events=len(world.timeline),
            digest=hashlib.sha256(failure.dumps()).hexdigest(),
            size=failure.size,
        )

    @classmethod
    def in_world(cls, world: World, source: str) -> Facts | None:
        """Return the facts of the failure that a world's file holds; ``None`` if it holds none."""
        failure = Failure.found_in(world)
        return None if failure is None else cls.of(failure, source)

    @property
    def key(self) -> tuple[str, str, str]:
        """What makes two failures one: controller, motion model, class."""
        return in_plain_place(self.controller), self.motion, self.kind

    @property
    def order(self) -> tuple[tuple[int, ...], str]:
        """The smallest comes first; of equally large ones that with the lower digest."""
        return self.size, self.digest

    def describe_size(self) -> str:
        """``5x8, 12 solid``, and the events if there are any."""
        changes = f", {self.events} events" if self.events else ""
        return f"{self.width}x{self.height}, {self.solid} solid{changes}"


@dataclass(frozen=True)
class CorpusEntry:
    """A failure in a corpus.

    Args:
        path: Its file; in an archive the archive's path and then the name there.
        facts: What its text says.
        seen: When the file was last changed, whole seconds since 1970, UTC; ``None`` in an archive.
    """

    path: Path
    facts: Facts
    seen: int | None = None

    @property
    def first_seen(self) -> str:
        """The day and time, UTC, as ISO 8601 writes it; empty if it is not known."""
        if self.seen is None:
            return ""
        try:
            return datetime.fromtimestamp(self.seen, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        except (OSError, OverflowError, ValueError):  # a file system's date that is none
            return ""

    @property
    def replay_command(self) -> str:
        """The command that shows the failure again."""
        return f"worldgen replay {shlex.quote(str(self.path))}"

    def as_dict(self) -> dict[str, Any]:
        """One row of a table: names of columns and their values."""
        facts = asdict(self.facts)
        del facts["size"]  # the columns of the world say enough
        row = {"file": str(self.path)}
        row |= {("class" if name == "kind" else name): value for name, value in facts.items()}
        row["first_seen"] = self.first_seen
        return row
