"""Locate a failure in a repository: at the controller's source if that is part of it."""

from __future__ import annotations

import ast
import os
import shlex
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from sim.controllers import CONTROLLERS
from sim.controllers.programs.process import is_process_name
from sim.controllers.shared.object_file import is_library_name, library_file
from worldgen.files.whole import read_text
from worldgen.plugins.trust import file_of_module
from worldgen.support.paths import real_path


@dataclass(frozen=True)
class Place:
    """A line in a file.

    Args:
        uri: Path relative to the repository's root, as a URI.
        line: Line number, from 1.
    """

    uri: str
    line: int = 1


def repository(folder: Path | None = None) -> Path:
    """Return the root of the repository.

    That is GitHub's workspace, or else the nearest folder with ``.git``, or else the folder itself.
    """
    here = real_path(folder or Path.cwd())
    workspace = os.environ.get("GITHUB_WORKSPACE")
    if workspace and here.is_relative_to(real_path(Path(workspace))):
        return real_path(Path(workspace))
    return next((one for one in (here, *here.parents) if (one / ".git").exists()), here)


def place_of(controller: str, root: Path) -> Place | None:
    """Return where a controller's source is; ``None`` if it is not in the repository.

    Args:
        controller: Name, ``package.module:name``, ``./file.py:name``, ``lib:./file.so:name`` or
            ``cmd:program``.
        root: Root of the repository.
    """
    if is_process_name(controller):
        uris = (uri_of(file, root) for file in _files(controller.partition(":")[2]))
        return next((Place(uri) for uri in uris if uri), None)
    if is_library_name(controller):
        uri = uri_of(library_file(controller), root)
        return Place(uri) if uri else None
    # A registered name refers to a module; its source is only parsed, never run.
    point = CONTROLLERS.entry_points().get(controller)
    module, _, name = (point.value if point else controller).rpartition(":")
    file = Path(module) if module.endswith(".py") else file_of_module(module)
    uri = uri_of(file, root) if file is not None and file.is_file() else None
    return None if file is None or uri is None else Place(uri, _line(file, name))


def uri_of(path: Path, root: Path) -> str | None:
    """Return a path relative to the repository's root as a URI; ``None`` if it is outside."""
    with suppress(ValueError):
        return quote(real_path(path).relative_to(root).as_posix(), errors="replace")
    return None


def _files(command: str) -> list[Path]:
    """Return the words of a command that are files."""
    with suppress(ValueError):  # unbalanced quotes
        return [Path(word) for word in shlex.split(command) if Path(word).is_file()]
    return []


def _line(file: Path, name: str) -> int:
    """Return the line of a module that defines a name; 1 if that cannot be determined."""
    try:
        statements = ast.parse(read_text(file)).body
    except Exception:  # noqa: BLE001 - any file may be named; a place without a line is still useful
        return 1
    return next((one.lineno for one in statements if name in _names(one)), 1)


def _names(statement: ast.stmt) -> list[str]:
    """Return the names that a statement defines."""
    if isinstance(statement, ast.ClassDef | ast.FunctionDef):
        return [statement.name]
    targets = statement.targets if isinstance(statement, ast.Assign) else []
    targets = [statement.target] if isinstance(statement, ast.AnnAssign) else targets
    return [one.id for one in targets if isinstance(one, ast.Name)]
