"""Find a behaviour by name, and read a composition as the command line writes it.

``avoid+angle=2,follow+hand=right,wander`` lists parts, the highest priority first. An option of a
part follows its name. A part of your own is ``./mine.py:name``.
"""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any

from sim.controllers.base import DEFAULT_SENSES
from sim.controllers.behaviours.base import Behaviour, Layer
from sim.controllers.instances import instance_of, origin_of
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter
from worldgen.parameters import (
    Parameter,
    parameters_of_fields,
    parse_options,
    split_headed,
    split_options,
)
from worldgen.parameters.bounds import Bounds
from worldgen.plugins.registry import Registry, user_code

PREFIX = "behaviours"
ARBITERS = ("priority", "vote", "learning")
"""Ways to arbitrate in a composition; their indices are the values of ``WgComposition.arbiter``."""
_EXAMPLE = f"{PREFIX}:avoid,follow,wander or {PREFIX}+by=vote:avoid+priority=3,approach"
_FIELDS = ("duration", "interruptible", "restarts", "memory", "senses", "needs")


@dataclasses.dataclass(frozen=True)
class PartOptions:
    """Options that every part has.

    Args:
        priority: The part with the highest priority acts, among those that apply. 0: earlier parts
            in the list have higher priority. In a vote it is the part's weight.
        duration: Number of steps that it acts once it has control; 0: its own duration.
        interruptible: True if a part of higher priority can take over before it is done.
    """

    priority: Annotated[float, Bounds(0, 1_000_000)] = 0.0
    duration: Annotated[int, Bounds(0, 1_000_000, "steps")] = 0
    interruptible: bool = False


def is_composition_name(name: str) -> bool:
    """Return True if a controller's name lists behaviours."""
    return split_headed(name, PREFIX) is not None


def listed_names(name: str) -> list[str]:
    """Return the names of the behaviours that a controller's name lists, without their options."""
    listed = name.partition(":")[2]
    return [split_options(part, "avoid+angle=2")[0] for part in listed.split(",") if part.strip()]


def options_of(behaviour: Behaviour) -> tuple[Parameter, ...]:
    """Return the options that a part with this behaviour has."""
    own = () if behaviour.options is None else parameters_of_fields(behaviour.options)
    return (*own, *parameters_of_fields(PartOptions))


def _accept(name: str, thing: Any) -> Behaviour:
    if isinstance(thing, Behaviour):
        return thing
    # A class is instantiated without arguments; this and reading its attributes run the user's
    # code.
    if isinstance(thing, type):
        thing = instance_of(thing, f"behaviour {name!r}")
    with user_code(f"behaviour {name!r}: looking at its attributes"):
        missing = [one for one in ("trigger", "action") if not callable(getattr(thing, one, None))]
        known = {key: getattr(thing, key) for key in _FIELDS if hasattr(thing, key)}
        plain_name = getattr(thing, "name", type(thing).__name__)
    if missing:
        raise InvalidParameter(
            "not-a-behaviour",
            "behaviour {name!r} has no {missing}",
            "it must have trigger(observation, memory) and action(observation, memory) -> "
            "(command, memory), or be a Behaviour",
            name=name,
            missing=" and no ".join(missing),
        )
    # A class that declares no senses may read all senses that allow proofs, like a controller.
    known.setdefault("senses", DEFAULT_SENSES)
    known.setdefault("needs", RobotOptions())
    return Behaviour(str(plain_name), thing.trigger, thing.action, **known)


BEHAVIOURS: Registry[Behaviour] = Registry("worldgen.behaviours", "behaviour", _accept)


def read_composition(name: str) -> tuple[tuple[Layer, ...], str]:
    """Read the name of a controller that lists behaviours.

    Args:
        name: ``behaviours:avoid,follow,wander``, or with options of the whole composition before
            the colon.

    Returns:
        The parts, and how they arbitrate.

    Raises:
        InvalidParameter: If it lists nothing, or a name or an option is unknown.
    """
    head, _, listed = name.partition(":")
    _, words = split_options(head, _EXAMPLE)
    arbiter = words.pop("by", ARBITERS[0])
    if words or arbiter not in ARBITERS:
        raise InvalidParameter(
            "unknown-name",
            "a composition has no {what}",
            "+by={known!l} and options of the run go before the colon",
            what=f"option {next(iter(words))!r}" if words else f"arbiter {str(arbiter)!r}",
            known=list(ARBITERS),
        )
    return parts_of(listed), str(arbiter)


def parts_of(listed: str) -> tuple[Layer, ...]:
    """Read parts as the command line lists them.

    Args:
        listed: ``avoid+angle=2,follow,./mine.py:Mine+priority=5``.

    Raises:
        InvalidParameter: If the list is empty, or a name or an option is unknown.
    """
    texts = [text.strip() for text in listed.split(",")]
    if not all(texts):
        raise InvalidParameter(
            "empty-name",
            "{listed!q} contains an empty name",
            "write {example}",
            listed=listed,
            example=_EXAMPLE,
        )
    return tuple(map(_part, texts))


def _part(text: str) -> Layer:
    name, words = split_options(text, "avoid+angle=2")
    behaviour = BEHAVIOURS.get(name)
    # Runs may have left something in an instance, so each composition gets its own.
    origin = origin_of(getattr(behaviour.action, "__self__", None))
    if origin is not None:
        behaviour = _accept(name, origin.another())
    values = parse_options(words, options_of(behaviour), f"behaviour {name}")
    return Layer(
        behaviour,
        values.pop("priority", 0.0) or None,
        values.pop("duration", 0) or None,
        values.pop("interruptible", None),
        values,
    )
