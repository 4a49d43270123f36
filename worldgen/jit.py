"""Compiles kernels with numba and keeps the result between runs.

Numba's own cache keeps stale code when a helper in another file changes. So the cache folder of a kernel
is named by a digest of every source file beside it, of the package's folder of kernels, of what it says it is
built on, and of the compiler's versions.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import stat
import tempfile
import types
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar, cast

from worldgen.progress import Work, say_once, working

__all__ = ["cache_folder", "cache_root", "kernel", "lazy_kernel"]

F = TypeVar("F", bound=Callable[..., Any])

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_compiling: list[Work] = []  # what is compiled now: one, or none
_PARTS = {
    "worldgen": "the generator and its proofs",
    "sim": "the simulator",
    "fuzz": "the search",
    "worldgen_plugins": "the environments",
}


def cache_root() -> Path | None:
    """Return the folder of compiled kernels, or None if no folder is safe from other users.

    That is ``WORLDGEN_CACHE_DIR``, else the user's cache, else a private folder under the temporary directory. Kernels
    are pickles with machine code, so a folder counts only if this user owns it and nobody else can write in it.
    """
    return _checked_root(os.environ.get("WORLDGEN_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"))


@functools.cache
def _checked_root(named: str | None, cache_home: str | None) -> Path | None:
    refused = []
    if named:
        folder = Path(named)
        fault = _fault_of(folder)
        if not fault:
            return folder
        refused.append(f"WORLDGEN_CACHE_DIR={named} {fault}")
    with contextlib.suppress(RuntimeError):  # no home at all
        own = Path(cache_home) if cache_home else Path.home() / ".cache"
        folder = own / "worldgen"
        _tighten(folder)
        fault = _fault_of(folder)
        if not fault:
            if refused:
                say_once(f"{refused[0]}; compiled kernels are kept in {folder} instead")
            return folder
        refused.append(f"{folder} {fault}")
    folder = Path(tempfile.gettempdir()) / f"worldgen-{os.geteuid() if hasattr(os, 'geteuid') else 'cache'}"
    fault = _fault_of(folder, private=True)
    if not fault:
        return folder
    refused.append(f"{folder} {fault}")
    say_once(
        f"no folder can keep compiled kernels ({'; '.join(refused)}), so they are compiled in every run; "
        "set WORLDGEN_CACHE_DIR to a folder of your own that others cannot write"
    )
    return None


def _tighten(folder: Path) -> None:
    """Take the right to write from others, which a lax umask gave them on a folder that we made."""
    with contextlib.suppress(OSError):
        status = folder.lstat()
        if stat.S_ISDIR(status.st_mode) and hasattr(os, "geteuid") and status.st_uid == os.geteuid():
            folder.chmod(stat.S_IMODE(status.st_mode) & ~_OTHERS_WRITE)


def _fault_of(folder: Path, *, private: bool = False) -> str:
    """Say why kernels cannot be kept in a folder, which is made if missing; empty if they can.

    Args:
        folder: Any folder.
        private: Whether it stands where everybody can make folders: then it is no symlink, and nobody else may read it.
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        status = folder.lstat() if private else folder.stat()
    except OSError as error:
        return f"cannot be made: {error.strerror}"
    if not stat.S_ISDIR(status.st_mode):
        return "is not a folder"
    if hasattr(os, "geteuid"):
        if status.st_uid != os.geteuid():
            return "belongs to another user"
        if status.st_mode & (0o077 if private else _OTHERS_WRITE):
            return "can be written by other users"
    return "" if os.access(folder, os.W_OK | os.X_OK) else "cannot be written"


@functools.cache
def cache_folder(source_folder: Path, built_on: Path | None = None) -> Path | None:
    """Return where the compiled kernels of a folder of sources are kept: another place whenever one of them changes.

    Another numba or llvmlite gets another place too, because one need not be able to read what the other wrote.

    None means that they are not kept: no folder is safe from other users.
    """
    root = cache_root()
    if root is None:
        return None
    digest = hashlib.sha256(f"numba {version('numba')}, llvmlite {version('llvmlite')}".encode())
    others = () if built_on is None else built_on.glob("*.py")
    for source in sorted({*source_folder.glob("*.py"), *_shared(source_folder), *others}):
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    folder = root / f"kernels-{digest.hexdigest()[:16]}"
    fault = _fault_of(folder)
    if fault:
        say_once(f"{folder} {fault}, so kernels are compiled in every run; remove it")
    return None if fault else folder


def _shared(folder: Path) -> Iterator[Path]:
    """Sources of the folder ``kernels`` of the same package, whose functions become part of kernels elsewhere."""
    while (folder.parent / "__init__.py").is_file():
        folder = folder.parent
    return (folder / "kernels").glob("*.py")


def kernel(
    function: F,
    *,
    signature: Any = None,
    allocates: bool = True,
    inline: bool = False,
    built_on: Path | None = None,
) -> F:
    """Compiles a function that knows only numbers and arrays; ``fastmath`` never.

    ``kernel(f).py_func`` is ``f`` again: the two agree to the last bit.

    Args:
        function: What to compile.
        signature: A numba signature to compile for at once; without one, types come with the first call.
        allocates: Whether it makes arrays or slices. One that does not needs no reference counts, which cost
            10 ns for every array of every call: without them the lattice robot's step took 112 ns, not 412.
        inline: Whether its code stands in place of each call from another kernel; the two kinds of episode ran
            1.7 and 2.2 times as fast so, and compiled in 1.1 times the time.
        built_on: Folder of another package's kernels that it calls.
    """
    import numba

    options: dict[str, Any] = {"nogil": True, "forceinline": inline}
    options |= {} if allocates else {"_nrt": False}
    dispatcher: Any = numba.njit(**options)(function)
    if dispatcher is function:  # NUMBA_DISABLE_JIT
        return function
    _keep_compiled(dispatcher, function, cache_folder(Path(function.__code__.co_filename).parent, built_on))
    if signature is not None:
        dispatcher.compile(signature)
        dispatcher.disable_compile()
    return cast(F, _without_literals(dispatcher))


def _keep_compiled(dispatcher: Any, function: Callable[..., Any], folder: Path | None) -> None:
    """Give a kernel its cache, and let it say when it is compiled: that takes up to a minute.

    Args:
        dispatcher: The kernel.
        function: What it is compiled from.
        folder: Where it is kept; None keeps nothing.
    """
    import numba
    from numba.core.caching import NullCache

    package = function.__module__.partition(".")[0]
    often = "in this run: no folder can keep it" if folder is None else "once per installation"
    message = f"compiling {_PARTS.get(package, function.__module__)}, {often}"
    mine: list[contextlib.ExitStack] = []

    def missed() -> None:
        # A kernel compiles those that it calls; they belong to the outermost one's piece of work.
        if not _compiling and mine:
            _compiling.append(mine[-1].enter_context(working(message)))
            mine[-1].callback(_compiling.clear)
        for work in _compiling:
            work.say(function.__name__)

    if folder is None:

        class Nothing(NullCache):
            def load_overload(self, sig: Any, target_context: Any) -> None:
                missed()

        dispatcher._cache = Nothing()
    else:
        from worldgen.kernel_cache import KernelCache

        config: Any = numba.config
        before = config.CACHE_DIR
        config.CACHE_DIR = str(folder)
        try:
            dispatcher._cache = KernelCache(function, folder, missed)
        finally:
            config.CACHE_DIR = before
    compile_now = dispatcher.compile

    def compile_aloud(signature: Any) -> Any:
        with contextlib.ExitStack() as stack:
            mine.append(stack)
            try:
                return compile_now(signature)
            finally:
                mine.remove(stack)

    dispatcher.compile = compile_aloud


def _without_literals(dispatcher: Any) -> Any:
    """Lets calls with constants share one compilation: to numba a bare 0 is of a type of its own."""
    from numba.core import types as numba_types

    unliteral: Any = numba_types.unliteral
    typed = getattr(dispatcher, "get_call_template", None)
    if typed is not None:  # there is none where numba compiles nothing
        dispatcher.get_call_template = lambda args, kws: typed(
            tuple(map(unliteral, args)), {name: unliteral(value) for name, value in kws.items()}
        )
    return dispatcher


def lazy_kernel(function: F, *helpers: Callable[..., Any]) -> F:
    """The compiled twin of a function, made at its first call: numba costs a second that small worlds save.

    Args:
        function: What to compile.
        *helpers: Plain functions of its module that it calls, or that a later one of them calls, and that make
            no arrays; in the twin their code stands in place of each call.
    """
    made: list[F] = []

    @functools.wraps(function)
    def call(*args: Any) -> Any:
        if not made:
            made.append(kernel(_with_compiled(function, helpers)))
        return made[0](*args)

    return cast(F, call)


def _with_compiled(function: F, helpers: tuple[Callable[..., Any], ...]) -> F:
    """A copy of a function whose helpers are kernels; the function itself goes on calling plain Python."""
    if not helpers:
        return function
    names = dict(function.__globals__)
    for helper in helpers:
        names[helper.__name__] = kernel(_copy(helper, names), allocates=False, inline=True)
    return _copy(function, names)


def _copy(function: F, names: dict[str, Any]) -> F:
    copy = types.FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    copy.__qualname__, copy.__module__ = function.__qualname__, function.__module__
    return cast(F, copy)
