"""One page's connection: receives requests, sends answers and their parts.

Some newer requests replace older ones of the same kind.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from fuzz.studio.campaigns.watching import Watching
from fuzz.studio.gate import SUBPROTOCOL
from fuzz.studio.requests.edits import Edits
from fuzz.studio.requests.refusals import our_fault, refusal
from fuzz.studio.workers import WORKER_OF, Ended, Worker
from worldgen.errors import Message

PROTOCOL = 3  # increased whenever an older page would not understand
# Only the newest request of these kinds counts.
_REPLACED = frozenset(
    {"compare", "decide", "edits", "generate", "measure", "run", "signal", "watch", "widest"}
)
# Requests that run controllers or take a long time, and write nothing, can be ended.
_ENDED = _REPLACED | {"before", "drive", "hello", "look", "picture"}
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
_NO_JSON = Message("not-json", "this is not JSON", "send one object")
_NO_ID = Message("no-id", "a message needs its own id, an integer from 0")
_FULL = Message("too-many-waiting", "too many requests are waiting", "wait for answers")


@dataclass(eq=False)
class _StudioRequest:
    """A request that is being answered."""

    number: int
    kind: str
    worker: Worker | Watching | Edits
    task: asyncio.Task[None] | None = None
    running: bool = False
    replaced: bool = False


@dataclass(eq=False)
class Session:
    """One connection.

    Args:
        socket: The connection to the page.
        workers: The workers by name.
        begins: First message to the page: the file to open, if the studio was started with one.
    """

    socket: WebSocket
    workers: Mapping[str, Worker | Watching | Edits]
    begins: Mapping[str, Any]
    _jobs: dict[int, _StudioRequest] = field(default_factory=dict)
    _newest: dict[str, _StudioRequest] = field(default_factory=dict)

    async def serve(self) -> None:
        """Answer requests until the page disconnects."""
        await self.socket.accept(SUBPROTOCOL)
        await self._send({"protocol": PROTOCOL, **self.begins})
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                await self._take(await self._hear())
        for job in list(self._jobs.values()):
            self._end(job)

    async def _hear(self) -> str:
        try:
            return await self.socket.receive_text()
        except KeyError:  # raised by Starlette for bytes
            return ""

    async def _take(self, text: str) -> None:
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            await self._send({"id": -1, "error": refusal(_NO_JSON)})
            return
        # Every request has an id that is not in use.
        number = message.get("id") if isinstance(message, dict) else None
        if type(number) is not int or number < 0 or number in self._jobs:
            await self._send({"id": -1, "error": refusal(_NO_ID)})
            return
        kind = message.get("do")
        if kind == "cancel":
            job = self._jobs.get(message.get("of", -1)) if type(message.get("of")) is int else None
            if job is not None and job.kind in _ENDED:
                self._end(job)
            await self._send({"id": number, "answer": {}})
        elif not isinstance(kind, str) or kind not in WORKER_OF:
            unknown = Message(
                "unknown-name",
                "there is no request {name!q}",
                "see the protocol",
                name=str(kind)[:40],
            )
            await self._send({"id": number, "error": refusal(unknown)})
        elif len(self._jobs) >= _MOST_WAITING:
            await self._send({"id": number, "error": refusal(_FULL)})
        else:
            self._begin(_StudioRequest(number, kind, self.workers[WORKER_OF[kind]]), message)

    def _begin(self, job: _StudioRequest, message: dict[str, Any]) -> None:
        old = self._newest.get(job.kind) if job.kind in _REPLACED else None
        if old is not None:
            old.replaced = True
        self._jobs[job.number] = self._newest[job.kind] = job
        job.task = asyncio.create_task(self._do(job, old, message))
        for name in _WARM.get(job.kind, ()):
            # If a process cannot start now, a later request to it reports that.
            with contextlib.suppress(OSError):
                self.workers[name].warm()

    async def _do(
        self, job: _StudioRequest, old: _StudioRequest | None, message: dict[str, Any]
    ) -> None:
        """Do one job, after the one that it replaces has ended."""
        reply: dict[str, Any] = {"ended": True}
        try:
            if old is not None and old.task is not None and not old.task.done():
                await asyncio.wait({old.task}, timeout=_PATIENCE if old.running else 0)
                self._end(old)
            if not (job.replaced and job.kind in _ENDED):
                reply = await self._ask(job, message)
        except Ended:
            if not job.replaced:
                reply = {"error": refusal(_DIED)}
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: the page has disconnected
            pass
        except Exception as error:  # noqa: BLE001 - without an answer the page would wait forever
            reply = {"error": refusal(our_fault(error))}
        finally:
            self._jobs.pop(job.number, None)
        # RuntimeError: the page has disconnected.
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._send({"id": job.number, **reply})

    async def _ask(self, job: _StudioRequest, message: dict[str, Any]) -> dict[str, Any]:
        try:
            # Stop reading parts as soon as a newer request replaces this one.
            async with contextlib.aclosing(job.worker.ask(job.kind, message)) as replies:
                async for what, table in replies:
                    if job.replaced and job.kind in _ENDED:
                        break
                    job.running = True
                    if what == "part":
                        await self._send({"id": job.number, "part": table})
                    elif what != "turn":
                        return {what: table}
            raise Ended
        finally:
            job.running = False

    def _end(self, job: _StudioRequest) -> None:
        """End a job: a running one by ending its process, a waiting one by never starting it."""
        job.replaced = True
        if job.kind in _ENDED and job.running:
            job.worker.end()

    async def _send(self, message: Mapping[str, Any]) -> None:
        await self.socket.send_text(json.dumps(message, separators=(",", ":"), allow_nan=False))
