"""Watch and stop campaigns by their folders, independently of the workers."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncGenerator, Sequence
from pathlib import Path
from typing import Any

from fuzz.studio.requests.folder import Folder
from worldgen.errors import InvalidParameter, Message, WorldgenError

_EVERY = 0.5  # s between checks of a campaign
_ENDS = 2.0  # s to wait for a campaign that was stopped; it may end later
_LOOK = 0.05  # s between checks for its end


class Watching:
    """Answers ``watch`` and ``stop`` for any number of pages at the same time.

    Other workers are processes that do one thing at a time.

    Args:
        folder: The opened folder.
        named: Controllers that were named at the start.
    """

    def __init__(self, folder: Folder, named: Sequence[str] = ()) -> None:
        self._folder = folder
        self._named = tuple(named)

    async def ask(self, kind: str, message: dict[str, Any]) -> AsyncGenerator[tuple[str, Any]]:
        """Report a campaign's state until it ends; or stop it, and report the state then.

        Yields:
            ``("turn", {})`` while nothing is new, ``("part", {"state": state})`` after each change,
            then ``("answer", {"state": state})`` or ``("error", refusal)``.
        """
        before: dict[str, Any] = {}
        while True:
            try:
                state = await asyncio.to_thread(
                    self._stop if kind == "stop" else self._state, message
                )
            except WorldgenError as error:
                yield "error", self._folder.refusal(error)
                return
            except OSError as error:
                yield (
                    "error",
                    self._folder.refusal(
                        Message(
                            "unreadable",
                            "the campaign's folder cannot be read: {reason}",
                            "try again",
                            reason=error.strerror or str(error),
                        )
                    ),
                )
                return
            if state is None or kind == "stop" or not state["running"]:
                yield "answer", {"state": state}
                return
            # While it runs, at least the elapsed time changes, so that the page's clock ticks.
            yield ("part", {"state": state}) if state != before else ("turn", {})
            before = state
            await asyncio.sleep(_EVERY)

    def warm(self) -> None:
        """Do nothing: there is no process to start."""

    def end(self) -> None:
        """Do nothing: the generator ends when nobody reads from it."""

    def _state(self, message: dict[str, Any]) -> dict[str, Any] | None:
        name = str(message.get("folder"))
        place = self._place(name)
        state: dict[str, Any] = _reads().campaign_state(place, name, self._folder.root, self._named)
        return state

    def _stop(self, message: dict[str, Any]) -> dict[str, Any] | None:
        """End a campaign as Ctrl-C would.

        If it has not begun yet, the process that waits for it to begin ends it.
        """
        reads = _reads()
        place = self._place(str(message.get("folder")))
        process = reads.running_process(place)
        if process is not None:
            reads.interrupt(process)
        stopped = process is not None or reads.end_beginnings(place / reads.MEMORY)
        until = time.monotonic() + _ENDS
        while (
            process is not None
            and reads.running_process(place) is not None
            and time.monotonic() < until
        ):
            time.sleep(_LOOK)
        return None if stopped and not reads.is_campaign(place) else self._state(message)

    def _place(self, name: str) -> Path:
        place = self._folder.place(name)
        if not _reads().is_own(place):
            raise InvalidParameter(
                "not-a-campaign-folder",
                "{name!r} is not a campaign's folder in the opened one",
                "choose another",
                name=name,
            )
        return place


def _reads() -> Any:
    # Expensive to import, so not before a page watches a campaign.
    from fuzz.studio.campaigns import state  # noqa: PLC0415

    return state
