"""Run work on a Dask cluster; this is the only module that needs the extra ``[dask]``."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, suppress
from typing import ParamSpec, Self, TypeVar

from distributed import Client, KilledWorker

from fuzz.campaign.executors.executor import WorkersLost
from fuzz.campaign.executors.remote import RemoteJob
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.plugins.workers import ctrl_c_held_back

P = ParamSpec("P")
T = TypeVar("T")

# For any other address, Dask leaves a half-built client behind.
_ADDRESS = re.compile(r"([a-z]+://)?[^\s/]+:[0-9]{1,5}")
# Units in progress per worker: one being done, and one waiting there.
_PER_WORKER = 2
# Seconds between two checks of the list of workers.
_LOOK = 1.0
# Timeout, s.
_TO_CONNECT = 10.0
_OPTION = "--scheduler"
_GONE = "the Dask scheduler at {address} no longer answers"


class _Client(Client):  # type: ignore[misc] # it has no types
    """A client that code which failed to create it does not await."""

    def __del__(self) -> None:
        if self.status == "running":
            self.close()


class DaskExecutor:
    """The workers of a Dask cluster, which may come and go.

    If a worker dies, the scheduler gives its work to another. Before its first work, each worker
    checks that its code equals ours; the files of the user's controllers, families and oracles are
    sent along.

    Args:
        address: Address of the scheduler: ``tcp://host:8786``.
        config: Definition of the campaign.

    Raises:
        InvalidParameter: If the address is invalid, or a file of the configuration cannot be read.
    """

    def __init__(self, address: str, config: CampaignConfig) -> None:
        if not _ADDRESS.fullmatch(address):
            raise InvalidParameter(
                "not-an-address",
                "{option} {address!r} is not an address",
                "use the address that the scheduler prints, such as tcp://host:8786",
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
        """Return two for each worker."""
        if time.monotonic() - self._looked > _LOOK:
            self._room = _PER_WORKER * len(self._client.nthreads())
            self._looked = time.monotonic()
        # Without any worker they wait at the scheduler.
        return max(self._room, _PER_WORKER)

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Submit it to the scheduler."""
        future: Future[T] = self._pool.submit(self._job.run, work, args, kwargs)
        return future

    def prepare(self, scenarios: Sequence[Scenario]) -> list[Future[float]]:
        """Do nothing: workers come and go, and each loads its modules with its first work."""
        return []

    def counts(self) -> None:
        """Return nothing: workers on other machines share no counters."""

    def stop(self) -> None:
        """Do nothing: work in progress is cancelled at the end."""

    def go_on(self) -> None:
        """Do nothing, as :meth:`stop` does."""

    def listen(self) -> None:
        """Raise ``KeyboardInterrupt`` if Ctrl-C was pressed.

        Raises:
            WorkersLost: If the scheduler can't be reached.
        """
        self._listen()
        if self._client.status != "running":
            raise WorkersLost("scheduler-lost", _GONE, address=self._address)

    def __enter__(self) -> Self:
        """Connect.

        Raises:
            InvalidParameter: If no scheduler answers.
        """
        # We report errors ourselves, once.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            self._client = _Client(self._address, timeout=_TO_CONNECT, set_as_default=False)
        # A server of another kind may seem to send exabytes.
        except (MemoryError, OSError, ValueError) as error:
            raise InvalidParameter(
                "no-scheduler",
                "no Dask scheduler answers at {address!r} ({reason})",
                "start a scheduler, and give the address that it prints",
                address=self._address,
                reason=str(error),
            ) from error
        self._pool = self._client.get_executor(pure=False)
        self._listen = self._open.enter_context(ctrl_c_held_back())
        return self

    def __exit__(self, _kind: object, error: BaseException | None, _at: object) -> None:
        """Disconnect, which cancels work in progress.

        Raises:
            WorkersLost: If the scheduler can't be reached, or the work killed worker after worker.
            InvalidParameter: If the workers' code differs from ours.
        """
        with self._open, suppress(OSError, RuntimeError):
            self._pool.shutdown(wait=False)
            self._client.close(timeout=_TO_CONNECT)
        if error is not None and not isinstance(error, WorldgenError):
            _retell(error, self._address)


def _retell(error: BaseException, address: str) -> None:
    """Raise an error as a plain sentence if it isn't our fault."""
    if isinstance(error, KilledWorker):
        raise WorkersLost(
            "killed-worker",
            "the same piece of work ended {workers} workers, the most that the scheduler allows; "
            "the controller may kill them, or they may need more memory (docs/howto/cluster.md)",
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
