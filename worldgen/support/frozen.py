"""Immutable arrays.

An immutable object holds its own copy, made once and shared from then on.
"""

from __future__ import annotations

import weakref
from typing import TypeVar

import numpy as np
import numpy.typing as npt

T = TypeVar("T", bound=np.generic)

# Arrays that were created or frozen here, by identity; no writable view of them exists elsewhere.
_ours: weakref.WeakValueDictionary[int, npt.NDArray[np.generic]] = weakref.WeakValueDictionary()


def frozen(values: npt.ArrayLike, dtype: npt.DTypeLike) -> npt.NDArray[np.generic]:
    """Return the values as a read-only array.

    They are copied, unless this function has already frozen them.

    Args:
        values: Anything that NumPy can turn into an array.
        dtype: Type of the elements.
    """
    if isinstance(values, np.ndarray) and values.dtype == dtype and _is_ours(values):
        return values
    array = np.array(values, dtype=dtype)
    # A byte of 255 from an image is true when viewed as bool, but cannot index two letters.
    if array.dtype == np.bool_:
        array = array.view(np.uint8) != 0
    return _keep(array)


class HoldsFrozen:
    """A base of immutable classes with arrays.

    In a copy and after unpickling they are frozen, too.
    """

    def __setstate__(self, state: dict[str, object]) -> None:
        """Set the state from ``pickle`` or ``copy``."""
        for name, value in state.items():
            object.__setattr__(
                self, name, frozen(value, value.dtype) if isinstance(value, np.ndarray) else value
            )


def freeze(array: npt.NDArray[T]) -> npt.NDArray[T]:
    """Freeze an array in place, and mark it as not needing a copy.

    The caller must not keep a writable view of it.

    Args:
        array: A new array. A view of another array is left alone, and copied later.
    """
    if array.base is None and array.flags.c_contiguous:
        _keep(array)
    return array


def _keep(array: npt.NDArray[T]) -> npt.NDArray[T]:
    array.setflags(write=False)
    _ours[id(array)] = array
    return array


def _is_ours(array: npt.NDArray[np.generic]) -> bool:
    """Return True if this exact array was registered and is still read-only."""
    return not array.flags.writeable and _ours.get(id(array)) is array
