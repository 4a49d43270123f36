"""Worlds behind a campaign's archive of behaviours.

Of each kind the simplest, as the store has it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY, FolderStore, read_summary
from fuzz.search.features import decode_scene
from worldgen.errors import FormatError, InvalidParameter
from worldgen.files.whole import read_text
from worldgen.world import World

__all__ = ["elite_of", "runs_in"]


def elite_of(folder: Path, i: int, j: int) -> World:
    """The simplest world that a campaign has met in a cell of its archive.

    Args:
        folder: Of the campaign.
        i: The cell along the archive's first axis.
        j: Likewise, along the second.

    Raises:
        InvalidParameter: If the archive has no such cell, or the store does not know its world any
            more.
        FormatError: If the campaign's files cannot be read.
    """
    summary = read_summary(folder)
    cells = [] if summary is None or summary.archive is None else summary.archive.cells
    shown = next(((quality, verdict) for x, y, quality, verdict in cells if (x, y) == (i, j)), None)
    if shown is None:
        raise InvalidParameter(
            "empty-cell",
            "the archive in {name} has nothing in cell [{i}, {j}]",
            "choose one that is filled",
            name=folder.name,
            i=i,
            j=j,
        )
    for cell, layout, quality, verdict in _elites(folder / MEMORY / "units"):
        if cell[:2] == [i, j] and (quality, verdict) == shown:
            return decode_scene(bytes.fromhex(layout))
    raise InvalidParameter(
        "world-not-kept",
        "{name} has not kept the world of this cell",
        "go on with the campaign",
        name=folder.name,
    )


def _elites(units: Path) -> Iterator[tuple[list[int], str, float, str]]:
    """What units have brought to the archive, in their order."""
    for file in sorted(units.glob("*.json")):
        if file.is_symlink() or not file.is_file():
            continue
        text = read_text(file)
        if '"elites": []' in text:
            continue
        try:
            for cell, layout, quality, verdict in json.loads(text)["elites"]:
                yield list(cell), str(layout), float(quality), str(verdict)
        except (KeyError, RecursionError, TypeError, ValueError) as error:
            raise FormatError(
                "invalid-entry",
                "is not an entry of a campaign store",
                "go on with the campaign, which mends it",
                source=str(file),
            ) from error


def runs_in(folder: Path) -> dict[str, Any] | None:
    """Who runs in a campaign's worlds, as the page wants it of a failure.

    Null where its robots are not all alike.
    """
    stored = FolderStore.stored_in(folder)
    said = stored[0].configuration if stored else {}
    scenario = said.get("scenario")
    if (
        said.get("vary")
        or not isinstance(scenario, dict)
        or not isinstance(scenario.get("parameters"), dict)
    ):
        return None
    return {name: scenario.get(name) for name in ("controller", "motion", "seed", "parameters")}
