"""Watching a campaign, and stopping it.

By its folder, beside everything else, whatever the lanes are busy with.
"""

from __future__ import annotations

import asyncio
import importlib
import time
from collections.abc import AsyncGenerator
from pathlib import Path
from typing import Any

from fuzz.studio.beginning import end_beginnings
from fuzz.studio.folder import Folder
from worldgen.errors import InvalidParameter, Message, WorldgenError

__all__ = ["Watching"]

_EVERY = 0.5  # s between two looks
_ENDS = 2.0  # s that a campaign is waited for that was told to end; it may end later
_LOOK = 0.05  # s between two looks whether it has
_OFTEN = 6  # looks without a change after which the state is told all the same: the clock goes on


class Watching:
    """Answers ``watch`` and ``stop`` for any number of pages at once.

    Other lanes are processes that do one at a time.

    Args:
        folder: The opened one.
    """

    def __init__(self, folder: Folder) -> None:
        self._folder = folder

    async def ask(self, kind: str, message: dict[str, Any]) -> AsyncGenerator[tuple[str, Any]]:
        """Tells a campaign's state until it stands still; or has it stop, and tells the state then.

        Yields:
            ``("turn", {})`` while nothing is new, ``("part", {"state": state})`` as often as there
            is something, then ``("answer", {"state": state})`` or ``("error", refusal)``.
        """
        before: dict[str, Any] = {}
        quiet = 0
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
                            "look at it again",
                            reason=error.strerror or str(error),
                        )
                    ),
                )
                return
            if state is None or kind == "stop" or not state["running"]:
                yield "answer", {"state": state}
                return
            changed = state | {"elapsed": 0.0} != before or quiet >= _OFTEN
            before = state | {"elapsed": 0.0}
            quiet = 0 if changed else quiet + 1
            yield ("part", {"state": state}) if changed else ("turn", {})
            await asyncio.sleep(_EVERY)

    def warm(self) -> None:
        """Nothing: there is no process that would have to begin."""

    def end(self) -> None:
        """Nothing: who is not asked for more ends by itself."""

    def _state(self, message: dict[str, Any]) -> dict[str, Any] | None:
        name = str(message.get("folder"))
        place = self._place(name)
        state: dict[str, Any] = _reads().campaign_state(place, name, self._folder.root)
        return state

    def _stop(self, message: dict[str, Any]) -> dict[str, Any] | None:
        """Has a campaign end as Ctrl-C would.

        What has yet to begin is ended by the process that waits for it.
        """
        reads = _reads()
        place = self._place(str(message.get("folder")))
        process = reads.running_process(place)
        if process is not None:
            reads.interrupt(process)
        told = process is not None or end_beginnings(place / reads.MEMORY)
        until = time.monotonic() + _ENDS
        while (
            process is not None
            and reads.running_process(place) is not None
            and time.monotonic() < until
        ):
            time.sleep(_LOOK)
        return None if told and not reads.is_campaign(place) else self._state(message)

    def _place(self, name: str) -> Path:
        place = self._folder.place(name)
        if not _reads().is_own(place):
            raise InvalidParameter(
                "not-a-campaign-folder",
                "{name!r} is no folder of a campaign in the opened one",
                "give the name of another",
                name=name,
            )
        return place


def _reads() -> Any:
    return importlib.import_module(
        "fuzz.studio.campaign_state"
    )  # heavy: not before somebody watches
