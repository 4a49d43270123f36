"""Read the description that a shared library gives of a controller: ``lib:./robot.so:act``.

``worldgen_controller.h`` is the contract. A library is code, and runs with all the rights of the
process that loads it.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sim._core import ffi, lib
from sim.controllers.shared import guarded
from worldgen.errors import InvalidParameter, Message
from worldgen.plugins.trust import check_code
from worldgen.support.paths import expanded

_PREFIX = "lib:"
# Suffix of the function that describes a controller.
_OFFER = "_controller"
_BUILD = 'cc -std=c17 -O2 -shared -fPIC -I"$(worldgen --include)" robot.c -o robot.so'


def is_library_name(name: str) -> bool:
    """Return True if a controller's name refers to one in a shared library."""
    return name.startswith(_PREFIX)


def library_file(name: str) -> Path:
    """Return the file of the library in a controller's name."""
    return expanded(name.removeprefix(_PREFIX).rpartition(":")[0])


def include_folder() -> Path:
    """Return the folder that contains ``worldgen_controller.h``."""
    return Path(__file__).parents[2] / "include"


# Size of a description up to and including `start_speed`, as in the first headers.
_FIRST_SIZE = int(ffi.offsetof("WgControllerInfo", "neighbour_range"))


def declares(info: Any, field: str) -> bool:
    """Return True if a description is long enough to have a field."""
    return int(info.size) > int(ffi.offsetof("WgControllerInfo", field))


@functools.cache
def info_of(name: str) -> Any:
    """Return a library's description of its controller, after checking its version.

    Raises:
        InvalidParameter: If the name, the library or the description is not valid.
    """
    place, colon, function = name.removeprefix(_PREFIX).rpartition(":")
    if not colon or not place or not function:
        raise InvalidParameter(
            "no-function-named",
            "controller {name!r} names no function",
            "write lib:./robot.so:act",
            name=name,
        )

    # Every controller comes with a function without arguments that returns its description.
    loaded = _loaded(name, expanded(place))
    try:
        offer = getattr(loaded, function + _OFFER)
    except AttributeError:
        raise InvalidParameter.of(_missing(name, place, function, loaded)) from None
    offer.restype = ctypes.c_void_p
    offer.argtypes = ()
    address = offer()
    if not address:
        raise InvalidParameter(
            "offers-nothing",
            "controller {name!r}: {function}{offer}() returned NULL",
            "offer it with WG_CONTROLLER",
            name=name,
            function=function,
            offer=_OFFER,
        )

    # Check version and size before reading any other field, as these may have moved.
    info = ffi.cast("const WgControllerInfo *", address)
    if info.abi != lib.WG_CONTROLLER_ABI:
        raise InvalidParameter(
            "other-header-version",
            "controller {name!r} was built for version {version} of worldgen_controller.h, "
            "but this is version {wanted}",
            "build it again: {build}",
            name=name,
            version=info.abi,
            wanted=lib.WG_CONTROLLER_ABI,
            build=_BUILD,
        )
    # The description of a library built before the latest fields were added lacks these fields.
    if info.size not in (_FIRST_SIZE, ffi.sizeof("WgControllerInfo")):
        raise InvalidParameter(
            "other-header-version",
            "controller {name!r} describes itself in {size} bytes, but a WgControllerInfo has "
            "{wanted}",
            "build it again with this worldgen's header: {build}",
            name=name,
            size=info.size,
            wanted=ffi.sizeof("WgControllerInfo"),
            build=_BUILD,
        )
    if info.act == ffi.NULL:
        raise InvalidParameter(
            "no-act",
            "controller {name!r} has no act",
            "offer it with WG_CONTROLLER({function}, ...)",
            name=name,
            function=function,
        )
    return info


def check_file(name: str) -> None:
    """Refuse the name of a library whose file does not exist, without loading it.

    Raises:
        InvalidParameter: If the file does not exist.
    """
    file = library_file(name)
    if not file.is_file():
        raise InvalidParameter(
            "no-such-file",
            "controller {name!r}: {file} does not exist",
            "build it: {build}",
            name=name,
            file=file,
            build=_BUILD,
        )


def _loaded(name: str, file: Path) -> ctypes.CDLL:
    """Return the library; it stays loaded until this process ends."""
    check_file(name)
    check_code(name)
    _check_loading(name, file)
    try:
        with _rounding_kept():
            return ctypes.CDLL(str(file.resolve()))
    except OSError as error:
        raise InvalidParameter(
            "cannot-load",
            "controller {name!r}: {file} cannot be loaded ({reason})",
            "build a shared library: {build}",
            name=name,
            file=file,
            reason=str(error),
            build=_BUILD,
        ) from None


def _check_loading(name: str, file: Path) -> None:
    """Load a library in another process first, because its own start code may crash or hang.

    Raises:
        InvalidParameter: If it does.
    """
    if not guarded.can_fork:
        return
    system = ctypes.CDLL(None)
    offer = guarded.SHARED.new("WgOffer *")
    text = guarded.SHARED.own(np.frombuffer(os.fsencode(file.resolve()) + b"\0", np.uint8))
    function = guarded.SHARED.own(
        np.frombuffer(f"{name.rpartition(':')[2]}{_OFFER}\0".encode(), np.uint8)
    )
    offer.open = ffi.cast("WgOpen", ctypes.cast(system.dlopen, ctypes.c_void_p).value)
    offer.find = ffi.cast("WgFind", ctypes.cast(system.dlsym, ctypes.c_void_p).value)
    offer.flags = os.RTLD_NOW
    offer.file = ffi.cast("char *", ffi.from_buffer(text))
    offer.function = ffi.cast("char *", ffi.from_buffer(function))
    try:
        guarded.call(ffi.addressof(lib, "wg_call_offer"), (), (offer,))
    except guarded.ControllerDied as death:
        raise InvalidParameter(
            "cannot-load",
            "controller {name!r}: {file} cannot be loaded ({reason})",
            "correct what it does before its controller acts: constructors, and {function}",
            name=name,
            file=file,
            reason=death.error,
            function=f"{name.rpartition(':')[2]}{_OFFER}()",
        ) from None


@contextlib.contextmanager
def _rounding_kept() -> Iterator[None]:
    """Restore how floating point rounds; a library built with -ffast-math changes it."""
    before = lib.wg_rounding()
    try:
        yield
    finally:
        lib.wg_set_rounding(before)


def _missing(name: str, place: str, function: str, loaded: ctypes.CDLL) -> Message:
    """Return the message for a library that does not offer a controller."""
    if hasattr(loaded, function):
        return Message(
            "offers-no-controller",
            "controller {name!r}: {file} has a function {function}, but does not offer it as a "
            "controller",
            "add WG_CONTROLLER({function}, .memory_size = ...) and build it again",
            name=name,
            file=place,
            function=function,
        )
    return Message(
        "offers-no-controller",
        "controller {name!r}: {file} offers no controller {function}",
        "name another, or add WG_CONTROLLER({function}, .memory_size = ...) and build it again",
        name=name,
        file=place,
        function=function,
    )
