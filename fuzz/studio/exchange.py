"""Import and export maps of other programs for the page, as on the command line."""

from __future__ import annotations

import contextlib
import io
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath

from fuzz.studio.requests.folder import Folder, Opened, answer, digest_of
from fuzz.studio.requests.limits import MOST_DROPPED
from fuzz.studio.requests.messages import opened_message, restored
from fuzz.studio.requests.protocol import Bring, Export, Exported, NamedFile, OpenedMessage
from fuzz.studio.requests.refusals import describe_note, hide
from fuzz.studio.requests.running import check_registered
from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.files.whole import check_output
from worldgen.files.worlds import SIDECAR, is_world_file, read_whole_world
from worldgen.interop import FORMATS, ImportedRobot, export_world, import_world, write_export
from worldgen.interop.formats.movingai import scenario_contents

# Suffixes of files that accompany a map but are not maps themselves.
_BESIDE = (SIDECAR, ".scen", ".tsx", ".inc")
# Pictures are maps only if no other file refers to them.
_PICTURES = (".pgm", ".png", ".bmp", ".ppm", ".jpg", ".jpeg")


@answer.register
def _bring(request: Bring, opened: Opened, part: object) -> OpenedMessage:
    if request.format is not None:
        check_registered("format", request.format, FORMATS.names())
    # A map in the folder, with the scenario next to it.
    if request.files is None:
        place = opened.folder.place_of_map(request.name or "")
        companions = (place.with_name(f"{one}.scen") for one in (place.name, place.stem))
        scenario = next((one for one in companions if one.is_file()), None)
        return _imported(place, request, scenario, request.row)
    # Files dropped on the page: put them into a temporary folder, and find the map among them.
    with tempfile.TemporaryDirectory() as there, _without(Path(there)):
        places = _put_down(request.files, Folder(Path(there)))
        main = _main_of(places)
        scenario = next((one for one in places if one.suffix.lower() == ".scen"), None)
        if is_world_file(main.name) and request == Bring(id=request.id, files=request.files):
            return opened_message(read_whole_world(main), main=main.name)
        return _imported(main, request, scenario, 1 if request.row is None else request.row)


@answer.register
def _export(request: Export, opened: Opened, part: object) -> Exported:
    check_registered("format", request.format, FORMATS.names())
    folder = opened.folder
    place = folder.place(request.name)
    export = export_world(
        restored(request.world),
        request.format,
        file=place.name,
        options=request.options,
        at=request.at,
        origin=request.origin,
        sidecar=request.sidecar,
    )
    lost = [*map(describe_note, export.lost)]
    notes = [*map(describe_note, export.notes)]
    if not request.keep:
        download = _download(place.stem, export.files)
        return Exported(lost=lost, notes=notes, files=[download], inside=list(export.files))
    # A link with the name of an accompanying file would lead outside the folder.
    for other in export.files:
        folder.place((place.parent / other).relative_to(folder.root).as_posix())
    _check_suffix(request.format, place.name)
    for other in export.files:
        check_output(place.parent / other, request.overwrite)
        folder.check_replaceable(place.parent / other, opened.written)
    written = write_export(export, place.parent, force=request.overwrite)
    opened.written.update({path: digest_of(path) for path in written})
    names = [path.relative_to(folder.root).as_posix() for path in written]
    return Exported(lost=lost, notes=notes, written=names)


def _check_suffix(known: str, name: str) -> None:
    """Refuse a name that a file of this format does not have, such as that of code."""
    suffixes = FORMATS.get(known).suffixes
    if suffixes and not name.lower().endswith(suffixes):
        raise InvalidParameter(
            "wrong-suffix",
            "{name!r} is not the name of a file of the format {format}",
            "choose a name that ends in {suffix}",
            name=name,
            format=known,
            suffix=suffixes[0],
        )


def _download(stem: str, files: Mapping[str, bytes]) -> NamedFile:
    """Return the only file, or an archive of several: browsers ask before saving a second one."""
    if len(files) == 1:
        return NamedFile(*next(iter(files.items())))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            # Without a time stamp, so that equal exports have equal bytes.
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return NamedFile(f"{stem}.zip", packed.getvalue())


def _put_down(files: Sequence[NamedFile], folder: Folder) -> list[Path]:
    """Write dropped files to their own folder, under their names without paths.

    Raises:
        InvalidParameter: If they are too large or have the same name.
    """
    places: list[Path] = []
    total = 0
    for file in files:
        name = PurePosixPath(file.name.replace("\\", "/")).name or "map"
        total += len(file.data)
        if total > MOST_DROPPED:
            raise InvalidParameter(
                "too-large",
                "{bytes} bytes are more than the {most} allowed for dropped files",
                "put them into the studio's folder",
                bytes=total,
                most=MOST_DROPPED,
            )
        # A hidden name would be refused although the file is fine.
        place = folder.place(name.lstrip(".") or "map")
        if place in places:
            raise InvalidParameter(
                "twice", "two of the files are called {name}", "drop one of them", name=place.name
            )
        place.write_bytes(file.data)
        places.append(place)
    return places


def _main_of(places: Sequence[Path]) -> Path:
    """Return the map among dropped files; it refers to the others, or the others accompany it.

    Raises:
        InvalidParameter: If several of them could be the map.
    """
    maps = [place for place in places if not place.name.lower().endswith(_BESIDE)] or list(places)
    found = [place for place in maps if place.suffix.lower() not in _PICTURES] or maps
    if len(found) > 1:
        names = ", ".join(place.name for place in found)
        raise InvalidParameter(
            "several-maps",
            "{names} are {count} maps",
            "drop one map, with the files that it refers to",
            names=names,
            count=len(found),
        )
    return found[0]


def _imported(place: Path, request: Bring, scenario: Path | None, row: int | None) -> OpenedMessage:
    """Return a map as a world, with its format and the number of problems in its scenario."""
    if request.row and scenario is None:
        raise InvalidParameter(
            "no-scenario",
            "a row can only be chosen from a scenario",
            "import the .scen file together with its map",
        )
    used = scenario if row else None
    robot = ImportedRobot(
        radius=request.radius,
        scenario=used,
        row=row or 1,
        seed=None if request.seed is None else int(request.seed),
    )
    imported = import_world(place, robot, name=request.format, options=request.options)
    # Never open a map that was only partly understood: the rest may be a wall.
    if imported.withheld:
        raise FormatError(
            "part-not-read",
            "{reason}",
            "`worldgen import --ignore-unread` makes a world without it, which you can open here",
            at_terminal=True,
            reason=imported.decision.reason,
            source=str(place),
        )
    # Report how the map was read, so that the user can choose differently.
    known = imported.world.provenance.params.get("format") if imported.world.provenance else None
    rows = _rows_of(scenario) if scenario is not None and known == "movingai" else 0
    scenario_note = (f"Row {row} of the {rows} of its scenario.",) if used is not None else ()
    notes = (*scenario_note, *imported.notes, *imported.warnings)
    return opened_message(
        imported.world,
        main=place.name,
        format=known,
        rows=rows,
        row=None if used is None else row,
        notes=[*map(describe_note, notes)],
    )


def _rows_of(scenario: Path) -> int:
    """Return the number of problems in a scenario.

    0 if it is faulty, which is reported when a problem is requested.
    """
    with contextlib.suppress(FormatError):
        return scenario_contents(scenario)[1]
    return 0


@contextlib.contextmanager
def _without(folder: Path) -> Iterator[None]:
    """Remove a temporary folder's path from errors."""
    try:
        yield
    except FormatError as error:
        source = Path(error.source).name if error.source else None
        raise FormatError.of(hide(error.message, folder), line=error.line, source=source) from error
    except WorldgenError as error:
        raise type(error).of(hide(error.message, folder)) from error
