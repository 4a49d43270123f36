"""Import and export maps of other programs for the page, as on the command line."""

from __future__ import annotations

import base64
import contextlib
import io
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec

from fuzz.studio.requests.folder import Folder, Opened, digest_of
from fuzz.studio.requests.limits import MOST_DROPPED
from fuzz.studio.requests.messages import (
    Request,
    SendPart,
    checked,
    opened_message,
    restored,
    seed_of,
)
from fuzz.studio.requests.messages import field as part_of
from fuzz.studio.requests.refusals import describe_note, hide
from fuzz.studio.requests.running import check_registered
from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.files.whole import check_output
from worldgen.files.worlds import SIDECAR, is_world_file, read_whole_world
from worldgen.interop import FORMATS, ImportedRobot, export_world, import_world, write_export
from worldgen.interop.formats.movingai import scenario_contents

_MOST_FILES = 20  # files that can be dropped on the page at once
# Suffixes of files that accompany a map but are not maps themselves.
_BESIDE = (SIDECAR, ".worldgen.toml", ".scen", ".tsx", ".inc")
# Pictures are maps only if no other file refers to them.
_PICTURES = (".pgm", ".png", ".bmp", ".ppm", ".jpg", ".jpeg")


class _Outgoing(msgspec.Struct):
    world: dict[str, Any]
    name: str
    keep: bool
    overwrite: bool = False
    options: dict[str, Any] | None = None
    at: float | None = None
    origin: tuple[float, float] | None = None
    sidecar: bool = True


@dataclass(frozen=True)
class ExchangeAnswers(Opened):
    """Answers that concern files of other programs."""

    _written: dict[Path, str] = field(default_factory=dict, init=False, repr=False, compare=False)

    def bring(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return a foreign map from the folder or the page; choose missing places."""
        wanted = _wanted(message)
        # A map in the folder, with the scenario next to it.
        if "data" not in message and "files" not in message:
            name = part_of(message, "name", str)
            place = self.folder.place_of_map(name)
            companions = (
                place.with_name(one) for one in (f"{place.name}.scen", f"{place.stem}.scen")
            )
            scenario = next((one for one in companions if one.is_file()), None)
            return _imported(place, wanted, scenario, wanted.row) | {"main": place.name}
        # Files dropped on the page: put them into a temporary folder, and find the map among them.
        files = message.get("files", [{"name": message.get("name"), "data": message.get("data")}])
        with tempfile.TemporaryDirectory() as there, _without(Path(there)):
            places = _put_down(files, Folder(Path(there)))
            main = _main_of(places)
            scenario = next((one for one in places if one.suffix.lower() == ".scen"), None)
            if is_world_file(main.name) and wanted == _Wanted():
                return opened_message(read_whole_world(main)) | {"main": main.name}
            return _imported(main, wanted, scenario, 1 if wanted.row is None else wanted.row) | {
                "main": main.name
            }

    def _check_suffix(self, known: str, name: str) -> None:
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

    def export(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return a world in another program's format, for the browser or in the folder."""
        known = _format_name(message)
        if known is None:
            raise InvalidParameter("empty-name", "no format is given", "choose one")
        # Read the message, and make the export.
        sent = checked(message, _Outgoing)
        world = restored(sent.world)
        place = self.folder.place(sent.name)
        export = export_world(
            world,
            known,
            file=place.name,
            options=sent.options or {},
            at=sent.at,
            origin=sent.origin,
            sidecar=sent.sidecar,
        )
        remarks = {
            name: [describe_note(one) for one in getattr(export, name)]
            for name in ("lost", "notes")
        }
        # Write it to the folder, or return it for the browser.
        if sent.keep:
            # A link with the name of an accompanying file would lead outside the folder.
            for other in export.files:
                self.folder.place((place.parent / other).relative_to(self.folder.root).as_posix())
            self._check_suffix(known, place.name)
            for other in export.files:
                check_output(place.parent / other, sent.overwrite)
                self.folder.check_replaceable(place.parent / other, self._written)
            written = write_export(export, place.parent, force=sent.overwrite)
            self._written.update({path: digest_of(path) for path in written})
            return remarks | {
                "written": [path.relative_to(self.folder.root).as_posix() for path in written]
            }
        name, data = _download(place.stem, export.files)
        return remarks | {
            "files": [{"name": name, "data": base64.b64encode(data).decode()}],
            "inside": list(export.files),
        }


def _download(stem: str, files: Mapping[str, bytes]) -> tuple[str, bytes]:
    """Return the only file, or an archive of several: browsers ask before saving a second one."""
    if len(files) == 1:
        return next(iter(files.items()))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            # Without a time stamp, so that equal exports have equal bytes.
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return f"{stem}.zip", packed.getvalue()


class _DroppedFile(msgspec.Struct):
    name: str
    data: str


def _put_down(files: object, folder: Folder) -> list[Path]:
    """Write dropped files to their own folder, under their names without paths.

    Raises:
        InvalidParameter: If they are too large or too many, have the same name, or are not files.
    """
    if not isinstance(files, list) or not 1 <= len(files) <= _MOST_FILES:
        raise InvalidParameter(
            "out-of-range",
            "drop 1 to {most} files: a map and the files that it refers to",
            most=_MOST_FILES,
        )
    places: list[Path] = []
    total = 0
    for file in checked(files, list[_DroppedFile]):
        name = PurePosixPath(file.name.replace("\\", "/")).name or "map"
        data = _bytes_of(file.data)
        total += len(data)
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
        place.write_bytes(data)
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


def _format_name(message: Request) -> str | None:
    """Return the format in a message; it must be registered, because others are code from files."""
    name = message.get("format")
    if name is not None:
        check_registered("format", str(name), FORMATS.names())
    return name


class _Wanted(msgspec.Struct):
    """Settings for reading a map; the file or the defaults provide the rest.

    Attributes:
        format: Name of the format.
        options: Options of that format, by name.
        radius: Radius of the robot, m.
        row: Number of the problem in its scenario, from 1; 0 for no problem.
        seed: Seed of the search for distant places, as digits.
    """

    format: str | None = None
    options: dict[str, Any] | None = None
    radius: float | None = None
    row: int | None = None
    seed: str | None = None


def _wanted(message: Request) -> _Wanted:
    """Return the page's settings for reading a map."""
    wanted = checked(message, _Wanted)
    _format_name(message)
    if wanted.seed is not None:
        seed_of(message)
    return wanted


def _bytes_of(text: str) -> bytes:
    try:
        return base64.b64decode(text, validate=True)
    except ValueError as error:
        raise InvalidParameter(
            "not-base64", "the message's data is not base64", "send the file's bytes"
        ) from error


def _imported(
    place: Path, wanted: _Wanted, scenario: Path | None, row: int | None
) -> dict[str, Any]:
    """Return a map as a world, with its format and the number of problems in its scenario."""
    if wanted.row and scenario is None:
        raise InvalidParameter(
            "no-scenario",
            "a row can only be chosen from a scenario",
            "import the .scen file together with its map",
        )
    used = scenario if row else None
    robot = ImportedRobot(
        radius=wanted.radius,
        scenario=used,
        row=row or 1,
        seed=None if wanted.seed is None else int(wanted.seed),
    )
    imported = import_world(place, robot, name=wanted.format, options=wanted.options or {})
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
    facts = {"format": known, "rows": rows, "row": row if used is not None else None}
    notes = [
        describe_note(words) for words in (*scenario_note, *imported.notes, *imported.warnings)
    ]
    return opened_message(imported.world) | facts | {"notes": notes}


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
