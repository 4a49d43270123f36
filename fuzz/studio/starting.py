"""What is wrong with the studio's arguments.

As far as it shows before any code of a user's is run.
"""

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

__all__ = ["check_controller", "check_world"]


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
"""What a module's text mentions that may make names which the text does not."""


def check_controller(label: str) -> None:
    """Refuses what names no controller.

    Its code is looked at, and not run: that is left to processes that may hang.

    Args:
        label: A controller's name, with variations.

    Raises:
        InvalidParameter: If nothing is called so.
    """
    try:
        name = Scenario.parse(label).controller
    except InvalidParameter as error:
        try:
            name = Scenario.parse(
                label, motion="stepped"
            ).controller  # with options of the other kind
        except InvalidParameter:
            raise error from None
    place, colon, attribute = name.rpartition(":")
    if name in CONTROLLERS.names() or is_process_name(name):
        return
    if is_library_name(name):
        check_file(name)
        return
    if not colon:
        CONTROLLERS.get(name)  # which says what there is, and what is nearly called so
    elif place.endswith(".py"):
        _check_file(name, Path(place).expanduser(), attribute)
    elif not place:
        raise InvalidParameter(
            "no-module-named",
            "controller {name!r} names no module",
            "name it too, module{attribute} or ./file.py{attribute}",
            name=name,
            attribute=name[:40],
        )
    elif not _is_there(place.partition(".")[0]):
        raise InvalidParameter(
            "module-missing",
            "controller {name!r}: there is no module {module}",
            "a file is named ./{module}.py",
            name=name,
            module=place,
        )


def _is_there(module: str) -> bool:
    try:
        return module != "__main__" and importlib.util.find_spec(module) is not None
    except (ValueError, ImportError):  # of an empty name
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
            "controller {name!r}: {path} is no Python: {reason}",
            "mend it",
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
    """Every name that a module's text mentions: what is not among them, it hardly has."""
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
    """Refuses a file that holds no world; what a map leaves open, the page asks for.

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
        if not error.message.at_terminal:  # its options are fields on the page
            raise
