"""Read the state of a campaign from its folder, while it runs and afterwards.

It does not matter who runs the campaign, or from where.
"""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

from fuzz.campaign.store import MARK, MEMORY, FolderStore, Status, Summary, read_error, read_summary
from fuzz.overview.answer import CampaignAnswer, answer_of
from fuzz.overview.result import read_overview
from fuzz.studio.requests.edits import digest_of_file
from fuzz.studio.requests.folder import Folder
from fuzz.studio.requests.protocol import CampaignState
from fuzz.studio.requests.refusals import refusal
from fuzz.studio.requests.running import names_of
from fuzz.unit.live import LiveState, not_arrived, read_live
from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.files.json_file import converted, plain
from worldgen.files.locks import holder
from worldgen.files.worlds import is_world_file
from worldgen.support.paths import expanded

SAID = "studio.txt"
"""Name, in the campaign store, of the stderr of a process that the studio started; for people."""

# A later refusal at a terminal, such as the refusal of a second start, does not concern the
# campaign.
_ENDED_WELL = (Status.DONE, Status.STOPPED)


def is_campaign(folder: Path) -> bool:
    """Return True if a campaign was begun in a folder."""
    return (folder / MEMORY / "campaign.json").is_file()


def is_own(folder: Path) -> bool:
    """Return True if a campaign store contains only files and folders.

    A link could lead elsewhere, and a pipe could block.
    """
    memory = folder / MEMORY
    if memory.is_symlink() or not memory.is_dir():
        return not memory.is_symlink()
    with os.scandir(memory) as entries:
        return all(
            entry.is_file(follow_symlinks=False) or entry.is_dir(follow_symlinks=False)
            for entry in entries
        )


def running_process(folder: Path) -> int | None:
    """Return the process that runs a folder's campaign; ``None`` if none on this machine does."""
    return holder(folder / MEMORY / "lock")


def interrupt(process: int) -> None:
    """End a campaign's process as Ctrl-C would, as far as the operating system allows that."""
    with contextlib.suppress(ProcessLookupError):  # it has already ended
        os.kill(process, signal.SIGTERM if os.name == "nt" else signal.SIGINT)


def own_folder(folder: Folder, name: str) -> Path:
    """Return a folder in the opened one whose campaign store is not a link to elsewhere.

    Raises:
        InvalidParameter: If it has such a link, or its name leads out of the opened folder.
    """
    out = folder.place(name)
    if out == folder.root or not is_own(out):
        raise InvalidParameter(
            "not-a-campaign-folder",
            "{name!r} is not a campaign's folder in the opened one",
            "choose another",
            name=name,
        )
    return out


def campaign_state(
    folder: Path, name: str, opened: Path | None = None, named: Sequence[str] = ()
) -> CampaignState:
    """Return the state of a campaign.

    Args:
        folder: Folder of its failures.
        name: Name of the folder on the page.
        opened: The opened folder.
        named: Controllers that were named when the studio was started. No other controller's file
            is read.

    Raises:
        FormatError: If its files cannot be read.
    """
    running = running_process(folder) is not None
    stored = FolderStore.stored_in(folder)
    if stored is None:
        raise FormatError("no-campaign", "holds no campaign", "begin one there", source=folder.name)
    fingerprint, budget = stored
    recorded = fingerprint.configuration.get("scenario")
    scenario = recorded if isinstance(recorded, dict) else {}
    controller = str(scenario.get("controller", ""))
    summary = read_summary(folder)
    # The totals so far; zeros before the campaign has written a summary.
    totals: dict[str, Any] = {} if summary is None else plain(summary)
    totals["archive"] = (
        None if summary is None or summary.archive is None else summary.archive.table()
    )
    state = converted(
        totals
        | {
            "folder": name,
            "running": running,
            "controller": controller,
            "edited": controller in names_of(tuple(named))
            and _is_edited(controller, fingerprint.code.get(f"controller {controller}")),
            "motion": str(scenario.get("motion", "")),
            "seed": str(fingerprint.configuration.get("seed", "")),
            "budget": plain(budget),
            "failures": _stamp(folder),
        },
        CampaignState,
    )
    state.failed = not_arrived(state.verdicts)
    if running:
        _add_live(state, read_live(folder / MEMORY))
        return state
    state.conclusion = _conclusion(folder, summary)
    status = Status.UNKNOWN if summary is None else summary.status
    error = None if status in _ENDED_WELL else read_error(folder)
    if error is not None or status == Status.FAILED:
        state.error = None if error is None else refusal(error, opened)
        state.activity = "gave-up"
    # A process that was killed has left the status "running".
    elif status in (Status.STOPPED, Status.RUNNING) or state.units < (budget.units or 0):
        state.activity = "stopped"
    return state


def _conclusion(folder: Path, summary: Summary | None) -> CampaignAnswer | None:
    """Return what a campaign found out; ``None`` if it has not ended, or its overview is damaged."""
    result = None
    with contextlib.suppress(WorldgenError):
        result = read_overview(folder)
    if result is None or summary is None:
        return None
    return answer_of(msgspec.structs.replace(result, summary=summary))


def _add_live(state: CampaignState, live: LiveState | None) -> None:
    """Add to a running campaign's state what it has done since its last summary.

    A process on another machine may be unable to write the file.
    """
    state.elapsed = 0.0 if live is None else live.elapsed
    state.activity = "preparing" if live is None else live.phase.value
    if live is None:
        return
    state.shrinking = live.shrinking
    # The summary still counts a resumed campaign's earlier runs until the campaign has read them
    # again.
    state.worlds = max(state.worlds, live.worlds)
    state.steps = max(state.steps, live.steps)
    state.failed = max(state.failed, live.failed)


def _is_edited(controller: str, digest: str | None) -> bool:
    """Return True if a controller's file differs from the one that a campaign runs."""
    place = controller.rpartition(":")[0]
    now = digest_of_file(str(expanded(place))) if place.endswith(".py") else ""
    return bool(now and digest) and now != digest


def _stamp(folder: Path) -> str:
    """Return a string that changes whenever a failure in the folder is new or smaller."""
    found = [
        (path.name, path.stat().st_mtime_ns)
        for path in folder.iterdir()
        if is_world_file(path.name)
    ]
    return f"{len(found)}-{max((when for _, when in found), default=0)}"


@contextlib.contextmanager
def beginning(memory: Path) -> Iterator[Path]:
    """Keep a mark in a campaign's store while the campaign is about to begin.

    Removing the mark ends the campaign before it has begun.

    Args:
        memory: The store, which must exist.
    """
    mark = memory / f"{MARK}{os.getpid()}"
    mark.touch()
    try:
        yield mark
    finally:
        mark.unlink(missing_ok=True)


def end_beginnings(folder: Path) -> bool:
    """End all campaigns that are about to begin in a folder; return True if there were any."""
    memory = folder / MEMORY
    marks = list(memory.glob(f"{MARK}*")) if memory.is_dir() else []
    for mark in marks:
        mark.unlink(missing_ok=True)
    return bool(marks)
