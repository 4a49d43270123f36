"""A campaign's Hypothesis database: what failed in the lanes in which Hypothesis draws."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from hypothesis.database import DirectoryBasedExampleDatabase, ExampleDatabase

from fuzz.campaign.config import CampaignConfig
from worldgen.errors import OutputError
from worldgen.files.grid import world_digest

__all__ = ["Failed", "exception_of", "remembered"]


def remembered(config: CampaignConfig, lane: str) -> ExampleDatabase:
    """Where Hypothesis keeps what failed in a lane, by what decides how its choices are read.

    Raises:
        OutputError: If the folder cannot be made.
    """
    folder = Path(config.database)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            "unwritable",
            "{folder}: no folder for a database can be made: {reason}",
            folder=folder,
            reason=error.strerror or str(error),
        ) from error
    scenario = config.scenario
    where = world_digest(config.fixed_map) if config.fixed_map is not None and lane == "map" else ""
    varied = (scenario.label(), scenario.run.motion, config.time_steps, config.vary, lane, where)
    return _Keyed(DirectoryBasedExampleDatabase(folder), f"worldgen {varied!r}".encode())


class _Keyed(ExampleDatabase):
    """A database under a key of ours.

    Hypothesis's own is a digest of the source, so any edit would orphan it.
    """

    def __init__(self, inner: ExampleDatabase, key: bytes) -> None:
        super().__init__()
        self._inner = inner
        self._key = key

    def _own(self, key: bytes) -> bytes:
        _, dot, kind = key.rpartition(b".")  # ".secondary", ".pareto"
        return self._key + dot + kind if kind in (b"secondary", b"pareto") else self._key

    def fetch(self, key: bytes) -> Iterable[bytes]:
        return self._inner.fetch(self._own(key))

    def save(self, key: bytes, value: bytes) -> None:
        self._inner.save(self._own(key), value)

    def delete(self, key: bytes, value: bytes) -> None:
        self._inner.delete(self._own(key), value)


class Failed(Exception):
    """Tells Hypothesis that a draw failed."""


@cache
def exception_of(kind: str) -> type[Failed]:
    """One type for each class of failures, for Hypothesis tells failures apart by their type and line."""
    return type(f"Failed_{kind}", (Failed,), {})
