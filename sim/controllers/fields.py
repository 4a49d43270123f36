"""A class's own fields as options in its name: ``./mine.py:Robot+lookahead=0.4``."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sim.controllers.instances import InstanceOrigin, origin_of
from sim.controllers.learning import LEARNED
from sim.options.run import WORDS_OF_A_RUN
from worldgen.errors import InvalidParameter
from worldgen.parameters import Parameter, initial_values, parameters_of_class
from worldgen.parameters.known_names import unknown_name

# What a run, a page or a table reads from a controller, so a user's number cannot have such a name.
_OF_THE_CONTRACT = frozenset(
    {
        "about",
        "arbitration",
        "learning",
        "made_of",
        "memory_fields",
        "memory_map",
        "memory_map_on",
        "name",
        "needs",
        "senses",
        "variants",
    }
)

OF_A_WORLD = frozenset({"robot_radius", "robot_speed", "robot_target_radius"})
"""Quantities of a world that a campaign varies or fixes, so a field cannot have such a name."""

_TAKEN = _OF_THE_CONTRACT | OF_A_WORLD | WORDS_OF_A_RUN | {LEARNED}


def fields_of(kind: type) -> tuple[Parameter, ...]:
    """Return the fields of a controller's class that its name may set.

    Declarations of the contract are not among them, and neither are names of options of a run, or
    of quantities of a world.
    """
    return tuple(one for one in parameters_of_class(kind) if one.name not in _TAKEN)


def hidden_fields(kind: type) -> tuple[Parameter, ...]:
    """Return the fields that no name can set, because an option of a run is called the same."""
    return tuple(one for one in parameters_of_class(kind) if one.name in WORDS_OF_A_RUN)


def describe_fields(fields: tuple[Parameter, ...]) -> str:
    """Return the fields with types and defaults: ``lookahead: float = 0.4, turns: int = 3``."""
    return ", ".join(f"{one.name}: {one.kind.__name__} = {one.default!r}" for one in fields)


def unknown_field(controller: str, kind: type | None, name: str) -> InvalidParameter:
    """Return the error for an option that is neither a field of a class nor an option of a run.

    Args:
        controller: The controller's name without options.
        kind: Its class; ``None`` if it is a library, or anything else that has no fields.
        name: The option.
    """
    if kind is not None and name in _OF_THE_CONTRACT:
        return InvalidParameter(
            "option-reserved",
            "{name} of {controller} belongs to the contract of controllers, so no name can set it",
            "change it in the class",
            controller=controller,
            name=name,
        )
    if kind is not None and name in OF_A_WORLD:
        return InvalidParameter(
            "option-reserved",
            "{name} is a quantity of the world, so no field of {controller} can be set by that name",
            "rename the field",
            controller=controller,
            name=name,
        )
    value = _value_of(kind, name)
    if not isinstance(value, bool | int | float | str) and value is not inspect.Parameter.empty:
        return InvalidParameter(
            "option-reserved",
            "{name} of {controller} is a {kind}, and only an int, float, bool or str can be set",
            "change it in the class, or make it one of these",
            controller=controller,
            name=name,
            kind=type(value).__name__,
        )
    fields = () if kind is None else fields_of(kind)
    known = [*(one.name for one in fields), *sorted(WORDS_OF_A_RUN)]
    remedy = "its fields are {fields}"
    if kind is None:
        remedy = "only a Python class has fields"
    elif not fields:
        remedy = "a field is a public attribute that is an int, float, bool or str, and it has none"
    return InvalidParameter.of(
        unknown_name(
            "{controller} has no field {name!r}, and a run has no such option",
            name,
            known,
            remedy,
            controller=controller,
            fields=describe_fields(fields),
        )
    )


def _value_of(kind: type | None, name: str) -> Any:
    """Return what a class has under a name that isn't a method; ``empty`` if it has nothing."""
    empty = inspect.Parameter.empty
    if kind is None or name.startswith("_"):
        return empty
    value = initial_values(kind).get(name, inspect.getattr_static(kind, name, empty))
    is_code = callable(value) or hasattr(type(value), "__get__")
    return empty if is_code else value


def parse_field(field: Parameter, text: str | None, controller: str) -> Any:
    """Return the value of a field as a name writes it; nothing after ``=`` is an empty word.

    Raises:
        InvalidParameter: If the text is not a value of the field's type.
    """
    if text == "" and field.kind is str and not field.choices:
        return ""
    return field.parse(text, controller)


def with_fields(given: Any, kind: type, words: Mapping[str, str | None], base: str) -> Any:
    """Return another instance of a controller's class, with fields as the command line sets them.

    Args:
        given: The instance without them.
        kind: Its class.
        words: The fields' values as text.
        base: The controller's name without them.

    Raises:
        InvalidParameter: If a field does not exist, a value has the wrong type, or the class
            refuses it.
    """
    fields = {one.name: one for one in fields_of(kind)}
    for name in words:
        if name not in fields:
            raise unknown_field(base, kind, name)
    values = {name: parse_field(fields[name], text, base) for name, text in words.items()}
    origin = origin_of(given) or InstanceOrigin(f"controller {base!r}", kind)
    made = replace(
        origin,
        make=functools.partial(_made, kind, values),
        own=None,
        varying=set(),
        fields=", ".join(f"{name}={value}" for name, value in values.items()),
    )
    instance = made.another()
    for name, value in values.items():
        now = getattr(instance, name, value)
        if name not in initial_values(kind) and now != value:
            raise InvalidParameter(
                "field-overwritten",
                "__init__ of {controller} sets {name} to {now!r}, so {name}={value} has no effect",
                "make it a parameter of __init__: def __init__(self, {name}={now!r})",
                controller=base,
                name=name,
                value=value,
                now=now,
            )
    return instance


def _made(kind: type, values: Mapping[str, Any]) -> Any:
    """Return an instance with these values.

    An attribute of the class becomes one of the instance before ``__init__`` runs, so that what
    ``__init__`` computes from it is right. The class itself stays as it is for other runs.
    """
    initial = initial_values(kind)
    given = {name: value for name, value in values.items() if name in initial}
    if len(given) == len(values):
        return kind(**given)
    new: Any = kind.__new__
    made = new(kind, **given)
    for name, value in values.items():
        if name not in initial:
            # A frozen dataclass refuses the usual way of setting an attribute.
            object.__setattr__(made, name, value)
    made.__init__(**given)
    return made
