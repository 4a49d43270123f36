"""Processes that do the work, so that the server stays responsive and work can be ended."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import AsyncGenerator, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzz.studio.requests.edits import edited_files, loaded_files
from fuzz.studio.requests.folder import Folder
from fuzz.studio.requests.protocol import Compare, Request, Run
from fuzz.studio.requests.refusals import our_fault
from worldgen.errors import Message, WorldgenError
from worldgen.plugins.trust import Inherited
from worldgen.plugins.workers import become_worker, sigint_blocked

if TYPE_CHECKING:
    from multiprocessing.context import ForkServerContext, SpawnContext

_NICE = 5  # gives the page priority


def start_beside(target: Callable[..., None], *args: Any, nice: int) -> BaseProcess:
    """Start a process that works for the server.

    It ignores Ctrl-C, gives the page priority, and ends with the server, however it ends.

    Args:
        target: The function to run, from a module.
        *args: Its arguments.
        nice: Niceness, the priority of everything else over it, from 0 to 19.
    """
    with sigint_blocked():
        process = _context().Process(
            target=_begin, args=(Inherited(), dict(os.environ), nice, target, *args), daemon=True
        )
        process.start()
    return process


def _context() -> ForkServerContext | SpawnContext:
    """Return how processes begin.

    On Linux a server process loads what they need, once, and they are forks of it, which takes
    milliseconds. Elsewhere, and where its socket cannot be made because the path of the temporary
    folder is too long, each loads everything itself, which takes a second.
    """
    if sys.platform == "linux":
        from multiprocessing import forkserver  # noqa: PLC0415 - Windows has none

        multiprocessing.set_forkserver_preload(["fuzz.studio.answers"])
        with contextlib.suppress(OSError):
            forkserver.ensure_running()
            return multiprocessing.get_context("forkserver")
    return multiprocessing.get_context("spawn")


def _begin(
    _: Inherited, environment: Mapping[str, str], nice: int, target: Callable[..., None], *args: Any
) -> None:
    # A fork has the variables of the time when its server began.
    os.environ.clear()
    os.environ.update(environment)
    become_worker()
    # Campaigns that are started in this process must receive Ctrl-C.
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # AttributeError: Windows has no nice.
    with contextlib.suppress(OSError, AttributeError):
        os.nice(nice)
    target(*args)


class Ended(Exception):
    """The work was ended before it was finished."""


class Worker:
    """A process that does one thing at a time.

    It starts with the first request, and again after each forced end and after each edit of a file
    whose code it has loaded.

    Args:
        folder: The folder that can be read and written.
        named: Controllers that were named at the start.
    """

    def __init__(self, folder: Folder, named: tuple[str, ...]) -> None:
        self._given = (str(folder.root), named)
        self._turn = asyncio.Lock()
        # A separate thread: many waiting requests would use up asyncio's shared ones.
        self._thread = ThreadPoolExecutor(1, "worker")
        self._process: BaseProcess | None = None
        self._pipe: Connection | None = None
        self.loaded: dict[str, str] = {}
        """The user's files whose code the process has loaded, with the digest of each."""

    async def ask(self, request: Request) -> AsyncGenerator[tuple[str, Any, dict[str, str]]]:
        """Pass one request to a worker, and return the answer.

        Yields:
            ``"turn"`` when it is this request's turn, ``"part"`` with each part, then ``"answer"``
            or ``"error"`` with a refusal; each with the user's files whose code has run.

        Raises:
            Ended: If the process was ended in the meantime.
        """
        async with self._turn:
            yield "turn", None, {}
            wait = asyncio.get_running_loop().run_in_executor
            edited = await wait(self._thread, edited_files, self.loaded) if self.loaded else []
            if edited:
                self.end()  # it would run the old code
            pipe = self._pipe if self._process is not None and self._process.is_alive() else None
            pipe = pipe or self._start()
            heard_all = False
            try:
                # Sending a large message blocks until the process has started.
                await wait(self._thread, pipe.send, request)
                while not heard_all:
                    what, value, loaded = await wait(self._thread, pipe.recv)
                    heard_all = what != "part"
                    self.loaded = loaded if heard_all else self.loaded
                    yield what, value, loaded
            except (EOFError, OSError) as error:
                raise Ended from error
            finally:
                if not heard_all:
                    self.end()  # otherwise the next request would receive the remaining parts

    def warm(self) -> None:
        """Start the process before the first request, because that takes a second."""
        if self._process is None:
            self._start()

    def end(self) -> None:
        """End the current work."""
        if self._process is not None:
            self._process.kill()
            self._process = None

    def _start(self) -> Connection:
        ours, theirs = multiprocessing.Pipe()
        process = start_beside(_work, theirs, *self._given, nice=_NICE)
        theirs.close()  # so that the pipe closes when the process ends
        self._process = process
        self._pipe = ours
        self.loaded = {}
        return ours


def _work(pipe: Connection, folder: str, named: tuple[str, ...]) -> None:
    """Answer requests in the process until the server ends."""
    from fuzz.studio.answers import answer  # noqa: PLC0415 - expensive, needed only here
    from fuzz.studio.requests.folder import Opened  # noqa: PLC0415
    from fuzz.studio.requests.running import allow_only  # noqa: PLC0415

    allow_only(named)
    opened = Opened(Folder(Path(folder)), named)
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            request = pipe.recv()
            since = time.time()
            # A part of a run says which code of the user's was loaded.
            runs_code = isinstance(request, Run | Compare) and named

            def send_part(part: Any, since: float = since, runs_code: object = runs_code) -> None:
                pipe.send(("part", part, loaded_files(since) if runs_code else {}))

            try:
                what, value = "answer", answer(request, opened, send_part)
            except (BrokenPipeError, EOFError):
                raise
            except Exception as error:  # noqa: BLE001 - no error must end the studio
                what, value = "error", opened.folder.refusal(_fault(error))
            pipe.send((what, value, loaded_files(since)))


def _fault(error: Exception) -> WorldgenError | Message:
    """Return the message for an error in a worker."""
    if isinstance(error, WorldgenError):
        return error
    if isinstance(error, MemoryError):
        return Message("out-of-memory", "out of memory", "use a smaller world")
    if isinstance(error, OSError):  # for example a full disk, perhaps of the temporary folder
        return Message(
            "disk-refuses",
            "the disk reported an error: {reason}",
            "free some space, or use another disk",
            reason=error.strerror or str(error),
        )
    return our_fault(error)
