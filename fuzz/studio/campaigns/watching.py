"""Answers that need no process of their own: the server watches files for any number of pages."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncGenerator, Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY
from fuzz.studio.campaigns import state as states
from fuzz.studio.requests.edits import code_files, digest_of_file, own_files
from fuzz.studio.requests.folder import Folder
from fuzz.studio.requests.protocol import CampaignState, Request, Stop, Watch
from worldgen.errors import Message, WorldgenError

_CODE_EVERY = 0.25  # s between checks of the files of code
_EVERY = 0.5  # s between checks of a campaign
_ENDS = 2.0  # s to wait for a campaign that was stopped; it may end later
_LOOK = 0.05  # s between checks for its end


class Watching:
    """Answers ``edits``, ``watch`` and ``stop``; other workers do one thing at a time.

    Args:
        folder: The opened folder.
        named: Controllers that were named at the start.
        loaded: Returns the files that the studio's processes have loaded, such as those that a
            controller imports from its folder.
    """

    def __init__(
        self, folder: Folder, named: Sequence[str] = (), loaded: Callable[[], Iterable[str]] = tuple
    ) -> None:
        self._folder = folder
        self._named = tuple(named)
        self._loaded = loaded

    def ask(self, request: Request) -> AsyncGenerator[tuple[str, Any, dict[str, str]]]:
        """Answer a request; see ``Worker.ask``."""
        if isinstance(request, Watch | Stop):
            return self._campaign(request)
        return self._edits()

    async def _edits(self) -> AsyncGenerator[tuple[str, Any, dict[str, str]]]:
        """Report the files of the named controllers now, and whenever they have changed."""
        shown: dict[str, str] | None = None
        before: dict[str, str] = {}
        while True:
            now = await asyncio.to_thread(self._digests)
            # A file is empty for a moment while an editor writes it, so wait until it stays.
            if shown is None or (now == before and now != shown):
                shown = now
                yield "part", code_files(now, self._named), {}
            else:
                yield "turn", None, {}
            before = now
            await asyncio.sleep(_CODE_EVERY)

    def _digests(self) -> dict[str, str]:
        files = {file for label in self._named for file in own_files(label)}
        return {file: digest_of_file(file) for file in sorted(files | set(self._loaded()))}

    async def _campaign(
        self, request: Watch | Stop
    ) -> AsyncGenerator[tuple[str, Any, dict[str, str]]]:
        """Report a campaign's state until it ends; or stop it, and report the state then."""
        before: CampaignState | None = None
        while True:
            try:
                state = await asyncio.to_thread(self._read, request)
            except WorldgenError as error:
                yield "error", self._folder.refusal(error), {}
                return
            except OSError as error:
                reason = error.strerror or str(error)
                problem = "the campaign's folder cannot be read: {reason}"
                fault = Message("unreadable", problem, "try again", reason=reason)
                yield "error", self._folder.refusal(fault), {}
                return
            if state is None or isinstance(request, Stop) or not state.running:
                yield "answer", state, {}
                return
            # While it runs, at least the elapsed time changes, so that the page's clock ticks.
            yield ("part" if state != before else "turn"), state, {}
            before = state
            await asyncio.sleep(_EVERY)

    def warm(self) -> None:
        """Do nothing: there is no process to start."""

    def end(self) -> None:
        """Do nothing: the generator ends when nobody reads from it."""

    def _read(self, request: Watch | Stop) -> CampaignState | None:
        """Return a campaign's state, after ending it as Ctrl-C would if it is to be stopped.

        If it has not begun yet, the process that waits for it to begin ends it.
        """
        place = states.own_folder(self._folder, request.folder)
        if isinstance(request, Stop) and _stopped(place) and not states.is_campaign(place):
            return None
        return states.campaign_state(place, request.folder, self._folder.root, self._named)


def _stopped(place: Path) -> bool:
    """Stop a campaign and wait for its end; return True if there was one to stop."""
    process = states.running_process(place)
    if process is None:
        return states.end_beginnings(place / MEMORY)
    states.interrupt(process)
    until = time.monotonic() + _ENDS
    while states.running_process(place) is not None and time.monotonic() < until:
        time.sleep(_LOOK)
    return True
