"""Turn a manifest's lines back into worlds; the family must exist here in the same version."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES, RECIPE
from worldgen.sets.making import Job
from worldgen.sets.manifest import ManifestEntry

__all__ = ["entry_jobs"]


def entry_jobs(entries: Iterable[ManifestEntry], families: Sequence[str] = ()) -> list[Job]:
    """Return the jobs for these lines.

    Args:
        entries: The lines.
        families: Where to find unregistered families, as ``./file.py:name``.

    Raises:
        InvalidParameter: If a family is unknown or has a different version than in the manifest, or
            a parameter does not exist.
    """
    places = {FAMILIES.get(place).name: place for place in families}
    checked: dict[tuple[str, int], str] = {}
    jobs: list[Job] = []
    for entry in entries:
        key = (entry.family, entry.version)
        if key not in checked:
            checked[key] = _place(entry, places.get(entry.family, entry.family))
        # The families of a set are one object.
        if not jobs or entry.params is not jobs[-1].params:
            FAMILIES.find(checked[key], entry.params).complete(entry.params)
        jobs.append(Job(checked[key], entry.seed, entry.params, entry.metrics))
    return jobs


def _place(entry: ManifestEntry, place: str) -> str:
    # Its text is among the parameters.
    if place.startswith(RECIPE):
        return place
    if place == entry.family and place not in FAMILIES.names():
        raise InvalidParameter(
            "unknown-name",
            "the set is of family {family!r}, which is not one of {known!l}",
            "give its file: --family ./file.py:name",
            at_terminal=True,
            family=place,
            known=list(FAMILIES.names()),
        )
    found = FAMILIES.get(place)
    if found.version != entry.version:
        raise InvalidParameter(
            "other-version",
            "the set was made by {family} version {version}, but this is version {found}, which "
            "makes other worlds",
            "install the worldgen that the manifest names",
            family=entry.family,
            version=entry.version,
            found=found.version,
        )
    return place
