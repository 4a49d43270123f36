"""See the state that a Python class keeps outside its memory."""

from __future__ import annotations

import functools
import io
import pickle
import random
import sys
import types
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sim.controllers.timeline_reads import ignoring_pickles
from worldgen.plugins.user_modules import neighbours_of

_Cached = type(functools.cache(len))


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


@dataclass(frozen=True)
class SharedVariables:
    """A copy of the variables of a class's modules, to set them back without loading a file again.

    Args:
        places: The tables that hold them: of modules, of classes and functions that these define.
        data: The values in all of them, as one pickle, so that what they share stays shared.
    """

    places: list[Any]
    data: bytes

    @classmethod
    def of(cls, kind: type) -> SharedVariables | None:
        """Return a copy of the current values; ``None`` if one of them cannot be copied."""
        modules = modules_of_user(kind)
        places = [place for module in modules for place in _places_in(module)]
        try:
            return cls(places, pickle.dumps([_values_in(place) for place in places]))
        except Exception:  # noqa: BLE001 - anything that cannot be pickled cannot be copied
            return None

    def is_current(self, kind: type) -> bool:
        """Return True if all variables have the copied values."""
        now = SharedVariables.of(kind)
        return now is not None and now.data == self.data

    def changed(self) -> list[str]:
        """Return the names of the variables that have other values now."""
        names = []
        for place, before in zip(self.places, pickle.loads(self.data), strict=True):
            if isinstance(place, types.FunctionType):
                continue
            owner = f"{place.__name__}." if isinstance(place, type) else ""
            now = _values_in(place)
            names += [
                f"{owner}{name}"
                for name in before.keys() | now.keys()
                if _pickled_if_it_can_be(before.get(name)) != _pickled_if_it_can_be(now.get(name))
            ]
        return names

    def restore(self, kind: type) -> bool:
        """Set all variables back; return False if that is not possible."""
        now = SharedVariables.of(kind)
        # A module or a function that runs have added is not in the copy.
        if now is None or now.places != self.places:
            return False
        try:
            for place, values in zip(self.places, pickle.loads(self.data), strict=True):
                _set_values(place, values)
        except Exception:  # noqa: BLE001 - a class may refuse; its file is then loaded again
            return False
        return True


def _places_in(module: types.ModuleType) -> list[Any]:
    """Return a module, and the classes and functions that it defines, also those in classes."""
    found: list[Any] = [module]
    for place in found:
        for thing in [*vars(place).values()] if not isinstance(place, types.FunctionType) else ():
            function = getattr(thing, "__func__", thing)
            is_own = getattr(function, "__module__", None) == module.__name__
            is_new = not any(function is one for one in found)
            if is_own and is_new and isinstance(function, type | types.FunctionType):
                found.append(function)
    return found


def _values_in(place: Any) -> Any:
    if isinstance(place, types.FunctionType):
        return place.__defaults__, place.__kwdefaults__, place.__dict__, _around(place)
    return _data(vars(place))


def _set_values(place: Any, values: Any) -> None:
    if isinstance(place, types.FunctionType):
        place.__defaults__, place.__kwdefaults__, attributes, around = values
        place.__dict__.clear()
        place.__dict__.update(attributes)
        for number, value in around.items():
            (place.__closure__ or ())[int(number)].cell_contents = value
        return
    for name in _data(vars(place)).keys() - values.keys():
        delattr(place, name)
    for name, value in values.items():
        setattr(place, name, value)
        # Its answers may come from variables that have just been set back.
        if isinstance(value, _Cached):
            value.cache_clear()


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


def modules_of_user(kind: type) -> list[types.ModuleType]:
    """Return the modules of a class and its bases that are a user's, and the files next to them."""
    bases = [base for base in kind.__mro__ if _is_of_a_user(base)]
    return [*dict.fromkeys(module for base in bases for module in _modules_of(base))]


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
        and (
            # A generator's method, such as ``random.Random().gauss``, has the generator's state.
            isinstance(getattr(value, "__self__", None), random.Random)
            or not isinstance(
                value, (*code, types.GetSetDescriptorType, types.MemberDescriptorType)
            )
        )
    }
