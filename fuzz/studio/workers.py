"""Processes in which the work is done.

The server stays live, and what nobody wants any more can be ended.
"""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
from collections.abc import AsyncGenerator
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from fuzz.studio.folder import Folder
from fuzz.studio.processes import start_beside
from fuzz.studio.refusals import our_fault, refusal
from worldgen.errors import Message, WorldgenError

__all__ = ["LANES", "Ended", "Worker"]

_NICE = 5  # the page comes first

LANES = {
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
    "shift": "making",
    "measure": "widths",
    "run": "runs",
    "check": "looks",
    "picture": "pictures",
    "before": "pictures",
    "begin": "campaigns",
    "command": "campaigns",
    "resume": "campaigns",
    "watch": "watching",
    "stop": "watching",
    "campaigns": "walls",
    "failures": "walls",
    "know": "walls",
    "look": "looks",
    "elite": "looks",
    "snippet": "looks",
}
"""Which process does what.

What is saved is never ended, a long search for a proof stops no run, and
what takes long to begin can be stopped meanwhile."""


class Ended(Exception):
    """The work was ended before it was done."""


class Worker:
    """A process that does one thing after the other.

    It starts with the first and after each end by force.

    Args:
        folder: What can be read and written.
        named: Controllers that were named at the start.
    """

    def __init__(self, folder: Folder, named: tuple[str, ...]) -> None:
        self._given = (str(folder.root), named)
        self._turn = asyncio.Lock()
        self._thread = ThreadPoolExecutor(
            1, "lane"
        )  # of its own: all that wait at once would use up asyncio's
        self._process: BaseProcess | None = None
        self._pipe: Connection | None = None

    async def ask(self, kind: str, message: dict[str, Any]) -> AsyncGenerator[tuple[str, Any]]:
        """Has one thing done.

        Yields:
            ``("turn", {})`` when its turn has come, ``("part", table)`` as often as there are
            parts, then ``("answer", table)`` or ``("error", refusal)``.

        Raises:
            Ended: If the process was ended meanwhile.
        """
        async with self._turn:
            yield "turn", {}
            pipe = self._pipe if self._process is not None and self._process.is_alive() else None
            pipe = pipe or self._start()
            heard_all = False
            wait = asyncio.get_running_loop().run_in_executor
            try:
                await wait(
                    self._thread, pipe.send, (kind, message)
                )  # a large one waits until the process has begun
                while not heard_all:
                    said = await wait(self._thread, pipe.recv)
                    heard_all = said[0] != "part"
                    yield said
            except (EOFError, OSError) as error:
                raise Ended from error
            finally:
                if not heard_all:
                    self.end()  # or the next one would hear the rest

    def warm(self) -> None:
        """Has the process begin, which takes a second, before anything is asked of it."""
        if self._process is None:
            self._start()

    def end(self) -> None:
        """Ends what is being done."""
        if self._process is not None:
            self._process.kill()
            self._process = None

    def _start(self) -> Connection:
        ours, theirs = multiprocessing.Pipe()
        process = start_beside(_work, theirs, *self._given, nice=_NICE)
        theirs.close()  # so that the end of the process is the end of the pipe
        self._process = process
        self._pipe = ours
        return ours


def _work(pipe: Connection, folder: str, named: tuple[str, ...]) -> None:
    """What the process does until the server is gone."""
    from fuzz.studio.answers import Answers  # noqa: PLC0415 - heavy: in this process only
    from fuzz.studio.running import allow_only  # noqa: PLC0415

    allow_only(named)
    answers = Answers(Folder(Path(folder)), named)
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            kind, message = pipe.recv()
            pipe.send(_answer(answers, kind, message, pipe))


def _answer(answers: Any, kind: str, message: dict[str, Any], pipe: Connection) -> tuple[str, Any]:
    try:
        return "answer", getattr(answers, kind)(message, lambda table: pipe.send(("part", table)))
    except (BrokenPipeError, EOFError):
        raise
    except WorldgenError as error:
        return "error", answers.folder.refusal(error)
    except UnicodeEncodeError:
        return "error", refusal(
            Message(
                "half-a-character",
                "the message has half of a character in a text",
                "send whole ones",
            )
        )
    except MemoryError:
        return "error", refusal(Message("out-of-memory", "out of memory", "take a smaller world"))
    except OSError as error:  # a full disk, of the temporary folder too
        return "error", answers.folder.refusal(
            Message(
                "disk-refuses",
                "the disk cannot do this: {reason}",
                "make room, or use another one",
                reason=error.strerror or str(error),
            )
        )
    except Exception as error:  # noqa: BLE001 - a fault of ours must not end the studio
        return "error", refusal(our_fault(error))
