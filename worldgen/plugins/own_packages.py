"""Keep a user's folder or file named ``sim`` or ``fuzz`` from hiding our packages.

Many robot projects have such a folder. Our own program calls :func:`prefer_own_packages` first, so
it always imports ours, and :func:`check_not_ours` tells how to name a module of the user's folder.
A user's process, such as a test run, imports whatever comes first on Python's path; there,
:func:`check_hidden` reports a hidden package.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import sys
from pathlib import Path

from worldgen.errors import InvalidParameter

_PACKAGES = ("sim", "fuzz", "worldgen_plugins")
# A user's folder may be named worldgen, so do not look this file up through the package.
_ROOT = Path(__file__).resolve().parents[2]


def prefer_own_packages() -> None:
    """Make this process and its children prefer our packages to others of the same name.

    Folders on Python's path that hide ours are moved to its end, so that their other modules can
    still be imported.
    """
    hiding = [entry for entry in sys.path if _hides(entry)]
    if not hiding:
        return
    others = [entry for entry in sys.path if entry not in hiding]
    ours = [] if str(_ROOT) in others else [str(_ROOT)]
    sys.path[:] = [*others, *ours, *hiding]


def _hides(entry: str) -> bool:
    """Return True if this folder of Python's path has something else under one of our names."""
    if Path(entry).resolve() == _ROOT:
        return False
    finder = importlib.machinery.PathFinder
    return any(finder.find_spec(name, [entry]) is not None for name in _PACKAGES)


def hidden_package() -> tuple[str, Path] | None:
    """Return the first of our packages that another one hides, and the other one's path.

    Returns ``None`` if Python would import all of our packages.
    """
    for name in _PACKAGES:
        ours = _ROOT / name
        if not (ours / "__init__.py").is_file():
            continue
        found = _place_of(name)
        if found is not None and found.resolve() != ours:
            return name, found
    return None


def check_hidden() -> None:
    """Raise an error if another package hides one of ours.

    Raises:
        InvalidParameter: If one of our packages is hidden.
    """
    hidden = hidden_package()
    if hidden is None:
        return
    name, place = hidden
    kind = "folder" if place.is_dir() else "file"
    raise InvalidParameter(
        "hidden-package",
        "your {kind} {place} hides the package {name!r} of worldgen, because {parent} comes first "
        "on Python's path",
        "remove that folder from Python's path (PYTHONPATH; call `pytest --import-mode=importlib`, "
        "not `python -m pytest`), or rename {folder}",
        at_terminal=True,
        kind=kind,
        place=place,
        name=name,
        parent=place.parent,
        folder=place.name,
    )


def check_not_ours(module: str, attribute: str) -> None:
    """Raise an error if a user's module cannot be found because one of our packages hides it.

    Args:
        module: Name of the module, such as ``sim.robot``.
        attribute: Name of the object in it, for the message.

    Raises:
        InvalidParameter: If the module is in a folder with the name of one of our packages.
    """
    file = _file_behind(module)
    if file is not None:
        raise _hidden(module, file, "name the file: ./{file}:{attribute}", attribute=attribute)


def check_import(missing: ModuleNotFoundError) -> None:
    """Raise an error if a user's code imports a module of its own that one of our packages hides.

    Raises:
        InvalidParameter: If the module is in a folder with the name of one of our packages.
    """
    module = missing.name or ""
    file = _file_behind(module)
    if file is not None:
        remedy = "rename the folder, or put its modules into a package of another name"
        raise _hidden(module, file, remedy) from missing


def _hidden(module: str, file: Path, remedy: str, **facts: str) -> InvalidParameter:
    """Return the error for a user's file that one of our packages hides."""
    return InvalidParameter(
        "hidden-module",
        "{module!r} is looked for in worldgen's own package {package!r}, not in your folder "
        "{folder}/",
        remedy,
        module=module,
        package=module.partition(".")[0],
        folder=file.parent.as_posix(),
        file=file.as_posix(),
        **facts,
    )


def _file_behind(module: str) -> Path | None:
    """Return the user's file for a module, if one of our packages hides it."""
    package, _, inner = module.partition(".")
    if package not in _PACKAGES or not inner:
        return None
    place = Path(*module.split("."))
    for file in (place.with_suffix(".py"), place / "__init__.py"):
        if file.is_file() and not (_ROOT / file).is_file():
            return file
    return None


def _place_of(name: str) -> Path | None:
    """Return the folder of a package, or the file of a module, without importing it."""
    loaded = sys.modules.get(name)
    try:
        spec: importlib.machinery.ModuleSpec | None = (
            loaded.__spec__ if loaded is not None else importlib.util.find_spec(name)
        )
    except (ImportError, ValueError):
        return None
    if spec is None:
        return None
    # A package has folders; a module only has its file.
    folders = list(spec.submodule_search_locations or ())
    if folders:
        return Path(folders[0])
    return Path(spec.origin) if spec.origin else None
