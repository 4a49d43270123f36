"""See the state that a Python class keeps outside its memory."""

from __future__ import annotations

import io
import pickle
import random
import sys
import types
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from sim.runners.timeline_reads import ignoring_pickles
from worldgen.plugins.user_modules import neighbours_of


class HiddenState(NamedTuple):
    """State outside a controller's memory, as bytes to compare.

    Args:
        own: Attributes of the object and of its parts.
        shared: Variables of its classes and their modules.
        random: State of the random generators that all code shares.
    """

    own: bytes
    shared: bytes
    random: bytes


def hidden_state(controller: Any) -> HiddenState | None:
    """Return all state outside ``memory`` that can be seen.

    That is the state of the object, its classes and their modules, and of random generators.
    ``None`` if some of it cannot be pickled, and so cannot be compared.
    """
    parts = getattr(controller, "made_of", ())
    kinds = dict.fromkeys(base for one in (controller, *parts) for base in type(one).__mro__)
    own = [attributes(controller), *(_data(getattr(part, "__dict__", {})) for part in parts)]
    shared = [
        *(_data_of_class(base) for base in kinds if base is not object),
        *(
            _data_of_module(module)
            for base in kinds
            if _is_of_a_user(base)
            for module in _modules_of(base)
        ),
    ]
    generators = [random.getstate(), np.random.get_state()]
    try:
        return HiddenState(_pickled(own), _pickled(shared), _pickled(generators))
    except Exception:  # noqa: BLE001 - anything that cannot be pickled cannot be compared
        return None


def own_attributes(controller: Any) -> dict[str, bytes]:
    """Return the object's attributes as bytes to compare; empty for one that can't be pickled."""
    return {name: _pickled_if_it_can_be(value) for name, value in attributes(controller).items()}


def attributes(controller: Any) -> dict[str, Any]:
    """Return the object's attributes by name; not those of its class."""
    slots = [
        name
        for base in type(controller).__mro__
        for name in _slots(base)
        if hasattr(controller, name)
    ]
    kept = _data(getattr(controller, "__dict__", {}))
    return {**kept, **{name: getattr(controller, name) for name in slots}}


def _slots(kind: type) -> tuple[str, ...]:
    names = getattr(kind, "__slots__", ())
    return (names,) if isinstance(names, str) else tuple(names)


def _is_of_a_user(kind: type) -> bool:
    package = kind.__module__.partition(".")[0]
    return (
        package not in {"builtins", "typing", "sim", "fuzz", "worldgen"}
        and kind.__module__ in sys.modules
    )


def _modules_of(kind: type) -> list[types.ModuleType]:
    """Return a class's module, and the imported files next to it."""
    module = sys.modules[kind.__module__]
    return [module, *neighbours_of(module)]


def _data_of_module(module: types.ModuleType) -> list[Any]:
    """Return a module's variables, and those of the classes and functions that it defines.

    Unlike the controller's own file, an imported module may hold things that cannot be pickled;
    those are skipped.
    """
    own = [
        thing
        for thing in vars(module).values()
        if getattr(thing, "__module__", None) == module.__name__
    ]
    classes = [_data_of_class(thing) for thing in own if isinstance(thing, type)]
    data = [*_data(vars(module)).items(), *classes, *_data_of_functions(own)]
    own_file = module.__name__.startswith("_worldgen_user_") and "." not in module.__name__
    return data if own_file else [_pickled_if_it_can_be(item) for item in data]


def _pickled_if_it_can_be(data: Any) -> bytes:
    try:
        return _pickled(data)
    except Exception:  # noqa: BLE001 - as above
        return b""


def _pickled(data: Any) -> bytes:
    """Return equal bytes for equal data, whether or not equal parts of it are one object.

    Data that contains itself is an exception: for it, identity matters.
    """
    stream = io.BytesIO()
    pickler = pickle.Pickler(stream)
    pickler.fast = True
    # The controller does not read what this reads.
    with ignoring_pickles():
        try:
            pickler.dump(data)
        except ValueError:  # It contains itself.
            return pickle.dumps(data)
    return stream.getvalue()


def _data_of_class(kind: type) -> list[Any]:
    return [_data(vars(kind)), *_data_of_functions(vars(kind).values())]


def _data_of_functions(things: Iterable[Any]) -> list[Any]:
    """Return the parts of functions that can change: defaults, attributes, enclosing variables."""
    functions = [getattr(thing, "__func__", thing) for thing in things]
    return [
        [
            list(one.__defaults__ or ()),
            one.__kwdefaults__ or {},
            _data(one.__dict__),
            _data(_around(one)),
        ]
        for one in functions
        if isinstance(one, types.FunctionType)
    ]


def _around(function: types.FunctionType) -> dict[str, Any]:
    cells = function.__closure__ or ()
    return {
        str(number): cell.cell_contents
        for number, cell in enumerate(cells)
        if cell != types.CellType()
    }


def _data(names: Mapping[str, Any]) -> dict[str, Any]:
    code = (
        type,
        types.FunctionType,
        types.ModuleType,
        types.MethodType,
        classmethod,
        staticmethod,
        property,
    )
    return {
        name: value
        for name, value in names.items()
        if not name.startswith("__")
        and not isinstance(value, (*code, types.GetSetDescriptorType, types.MemberDescriptorType))
    }
