"""Processes in which the work is done: the server stays live, and what nobody wants any more can be ended."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import signal
from collections.abc import AsyncGenerator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from fuzz.studio.folder import Folder
from worldgen.errors import WorldgenError

__all__ = ["LANES", "Ended", "Lane"]

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
    "measure": "widths",
    "run": "runs",
    "picture": "pictures",
    "before": "pictures",
    "campaigns": "campaigns",
    "begin": "campaigns",
    "resume": "campaigns",
    "stop": "campaigns",
    "watch": "watching",
    "failures": "walls",
    "know": "walls",
    "look": "looks",
    "snippet": "looks",
}
"""Which process does what: what is saved is never ended, and a long search for a proof stops no run."""


class Ended(Exception):
    """The work was ended before it was done."""


class Lane:
    """A process that does one thing after the other; it starts with the first and after each end by force.

    Args:
        folder: What can be read and written.
        named: Controllers that were named at the start.
    """

    def __init__(self, folder: Folder, named: tuple[str, ...]) -> None:
        self._given = (str(folder.root), named)
        self._turn = asyncio.Lock()
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None

    async def ask(self, kind: str, message: dict[str, Any]) -> AsyncGenerator[tuple[str, Any]]:
        """Has one thing done.

        Yields:
            ``("turn", {})`` when its turn has come, ``("part", table)`` as often as there are parts, then
            ``("answer", table)`` or ``("error", sentence)``.

        Raises:
            Ended: If the process was ended meanwhile.
        """
        async with self._turn:
            yield "turn", {}
            pipe = self._pipe if self._process is not None and self._process.is_alive() else None
            pipe = pipe or self._start()
            heard_all = False
            try:
                pipe.send((kind, message))
                while not heard_all:
                    said = await asyncio.to_thread(pipe.recv)
                    heard_all = said[0] != "part"
                    yield said
            except (EOFError, OSError) as error:
                raise Ended from error
            finally:
                if not heard_all:
                    self.end()  # or the next one would hear the rest

    def end(self) -> None:
        """Ends what is being done."""
        if self._process is not None:
            self._process.kill()
            self._process = None

    def _start(self) -> Connection:
        ours, theirs = multiprocessing.Pipe()
        context = multiprocessing.get_context("spawn")
        self._process = context.Process(target=_work, args=(theirs, *self._given), daemon=True)
        self._process.start()
        theirs.close()  # so that the end of the process is the end of the pipe
        self._pipe = ours
        return ours


def _work(pipe: Connection, folder: str, named: tuple[str, ...]) -> None:
    """What the process does until the server is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's
    with contextlib.suppress(OSError):
        os.nice(5)  # the page comes first
    from fuzz.studio.answers import Answers  # noqa: PLC0415 - heavy: in this process only

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
        return "error", str(error)
    except MemoryError:
        return "error", "out of memory; take a smaller world"
    except Exception as error:  # noqa: BLE001 - a fault of ours must not end the studio
        return "error", f"a fault of our own, not of your input: {type(error).__name__}: {error}"
