"""Make a set from a plan or from a manifest, and continue one that was interrupted."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from worldgen.errors import InvalidParameter, OutputError, WorldgenError
from worldgen.family import FAMILIES
from worldgen.plugins.trust import admit_argument
from worldgen.sets.making import Job, Made, make_all
from worldgen.sets.manifest import MANIFEST, Manifest, ManifestEntry, ManifestHeader, read_manifest
from worldgen.sets.plan import SetPlan
from worldgen.sets.stores import PART, SetArchive, SetFolder, store_for

Progress = Callable[[int], None]
"""Called with the number of worlds saved so far, at the beginning and after each."""


class SetDiffers(WorldgenError):
    """A world differs from its entry in the manifest; ``facts["file"]`` is the world's file."""


@dataclass(frozen=True)
class SetDone:
    """A finished set.

    Args:
        worlds: Number of worlds.
        resumed: Number of worlds that existed already.
    """

    worlds: int
    resumed: int


@dataclass(frozen=True)
class _Work:
    """The worlds to write.

    Args:
        header: First line of the manifest.
        count: Number of worlds.
        made: Makes the worlds, starting with this one.
        named: A file's name, and its line in the manifest.
        refuse: Raises an error if the existing set is another one, or is finished.
    """

    header: bytes
    count: int
    made: Callable[[int], Iterator[Made]]
    named: Callable[[int, Made], tuple[str, bytes]]
    refuse: Callable[[Manifest], None]


def begun_set(out: Path) -> ManifestHeader | None:
    """Return the header of an unfinished set in this place; ``None`` if unreadable."""
    folder = out if out.is_dir() else out.with_name(out.name + PART)
    try:
        found = read_manifest(folder / MANIFEST)
    # The process that writes there will report the problem.
    except WorldgenError:
        return None
    return None if found.finished else found.header


def make_set(
    plan: SetPlan,
    out: Path,
    *,
    workers: int = 1,
    force: bool = False,
    progress: Progress | None = None,
) -> SetDone:
    """Make a set as a folder or an archive, or continue the same set if it is unfinished.

    Args:
        plan: Contents of the set.
        out: A folder, or a file that ends in ``.zip``.
        workers: Number of processes; the bytes are the same for any number. A search uses only this
            process.
        force: True to replace what exists.
        progress: Called with the progress.

    Raises:
        OutputError: If something else exists there, or cannot be written; worlds made so far stay.
        GenerationFailed: If a world cannot be made or found.
    """
    header = plan.header

    def named(k: int, made: Made) -> tuple[str, bytes]:
        digests = (made.digest, made.sha256, len(made.data), made.metrics, made.stratum)
        entry = ManifestEntry(
            plan.file(k), header.family, header.version, made.seed, made.params, *digests
        )
        return entry.file, entry.line(header)

    def refuse(old: Manifest) -> None:
        # Compare the contents of the line, because older versions worded it differently.
        if old.header.line() != header.line():
            raise _other(old, header, out)

    work = _Work(
        header.line(), header.count, lambda first: plan.made(first, workers), named, refuse
    )
    return _fill(work, out, force, progress)


def regenerate_set(
    manifest: Manifest,
    out: Path,
    *,
    families: tuple[str, ...] = (),
    workers: int = 1,
    force: bool = False,
    progress: Progress | None = None,
) -> SetDone:
    """Rebuild a set from its manifest, byte for byte; each world is compared before it is written.

    Args:
        manifest: The manifest.
        out: As for :func:`make_set`; an unfinished set is continued, too.
        families: Where to find unregistered families, as ``./file.py:name``.
        workers: Number of processes.
        force: True to replace what exists.
        progress: Called with the progress.

    Raises:
        SetDiffers: If a world differs from the manifest; those before it stay.
        InvalidParameter: If a family is unknown or has another version.
        OutputError: As for :func:`make_set`.
    """
    jobs = _entry_jobs(manifest.entries, families)

    def named(k: int, made: Made) -> tuple[str, bytes]:
        _check_same(manifest.entries[k], made, manifest.header)
        return manifest.entries[k].file, manifest.lines[k]

    def refuse(old: Manifest) -> None:
        if old.first != manifest.first or old.lines != manifest.lines[: len(old.lines)]:
            raise _other(old, manifest.header, out)

    work = _Work(
        manifest.first, len(jobs), lambda first: make_all(jobs[first:], workers), named, refuse
    )
    return _fill(work, out, force, progress)


def restore_set(
    manifest: Manifest,
    folder: Path,
    *,
    families: tuple[str, ...] = (),
    workers: int = 1,
    force: bool = False,
    progress: Progress | None = None,
) -> SetDone:
    """Rebuild the missing worlds of a set's folder.

    Args:
        manifest: The manifest.
        folder: Folder for its files.
        families: As for :func:`regenerate_set`.
        workers: Number of processes.
        force: True to overwrite files with other content.
        progress: Called with the progress.

    Raises:
        SetDiffers: If a world differs from the manifest; those before it stay.
        InvalidParameter: If a family is unknown or has another version.
        OutputError: If a file has other content, or cannot be written.
    """
    store = SetFolder(folder)
    # First compare the files on disk by checksum, so that only missing worlds are made again.
    wanted = [entry for entry in manifest.entries if not store.holds(entry, force=force)]
    done = len(manifest.entries) - len(wanted)
    for entry, made in zip(wanted, make_all(_entry_jobs(wanted, families), workers), strict=True):
        # A world that differs from the record means another version or family: stop before writing
        # it.
        _check_same(entry, made, manifest.header)
        store.put(entry.file, made.data)
        done += 1
        if progress is not None:
            progress(done)
    return SetDone(len(manifest.entries), len(manifest.entries) - len(wanted))


def _fill(work: _Work, out: Path, force: bool, progress: Progress | None) -> SetDone:
    # The store holds the lock until it is closed, whatever happens.
    store = store_for(out)
    try:
        old = store.find(force=force)
        resumed = 0
        if old is not None and not force:
            work.refuse(old)
            resumed = store.resume(old)
            # A finished set has nothing to resume; only --force replaces it.
            if len(old.entries) == work.count == resumed and not isinstance(store, SetArchive):
                raise OutputError(
                    "set-finished",
                    "{out} already holds this set, complete",
                    "use --force to make it again",
                    at_terminal=True,
                    out=out,
                )
        _write_all(
            work, store, resumed, old, started=old is not None and not force, progress=progress
        )
        store.finish()
        return SetDone(work.count, resumed)
    finally:
        store.close()


def _write_all(
    work: _Work,
    store: SetFolder,
    done: int,
    old: Manifest | None,
    *,
    started: bool,
    progress: Progress | None,
) -> None:
    tell = progress or (lambda _: None)
    tell(done)
    for made in work.made(done):
        # Wait until there is a world to write, so that bad parameters change nothing.
        if not started:
            store.start(work.header, old)
            started = True
        name, line = work.named(done, made)
        store.write(name, made.data, line)
        done += 1
        tell(done)


def _check_same(entry: ManifestEntry, made: Made, header: ManifestHeader) -> None:
    if made.sha256 == entry.sha256:
        return
    what = (
        "is another world"
        if made.digest != entry.digest
        else "is the same world, written differently"
    )
    raise SetDiffers(
        "world-differs",
        "{file} is different this time: {family} with seed {seed} {what} here than in the "
        "manifest, which worldgen {worldgen} wrote",
        "install that version",
        file=entry.file,
        family=entry.family,
        seed=entry.seed,
        what=what,
        worldgen=header.worldgen,
    )


def _other(old: Manifest, wanted: ManifestHeader, out: Path) -> OutputError:
    held = old.header
    return OutputError(
        "other-set",
        "{out} holds {made} of {count} worlds of another set: {family} from seed {seed}"
        + (" where {constraint}" if held.constraint else "")
        + (", by worldgen {worldgen}" if held.worldgen != wanted.worldgen else ""),
        "choose another folder, or use --force to replace it",
        at_terminal=True,
        out=out,
        made=len(old.entries),
        count=held.count,
        family=held.family,
        seed=held.seed,
        constraint=held.constraint,
        worldgen=held.worldgen,
    )


def _entry_jobs(entries: Iterable[ManifestEntry], families: Sequence[str] = ()) -> list[Job]:
    """Return the jobs that make the worlds of a manifest's lines again.

    Each family must exist here in the same version.

    Args:
        entries: The lines.
        families: Where to find unregistered families, as ``./file.py:name``.

    Raises:
        InvalidParameter: If a family is unknown or has a different version than in the manifest, or
            a parameter does not exist.
    """
    admit_argument(*families)
    places = {FAMILIES.get(place).name: place for place in families}
    checked: dict[tuple[str, int], str] = {}
    jobs: list[Job] = []
    for entry in entries:
        key = (entry.family, entry.version)
        if key not in checked:
            checked[key] = _place(entry, places.get(entry.family, entry.family))
        # The families of a set are one object.
        if not jobs or entry.params is not jobs[-1].params:
            FAMILIES.get(checked[key]).complete(entry.params)
        jobs.append(Job(checked[key], entry.seed, entry.params, entry.metrics))
    return jobs


def _place(entry: ManifestEntry, place: str) -> str:
    is_unknown = place == entry.family and place not in FAMILIES.names()
    if is_unknown:
        raise InvalidParameter(
            "unknown-name",
            "the set is of family {family!r}, which is not one of {known!l}",
            "use its file: --family ./file.py:name",
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
