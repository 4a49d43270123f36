"""What a campaign's folder says of it while it runs and afterwards.

Whoever runs it, and from where.
"""

from __future__ import annotations

import contextlib
import os
import signal
import time
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY, FolderStore, read_error, read_summary
from fuzz.studio.refusals import refusal
from worldgen.errors import FormatError
from worldgen.files.locks import holder
from worldgen.files.worlds import is_world_file

__all__ = ["SAID", "campaign_state", "interrupt", "is_campaign", "is_own", "running_process"]

SAID = "studio.txt"
"""Name, in a campaign's memory, of what its process writes to stderr when the studio has started it; for a person."""

_ENDED_WELL = (
    "done",
    "stopped",
)  # what was refused afterwards, at a terminal, says nothing of the campaign


def is_campaign(folder: Path) -> bool:
    """Whether a campaign was begun in a folder."""
    return (folder / MEMORY / "campaign.json").is_file()


def is_own(folder: Path) -> bool:
    """Whether a campaign's memory holds files and folders alone.

    No link to somewhere else, no pipe to wait for.
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
    """The process that does a folder's campaign now; ``None`` if none does on this machine."""
    return holder(folder / MEMORY / "lock")


def interrupt(process: int) -> None:
    """Has a campaign's process end as Ctrl-C would, where the system can do that to another process."""
    with contextlib.suppress(ProcessLookupError):  # it has just ended by itself
        os.kill(process, signal.SIGTERM if os.name == "nt" else signal.SIGINT)


def campaign_state(folder: Path, name: str, opened: Path | None = None) -> dict[str, Any]:
    """A campaign in numbers.

    Args:
        folder: Where its failures are.
        name: As the page knows the folder.
        opened: The opened folder.

    Returns:
        As docs/reference/studio-protocol.md says of ``state``.

    Raises:
        FormatError: If its files cannot be read.
    """
    running = running_process(folder) is not None
    state: dict[str, Any] = {
        "folder": name,
        "running": running,
        **_budget(folder),
        **_totals(folder),
    }
    lock = folder / MEMORY / "lock"
    state["elapsed"] = max(0.0, time.time() - lock.stat().st_mtime) if running else None
    state["failures"] = _stamp(folder)
    error = None if running or state["status"] in _ENDED_WELL else read_error(folder)
    state["error"] = None if error is None else refusal(error, opened)
    return state


def _budget(folder: Path) -> dict[str, Any]:
    """Whose campaign it is and how far it is to go, as it was begun."""
    stored = FolderStore.stored_in(folder)
    if stored is None:
        raise FormatError("no-campaign", "holds no campaign", "begin one there", source=folder.name)
    fingerprint, budget = stored
    scenario = fingerprint.configuration.get("scenario")
    said = scenario if isinstance(scenario, dict) else {}
    return {
        "controller": str(said.get("controller", "")),
        "motion": str(said.get("motion", "")),
        "seed": str(
            fingerprint.configuration.get("seed", "")
        ),  # of 64 bits, which a browser's numbers cannot hold
        "budget": {
            part: value if isinstance(value := budget.get(part), int | float) else None
            for part in _BUDGET
        },
    }


_BUDGET = ("units", "seconds")


def _totals(folder: Path) -> dict[str, Any]:
    """What it did until now; zeros before it first says something."""
    summary = read_summary(folder)
    if summary is None:
        none: dict[str, Any] = {"units": 0, "worlds": 0, "steps": 0, "seconds": 0.0}
        return none | {
            "status": "",
            "verdicts": {},
            "met": {},
            "known": {},
            "lanes": [],
            "archive": None,
        }
    return {
        "controller": summary.controller,
        "status": summary.status,
        "units": summary.units,
        "worlds": summary.worlds,
        "steps": summary.steps,
        "seconds": summary.seconds,
        "verdicts": summary.verdicts,
        "met": summary.met,
        "known": summary.known,
        "lanes": [vars(lane) for lane in summary.lanes],
        "archive": None if summary.archive is None else vars(summary.archive),
    }


def _stamp(folder: Path) -> str:
    """Another text whenever a failure in the folder itself is new or smaller."""
    found = [
        (path.name, path.stat().st_mtime_ns)
        for path in folder.iterdir()
        if is_world_file(path.name)
    ]
    return f"{len(found)}-{max((when for _, when in found), default=0)}"
