"""Rows of arrays without reference counts, for kernels that make no array and no slice.

A slice of numba's costs 10 ns for its reference count, and kernels without those can make none. A view of ours is
nothing but an address and a shape: whoever calls the kernel holds the memory.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numba import extending
from numba.core import cgutils, types
from numba.np import arrayobj

__all__ = ["page", "part", "row"]

_code: Any = cgutils
_numba: Any = arrayobj
_extending: Any = extending


def row(array: Any, index: int) -> Any:
    """``array[index]`` of an array of two or more dimensions in C order."""
    return array[index]


def part(array: Any, first: int, last: int) -> Any:
    """``array[first:last]`` of an array in C order."""
    return array[first:last]


def page(array: Any, height: int, width: int) -> Any:
    """The first ``height * width`` numbers of an array of one dimension in C order, as rows."""
    return array[: height * width].reshape(height, width)


def _type_of_row(_context: Any) -> Callable[[Any, Any], Any]:
    def result(array: Any, index: Any) -> Any:
        fits = _is_in_c_order(array) and array.ndim > 1 and isinstance(index, types.Integer)
        return array.copy(ndim=array.ndim - 1) if fits else None

    return result


def _type_of_part(_context: Any) -> Callable[[Any, Any, Any], Any]:
    def result(array: Any, first: Any, last: Any) -> Any:
        fits = _is_in_c_order(array) and isinstance(first, types.Integer) and isinstance(last, types.Integer)
        return array if fits else None

    return result


def _type_of_page(_context: Any) -> Callable[[Any, Any, Any], Any]:
    def result(array: Any, height: Any, width: Any) -> Any:
        fits = _is_in_c_order(array) and array.ndim == 1
        return array.copy(ndim=2) if fits and all(isinstance(n, types.Integer) for n in (height, width)) else None

    return result


def _code_of_row(context: Any, builder: Any, signature: Any, arguments: Sequence[Any]) -> Any:
    shape, strides = _extent(context, builder, signature, arguments)
    return _view(context, builder, signature, arguments, arguments[1], (shape[1:], strides[1:]))


def _code_of_part(context: Any, builder: Any, signature: Any, arguments: Sequence[Any]) -> Any:
    shape, strides = _extent(context, builder, signature, arguments)
    count = builder.sub(arguments[2], arguments[1])
    return _view(context, builder, signature, arguments, arguments[1], ([count, *shape[1:]], strides))


def _code_of_page(context: Any, builder: Any, signature: Any, arguments: Sequence[Any]) -> Any:
    _, (size,) = _extent(context, builder, signature, arguments)
    height, width = arguments[1:]
    first = width.type(0)
    return _view(context, builder, signature, arguments, first, ([height, width], [builder.mul(width, size), size]))


def _is_in_c_order(array: Any) -> bool:
    return isinstance(array, types.Array) and array.layout == "C"


def _extent(context: Any, builder: Any, signature: Any, arguments: Sequence[Any]) -> tuple[Any, Any]:
    """Shape and strides of the array in the first argument."""
    source = _numba.make_array(signature.args[0])(context, builder, arguments[0])
    return _code.unpack_tuple(builder, source.shape), _code.unpack_tuple(builder, source.strides)


def _view(
    context: Any,
    builder: Any,
    signature: Any,
    arguments: Sequence[Any],
    first: Any,
    extent: tuple[Sequence[Any], Sequence[Any]],
) -> Any:
    """What begins at an index of the array in the first argument, with a shape and strides."""
    source = _numba.make_array(signature.args[0])(context, builder, arguments[0])
    offset = builder.mul(first, _code.unpack_tuple(builder, source.strides)[0])
    view = _numba.make_array(signature.return_type)(context, builder)
    _numba.populate_array(
        view,
        data=_code.pointer_add(builder, source.data, offset, source.data.type),
        shape=extent[0],
        strides=extent[1],
        itemsize=source.itemsize,
        meminfo=None,
    )
    return view._getvalue()


_extending.type_callable(row)(_type_of_row)
_extending.type_callable(part)(_type_of_part)
_extending.type_callable(page)(_type_of_page)
_extending.lower_builtin(row, types.Array, types.Integer)(_code_of_row)
_extending.lower_builtin(part, types.Array, types.Integer, types.Integer)(_code_of_part)
_extending.lower_builtin(page, types.Array, types.Integer, types.Integer)(_code_of_page)
