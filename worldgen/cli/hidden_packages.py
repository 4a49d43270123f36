"""Whether a folder or file of the user's hides one of our packages, as ``sim/`` does from ``python -m worldgen``."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import sys
from pathlib import Path

import worldgen
from worldgen.errors import InvalidParameter

__all__ = ["check_hidden", "hidden_package"]

_PACKAGES = ("sim", "fuzz", "worldgen_plugins")


def hidden_package() -> tuple[str, Path] | None:
    """Return the first of our packages that Python would import from elsewhere, and where it would; else ``None``."""
    root = Path(worldgen.__file__).resolve().parent.parent
    for name in _PACKAGES:
        ours = root / name
        if not (ours / "__init__.py").is_file():
            continue
        found = _place_of(name)
        if found is not None and found.resolve() != ours:
            return name, found
    return None


def check_hidden() -> None:
    """Refuse to go on with another's package in the place of ours.

    Raises:
        InvalidParameter: If one is hidden.
    """
    hidden = hidden_package()
    if hidden is None:
        return
    name, place = hidden
    kind = "folder" if place.is_dir() else "file"
    raise InvalidParameter(
        "hidden-package",
        "your {kind} {place} hides the package {name!r} of worldgen, because {parent} comes first on Python's path",
        "call `worldgen` rather than `python -m worldgen`, take that folder out of PYTHONPATH, or rename {folder}",
        kind=kind,
        place=place,
        name=name,
        parent=place.parent,
        folder=place.name,
    )


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
    folders = list(spec.submodule_search_locations or ())
    if folders:
        return Path(folders[0])
    return Path(spec.origin) if spec.origin else None
