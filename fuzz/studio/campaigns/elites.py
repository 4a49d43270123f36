"""Find the worlds behind a campaign's archive of behaviours: the simplest of each cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fuzz.campaign.store import FolderStore, read_summary, stored_elites
from fuzz.layouts.features import decode_scene
from worldgen.errors import InvalidParameter
from worldgen.world import World


def elite_of(folder: Path, i: int, j: int) -> World:
    """Return the simplest world that a campaign has found for a cell of its archive.

    Args:
        folder: Folder of the campaign.
        i: Index of the cell along the archive's first axis.
        j: Index of the cell along the second axis.

    Raises:
        InvalidParameter: If the archive has no such cell, or the store no longer has its world.
        FormatError: If the campaign's files cannot be read.
    """
    summary = read_summary(folder)
    cells = [] if summary is None or summary.archive is None else summary.archive.cells
    shown = next(((quality, verdict) for x, y, quality, verdict in cells if (x, y) == (i, j)), None)
    if shown is None:
        raise InvalidParameter(
            "empty-cell",
            "the archive in {name} has no world in cell [{i}, {j}]",
            "choose a filled cell",
            name=folder.name,
            i=i,
            j=j,
        )
    for cell, layout, quality, verdict in stored_elites(folder):
        if cell[:2] == (i, j) and (quality, verdict) == shown:
            return decode_scene(bytes.fromhex(layout))
    raise InvalidParameter(
        "world-not-kept",
        "{name} no longer has the world of this cell",
        "resume the campaign",
        name=folder.name,
    )


def runs_in(folder: Path) -> dict[str, Any] | None:
    """Return the scenario of a campaign's worlds, in the form used for failures.

    Null if the campaign varies its robots.
    """
    stored = FolderStore.stored_in(folder)
    configuration = stored[0].configuration if stored else {}
    scenario = configuration.get("scenario")
    if (
        configuration.get("vary")
        or not isinstance(scenario, dict)
        or not isinstance(scenario.get("parameters"), dict)
    ):
        return None
    return {name: scenario.get(name) for name in ("controller", "motion", "seed", "parameters")}
