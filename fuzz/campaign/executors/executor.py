"""The interface between a campaign and its workers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import ParamSpec, Protocol, Self, TypeVar

from fuzz.unit.live import LiveCounts
from sim.scenario import Scenario
from worldgen.errors import WorldgenError

P = ParamSpec("P")
T = TypeVar("T")


class WorkersLost(WorldgenError):
    """Raised if the workers ended before the work did."""


class Executor(Protocol):
    """Runs pure functions of arguments that can be pickled, in any order."""

    @property
    def room(self) -> int:
        """Number of units that may be in progress at a time."""

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Submit a piece of work, which may have to wait for others."""

    def prepare(self, scenarios: Sequence[Scenario]) -> list[Future[float]]:
        """Start loading what the first units need, in every process that will do the work.

        The results are the same as for :func:`fuzz.campaign.executors.local.load`.
        """

    def listen(self) -> None:
        """Raise ``KeyboardInterrupt`` if Ctrl-C came; called often while the campaign waits."""

    def counts(self) -> LiveCounts | None:
        """Return what all workers have run so far; ``None`` if that is not known."""

    def stop(self) -> None:
        """Tell work in progress to end with its results so far, without waiting for it."""

    def go_on(self) -> None:
        """Do further work after :meth:`stop`."""

    def __enter__(self) -> Self:
        """Start what is needed."""

    def __exit__(self, _kind: object, error: BaseException | None, _at: object) -> None:
        """End the executor, immediately if there was an error.

        Raises:
            WorkersLost: If that caused the error.
        """
