"""Find the worlds behind a campaign's archive of behaviours: the simplest of each cell."""

from __future__ import annotations

from pathlib import Path

from fuzz.campaign.store import FolderStore, read_summary, stored_elites
from fuzz.layouts.features import decode_scene
from fuzz.search.histories import is_extreme
from fuzz.studio.requests.protocol import RecordedRun
from worldgen.errors import InvalidParameter
from worldgen.files.json_file import converted
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
        is_shown = cell[:2] == (i, j) and not is_extreme(cell)
        if is_shown and (quality, verdict) == shown:
            return decode_scene(bytes.fromhex(layout))
    raise InvalidParameter(
        "world-not-kept",
        "{name} no longer has the world of this cell",
        "resume the campaign",
        name=folder.name,
    )


def runs_in(folder: Path) -> RecordedRun | None:
    """Return what a campaign runs in its worlds; ``None`` if it varies its robots."""
    stored = FolderStore.stored_in(folder)
    configuration = stored[0].configuration if stored else {}
    if configuration.get("vary"):
        return None
    try:
        return converted(configuration.get("scenario"), RecordedRun)
    except ValueError:
        return None
