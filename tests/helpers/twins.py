"""Interpreted copies of kernels and of all functions that they call.

The compiled kernels must give the same bits.
"""

import types
from collections.abc import Callable
from typing import Any


def twin(kernel: Callable[..., Any], made: dict[int, Any] | None = None) -> Callable[..., Any]:
    """Return the Python function that a kernel was compiled from, which itself calls only such
    functions.
    """
    made = {} if made is None else made
    plain = getattr(kernel, "py_func", kernel)
    if id(plain) not in made:
        names = dict(plain.__globals__)
        made[id(plain)] = copy = types.FunctionType(
            plain.__code__, names, plain.__name__, plain.__defaults__, plain.__closure__
        )
        for name in plain.__code__.co_names:
            if hasattr(names.get(name), "py_func"):
                names[name] = twin(names[name], made)
        return copy
    return made[id(plain)]
