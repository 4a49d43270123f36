"""Open a campaign's folder, for a new campaign or to continue the same one.

A folder is refused for any other use.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass, replace
from pathlib import Path

from fuzz.campaign.store.fingerprint import (
    Fingerprint,
    config_of,
    controller_source,
    fingerprint_of,
    pace_of,
)
from fuzz.campaign.store.folder import Budget, FolderStore
from fuzz.unit.config import CampaignConfig
from worldgen.errors import FormatError, OutputError, WorldgenError
from worldgen.support.plain_text import shown

_WITH_ITS_CODE = "resume it in its original folder, with its original code"

# Limit on the differences to list.
_SAID_AT_MOST = 3


@dataclass(frozen=True)
class CampaignRun:
    """A campaign that may begin or continue.

    Args:
        config: Definition of the campaign.
        store: Its store, locked until it is closed.
        budget: Its budget.
        done: Units already in the folder.
    """

    config: CampaignConfig
    store: FolderStore
    budget: Budget
    done: int


def stored_seed(out: Path) -> int | None:
    """Return the seed of the campaign in a folder, or ``None`` if none can be read."""
    try:
        stored = FolderStore.stored_in(out)
        return None if stored is None else int(stored[0].configuration["seed"])
    except (FormatError, KeyError, OverflowError, TypeError, ValueError):
        return None


def with_stored_pace(config: CampaignConfig, out: Path) -> CampaignConfig:
    """Return a configuration with the pace of the same campaign in a folder, if there is one.

    A campaign keeps the pace with which it began, although the clock now gives another.
    """
    try:
        stored = FolderStore.stored_in(out)
        if stored is None:
            return config
        before = dict(stored[0].configuration)
        kept = replace(config, measured=pace_of(before.get("measured")))
        now = fingerprint_of(kept).configuration
    except (FormatError, KeyError, OverflowError, TypeError, ValueError):
        return config
    return kept if before == now else config


def controller_change(folder: Path, controller: str) -> str:
    """Return a sentence if a controller's file is not the one that a campaign ran.

    Only the file that defines it counts, not those that it imports.

    Args:
        folder: The campaign's folder.
        controller: Name of the controller.

    Returns:
        The sentence; empty if the file is the same, or if that is not known because the campaign
        had another controller.
    """
    try:
        stored = FolderStore.stored_in(folder)
        if stored is None or stored[0].configuration["scenario"]["controller"] != controller:
            return ""
        name, digest = controller_source(controller)
    except (KeyError, OSError, TypeError, WorldgenError):
        return ""
    if stored[0].code.get(name, digest) == digest:
        return ""
    return (
        f"{shown(controller)} has changed since the campaign in {shown(folder)}; what is shown is "
        "what it does now"
    )


def begin(config: CampaignConfig, out: Path, budget: Budget, *, force: bool = False) -> CampaignRun:
    """Begin a campaign in a folder, or continue the same one.

    A campaign that has neither done nor found anything may be replaced by another.

    Args:
        config: Definition of the campaign.
        out: The folder; created if missing.
        budget: Its budget.
        force: True to discard another campaign's results there, and to replace files of the same
            name.

    Raises:
        OutputError: If the folder holds other files, another process is writing it, or it cannot be
            written.
        FormatError: If its store cannot be read.
    """
    stored = None if force else FolderStore.stored_in(out)
    if stored is None and not force and out.is_dir() and any(out.glob("*.grid")):
        raise OutputError(
            "folder-holds-worlds",
            "{out} already holds .grid files",
            "use --force to add to them and replace those of the same name, or choose another "
            "folder",
            at_terminal=True,
            out=out,
        )
    fingerprint = fingerprint_of(config)
    store = FolderStore(out)
    try:
        if force or not store.has_results():
            store.forget()
        # Check again, because another process may have started.
        stored = FolderStore.stored_in(out)
        if stored is not None:
            _refuse_another(out, stored[0], fingerprint)
        return _open_run(config, store, fingerprint, budget)
    except BaseException:
        store.close()
        raise


def resume(out: Path, budget: Budget | None = None) -> CampaignRun:
    """Continue the campaign in a folder.

    Args:
        out: The folder.
        budget: Its budget; as before if omitted.

    Raises:
        OutputError: If there is none, other code did it, or its folder is unavailable.
        FormatError: If its store cannot be read.
        WorldgenError: If its configuration is unavailable here, such as a missing controller.
    """
    stored = FolderStore.stored_in(out)
    if stored is None:
        raise OutputError(
            "no-campaign",
            "{out} holds no campaign to resume",
            "worldgen fuzz --controller NAME --out {out} begins one",
            at_terminal=True,
            out=out,
        )
    fingerprint, before = stored
    try:
        config = config_of(fingerprint.configuration, str(out))
    except (AttributeError, KeyError, OverflowError, TypeError, ValueError) as error:
        raise FormatError(
            "invalid-campaign",
            "its configuration cannot be read: {reason}",
            "choose another folder, or start over with --force",
            at_terminal=True,
            reason=str(error),
            source=str(out),
        ) from error
    now = fingerprint_of(config)
    _refuse_another(out, fingerprint, now)
    store = FolderStore(out)
    try:
        return _open_run(config, store, now, budget or before)
    except BaseException:
        store.close()
        raise


def _open_run(
    config: CampaignConfig, store: FolderStore, fingerprint: Fingerprint, budget: Budget
) -> CampaignRun:
    done = store.units_done()
    if budget.units is not None and done > budget.units:
        raise OutputError(
            "campaign-is-further",
            "the campaign in {out} has already done {units} units",
            "use --units {units} or more, or --force to start over",
            at_terminal=True,
            out=store.out,
            units=done,
        )
    store.begin(fingerprint, budget)
    return CampaignRun(config, store, budget, done)


def _can_resume(out: Path, before: Fingerprint, now: Fingerprint) -> bool:
    """Return True if a stored campaign can be read, and its code is still the same.

    Of its code, only what another campaign has too is compared: the rest would have to be loaded,
    which nobody has asked for.
    """
    try:
        config_of(before.configuration, str(out))
    except (AttributeError, KeyError, OverflowError, TypeError, ValueError, WorldgenError):
        return False
    return all(before.code[name] == now.code[name] for name in before.code.keys() & now.code.keys())


def _refuse_another(out: Path, before: Fingerprint, now: Fingerprint) -> None:
    said = before.differences(now)
    if said:
        way_out = (
            f"worldgen fuzz --resume {shlex.quote(str(out))} continues that one"
            if before.configuration != now.configuration and _can_resume(out, before, now)
            else _WITH_ITS_CODE
        )
        more = f", and {len(said) - _SAID_AT_MOST} more" if len(said) > _SAID_AT_MOST else ""
        raise OutputError(
            "another-campaign",
            "{out} holds another campaign: {differences!l}{more}",
            "{way_out}, --force starts over, or choose another folder",
            at_terminal=True,
            out=out,
            differences=list(said[:_SAID_AT_MOST]),
            more=more,
            way_out=way_out,
        )
