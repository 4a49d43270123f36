"""Notice whether a controller that plans reads the changes of its world before they happen.

Its ``reset`` gets the whole world, future changes included. Most planners look at the walls only,
so they know no more about a fire than a robot that does not plan. :func:`noting_reads` makes runs
pass a timeline that notes access to its events. Whatever a copy of the world shares is noted, too,
and so is what functions read that the world is passed to.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Any

from worldgen.timeline import Timeline
from worldgen.world import World

_EVENTS = ("times", "ix", "iy", "states", "__dict__")


@dataclass
class Reads:
    """Whether anyone has read the events of a timeline."""

    any: bool = False


class _NotingTimeline(Timeline):
    """A timeline that notes access to its events; everything else about it is the same."""

    def __getattribute__(self, name: str) -> Any:
        if name in _EVENTS:
            _reads_of(self).any = True
        return super().__getattribute__(name)

    @property  # type: ignore[misc]
    def __class__(self) -> type[Timeline]:  # type: ignore[override]
        """The class of what ``dataclasses.replace`` makes of it."""
        return Timeline

    # That something changes, that a copy is equal, and how large the world must be do not tell where
    # and when it changes.
    def __len__(self) -> int:
        return len(_plain(self))

    def is_within(self, width: int, height: int) -> bool:
        return _plain(self).is_within(width, height)

    def __eq__(self, other: object) -> bool:
        return _plain(self) == (_plain(other) if isinstance(other, _NotingTimeline) else other)

    __hash__ = None

    def __copy__(self) -> Timeline:
        return self

    def __deepcopy__(self, memo: object) -> Timeline:
        return self

    def __reduce_ex__(self, protocol: Any) -> Any:
        # Nobody can see what another process does with it.
        if _pickles_count.get():
            _reads_of(self).any = True
        return _plain(self).__reduce_ex__(protocol)


def _plain(timeline: _NotingTimeline) -> Timeline:
    found: Timeline = object.__getattribute__(timeline, "_plain")
    return found


def _reads_of(timeline: _NotingTimeline) -> Reads:
    found: Reads = object.__getattribute__(timeline, "_reads")
    return found


_noted: ContextVar[Reads | None] = ContextVar("noted", default=None)
_pickles_count: ContextVar[bool] = ContextVar("pickles_count", default=True)


@contextmanager
def noting_reads() -> Iterator[Reads]:
    """Note whether the controllers of the runs in this block read the changes of their worlds."""
    reads = Reads()
    token = _noted.set(reads)
    try:
        yield reads
    finally:
        _noted.reset(token)


def are_reads_noted() -> bool:
    """Return True inside :func:`noting_reads`."""
    return _noted.get() is not None


@contextmanager
def ignoring_pickles() -> Iterator[None]:
    """Do not count pickling as reading, as when the simulator compares states."""
    token = _pickles_count.set(False)
    try:
        yield
    finally:
        _pickles_count.reset(token)


def world_to_read(world: World) -> World:
    """Return the world that a controller gets: with a noting timeline inside :func:`noting_reads`."""
    reads = _noted.get()
    if reads is None:
        return world
    timeline = world.timeline
    noting = object.__new__(_NotingTimeline)
    for name in ("times", "ix", "iy", "states"):
        object.__setattr__(noting, name, getattr(timeline, name))
    object.__setattr__(noting, "_plain", timeline)
    object.__setattr__(noting, "_reads", reads)
    return replace(world, timeline=noting)
