"""Read the state of a campaign from its folder, while it runs and afterwards.

It does not matter who runs the campaign, or from where.
"""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY, FolderStore, Status, read_error, read_summary
from fuzz.studio.requests.edits import digest_of_file
from fuzz.studio.requests.refusals import refusal
from fuzz.studio.requests.running import names_of
from fuzz.unit.live import Phase, not_arrived, read_live
from worldgen.errors import FormatError
from worldgen.files.json_file import plain
from worldgen.files.locks import holder
from worldgen.files.worlds import is_world_file
from worldgen.support.paths import expanded

_TOTALS = (
    "controller", "status", "units", "worlds", "steps", "seconds", "verdicts", "met", "known",
    "strategies", "answer", "answer_reason",
)  # fmt: skip

# Name of the mark of a campaign that is about to begin. The number of the waiting process follows,
# since two studios may begin a campaign in one folder.
_MARK = "studio.begins."

SAID = "studio.txt"
"""Name, in the campaign store, of the stderr of a process that the studio started; for people."""

# A later refusal at a terminal, such as the refusal of a second start, does not concern the
# campaign.
_ENDED_WELL = (Status.DONE, Status.STOPPED)


class Activity(StrEnum):
    """What a campaign is doing, or how it ended."""

    PREPARING = "preparing"
    SEARCHING = "searching"
    SHRINKING = "shrinking"
    EXPLAINING = "explaining"
    STOPPED = "stopped"
    DONE = "done"
    GAVE_UP = "gave-up"


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


def campaign_state(
    folder: Path, name: str, opened: Path | None = None, named: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the state of a campaign.

    Args:
        folder: Folder of its failures.
        name: Name of the folder on the page.
        opened: The opened folder.
        named: Controllers that were named when the studio was started. No other controller's file
            is read.

    Returns:
        The table ``state`` of fuzz/studio/protocol.md.

    Raises:
        FormatError: If its files cannot be read.
    """
    running = running_process(folder) is not None
    state: dict[str, Any] = {
        "folder": name,
        "running": running,
        **_beginning(folder, named),
        **_totals(folder),
    }
    # A process that was killed leaves the file behind, and a process on another machine may be
    # unable to write it.
    live = read_live(folder / MEMORY) if running else None
    state["elapsed"] = (0.0 if live is None else live.elapsed) if running else None
    state["shrinking"] = 0 if live is None else live.shrinking
    state["failed"] = not_arrived(state["verdicts"])
    if live is not None:
        # The summary still counts a resumed campaign's earlier runs until the campaign has read
        # them again.
        counted = {"worlds": live.worlds, "steps": live.steps, "failed": live.failed}
        state |= {name: max(state[name], count) for name, count in counted.items()}
    state["failures"] = _stamp(folder)
    status = state.pop("status")
    error = None if running or status in _ENDED_WELL else read_error(folder)
    state["error"] = None if error is None else refusal(error, opened)
    if running:
        state["activity"] = Activity(Phase.PREPARING if live is None else live.phase)
    elif error is not None or status == Status.FAILED:
        state["activity"] = Activity.GAVE_UP
    else:
        # A process that was killed has left the status "running".
        stopped = status in (Status.STOPPED, Status.RUNNING) or (
            state["units"] < (state["budget"]["units"] or 0)
        )
        state["activity"] = Activity.STOPPED if stopped else Activity.DONE
    return state


def _beginning(folder: Path, named: Sequence[str]) -> dict[str, Any]:
    """Return the controller, seed and budget with which the campaign was begun.

    Also report if the controller's file has been edited since then.
    """
    stored = FolderStore.stored_in(folder)
    if stored is None:
        raise FormatError("no-campaign", "holds no campaign", "begin one there", source=folder.name)
    fingerprint, budget = stored
    scenario = fingerprint.configuration.get("scenario")
    recorded = scenario if isinstance(scenario, dict) else {}
    return {
        "controller": (controller := str(recorded.get("controller", ""))),
        "edited": controller in names_of(tuple(named))
        and _is_edited(controller, fingerprint.code.get(f"controller {controller}")),
        "motion": str(recorded.get("motion", "")),
        # A 64-bit seed is text, because a browser's numbers cannot hold it.
        "seed": str(fingerprint.configuration.get("seed", "")),
        "budget": plain(budget),
    }


def _is_edited(controller: str, digest: str | None) -> bool:
    """Return True if a controller's file differs from the one that a campaign runs."""
    place = controller.rpartition(":")[0]
    now = digest_of_file(str(expanded(place))) if place.endswith(".py") else ""
    return bool(now and digest) and now != digest


def _totals(folder: Path) -> dict[str, Any]:
    """Return the totals so far; zeros before the campaign has written a summary."""
    summary = read_summary(folder)
    if summary is None:
        counts: dict[str, Any] = dict.fromkeys(("units", "worlds", "steps"), 0)
        tables: dict[str, Any] = {name: {} for name in ("verdicts", "met", "known")}
        return {
            "status": Status.UNKNOWN,
            **counts,
            "seconds": 0.0,
            **tables,
            "strategies": [],
            "answer": "",
            "answer_reason": "",
            "archive": None,
        }
    archive = None if summary.archive is None else summary.archive.table()
    whole = plain(summary)
    return {name: whole.get(name, "") for name in _TOTALS} | {"archive": archive}


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
    mark = memory / f"{_MARK}{os.getpid()}"
    mark.touch()
    try:
        yield mark
    finally:
        mark.unlink(missing_ok=True)


def end_beginnings(memory: Path) -> bool:
    """End all campaigns that are about to begin in a store; return True if there were any."""
    marks = list(memory.glob(f"{_MARK}*")) if memory.is_dir() else []
    for mark in marks:
        mark.unlink(missing_ok=True)
    return bool(marks)
