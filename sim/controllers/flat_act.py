"""Compile a user's act function with numba, in the form in which the core calls it.

Numba is an optional dependency, ``worldgen[numba]``.
"""

from __future__ import annotations

import functools
import warnings
from typing import Any

from sim.controllers.base import Act
from sim.kernels import layout
from worldgen.errors import InvalidParameter
from worldgen.plugins.installation import pip_install

# Functions whose addresses the core may hold; dropping a function would free its code.
_kept: list[Any] = []


@functools.cache
def compiled_act(act: Act) -> Any:
    """Return the compiled form of an act function of three flat float64 arrays.

    Raises:
        InvalidParameter: If numba is not installed, or cannot compile the function.
    """
    numba = _numba(act)
    array = numba.float64[::1]
    try:
        with warnings.catch_warnings():
            # If numba's warnings matter, a clearer error follows.
            warnings.simplefilter("ignore", numba.core.errors.NumbaWarning)
            compiled = numba.njit(numba.void(array, array, array), nogil=True, boundscheck=True)(
                getattr(act, "py_func", act)
            )
    except numba.core.errors.NumbaError as error:
        raise InvalidParameter(
            "does-not-compile",
            "controller function {function} does not compile: {reason}",
            "write it with numbers and arrays only, or write it as a Python class",
            function=_name(act),
            reason=_reason(error),
        ) from error

    # Numba has its own generator for random and numpy.random, which our seeds do not control.
    if any("_random_state" in code for code in compiled.inspect_llvm().values()):
        raise InvalidParameter(
            "draws-outside-seed",
            "controller function {function} draws random numbers from Python or NumPy, which a "
            "run's seed does not control",
            "use observation[OBS_RANDOM], and set command[CMD_DRAW] = 1.0",
            function=_name(act),
        )
    return compiled


@functools.cache
def flat_address(act: Act) -> int:
    """Return the address of an act function for the core to call.

    Returns:
        The address of a ``WgFlatAct``, whose result tells whether the function raised.

    Raises:
        InvalidParameter: If numba is not installed, or cannot compile the function.
    """
    compiled = compiled_act(act)
    numba = _numba(act)
    command_size = layout.CMD_SIZE + layout.MESSAGE_SIZE
    numbers = numba.types.CPointer(numba.float64)

    @numba.cfunc(numba.int64(numbers, numba.int64, numbers, numba.int64, numbers))  # type: ignore[untyped-decorator]
    def flat(
        observation: Any, observation_size: int, memory: Any, memory_size: int, command: Any
    ) -> int:
        try:
            compiled(
                numba.carray(observation, (observation_size,)),
                numba.carray(memory, (memory_size,)),
                numba.carray(command, (command_size,)),
            )
        except Exception:  # noqa: BLE001 - anything may be raised; a second run finds out what
            return 1
        return 0

    _kept.append(flat)
    address: Any = flat.address
    return int(address)


def _numba(act: Act) -> Any:
    try:
        import numba  # noqa: PLC0415 - an extra, and it takes half a second
    except ModuleNotFoundError as error:
        if error.name != "numba":
            raise
        raise InvalidParameter(
            "package-missing",
            "controller function {function} is compiled by numba, which is not installed",
            "{install}, or write it in C: worldgen new-controller mine --kind c",
            at_terminal=True,
            function=_name(act),
            install=pip_install("numba"),
        ) from None
    return numba


def _name(act: Act) -> str:
    return getattr(act, "__name__", repr(act))


def _reason(error: Exception) -> str:
    """Return numba's message without its list of compiler stages.

    If the message is about a call that numba does not know, include that call.
    """
    lines = (line.strip() for line in str(error).splitlines())
    reason = [
        line
        for line in lines
        if line and not line.startswith(("Failed in", "During:", "- Resolution"))
    ]
    with_call = len(reason) > 1 and reason[1].startswith(">>>")
    return " ".join(reason[: 2 if with_call else 1])
