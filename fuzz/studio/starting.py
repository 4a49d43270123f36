"""Check the studio's arguments, as far as possible without running a user's code."""

from __future__ import annotations

import ast
import importlib.util
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
    "*",
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
        tree = ast.parse(path.read_bytes())
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
    found = _names_in(tree)
    if attribute not in found and not found & _MAKES_NAMES:
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


def _names_in(tree: ast.Module) -> set[str]:
    """Return every name in a module's text; the module is unlikely to define any other."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, ast.Attribute):
            found.add(node.attr)
        elif isinstance(node, ast.alias):
            found.add((node.asname or node.name).partition(".")[0])
    return found


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
