"""Import the files next to a user's file: ``import geometry`` in ``./mine.py``.

As with ``python mine.py``, files in the folder come before installed packages. In contrast, the
folder is not added to ``sys.path``, which would affect every import in the process. Instead, each
folder becomes a package with a private name, and only imports in files of that folder look there.
Two folders may therefore each have a ``geometry.py``, and a folder named ``sim`` hides nothing of
ours.
"""

from __future__ import annotations

import builtins
import hashlib
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from worldgen.errors import InvalidParameter

_PACKAGE = "_worldgen_user_folder_"  # the private names begin with this; a digest follows
_OURS = ("worldgen", "sim", "fuzz", "worldgen_plugins")
_FOLDERS: dict[str, Path] = {}  # by the private name of the package
_READ: dict[str, str] = {}  # digest of each source file, as it was last read


class SourceLoader(importlib.machinery.SourceFileLoader):
    """Load a user's file from its source, and remember that source.

    Python's cache of compiled files compares times in whole seconds and sizes. If a number is
    edited twice within a second, the old code would run.
    """

    def get_code(self, fullname: str) -> CodeType:
        """Return the compiled source."""
        path = self.get_filename(fullname)
        data = self.get_data(path)
        _READ[path] = digest_of_source(data)
        code: CodeType = self.source_to_code(data, path)
        return code


def digest_of_source(data: bytes) -> str:
    """Return a digest of a file's contents, which changes when the file is edited."""
    return hashlib.sha256(data).hexdigest()[:16]


def sources_read() -> dict[str, str]:
    """Return the user's files that this process has read as code, with the digest of each.

    This includes files that were read but failed.
    """
    return dict(_READ)


def without_private_names(text: str) -> str:
    """Return a message of Python's import system with the modules' names as the user wrote them."""
    return re.sub(rf"{_PACKAGE}[0-9a-f]{{16}}\.", "", text)


def package_of(folder: Path) -> str:
    """Return the private name of a folder's package, and create the package on the first call."""
    folder = folder.resolve()
    # The name is derived from the folder, so two folders with equal file names don't collide.
    name = f"{_PACKAGE}{hashlib.sha256(str(folder).encode()).hexdigest()[:16]}"
    if name not in sys.modules:
        package = ModuleType(name, f"The files in {folder}.")
        package.__path__ = [str(folder)]
        sys.modules[name] = package
        _FOLDERS[name] = folder
        _forget_bare_names(folder)
    # Install the finders only once, when the first user file is loaded.
    if not any(isinstance(finder, _OfFolders) for finder in sys.meta_path):
        sys.meta_path.insert(0, _OfFolders())
        sys.meta_path.append(_ByBareName())
    return name


def import_in(module: ModuleType, package: str) -> None:
    """Make the imports in a module's source look in its folder first.

    Args:
        module: A module that has not been executed yet.
        package: Name of its folder's package, from :func:`package_of`.
    """
    # CPython looks up ``__import__`` in the module's own builtins, so replacing it there affects no
    # other module.
    module.__dict__["__builtins__"] = {**vars(builtins), "__import__": _Importer(package)}


def neighbours_of(module: ModuleType) -> list[ModuleType]:
    """Return the modules imported so far from a module's folder.

    The list is empty if the module was not loaded from a user's file.
    """
    its_builtins = module.__dict__.get("__builtins__")
    importer = its_builtins.get("__import__") if isinstance(its_builtins, dict) else None
    if not isinstance(importer, _Importer):
        return []
    return [
        found
        for name, found in list(sys.modules.items())
        if name.startswith(f"{importer.package}.")
    ]


def forget_folder(folder: Path) -> None:
    """Load the files of a folder again when they are next imported."""
    package = package_of(folder)
    importlib.invalidate_caches()
    for name in [name for name in sys.modules if name.startswith(f"{package}.")]:
        alias = name.removeprefix(f"{package}.")
        if sys.modules.get(alias) is sys.modules[name]:
            del sys.modules[alias]
        del sys.modules[name]


def _forget_bare_names(folder: Path) -> None:
    """Drop the bare names that a new folder makes ambiguous.

    The next import by such a name then reports the ambiguity.
    """
    for alias, module in list(sys.modules.items()):
        named = str(getattr(module, "__name__", ""))
        if (
            named.partition(".")[0] in _FOLDERS
            and named != alias
            and (folder / f"{alias}.py").is_file()
        ):
            del sys.modules[alias]


class _Importer:
    """Replace ``__import__`` in the files of one folder, so that they find each other."""

    def __init__(self, package: str) -> None:
        self.package = package

    def __call__(
        self,
        name: str,
        globals_: Mapping[str, Any] | None = None,
        locals_: Mapping[str, Any] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        root = name.partition(".")[0]
        if level != 0 or not _is_in(_FOLDERS[self.package], root):
            return builtins.__import__(name, globals_, locals_, fromlist or (), level)
        own = f"{self.package}.{name}"
        if fromlist:
            return builtins.__import__(own, globals_, locals_, fromlist, 0)
        importlib.import_module(own)
        return sys.modules[f"{self.package}.{root}"]


def _is_in(folder: Path, name: str) -> bool:
    """Return True if ``import name`` should find a file of the folder."""
    if name in _OURS or name in sys.builtin_module_names:
        return False
    spec = importlib.machinery.PathFinder.find_spec(name, [str(folder)])
    if spec is None:
        return False
    # A plain folder without __init__.py is a package only if nothing else of that name is
    # installed.
    return spec.loader is not None or importlib.machinery.PathFinder.find_spec(name) is None


class _OfFolders(importlib.abc.MetaPathFinder):
    """Find the modules of users' folders, and make them find each other."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        package = fullname.partition(".")[0]
        if package not in _FOLDERS or path is None:
            return None
        spec = importlib.machinery.PathFinder.find_spec(fullname, path, target)
        if spec is not None and isinstance(spec.loader, importlib.machinery.SourceFileLoader):
            spec.loader = _Loader(spec.loader.name, spec.loader.path)
        return spec


class _Loader(SourceLoader):
    def exec_module(self, module: ModuleType) -> None:
        import_in(module, module.__name__.partition(".")[0])
        super().exec_module(module)


class _ByBareName(importlib.abc.MetaPathFinder):
    """Find a folder's module by its bare name if nothing else has that name.

    Pickles and ``import_module`` need this. They get the same module object as the folder's own
    imports. A name that occurs in two folders is an error.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if path is not None or "." in fullname or fullname in _OURS:
            return None
        found = [
            package for package, folder in _FOLDERS.items() if (folder / f"{fullname}.py").is_file()
        ]
        if len(found) > 1:
            folders = " and ".join(str(_FOLDERS[package]) for package in found)
            raise InvalidParameter(
                "ambiguous-module",
                "module {module!r} is imported by name, but exists in several folders: {folders}",
                "write `import {module}` in the file that needs it, or rename one of them",
                module=fullname,
                folders=folders,
            )
        return (
            importlib.machinery.ModuleSpec(fullname, _Alias(f"{found[0]}.{fullname}"))
            if found
            else None
        )


class _Alias(importlib.abc.Loader):
    def __init__(self, name: str) -> None:
        self._name = name

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        module = importlib.import_module(self._name)
        self._spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        # The import system has just replaced the module's spec by the alias's; restore it.
        module.__spec__ = self._spec
