"""The workers of a Dask cluster; the only module that needs the extra ``[dask]``."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import ParamSpec, Self, TypeVar

from distributed import Client, KilledWorker

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.executors.executor import WorkersLost
from fuzz.campaign.executors.remote import RemoteJob
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.support.workers import ctrl_c_held_back

__all__ = ["DaskExecutor"]

P = ParamSpec("P")
T = TypeVar("T")

_ADDRESS = re.compile(
    r"([a-z]+://)?[^\s/]+:[0-9]{1,5}"
)  # Dask itself leaves half a client behind for any other
_PER_WORKER = 2  # units under way for each: one that it does, one that waits there
_LOOK = 1.0  # s between two looks at which workers there are
_TO_CONNECT = 10.0  # s
_OPTION = "--scheduler"
_GONE = "the Dask scheduler at {address} does not answer any more"


class _Client(Client):  # type: ignore[misc] # it has no types
    """A client that nobody waits for who could not make it."""

    def __del__(self) -> None:
        if self.status == "running":
            self.close()


class DaskExecutor:
    """The workers of a Dask cluster, which may come and go.

    A worker that dies is the scheduler's business: it gives the work to another. Each worker is
    asked before its first work whether its code is this one's; the files of controllers, families
    and oracles of one's own go along.

    Args:
        address: The scheduler's: ``tcp://host:8786``.
        config: What the campaign looks for.

    Raises:
        InvalidParameter: If the address is none, or a file of the configuration cannot be read.
    """

    def __init__(self, address: str, config: CampaignConfig) -> None:
        if not _ADDRESS.fullmatch(address):
            raise InvalidParameter(
                "not-an-address",
                "{option} {address!r} is no address",
                "give the one that the scheduler prints, such as tcp://host:8786",
                option=_OPTION,
                address=address,
            )
        self._address = address
        self._job = RemoteJob.of(config)
        self._room = 0
        self._looked = 0.0
        self._open = ExitStack()

    @property
    def room(self) -> int:
        """Two for each worker that there is."""
        if time.monotonic() - self._looked > _LOOK:
            self._room = _PER_WORKER * len(self._client.nthreads())
            self._looked = time.monotonic()
        return max(self._room, _PER_WORKER)  # without any worker they wait at the scheduler

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Give it to the scheduler."""
        future: Future[T] = self._pool.submit(self._job.run, work, args, kwargs)
        return future

    def prepare(self, config: CampaignConfig) -> list[Future[float]]:
        """Nothing: workers come and go, and each loads what it needs with its first work."""
        return []

    def stop(self) -> None:
        """Nothing: what is under way is cancelled at the end."""

    def listen(self) -> None:
        """Raise ``KeyboardInterrupt`` if Ctrl-C came.

        Raises:
            WorkersLost: If the scheduler is gone.
        """
        self._listen()
        if self._client.status != "running":
            raise WorkersLost("scheduler-lost", _GONE, address=self._address)

    def __enter__(self) -> Self:
        """Connect.

        Raises:
            InvalidParameter: If no scheduler answers.
        """
        logging.getLogger("distributed").setLevel(
            logging.CRITICAL
        )  # what goes wrong we say ourselves, once
        try:
            self._client = _Client(self._address, timeout=_TO_CONNECT, set_as_default=False)
        except (
            MemoryError,
            OSError,
            ValueError,
        ) as error:  # a server of another kind may seem to send exabytes
            raise InvalidParameter(
                "no-scheduler",
                "no Dask scheduler answers at {address!r} ({reason})",
                "start one, and give the address it prints",
                address=self._address,
                reason=str(error),
            ) from error
        self._pool = self._client.get_executor(pure=False)
        self._listen = self._open.enter_context(ctrl_c_held_back())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """Disconnect; what is under way is cancelled.

        Raises:
            WorkersLost: If the scheduler is gone, or work killed worker after worker.
            InvalidParameter: If the workers' code is other than ours.
        """
        with self._open, suppress(OSError, RuntimeError):
            self._pool.shutdown(wait=False)
            self._client.close(timeout=_TO_CONNECT)
        if error is not None and not isinstance(error, WorldgenError):
            _retell(error, self._address)


def _retell(error: BaseException, address: str) -> None:
    """Raise what went wrong as a sentence, where it is not our fault."""
    if isinstance(error, KilledWorker):
        raise WorkersLost(
            "killed-worker",
            "one piece of work ended as many workers as the scheduler allows, {workers}: "
            "perhaps the controller kills them, or they have too little memory "
            "(docs/howto/campaigns.md)",
            workers=error.allowed_failures + 1,
        ) from error
    if isinstance(error, CancelledError | OSError):
        raise WorkersLost("scheduler-lost", _GONE, address=address) from error
    if isinstance(error, ImportError | AttributeError) or "deserialization" in str(error):
        raise InvalidParameter(
            "other-code",
            "the cluster cannot read the work ({reason})",
            "install the same worldgen for the scheduler and every worker",
            at_terminal=True,
            reason=str(error),
        ) from error
