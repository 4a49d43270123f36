"""``worldgen regenerate``: rebuild a set from its manifest, or check that the two match."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import PATH, emit_json, force_option, json_option, note, say
from worldgen.errors import OutputError
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.sets import Manifest

EXAMPLES = (
    "\b\n  worldgen regenerate mazes/ --check\n  worldgen regenerate mazes/manifest.jsonl --out "
    "again/\n"
    "  worldgen regenerate mazes.zip --out again.zip"
)
# Limit on the differences listed as text; --json has all of them.
SHOWN = 20


@click.command(epilog=EXAMPLES)
@click.argument("path", metavar="SET", type=PATH)
@click.option("--out", type=PATH, help="Folder or archive to make; with --check, the one to check.")
@click.option(
    "--check", is_flag=True, help="Make nothing; list files that are missing, changed or extra."
)
@click.option(
    "--family",
    "families",
    multiple=True,
    help="File that defines a family that is not registered: ./mine.py:pillars.",
)
@force_option
@json_option
def regenerate(
    path: Path, out: Path | None, check: bool, families: tuple[str, ...], force: bool, as_json: bool
) -> None:
    """Rebuild a set of worlds from its manifest, or check it.

    SET is a set's folder, its archive, or only its manifest. With --out the whole set is made
    there; without it, the missing worlds are made in the set's own folder. Every world is compared
    with the manifest before it is written.

    Exits with 0 if the set matches its manifest, with 1 if it does not or a rebuilt world differs.
    """
    from worldgen.sets import manifest_of

    manifest = manifest_of(path)
    place = out or (path.parent if path.is_file() and path.suffix == ".jsonl" else path)
    known = _KnownSet(path, place, manifest)
    if check:
        _check(known, as_json=as_json)
    else:
        elsewhere = out is not None
        _make(known, families, elsewhere=elsewhere, force=force, as_json=as_json)


@dataclass(frozen=True)
class _KnownSet:
    """A set's manifest.

    Args:
        path: Path of the manifest.
        place: Folder or archive of the worlds.
        manifest: Its contents.
    """

    path: Path
    place: Path
    manifest: Manifest

    def emit(self, *, made: int, ok: bool, differences: list[dict[str, str]]) -> None:
        """Print the result as one JSON object."""
        emit_json(
            {
                "manifest": str(self.path),
                "out": str(self.place),
                "worlds": len(self.manifest.entries),
                "made": made,
                "ok": ok,
                "differences": differences,
            }
        )


def _check(known: _KnownSet, *, as_json: bool) -> None:
    from worldgen.sets import check_set

    place = known.place
    manifest = known.manifest
    with working(f"checking {place} against its manifest"):
        differences = check_set(place, manifest)
    if as_json:
        found = [{"kind": difference.kind, "file": difference.file} for difference in differences]
        known.emit(made=0, ok=not found, differences=found)
    for difference in differences[:SHOWN] if not as_json else ():
        say(f"{place / difference.file}: {difference.kind}")
    more = f"{len(differences)} differences" if len(differences) != 1 else "1 difference"
    note(
        f"{place}: {len(manifest.entries)} worlds, "
        f"{more if differences else 'everything matches the manifest'}"
    )
    if differences:
        raise click.exceptions.Exit(1)


def _make(
    known: _KnownSet, families: tuple[str, ...], *, elsewhere: bool, force: bool, as_json: bool
) -> None:
    from worldgen.cli.set_output import told, workers_for
    from worldgen.sets import SetDiffers, regenerate_set, restore_set

    place = known.place
    manifest = known.manifest
    count = len(manifest.entries)
    # An unfinished set is continued with its first command, not made again.
    if not manifest.finished:
        raise OutputError(
            "set-unfinished",
            "{path} is unfinished, with {count} of {planned} worlds",
            "run the command that started it to continue it",
            path=known.path,
            count=count,
            planned=manifest.header.count,
        )
    if not elsewhere and not place.is_dir():
        raise OutputError(
            "is-a-file",
            "{path} is one file",
            "use --out to make the set somewhere else, or --check to compare",
            at_terminal=True,
            path=known.path,
        )
    # Make all of its worlds elsewhere, or only the missing ones in its own place.
    try:
        with told(place, count, force=force and elsewhere) as progress:
            work = regenerate_set if elsewhere else restore_set
            processes = workers_for(count)
            done = work(
                manifest,
                place,
                families=families,
                workers=processes,
                force=force,
                progress=progress,
            )
    except SetDiffers as error:
        note(f"worldgen: {error}", always=True)
        if as_json:
            changed = {"kind": "changed", "file": error.facts["file"]}
            known.emit(made=0, ok=False, differences=[changed])
        raise click.exceptions.Exit(1) from error
    note(f"{place}: {count - done.resumed} worlds made, {done.resumed} already existed")
    if as_json:
        known.emit(made=count - done.resumed, ok=True, differences=[])
