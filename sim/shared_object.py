"""Reads what a shared library says about a controller in it: ``lib:./robot.so:act``.

``worldgen_controller.h`` is the contract. A library is code that runs with all rights of the process that loads it.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

from sim._core import ffi as _ffi
from sim._core import lib as _lib
from worldgen.errors import InvalidParameter

__all__ = ["check_file", "include_folder", "info_of", "is_library_name", "library_file"]

ffi: Any = _ffi
lib: Any = _lib

_PREFIX = "lib:"
_OFFER = "_controller"  # what follows the name of the function that describes it
_BUILD = 'cc -std=c17 -O2 -shared -fPIC -I"$(worldgen --include)" robot.c -o robot.so'


def is_library_name(name: str) -> bool:
    """Return whether a controller's name means one in a shared library."""
    return name.startswith(_PREFIX)


def library_file(name: str) -> Path:
    """Return the library that a controller's name means."""
    return Path(name.removeprefix(_PREFIX).rpartition(":")[0]).expanduser()


def include_folder() -> Path:
    """Return the folder of ``worldgen_controller.h``."""
    return Path(__file__).parent / "include"


@functools.cache
def info_of(name: str) -> Any:
    """Return what a library says of its controller, checked for the version of the interface.

    Raises:
        InvalidParameter: If there is no such thing.
    """
    place, colon, function = name.removeprefix(_PREFIX).rpartition(":")
    if not colon or not place or not function:
        raise InvalidParameter(f"controller {name!r} names no function; write lib:./robot.so:act")
    loaded = _loaded(name, Path(place).expanduser())
    try:
        offer = getattr(loaded, function + _OFFER)
    except AttributeError:
        raise InvalidParameter(_missing(name, place, function, loaded)) from None
    offer.restype = ctypes.c_void_p
    offer.argtypes = ()
    address = offer()
    if not address:
        raise InvalidParameter(f"controller {name!r}: {function}{_OFFER}() returned NULL; offer it with WG_CONTROLLER")
    info = ffi.cast("const WgControllerInfo *", address)
    if info.abi != lib.WG_CONTROLLER_ABI:
        raise InvalidParameter(
            f"controller {name!r} was built for version {info.abi} of worldgen_controller.h, and this is version "
            f"{lib.WG_CONTROLLER_ABI}; build it again: {_BUILD}"
        )
    if info.size != ffi.sizeof("WgControllerInfo"):
        raise InvalidParameter(
            f"controller {name!r} describes itself in {info.size} bytes, and a WgControllerInfo has "
            f"{ffi.sizeof('WgControllerInfo')}; build it again with this worldgen's header: {_BUILD}"
        )
    if info.act == ffi.NULL:
        raise InvalidParameter(f"controller {name!r} has no act; offer it with WG_CONTROLLER({function}, ...)")
    return info


def check_file(name: str) -> None:
    """Refuse a name of a library that is not there, without loading what is.

    Raises:
        InvalidParameter: If it is not there.
    """
    file = library_file(name)
    if not file.is_file():
        raise InvalidParameter(f"controller {name!r}: there is no file {file}; build it: {_BUILD}")


def _loaded(name: str, file: Path) -> ctypes.CDLL:
    """Return the library, which stays loaded until this process ends."""
    check_file(name)
    try:
        return ctypes.CDLL(str(file.resolve()))
    except OSError as error:
        raise InvalidParameter(
            f"controller {name!r}: {file} cannot be loaded ({error}); build a shared library: {_BUILD}"
        ) from None


def _missing(name: str, place: str, function: str, loaded: ctypes.CDLL) -> str:
    """Return what to say where a library does not offer a controller."""
    if hasattr(loaded, function):
        return (
            f"controller {name!r}: {place} has a function {function}, but does not offer it as a controller; "
            f"add WG_CONTROLLER({function}, .memory_size = ...) and build it again"
        )
    return (
        f"controller {name!r}: {place} offers no controller {function}; "
        f"name another, or add WG_CONTROLLER({function}, .memory_size = ...) and build it again"
    )
