"""Load families, controllers and motion models by name, including those of plug-ins."""

from __future__ import annotations

import contextlib
import difflib
import importlib
import importlib.util
import sys
from bdb import BdbQuit
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, Generic, TypeVar

from worldgen.errors import InvalidParameter, Message
from worldgen.parameters.known_names import unknown_name
from worldgen.plugins.entry_points import points_of
from worldgen.plugins.own_packages import check_import, check_not_ours
from worldgen.plugins.trust import check_code
from worldgen.plugins.user_modules import (
    SourceLoader,
    digest_of_source,
    forget_folder,
    import_in,
    package_of,
    sources_read,
    without_private_names,
)
from worldgen.support.paths import expanded, real_path
from worldgen.support.results import only_results_on_stdout

T = TypeVar("T")

_KNOWN = "known: {known!l}; for your own, use package.module:name or ./file.py:name"

_LENT: dict[str, Path] = {}


def lend(place: str, copy: Path) -> None:
    """Use a copy from another machine whenever the file ``place`` is named from now on."""
    _LENT[place] = copy


def _file(place: str) -> Path:
    return _LENT.get(place, Path(place))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # its name is too long, or its folder may not be read
        return False


@contextlib.contextmanager
def user_code(doing: str) -> Iterator[None]:
    """Turn any error of a user's code, even an attempt to exit Python, into ``InvalidParameter``.

    Only Ctrl-C passes through, and leaving the debugger counts as Ctrl-C. What the code prints goes
    to stderr.

    Args:
        doing: Description of the code, such as its file; the error message begins with it.

    Raises:
        InvalidParameter: If the code raises anything but ``KeyboardInterrupt``.
    """
    try:
        with only_results_on_stdout():
            yield
    except KeyboardInterrupt:
        raise
    except BdbQuit:
        raise KeyboardInterrupt from None
    except SystemExit as error:
        raise InvalidParameter(
            "code-failed",
            "{doing} ends Python (SystemExit: {reason})",
            "remove that exit, or put it under if __name__ == '__main__'",
            doing=doing,
            reason=str(error),
        ) from error
    except BaseException as error:
        raise InvalidParameter(
            "code-failed",
            "{doing} failed: {kind}: {reason}",
            doing=doing,
            kind=type(error).__name__,
            reason=without_private_names(str(error)),
        ) from error


@contextlib.contextmanager
def loading(doing: str) -> Iterator[None]:
    """Run code like :func:`user_code`; also explain an import that one of our packages hides."""
    try:
        with user_code(doing):
            yield
    except InvalidParameter as error:
        if isinstance(error.__cause__, ModuleNotFoundError):
            check_import(error.__cause__)
        raise


class Registry(Generic[T]):
    """Look up objects by entry-point name, ``package.module:name`` or ``./file.py:name``.

    Modules are imported only when one of their objects is requested, so listing names costs no
    start-up time.

    Args:
        group: Entry-point group, for example ``worldgen.families``.
        noun: Name of such an object in messages, for example ``family``.
        accept: Converts the object that a name refers to into a ``T``; raises
            :class:`InvalidParameter` if it can't.
    """

    def __init__(self, group: str, noun: str, accept: Callable[[str, Any], T]) -> None:
        self.group = group
        self.noun = noun
        self._accept = accept
        self._loaded: dict[str, T] = {}

    def entry_points(self) -> dict[str, EntryPoint]:
        """Return all entry points of the group by name.

        Raises:
            InvalidParameter: If two packages claim the same name.
        """
        found: dict[str, EntryPoint] = {}
        for point in points_of(self.group):
            other = found.get(point.name)
            if other is not None and other.value != point.value:
                raise InvalidParameter(
                    "twice",
                    "{noun} {name!r} is registered twice ({value} and {other})",
                    "uninstall one of the packages",
                    noun=self.noun,
                    name=point.name,
                    value=other.value,
                    other=point.value,
                )
            found[point.name] = point
        return found

    def names(self) -> list[str]:
        """Return the registered names, sorted."""
        return sorted(self.entry_points())

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def get(self, name: str) -> T:
        """Return the object with this name, and load it if necessary.

        Raises:
            InvalidParameter: If nothing has this name, loading it fails, or it has the wrong type.
        """
        key = identity(name)
        # Loaded code is checked again, because the next command may not have named it.
        if ":" in name and not self._is_registered(name):
            check_code(name)
        if key not in self._loaded:
            point = self.entry_points().get(name)
            # An installed name is loaded by its entry point, anything with a colon by its path.
            if point is not None:
                with loading(f"{self.noun} {name!r}: loading {point.value}"):
                    thing = point.load()
            elif ":" in name:
                thing = self._load_path(name)
            else:
                raise InvalidParameter.of(self._unknown(name))
            self._loaded[key] = self._accept(name, thing)
        return self._loaded[key]

    def _is_registered(self, name: str) -> bool:
        """Return True for a registered name, and for the place of a registered object."""
        return any(name in (point.name, point.value) for point in points_of(self.group))

    def renew(self, place: str) -> None:
        """Forget what was made from a file, so that the next request makes it again.

        The file's module stays loaded, and its top level does not run again.
        """
        file = identity(f"{place}:").rpartition(":")[0]
        for key in [key for key in self._loaded if key.startswith(f"{file}:")]:
            del self._loaded[key]

    def forget(self, place: str) -> None:
        """Forget a file and the files next to it, so that the next request loads them again."""
        self.renew(place)
        file = identity(f"{place}:").rpartition(":")[0]
        if file.endswith(".py"):
            sys.modules.pop(_module_name(Path(file)), None)
            forget_folder(Path(file).parent)

    def source(self, name: str) -> Path | None:
        """Return the file that defines the object with this name, or ``None`` if no file does."""
        point = self.entry_points().get(name)
        if point is None and ":" in name and not self._is_registered(name):
            check_code(name)
        place = name.rpartition(":")[0] if point is None else point.module
        if place.endswith(".py"):
            return _file(place)
        with user_code(f"{self.noun} {name!r}: looking for {place}"):
            found = importlib.util.find_spec(place) if place else None
        return (
            Path(found.origin)
            if found is not None and found.has_location and found.origin
            else None
        )

    def _unknown(self, name: str) -> Message:
        return unknown_name(
            "no {noun} is called {name!r}", name, self.names(), _KNOWN, noun=self.noun
        )

    def _no_module(self, name: str, place: str) -> InvalidParameter:
        return InvalidParameter(
            "no-such-module",
            "{noun} {name!r}: Python finds no module {place!r}",
            _KNOWN,
            noun=self.noun,
            name=name,
            place=place,
            known=self.names(),
        )

    def _load_path(self, name: str) -> Any:
        place, _, attribute = name.rpartition(":")
        is_file = place.endswith(".py")
        if is_file and not _is_file(expanded(_file(place))):
            raise InvalidParameter(
                "no-such-file",
                "{noun} {name!r}: there is no such file",
                "check the path",
                noun=self.noun,
                name=name,
            )
        if not is_file:
            # A user's file with the name of one of our packages would be hidden by ours.
            check_not_ours(place, attribute)
        # import_module() takes neither as a name of a module.
        if not is_file and not all(place.split(".")):
            raise self._no_module(name, place)
        try:
            with loading(f"{self.noun} {name!r}: loading {place}"):
                module = _load_file(_file(place)) if is_file else importlib.import_module(place)
                if hasattr(module, attribute):
                    return getattr(module, attribute)
        except InvalidParameter as error:
            # A module that the user's own module lacks is a fault of its code.
            missing = error.__cause__
            lacks_module = isinstance(missing, ModuleNotFoundError) and not is_file
            if lacks_module and f"{place}.".startswith(f"{getattr(missing, 'name', None)}."):
                raise self._no_module(name, place) from missing
            raise
        # The attribute is missing, so suggest a similar one, or list the file's own definitions.
        public = [key for key in vars(module) if not key.startswith("_")]
        own = [
            key
            for key in public
            if getattr(vars(module)[key], "__module__", None) == module.__name__
        ]
        near = "".join(difflib.get_close_matches(attribute, public, n=1))
        raise InvalidParameter(
            "unknown-name",
            "{noun} {name!r}: {place} has no {attribute!r}",
            "did you mean {near!r}? there are {known!l:none}"
            if near
            else "it has {known!l:nothing}",
            noun=self.noun,
            name=name,
            place=place,
            attribute=attribute,
            near=near,
            known=own or public,
        )


def identity(name: str) -> str:
    """Return the name with a file's path made absolute.

    ``./mine.py:Robot`` means something else in every working directory, so it cannot be a key.
    """
    place, colon, attribute = name.rpartition(":")
    return (
        f"{real_path(expanded(_file(place)))}{colon}{attribute}" if place.endswith(".py") else name
    )


def _module_name(path: Path) -> str:
    return f"_worldgen_user_{path.stem}_{abs(hash(str(path))):x}"


def _load_file(path: Path) -> Any:
    path = real_path(expanded(path))
    module_name = _module_name(path)
    # A controller and an oracle in one file share its module, unless it was edited in between.
    loaded = sys.modules.get(module_name)
    if loaded is not None and sources_read().get(str(path)) == digest_of_source(path.read_bytes()):
        return loaded
    loader = SourceLoader(module_name, str(path))
    spec = importlib.util.spec_from_file_location(module_name, path, loader=loader)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    import_in(module, package_of(path.parent))
    # Register the module before running it, as the import system does: dataclasses and pickles look
    # it up there.
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[module_name]
        raise
    return module
