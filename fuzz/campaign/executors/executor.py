"""What a campaign asks of those who do its work."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from types import TracebackType
from typing import ParamSpec, Protocol, Self, TypeVar

from fuzz.campaign.config import CampaignConfig
from worldgen.errors import WorldgenError

__all__ = ["Executor", "WorkersLost"]

P = ParamSpec("P")
T = TypeVar("T")


class WorkersLost(WorldgenError):
    """Those who did the work ended before it did."""


class Executor(Protocol):
    """Does pure functions of arguments that can be pickled, in any order."""

    @property
    def room(self) -> int:
        """How many units may be under way at a time."""

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Begin a piece of work, or put it behind what is under way."""

    def prepare(self, config: CampaignConfig) -> list[Future[float]]:
        """Begin to load what the first units need, wherever work will be done.

        Results are those of :func:`fuzz.campaign.loading.load`.
        """

    def listen(self) -> None:
        """Raise ``KeyboardInterrupt`` if Ctrl-C came; called often while the campaign waits."""

    def stop(self) -> None:
        """Tell whatever is under way to end with what it has; nobody waits for what does not."""

    def __enter__(self) -> Self:
        """Start what is needed."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """End it, at once if something went wrong.

        Raises:
            WorkersLost: Instead of what went wrong, if it was that.
        """
