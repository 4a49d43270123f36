"""A campaign's Hypothesis database: examples that failed in strategies where Hypothesis draws."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from hypothesis.database import DirectoryBasedExampleDatabase, ExampleDatabase

from fuzz.unit.config import CampaignConfig
from worldgen.files.grid import world_digest
from worldgen.files.whole import refused_writes


def remembered(config: CampaignConfig, strategy: str) -> ExampleDatabase:
    """Return the database of a strategy; its key covers everything that gives examples a meaning.

    Raises:
        OutputError: If the folder cannot be made.
    """
    folder = Path(config.database)
    with refused_writes(folder):
        folder.mkdir(parents=True, exist_ok=True)
    scenario = config.scenario
    where = (
        world_digest(config.fixed_map) if config.fixed_map is not None and strategy == "map" else ""
    )
    varied = (
        scenario.label(),
        scenario.run.motion,
        config.time_steps,
        config.vary,
        strategy,
        where,
        *((config.robots,) if config.robots > 1 else ()),
    )
    return _Keyed(DirectoryBasedExampleDatabase(folder), f"worldgen {varied!r}".encode())


class _Keyed(ExampleDatabase):
    """A database under a fixed key.

    Hypothesis's own key is a digest of the test's source, so any edit would lose the examples.
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
    """Raised so that Hypothesis learns that a draw failed."""


@cache
def exception_of(kind: str) -> type[Failed]:
    """Return a separate exception type for each signature.

    Hypothesis distinguishes failures by type and line.
    """
    return type(f"Failed_{kind}", (Failed,), {})
