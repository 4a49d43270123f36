"""What is said of a failure without its world: whose it is, of what class, how large."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from fuzz.failure import scenario_of
from sim.controllers import in_plain_place
from sim.run_options import RunOptions
from sim.scenario import Scenario
from worldgen.errors import FormatError, InvalidParameter
from worldgen.grid_file import dumps
from worldgen.world import World

__all__ = ["Entry", "Facts"]


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

    @classmethod
    def of(cls, world: World, source: str) -> Facts | None:
        """The facts of a failure, ``None`` of a world without one.

        Args:
            world: From a file.
            source: The file's name for the message.

        Raises:
            FormatError: If its record names options that are unknown here.
        """
        if world.failure is None:
            return None
        try:
            record, options = scenario_of(world)
        except InvalidParameter as error:
            raise FormatError(
                "invalid-record", "the failure's record does not fit: {reason}", reason=str(error), source=source
            ) from error
        digest = hashlib.sha256(dumps(world)).hexdigest()
        return cls(
            controller=_label(record.controller, options),
            motion=record.motion,
            kind=str(record.details.get("class", record.verdict)),
            verdict=record.verdict,
            width=world.width,
            height=world.height,
            solid=world.solid_cells,
            events=len(world.timeline),
            digest=digest,
        )

    @property
    def key(self) -> tuple[str, str, str]:
        """What makes two failures one: controller, motion model, class."""
        return in_plain_place(self.controller), self.motion, self.kind

    @property
    def size(self) -> tuple[int, int, int]:
        """How large the world is: solid cells, then all cells, then events."""
        return self.solid, self.width * self.height, self.events

    @property
    def order(self) -> tuple[tuple[int, int, int], str]:
        """The smallest comes first; of equally large ones that with the lower digest."""
        return self.size, self.digest

    def size_in_words(self) -> str:
        """``5x8, 12 solid``, and the events if there are any."""
        changes = f", {self.events} events" if self.events else ""
        return f"{self.width}x{self.height}, {self.solid} solid{changes}"


@dataclass(frozen=True)
class Entry:
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

    def as_dict(self) -> dict[str, Any]:
        """One row of a table: names of columns and their values."""
        facts = asdict(self.facts)
        row = {"file": str(self.path)}
        row |= {("class" if name == "kind" else name): value for name, value in facts.items()}
        row["first_seen"] = self.first_seen
        return row


def _label(controller: str, options: RunOptions) -> str:
    """The controller as a user would write it; the time step is part of what a search draws, not of the robot."""
    return Scenario.of(controller, options).label(options.motion, options.time_step)
