"""Watching a campaign: its state as often as it changes, read from its folder beside everything else."""

from __future__ import annotations

import asyncio
import importlib
from collections.abc import AsyncGenerator
from typing import Any

from fuzz.studio.folder import Folder
from worldgen.errors import InvalidParameter, WorldgenError

__all__ = ["Watching"]

_EVERY = 0.5  # s between two looks
_OFTEN = 6  # looks without a change after which the state is told all the same: the clock goes on


class Watching:
    """Answers ``watch`` for any number of pages at once; the other lanes are processes and do one thing at a time.

    Args:
        folder: The opened one.
    """

    def __init__(self, folder: Folder) -> None:
        self._folder = folder

    async def ask(self, kind: str, message: dict[str, Any]) -> AsyncGenerator[tuple[str, Any]]:
        """Tells a campaign's state until it stands still.

        Yields:
            ``("turn", {})`` while nothing is new, ``("part", {"state": state})`` as often as there is something, then
            ``("answer", {"state": state})`` or ``("error", sentence)``.
        """
        before: dict[str, Any] = {}
        quiet = 0
        while True:
            try:
                state = await asyncio.to_thread(self._state, message)
            except WorldgenError as error:
                yield "error", self._folder.in_words(str(error))
                return
            except OSError as error:
                yield "error", f"the campaign's folder cannot be read: {error.strerror or error}; look at it again"
                return
            if not state["running"]:
                yield "answer", {"state": state}
                return
            changed = state | {"sitting": 0.0} != before or quiet >= _OFTEN
            before, quiet = state | {"sitting": 0.0}, 0 if changed else quiet + 1
            yield ("part", {"state": state}) if changed else ("turn", {})
            await asyncio.sleep(_EVERY)

    def warm(self) -> None:
        """Nothing: there is no process that would have to begin."""

    def end(self) -> None:
        """Nothing: who is not asked for more ends by itself."""

    def _state(self, message: dict[str, Any]) -> dict[str, Any]:
        name = str(message.get("folder"))
        reads = importlib.import_module("fuzz.studio.campaign_state")  # heavy: not before somebody watches
        place = self._folder.place(name)
        if not reads.is_own(place):
            raise InvalidParameter(f"{name!r} is no folder of a campaign in the opened one; give the name of another")
        state: dict[str, Any] = reads.campaign_state(place, name)
        return state
