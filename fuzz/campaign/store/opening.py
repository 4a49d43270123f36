"""Opens a campaign's folder: for a new campaign, to go on with the same one, and for nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.store.fingerprint import Setup, config_of, setup_of
from fuzz.campaign.store.folder import CampaignFolder
from worldgen.errors import FormatError, OutputError

__all__ = ["Goal", "Sitting", "begin", "resume", "stored_seed"]

_SAID_AT_MOST = 3  # differences


@dataclass(frozen=True)
class Goal:
    """How long a campaign is to search.

    Args:
        units: Amount of work, or ``None``.
        seconds: Time, of this sitting alone, or ``None``.
    """

    units: int | None = None
    seconds: float | None = None


@dataclass(frozen=True)
class Sitting:
    """A campaign that may begin, or go on.

    Args:
        config: What to look for.
        folder: Its memory, ours until it is closed.
        goal: How long.
        done: Units that the folder holds already.
    """

    config: CampaignConfig
    folder: CampaignFolder
    goal: Goal
    done: int


def stored_seed(out: Path) -> int | None:
    """The seed of the campaign in a folder, ``None`` if there is none, or none that can be read."""
    try:
        stored = CampaignFolder.stored_in(out)
        return None if stored is None else int(stored[0].configuration["seed"])
    except (FormatError, KeyError, OverflowError, TypeError, ValueError):
        return None


def begin(config: CampaignConfig, out: Path, goal: Goal, *, force: bool = False) -> Sitting:
    """Begins a campaign in a folder, or goes on with the same one; one that did nothing yet makes room for another.

    Args:
        config: What to look for.
        out: The folder; made if it is missing.
        goal: How long.
        force: Forget what another campaign did there, and replace files of the same name.

    Raises:
        OutputError: If the folder holds something else, another process is writing it, or it cannot be written.
        FormatError: If its memory cannot be read.
    """
    stored = None if force else CampaignFolder.stored_in(out)
    if stored is None and not force and out.is_dir() and any(out.glob("*.grid")):
        raise OutputError(
            "folder-holds-worlds",
            "{out} holds .grid files already",
            "give --force to add to them and replace those of the same name, or name another folder",
            at_terminal=True,
            out=out,
        )
    setup, folder = setup_of(config), CampaignFolder(out)
    try:
        if force or not folder.units_done():
            folder.forget()
        stored = CampaignFolder.stored_in(out)  # again, for another process may have begun
        if stored is not None:
            _refuse_another(out, stored[0], setup, f"worldgen fuzz --resume {out} goes on with that one")
        return _sitting(config, folder, setup, goal)
    except BaseException:
        folder.close()
        raise


def resume(out: Path, goal: Goal | None = None) -> Sitting:
    """Goes on with the campaign in a folder.

    Args:
        out: The folder.
        goal: How long; as before if left out.

    Raises:
        OutputError: If there is none, it was done by other code, or its folder cannot be had.
        FormatError: If its memory cannot be read.
        WorldgenError: If its configuration cannot be had here: its controller is missing, say.
    """
    stored = CampaignFolder.stored_in(out)
    if stored is None:
        raise OutputError(
            "no-campaign",
            "{out} holds no campaign to resume",
            "worldgen fuzz --controller NAME --out {out} begins one",
            at_terminal=True,
            out=out,
        )
    setup, before = stored
    try:
        config = config_of(setup.configuration)
        wanted = goal or _goal(before)
    except (AttributeError, KeyError, OverflowError, TypeError, ValueError) as error:
        raise FormatError(
            "invalid-campaign",
            "its configuration cannot be read: {reason}",
            "name another folder, or begin anew with --force",
            at_terminal=True,
            reason=str(error),
            source=str(out),
        ) from error
    now = setup_of(config)
    _refuse_another(out, setup, now, "resume it in the folder and with the code with which it began")
    folder = CampaignFolder(out)
    try:
        return _sitting(config, folder, now, wanted)
    except BaseException:
        folder.close()
        raise


def _sitting(config: CampaignConfig, folder: CampaignFolder, setup: Setup, goal: Goal) -> Sitting:
    done = folder.units_done()
    if goal.units is not None and done > goal.units:
        raise OutputError(
            "campaign-is-further",
            "the campaign in {out} has done {units} units already",
            "give --units {units} or more, or --force to begin anew",
            at_terminal=True,
            out=folder.out,
            units=done,
        )
    folder.begin(setup, {"units": goal.units, "seconds": goal.seconds})
    return Sitting(config, folder, goal, done)


def _goal(said: Mapping[str, Any]) -> Goal:
    units, seconds = said["units"], said["seconds"]
    return Goal(None if units is None else int(units), None if seconds is None else float(seconds))


def _refuse_another(out: Path, before: Setup, now: Setup, way_out: str) -> None:
    said = before.differences(now)
    if said:
        more = f", and {len(said) - _SAID_AT_MOST} more" if len(said) > _SAID_AT_MOST else ""
        raise OutputError(
            "another-campaign",
            "{out} holds another campaign: {differences!l}{more}",
            "{way_out}, --force begins anew, or name another folder",
            at_terminal=True,
            out=out,
            differences=list(said[:_SAID_AT_MOST]),
            more=more,
            way_out=way_out,
        )
