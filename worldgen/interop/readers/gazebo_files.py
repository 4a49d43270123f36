"""Find the files that a Gazebo world names: models and meshes.

Only three kinds of folders are ever looked into: the world's own, ``models`` in or next to it,
the folder of a model that was found, and those that the user lists in Gazebo's own variables. A file
that names any other place is refused.

Source: the SDFormat specification 1.12, ``<uri>``; the manual of Gazebo Sim, "Finding resources".
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from worldgen.errors import FormatError
from worldgen.interop.format.foreign_map import naming, read_bounded
from worldgen.interop.readers.xml_tree import XmlElement, read_xml
from worldgen.support.paths import expanded, real_path
from worldgen.support.plain_text import quote

MAX_BYTES = 64 << 20
"""Limit on a world and the models that it includes."""
VARIABLES = (
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH",
)
"""Gazebo's variables for folders of models, new and old."""

_LATE_DECLARATION = re.compile(rb"(?s)\A(\s++)<\?xml(?:(?!\?>).)*+\?>")
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*):/{0,2}(.*)", re.DOTALL)
# The description of a model, new and old.
_CONFIGS = ("model.config", "manifest.xml")
_MOST_CONFIG = 1 << 20
# A comment, a text that may look like one, or a tag. What has no end reaches to the end of the file,
# so that every byte is looked at once.
_MARKUP = re.compile(
    rb"(?s)(?P<comment><!--.*?-->)|(?P<text><!--.*|<!\[CDATA\[.*?(?:\]\]>|\Z)|<\?.*?(?:\?>|\Z))"
    rb"|<(?:[^\"'<>]++|\"[^\"]*+\"?|'[^']*+'?)*+"
)
_LISTED = re.compile(rb"<sdf\b([^<>]*)>([^<>]*)</sdf\s*>")
# The newest SDFormat that exists.
_NEWEST = (1, 12)


@dataclass(frozen=True)
class Home:
    """The folder of a file, in which its relative names begin.

    Args:
        folder: The folder.
        is_listed: True if the user listed a folder that holds it, so that links may lead out of it.
    """

    folder: Path
    is_listed: bool = False


class ModelFiles:
    """The files that belong to a world.

    Args:
        world: The world's file.

    Attributes:
        missing: URIs of which nothing was found.
        sizes: Bytes of the files that were read.
    """

    def __init__(self, world: Path) -> None:
        folder = world.parent
        self.home = Home(folder)
        above = real_path(folder).parent
        self._roots = [Home(folder), Home(folder / "models"), Home(above / "models")]
        if any((folder / name).is_file() for name in _CONFIGS):
            # A model on its own stands among its neighbours.
            self._roots.append(Home(above))
        listed = [part for name in VARIABLES for part in os.environ.get(name, "").split(os.pathsep)]
        self._roots += [Home(expanded(part), True) for part in listed if part.strip()]
        self._left = MAX_BYTES
        self._known: dict[tuple[str, Home], tuple[Path, Home] | None] = {}
        self._read: dict[Path, XmlElement] = {}
        self.sizes: dict[Path, int] = {}
        self.missing: dict[str, None] = {}

    def model(self, uri: XmlElement, home: Home) -> tuple[Path, Home] | None:
        """Return the file of the model that a URI names, and its folder; None if there is none.

        Raises:
            FormatError: If the URI leads out of the folders that count.
        """
        return self._found(uri, home, self._in_folder)

    def mesh(self, uri: XmlElement, home: Home) -> Path | None:
        """Return the mesh that a URI names, as :meth:`model` does."""
        found = self._found(uri, home, lambda _: None)
        return None if found is None else found[0]

    def _found(
        self, uri: XmlElement, home: Home, in_folder: Callable[[Home], tuple[Path, Home] | None]
    ) -> tuple[Path, Home] | None:
        """Return what a URI names; it is looked for once, as worlds repeat their models."""
        key = (uri.text.strip(), home)
        if key not in self._known:
            self._known[key] = None
            for place in self._places(uri, home):
                if place.folder.is_file():
                    self._known[key] = place.folder, Home(place.folder.parent, place.is_listed)
                elif place.folder.is_dir():
                    self._known[key] = in_folder(place)
                if self._known[key] is not None:
                    break
            else:
                self.missing[key[0]] = None
        return self._known[key]

    def read(self, path: Path) -> XmlElement:
        """Return the root of a model's file, which is parsed once.

        Raises:
            FormatError: If it is not XML, or all files together are too large.
        """
        if path not in self._read:
            with naming(path):
                data = read_bounded(path, self._left)
                self._left -= len(data)
                self.sizes[path] = len(data)
                self._read[path] = _read_leniently(data)
        return self._read[path]

    def _places(self, uri: XmlElement, home: Home) -> Iterator[Home]:
        """Yield the places that a URI may mean, the likeliest first."""
        scheme, parts = _parts(uri)
        where = (uri.text.strip(), uri.line)
        if scheme == "":
            yield from _inside(home, parts, *where)
        elif parts[:1] == [_name(real_path(home.folder))]:
            # A model that names its own folder, wherever that is.
            yield from _inside(home, parts[1:], *where)
        for root in self._roots:
            yield from _inside(root, parts, *where)
            if scheme in ("http", "https"):
                # Gazebo stores downloaded models under names in lower case.
                yield from _inside(root, [part.lower() for part in parts[:1]] + parts[1:], *where)

    def _in_folder(self, model: Home) -> tuple[Path, Home] | None:
        """Return the file of a model that its description, or its name, says."""
        for name in _CONFIGS:
            config = model.folder / name
            if config.is_file():
                _check_inside(model, config, name)
                return self._chosen(model, config)
        if (model.folder / "model.sdf").is_file():
            _check_inside(model, model.folder / "model.sdf", "model.sdf")
            return model.folder / "model.sdf", model
        # Downloaded models have a folder for each version.
        versions = [one.name for one in model.folder.iterdir() if one.name.isdecimal()][:1000]
        for version in sorted(versions, key=int, reverse=True)[:1]:
            return self._in_folder(Home(model.folder / version, model.is_listed))
        return None

    def _chosen(self, model: Home, config: Path) -> tuple[Path, Home]:
        """Return the file of the newest version of SDFormat that a description lists."""
        with naming(config):
            # Gazebo's parser forgives what XML forbids, such as a bare & in the description.
            data = _without("comment", "text", data=read_bounded(config, _MOST_CONFIG))
            listed = [(_version(found), found[2]) for found in _LISTED.finditer(data)]
            listed = [one for one in listed if one[0] <= _NEWEST]
            if not listed:
                raise FormatError(
                    "missing-element",
                    "has no <sdf> with the name of the model's file",
                    'add <sdf version="1.6">model.sdf</sdf>',
                )
            # Of equal versions the first counts.
            name = max(listed, key=lambda one: one[0])[1].decode(errors="replace").strip()
            for place in _inside(model, _plain(name), name):
                if place.folder.is_file():
                    return place.folder, model
            raise FormatError(
                "no-such-file",
                "sdf {name} does not exist",
                "put it next to {map}",
                name=quote(name, 80),
                map=config.name,
            )


def _read_leniently(data: bytes) -> XmlElement:
    """Return the root of a file that may break two rules of XML, as Gazebo's parser allows.

    They are no ``--`` inside a comment, and no declaration after one.
    """
    try:
        return read_xml(data)
    except FormatError as error:
        if error.code != "not-xml":
            raise
        return read_xml(_LATE_DECLARATION.sub(rb"\1", _without("comment", data=data), 1))


def _without(*kinds: str, data: bytes) -> bytes:
    """Return a file without its markup of some kinds, each line in its place."""

    def kept(found: re.Match[bytes]) -> bytes:
        return b"\n" * found[0].count(b"\n") if found.lastgroup in kinds else found[0]

    return _MARKUP.sub(kept, data)


def _name(folder: Path) -> str:
    """Return the name of a model's folder, which may have a folder for each version in it."""
    return folder.parent.name if folder.name.isdecimal() else folder.name


def _version(found: re.Match[bytes]) -> tuple[int, ...]:
    words = re.findall(rb"version\s*=\s*[\"']([0-9.]{1,20})[\"']", found[1])
    return tuple(int(word) for word in b"".join(words[:1]).split(b".") if word)


def _parts(uri: XmlElement) -> tuple[str, list[str]]:
    """Return the scheme of a URI, and the names of its path below a folder of models.

    Raises:
        FormatError: If it leads out of the folders that count.
    """
    text = uri.text.strip()
    found = _SCHEME.fullmatch(text)
    scheme, path = (found[1].lower(), found[2]) if found else ("", text)
    if path.startswith("/") and scheme in ("", "file"):
        raise _outside(text, uri.line)
    parts = _plain(path, text, uri.line)
    if scheme in ("http", "https"):
        # A model of Gazebo's server: .../models/NAME, which a folder on this machine may hold.
        at = parts.index("models") + 1 if "models" in parts else len(parts)
        version = "tip|files|[0-9]+"
        parts = [unquote(part) for part in parts[at:] if not re.fullmatch(version, part)]
        return scheme, _plain("/".join(parts), text, uri.line)
    return scheme, parts[1:] if scheme == "file" and parts[:1] == ["models"] else parts


def _plain(path: str, text: str = "", line: int | None = None) -> list[str]:
    """Return the names in a path, which must lead down only."""
    parts = [part for part in re.split(r"[/\\]", path) if part not in ("", ".")]
    if any(part == ".." or "\0" in part or ":" in part for part in parts):
        raise _outside(text or path, line)
    return parts


def _outside(text: str, line: int | None) -> FormatError:
    return FormatError(
        "outside-folder",
        "{name} is outside the folders of the world and its models",
        "copy it into `models` next to the world, and write model://NAME",
        name=quote(text, 80),
        line=line,
    )


def _inside(home: Home, parts: list[str], text: str, line: int | None = None) -> Iterator[Home]:
    """Yield the place below a folder, if there is something."""
    if not parts:
        return
    place = home.folder.joinpath(*parts)
    try:
        there = place.exists()
    # The name is too long for the file system.
    except OSError:
        return
    if there:
        _check_inside(home, place, text, line)
        yield Home(place, home.is_listed)


def _check_inside(home: Home, place: Path, text: str, line: int | None = None) -> None:
    """Refuse a link that leads out of its folder, unless the user listed that."""
    if not home.is_listed and not real_path(place).is_relative_to(real_path(home.folder)):
        raise FormatError(
            "outside-folder",
            "{name} is a link to a place outside its folder",
            "copy the file there instead",
            name=quote(text, 80),
            line=line,
        )
