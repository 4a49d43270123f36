"""Pass numpy arrays to the C cores: addresses, checked for type and order.

Every core is a module made by cffi (``build_tools/cores.py``). Its functions take plain pointers,
so an array of the wrong type would be read as garbage; these functions reject it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

_C_TYPES = {
    np.dtype(np.bool_): "uint8_t[]",
    np.dtype(np.uint8): "uint8_t[]",
    np.dtype(np.uint16): "uint16_t[]",
    np.dtype(np.int8): "int8_t[]",
    np.dtype(np.int16): "int16_t[]",
    np.dtype(np.int32): "int32_t[]",
    np.dtype(np.uint32): "uint32_t[]",
    np.dtype(np.int64): "int64_t[]",
    np.dtype(np.uint64): "uint64_t[]",
    np.dtype(np.float32): "float[]",
    np.dtype(np.float64): "double[]",
}

_OUT_OF_MEMORY = 3
_MEANINGS = {1: "an array is too small", 2: "a number is out of its range"}


def pointer(ffi: Any, array: np.ndarray[Any, Any], kind: type[np.generic]) -> Any:
    """Return the address of an array that C only reads. It must outlive the call.

    If C keeps the address after the call, own the array with :func:`kept`.

    Args:
        ffi: ``ffi`` of the core.
        array: Array in C order.
        kind: The dtype that C expects.

    Raises:
        TypeError: If the dtype differs.
        ValueError: If it is not in C order.
    """
    if array.dtype != kind:
        raise TypeError(f"the core takes {np.dtype(kind)}, not {array.dtype}")
    if not array.flags.c_contiguous:
        raise ValueError("the core takes arrays in C order")
    return ffi.from_buffer(_C_TYPES[array.dtype], array)


def writable(ffi: Any, array: np.ndarray[Any, Any], kind: type[np.generic]) -> Any:
    """Return the address of an array that C fills; see :func:`pointer`.

    Raises:
        BufferError: If the array is read-only.
    """
    if not array.flags.writeable:
        raise BufferError("the core would write into an array that is read-only")
    return pointer(ffi, array, kind)


def kept(
    ffi: Any, address: Any, *objects: object, free: Callable[[Any], object] | None = None
) -> Any:
    """Return an address that keeps alive everything that C finds through it.

    C keeps plain addresses, which Python does not count as references. Every struct that points to
    arrays, and every object of the core that does, is owned this way. A tuple of arrays in another
    attribute is not enough: Python may clear the attributes of an object in any order, and a
    core's function that frees an object may still read what it points to.

    Args:
        ffi: ``ffi`` of the core.
        address: A pointer to a struct or to an object of the core.
        objects: They are released only after ``free`` has returned.
        free: The core's function that frees the object; None if nothing needs to be freed.
    """

    def release(freed: Any, _objects: tuple[object, ...] = objects) -> None:
        if free is not None:
            free(freed)

    return ffi.gc(address, release)


def check(status: int) -> None:
    """Raise the error that a core's function returned, unless it is WG_OK.

    Raises:
        MemoryError: If the core ran out of memory.
        ValueError: If it refused its arguments, which is a bug of ours.
    """
    if status == 0:
        return
    if status == _OUT_OF_MEMORY:
        raise MemoryError("not enough memory for this world")
    raise ValueError(f"the core refused its arguments: {_MEANINGS.get(status, f'status {status}')}")
