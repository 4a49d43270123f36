"""One page's connection: receives requests, sends answers and their parts.

Some newer requests replace older ones of the same kind.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from fuzz.studio.campaigns.watching import Watching
from fuzz.studio.requests.protocol import (
    SUBPROTOCOL,
    Begins,
    Cancel,
    Reply,
    Request,
    decoded,
    encoded,
    number_of,
)
from fuzz.studio.requests.refusals import our_fault, refusal
from fuzz.studio.workers import Ended, Worker
from worldgen.errors import InvalidParameter, Message

# Seconds in which a replaced request may finish, because starting a new process takes longer.
_PATIENCE = 0.7
_WARM = {"campaigns": ("walls", "looks")}  # workers that the campaign page will use next
_MOST_WAITING = 64
_DIED = Message(
    "process-died",
    "the process that handled this has died: the controller ended or crashed Python, or memory "
    "ran out",
    "see its output in the studio's terminal; try again with another controller or a smaller world",
)
_NO_ID = Message("no-id", "a message needs its own id", "use another number")
_FULL = Message("too-many-waiting", "too many requests are waiting", "wait for answers")


@dataclass(eq=False)
class _Job:
    """A request that is being answered."""

    request: Request
    worker: Worker | Watching
    task: asyncio.Task[None] | None = None
    running: bool = False
    replaced: bool = False

    @property
    def is_over(self) -> bool:
        """Whether nobody wants its answer any more."""
        return self.replaced and self.request.can_end

    def end(self) -> None:
        """End it: a running one by ending its process, a waiting one by never starting it."""
        self.replaced = True
        if self.running and self.request.can_end:
            self.worker.end()


@dataclass(eq=False)
class Session:
    """One connection.

    Args:
        socket: The connection to the page.
        workers: The workers by name.
        begins: First message to the page.
    """

    socket: WebSocket
    workers: Mapping[str, Worker | Watching]
    begins: Begins
    _jobs: dict[int, _Job] = field(default_factory=dict)
    _newest: dict[type[Request], _Job] = field(default_factory=dict)

    async def serve(self) -> None:
        """Answer requests until the page disconnects."""
        await self.socket.accept(SUBPROTOCOL)
        await self._send(self.begins)
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                await self._take(await self._hear())
        for job in list(self._jobs.values()):
            job.end()

    async def _hear(self) -> str:
        try:
            return await self.socket.receive_text()
        except KeyError:  # raised by Starlette for bytes
            return ""

    async def _take(self, text: str) -> None:
        try:
            request = decoded(text)
        except InvalidParameter as error:
            await self._send(Reply(number_of(text), error=refusal(error)))
            return
        number = request.id
        if number in self._jobs:
            await self._send(Reply(-1, error=refusal(_NO_ID)))
        elif isinstance(request, Cancel):
            job = self._jobs.get(request.of)
            if job is not None and job.request.can_end:
                job.end()
            await self._send(Reply(number, answer=None))
        elif len(self._jobs) >= _MOST_WAITING:
            await self._send(Reply(number, error=refusal(_FULL)))
        else:
            self._begin(_Job(request, self.workers[request.worker]))

    def _begin(self, job: _Job) -> None:
        request = job.request
        old = self._newest.get(type(request)) if request.is_replaced else None
        if old is not None:
            old.replaced = True
        self._jobs[request.id] = self._newest[type(request)] = job
        job.task = asyncio.create_task(self._do(job, old))
        for name in _WARM.get(request.do, ()):
            # If a process cannot start now, a later request to it reports that.
            with contextlib.suppress(OSError):
                self.workers[name].warm()

    async def _do(self, job: _Job, old: _Job | None) -> None:
        """Do one job, after the one that it replaces has ended."""
        number = job.request.id
        reply = Reply(number, ended=True)
        try:
            if old is not None and old.task is not None and not old.task.done():
                await asyncio.wait({old.task}, timeout=_PATIENCE if old.running else 0)
                old.end()
            if not job.is_over:
                reply = await self._ask(job)
        except Ended:
            if not job.replaced:
                reply = Reply(number, error=refusal(_DIED))
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: the page has disconnected
            pass
        except Exception as error:  # noqa: BLE001 - without an answer the page would wait forever
            reply = Reply(number, error=refusal(our_fault(error)))
        finally:
            self._jobs.pop(number, None)
        # RuntimeError: the page has disconnected.
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._send(reply)

    async def _ask(self, job: _Job) -> Reply:
        try:
            # Stop reading parts as soon as a newer request replaces this one.
            async with contextlib.aclosing(job.worker.ask(job.request)) as replies:
                async for what, value, code in replies:
                    if job.is_over:
                        break
                    job.running = True
                    if what == "part":
                        await self._send(Reply(job.request.id, part=value, code=code))
                    elif what != "turn":
                        return Reply(job.request.id, **{what: value})
            raise Ended
        finally:
            job.running = False

    async def _send(self, message: Any) -> None:
        await self.socket.send_text(encoded(message).decode())
