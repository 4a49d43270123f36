"""Check the studio's arguments, as far as possible without running a user's code."""

from __future__ import annotations

import ast
import importlib.util
import re
from pathlib import Path

from sim.controllers import CONTROLLERS
from sim.controllers.programs.process import is_process_name
from sim.controllers.shared.object_file import check_file, is_library_name
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.files.archives import is_archive
from worldgen.files.grid import read_world
from worldgen.files.worlds import is_world_file
from worldgen.interop import read_map
from worldgen.support.paths import expanded

_MAKES_NAMES = {
    "__getattr__",
    "__dict__",
    "globals",
    "vars",
    "locals",
    "modules",
    "setattr",
    "exec",
}
"""Names in a module's text which suggest that it defines further names at run time."""


def check_controller(label: str) -> None:
    """Refuse a name that does not belong to a controller.

    Its code is read but not run; only processes that may hang run it.

    Args:
        label: A controller's name, with variations.

    Raises:
        InvalidParameter: If there is no such controller.
    """
    try:
        name = Scenario.parse(label).controller
    except InvalidParameter as error:
        try:
            # Its options may belong to the thesis's robot.
            name = Scenario.parse(label, motion="stepped").controller
        except InvalidParameter:
            raise error from None
    place, colon, attribute = name.rpartition(":")
    if name in CONTROLLERS.names() or is_process_name(name):
        return
    if is_library_name(name):
        check_file(name)
        return
    if not colon:
        CONTROLLERS.get(name)  # raises, with the registered names and similar ones
    elif place.endswith(".py"):
        _check_file(name, expanded(place), attribute)
    elif not place:
        raise InvalidParameter(
            "no-module-named",
            "controller {name!r} does not name a module",
            "add it: module{attribute} or ./file.py{attribute}",
            name=name,
            attribute=name[:40],
        )
    elif not _is_there(place.partition(".")[0]):
        raise InvalidParameter(
            "module-missing",
            "controller {name!r}: there is no module {module}",
            "if it is a file, write ./{module}.py",
            name=name,
            module=place,
        )


def _is_there(module: str) -> bool:
    try:
        return module != "__main__" and importlib.util.find_spec(module) is not None
    except (ValueError, ImportError):  # ValueError: the name is empty
        return False


def _check_file(name: str, path: Path, attribute: str) -> None:
    try:
        text = path.read_bytes()
        tree = ast.parse(text)
    except OSError as error:
        why = error.strerror or str(error)
        raise InvalidParameter(
            "unreadable",
            "controller {name!r}: {path} cannot be read: {reason}",
            "check the name",
            name=name,
            path=path,
            reason=why,
        ) from error
    except (SyntaxError, ValueError, RecursionError) as error:
        raise InvalidParameter(
            "invalid-python",
            "controller {name!r}: {path} is not valid Python: {reason}",
            "correct it",
            name=name,
            path=path,
            reason=str(error),
        ) from error
    # Every name that a module defines is a word of its text, unless the module makes names.
    words = {*re.findall(r"\w+|\*$", text.decode("utf-8", "replace"), re.MULTILINE)}
    if not words & {attribute, "*", *_MAKES_NAMES}:
        classes = [node.name for node in tree.body if isinstance(node, ast.ClassDef)]
        raise InvalidParameter(
            "no-such-attribute",
            "controller {name!r}: {path} has no {attribute!r}",
            "its classes: {classes!l:none}",
            name=name,
            path=path,
            attribute=attribute,
            classes=list(classes),
        )


def check_world(path: Path) -> None:
    """Refuse a file without a world; the page asks for the options that a map needs.

    Raises:
        WorldgenError: If it cannot be read.
    """
    if is_archive(path):
        raise InvalidParameter(
            "is-an-archive",
            "{path} is an archive of worlds",
            "open its folder: worldgen studio {parent}",
            at_terminal=True,
            path=path,
            parent=path.parent,
        )
    try:
        read_world(path) if is_world_file(path.name) else read_map(path)
    except WorldgenError as error:
        if not error.message.at_terminal:  # the page has fields for these options
            raise
