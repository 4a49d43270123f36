"""Arrays that nobody changes.

What is immutable holds its own copy, made once and shared from then on.
"""

from __future__ import annotations

import weakref
from typing import TypeVar

import numpy as np
import numpy.typing as npt

__all__ = ["HoldsFrozen", "freeze", "frozen"]

T = TypeVar("T", bound=np.generic)

# Arrays that were made or handed over here, by identity: of these there is no writable view
# elsewhere.
_ours: weakref.WeakValueDictionary[int, npt.NDArray[np.generic]] = weakref.WeakValueDictionary()


def frozen(values: npt.ArrayLike, dtype: npt.DTypeLike) -> npt.NDArray[np.generic]:
    """Return the values as a read-only array.

    They are copied, unless this function has already frozen them.

    Args:
        values: Anything that NumPy makes an array of.
        dtype: Type of the elements.
    """
    if isinstance(values, np.ndarray) and values.dtype == dtype and _is_ours(values):
        return values
    array = np.array(values, dtype=dtype)
    if (
        array.dtype == np.bool_
    ):  # an image's 255 seen as a bool is true, and no index of two letters
        array = array.view(np.uint8) != 0
    return _keep(array)


class HoldsFrozen:
    """A base of immutable classes with arrays.

    In a copy and in what was pickled they are frozen, too.
    """

    def __setstate__(self, state: dict[str, object]) -> None:
        """Take over what ``pickle`` or ``copy`` brings."""
        for name, value in state.items():
            object.__setattr__(
                self, name, frozen(value, value.dtype) if isinstance(value, np.ndarray) else value
            )


def freeze(array: npt.NDArray[T]) -> npt.NDArray[T]:
    """Freeze an array in place and say that it need not be copied.

    The caller keeps no writable view of it.

    Args:
        array: A fresh one. A view of another array is left as it is, and copied later.
    """
    if array.base is None and array.flags.c_contiguous:
        _keep(array)
    return array


def _keep(array: npt.NDArray[T]) -> npt.NDArray[T]:
    array.setflags(write=False)
    _ours[id(array)] = array
    return array


def _is_ours(array: npt.NDArray[np.generic]) -> bool:
    """Return whether this very array was kept, and nobody made it writable since."""
    return not array.flags.writeable and _ours.get(id(array)) is array
