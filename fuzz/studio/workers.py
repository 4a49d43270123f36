"""Processes that do the work, so that the server stays responsive and work can be ended."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import multiprocessing
import os
import signal
import time
from collections.abc import AsyncGenerator, Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzz.studio.requests.edits import edited_files, loaded_files
from fuzz.studio.requests.folder import Folder
from fuzz.studio.requests.refusals import our_fault, refusal
from worldgen.errors import Message, WorldgenError
from worldgen.plugins.trust import Inherited
from worldgen.plugins.workers import become_worker, sigint_blocked

if TYPE_CHECKING:
    from fuzz.studio.requests.messages import SendPart

_NICE = 5  # gives the page priority
_RUN = ("run", "compare")  # requests whose results depend on the user's code

WORKER_OF = {
    "hello": "files",
    "files": "files",
    "open": "files",
    "save": "files",
    "bring": "files",
    "export": "files",
    "decide": "proofs",
    "widest": "widths",
    "signal": "making",
    "generate": "making",
    "preview": "looks",
    "shift": "making",
    "measure": "widths",
    "run": "runs",
    "drive": "looks",
    "check": "looks",
    "compare": "tables",
    "picture": "pictures",
    "before": "pictures",
    "begin": "campaigns",
    "command": "campaigns",
    "resume": "campaigns",
    "edits": "edits",
    "watch": "watching",
    "stop": "watching",
    "campaigns": "walls",
    "failures": "walls",
    "know": "walls",
    "look": "looks",
    "elite": "looks",
    "snippet": "looks",
}
"""The process for each kind of request.

Saving is never interrupted, a long search for a proof does not delay a run, and anything that is
slow to start can be stopped while it starts.
"""


def start_beside(target: Callable[..., None], *args: Any, nice: int) -> BaseProcess:
    """Start a process that works for the server.

    It ignores Ctrl-C, gives the page priority, and ends with the server, however it ends.

    Args:
        target: The function to run, from a module.
        *args: Its arguments.
        nice: Niceness, the priority of everything else over it, from 0 to 19.
    """
    process = multiprocessing.get_context("spawn").Process(
        target=_begin, args=(Inherited(), nice, target, *args), daemon=True
    )
    with sigint_blocked():
        process.start()
    return process


def _begin(_: Inherited, nice: int, target: Callable[..., None], *args: Any) -> None:
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

    async def ask(self, kind: str, message: dict[str, Any]) -> AsyncGenerator[tuple[str, Any]]:
        """Pass one request to a worker, and return the answer.

        Yields:
            ``("turn", {})`` when it is this request's turn, ``("part", table)`` for each part, then
            ``("answer", table)`` or ``("error", refusal)``.

        Raises:
            Ended: If the process was ended in the meantime.
        """
        async with self._turn:
            yield "turn", {}
            wait = asyncio.get_running_loop().run_in_executor
            edited = await wait(self._thread, edited_files, self.loaded) if self.loaded else []
            if edited:
                self.end()  # it would run the old code
            pipe = self._pipe if self._process is not None and self._process.is_alive() else None
            pipe = pipe or self._start()
            heard_all = False
            try:
                # Sending a large message blocks until the process has started.
                await wait(self._thread, pipe.send, (kind, message))
                while not heard_all:
                    what, table, loaded = await wait(self._thread, pipe.recv)
                    heard_all = what != "part"
                    self.loaded = loaded if heard_all else self.loaded
                    yield what, table
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
    from fuzz.studio.answers import Answers  # noqa: PLC0415 - expensive, needed only here
    from fuzz.studio.requests.running import allow_only  # noqa: PLC0415

    allow_only(named)
    answers = Answers(Folder(Path(folder)), named)
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            kind, message = pipe.recv()
            since = time.time()
            send_part = functools.partial(_send_part, pipe, since, runs_code=kind in _RUN and named)
            what, table = _answer(answers, kind, message, send_part)
            pipe.send((what, table, loaded_files(since)))


def _send_part(pipe: Connection, since: float, table: dict[str, Any], *, runs_code: object) -> None:
    """Send a part of an answer; that of a run also says which code of the user's was loaded."""
    pipe.send(("part", table | {"code": loaded_files(since)} if runs_code else table, {}))


def _answer(
    answers: Any, kind: str, message: dict[str, Any], send_part: SendPart
) -> tuple[str, Any]:
    try:
        return "answer", getattr(answers, kind)(message, send_part)
    except (BrokenPipeError, EOFError):
        raise
    except WorldgenError as error:
        return "error", answers.folder.refusal(error)
    except UnicodeEncodeError:
        return "error", refusal(
            Message(
                "half-a-character",
                "a text in the message contains half of a surrogate pair",
                "send whole characters",
            )
        )
    except MemoryError:
        return "error", refusal(Message("out-of-memory", "out of memory", "use a smaller world"))
    except OSError as error:  # for example a full disk, perhaps of the temporary folder
        return "error", answers.folder.refusal(
            Message(
                "disk-refuses",
                "the disk reported an error: {reason}",
                "free some space, or use another disk",
                reason=error.strerror or str(error),
            )
        )
    except Exception as error:  # noqa: BLE001 - an internal error must not end the studio
        return "error", refusal(our_fault(error))
