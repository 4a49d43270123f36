"""Remember how a controller was made, so that another one can take its place."""

from __future__ import annotations

import inspect
import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from sim.controllers.answers import Answers
from sim.controllers.hidden_state import SharedVariables
from worldgen.errors import InvalidParameter
from worldgen.parameters import initial_values
from worldgen.plugins.registry import user_code


@dataclass
class InstanceOrigin:
    """Where an instance comes from, and the state in which its first run began.

    Args:
        name: Name of the controller or behaviour, with its noun, for messages.
        make: Its class, or another function that makes it without arguments.
        own: Its attributes when its first run began, as bytes to compare.
        shared: The variables of its classes and modules at the same time; ``None`` if unknown.
        varying: Attributes that differ in each new instance, so they say nothing about runs.
        loaded: The variables of its classes and modules before the first instance was made;
            ``None`` if they cannot be copied.
        changed: The variables of its classes and modules that runs have changed; ``None`` as long
            as nobody needs to know.
        fields: The fields that its name sets, such as ``lookahead=0.2``.
        answers: What its instances have answered so far.
    """

    name: str
    make: Callable[[], Any]
    own: Mapping[str, bytes] | None = None
    shared: bytes | None = None
    varying: set[str] = field(default_factory=set)
    loaded: SharedVariables | None = None
    changed: list[str] | None = None
    fields: str = ""
    answers: Answers = field(default_factory=Answers)

    def another(self) -> Any:
        """Return another instance."""
        how = f"with {self.fields}" if self.fields else "without arguments"
        with user_code(f"{self.name}: making it {how}"):
            made = self.make()
        remember(made, self)
        return made


_ORIGINS: dict[int, tuple[weakref.ref[Any], InstanceOrigin]] = {}


def instance_of(kind: type, name: str) -> Any:
    """Return an instance of a class, and remember where it comes from.

    Raises:
        InvalidParameter: If its ``__init__`` needs arguments, or making it raises an exception.
    """
    empty = inspect.Parameter.empty
    needed = [one for one, default in initial_values(kind).items() if default is empty]
    if needed:
        raise InvalidParameter(
            "code-failed",
            "{name}: __init__ of {kind} needs {needed!l}, and it is called without arguments",
            "give each a default, which the name can then replace: +{first}=VALUE",
            name=name,
            kind=kind.__name__,
            needed=needed,
            first=needed[0],
        )
    return InstanceOrigin(name, kind, loaded=SharedVariables.of(kind)).another()


def origin_of(controller: object) -> InstanceOrigin | None:
    """Return where an instance comes from; ``None`` if the user made it."""
    found = _ORIGINS.get(id(controller))
    return found[1] if found is not None and found[0]() is controller else None


def remember(made: object, origin: InstanceOrigin) -> None:
    """Remember how an object was made, as long as it exists."""
    number = id(made)
    try:
        alive = weakref.ref(made, lambda _: _ORIGINS.pop(number, None))
    except TypeError:  # a class with __slots__ may not allow weak references
        return
    _ORIGINS[number] = (alive, origin)
