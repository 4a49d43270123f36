"""Compose behaviours into a controller.

If all of them are the library's, the arbiter runs in C with them, at the speed of any compiled
controller. A behaviour in Python makes the composition a controller in Python; the arbiter is the
same C code, which then calls Python.

All memory is declared: the arbiter's and each part's. So loops can be proved.

Sources: Rodney A. Brooks, "A robust layered control system for a mobile robot", IEEE Journal of
    Robotics and Automation 2 (1986), for priorities; Julio K. Rosenblatt, "DAMN: a distributed
    architecture for mobile navigation", Journal of Experimental & Theoretical Artificial
    Intelligence 9 (1997), for votes; Pattie Maes and Rodney A. Brooks, "Learning to coordinate
    behaviors", AAAI (1990), for an arbiter that learns.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from sim._core import lib
from sim.controllers.base import CompiledController, Controller, Memory, Observation
from sim.controllers.behaviours.arbitration import Arbitration, PartFacts, in_words
from sim.controllers.behaviours.base import Behaviour, Layer
from sim.controllers.behaviours.catalogue import ARBITERS, PREFIX, read_composition
from sim.controllers.behaviours.library import HANDS, IDLE, TURN_WORDS, TURNS
from sim.controllers.behaviours.with_python import ComposedController
from sim.controllers.core_act import CoreAct, memory_at_reset, size_of
from sim.controllers.learning import Learning
from sim.controllers.memory_view import MemoryField
from sim.kernels.layout import place
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Floats, Ints

MOST_PARTS = int(lib.WG_MOST_PARTS)
# The memory begins with the arbiter's, a WgShared.
ACTED = place("WgComposition", "acted")
ARBITER = place("WgComposition", "arbiter")
COUNT = place("WgComposition", "count")
_WORDS: dict[str, dict[str, float]] = {"turn": TURNS, "hand": HANDS}

# The thesis's robots as compositions: their parts.
_THESIS_PARTS = ("collide", "seek", "drive")


def composition_named(name: str) -> Controller:
    """Return the controller with a name such as ``behaviours:avoid,follow,wander``.

    Raises:
        InvalidParameter: If it lists nothing, or a name or an option is unknown.
    """
    parts, arbiter = read_composition(name)
    return composed(parts, arbiter, name=name)


def composed(
    parts: Iterable[Layer | Behaviour], arbiter: str = ARBITERS[0], *, name: str = PREFIX
) -> CompiledController | ComposedController:
    """Return the controller that is composed of some parts.

    Args:
        parts: The parts, the highest priority first unless they specify otherwise.
        arbiter: ``priority``, ``vote``, or ``learning``.
        name: Name in messages and files.

    Raises:
        InvalidParameter: If there are no parts, or more than 16, or no such arbiter exists.
    """
    listed = tuple(part if isinstance(part, Layer) else Layer(part) for part in parts)
    if not 1 <= len(listed) <= MOST_PARTS:
        raise InvalidParameter(
            "out-of-range",
            "a composition has {count} parts",
            "list 1 to {most} behaviours",
            count=len(listed),
            most=MOST_PARTS,
        )
    if arbiter not in ARBITERS:
        raise InvalidParameter(
            "unknown-name",
            "no arbiter is called {arbiter!r}",
            "use {known!l}",
            arbiter=arbiter,
            known=list(ARBITERS),
        )
    priorities = [
        float(len(listed) - place) if part.priority is None else float(part.priority)
        for place, part in enumerate(listed)
    ]
    others = tuple(part.behaviour for part in listed if part.behaviour.kind < 0)
    declared: dict[str, Any] = {
        "senses": _senses(listed, arbiter),
        "needs": _needs(listed),
        "memory_fields": (MemoryField("steps left", place("WgComposition", "shared", "counter")),),
        "arbitration": _arbitration(listed, priorities, arbiter),
    }
    memory = _memory(listed, priorities, arbiter)
    if others:
        return ComposedController(name, memory, others, **declared)
    return CompiledController(
        name,
        CoreAct("composition"),
        memory,
        start_speed=np.inf if _is_the_thesis(listed, arbiter) else 0.0,
        thesis_rule=_thesis_rule(listed, priorities, arbiter),
        randomised=any(_is_random(part) for part in listed),
        learning=_learning(len(listed)) if arbiter == "learning" else None,
        **declared,
    )


def _is_random(part: Layer) -> bool:
    return part.behaviour.randomised or part.options.get("turn") == "random"


def _is_the_thesis(parts: Sequence[Layer], arbiter: str) -> bool:
    """Return True if the parts are the thesis's three, whatever their options."""
    names = sorted(part.behaviour.name for part in parts)
    return names == sorted(_THESIS_PARTS) and arbiter == ARBITERS[0]


def _thesis_rule(parts: Sequence[Layer], priorities: Sequence[float], arbiter: str) -> int:
    """Return the thesis's rule if the composition is one of its robots, else 0.

    The motion model ``stepped`` then runs the thesis's own program.
    """
    if not _is_the_thesis(parts, arbiter):
        return 0
    order = [parts[k].behaviour.name for k in np.argsort(priorities, kind="stable")]
    changed = any(
        part.steps != part.behaviour.duration
        or part.can_be_interrupted != part.behaviour.interruptible
        for part in parts
    )
    if changed or order != list(_THESIS_PARTS):
        return 0
    (collide,) = (part for part in parts if part.behaviour.name == _THESIS_PARTS[0])
    return int(TURNS[collide.options.get("turn", "right")])


def _numbers(part: Layer) -> list[float]:
    """Return the values of a part's options as the core reads them."""
    kind = part.behaviour.options
    if kind is None:
        return []
    values = kind(**part.options)
    found = []
    for one in dataclasses.fields(values):
        value = getattr(values, one.name)
        found.append(float(_WORDS[one.name][value] if one.name in _WORDS else value))
    return found


def _state_size(behaviour: Behaviour) -> int:
    if behaviour.kind < 0:
        return len(behaviour.memory)
    return int(lib.wg_behaviour_at(behaviour.kind).state_size)


def _learning(count: int) -> Learning:
    """Return where a composition of this many parts keeps what its arbiter has learned."""
    first = size_of("WgComposition") + count * size_of("WgStoredPart") + size_of("WgLearning")
    conditions = int(lib.WG_CONDITIONS) * (1 + count)
    return Learning(first, conditions * size_of("WgFeedback"), whole=True)


def _memory(parts: Sequence[Layer], priorities: Sequence[float], arbiter: str) -> Memory:
    """Return the memory at reset: see ``WgComposition``."""
    counts = {ARBITER: ARBITERS.index(arbiter), COUNT: len(parts)}
    memory = [*memory_at_reset(size_of("WgComposition"), {**IDLE, ACTED: -1.0, **counts})]

    # Add the parts, each with its options padded to the same size.
    own = 0
    for part, priority in zip(parts, priorities, strict=True):
        kind = part.behaviour.kind
        if kind < 0:
            own += 1
            kind = -own
        options = _numbers(part)
        memory += [float(kind), priority, float(part.steps), float(part.can_be_interrupted)]
        memory += options + [0.0] * (int(lib.WG_PART_OPTIONS) - len(options))

    # Add the numbers that some arbiters keep, then the parts' own states.
    if arbiter == "vote":
        memory += [0.0] * len(parts)
    if arbiter == "learning":
        learned = _learning(len(parts))
        memory += [0.0] * (learned.places.stop - len(memory))
    for part in parts:
        behaviour = part.behaviour
        memory += behaviour.memory if behaviour.kind < 0 else [0.0] * _state_size(behaviour)
    return tuple(float(number) for number in memory)


def _senses(parts: Sequence[Layer], arbiter: str) -> tuple[str, ...]:
    """Return all senses that any part reads, in the order of an observation."""
    read = {sense for part in parts for sense in part.behaviour.senses}
    if not any(_is_random(part) or part.behaviour.kind < 0 for part in parts):
        read.discard("random")
    if arbiter == "learning":
        read |= {"bump", "signal"}
    return tuple(name for name in Observation._fields if name in read)


def _needs(parts: Sequence[Layer]) -> RobotOptions:
    """Return the options of the robot that the parts need; if two differ, the first counts."""
    changed: dict[str, Any] = {}
    for part in reversed(parts):
        changed |= part.behaviour.needs.changed()
    return RobotOptions.of(changed)


def _acted(memories: Floats) -> Ints:
    """Return the part that acted in each step; see :class:`Arbitration`."""
    return memories[1:, ACTED].astype(np.int64)


def _arbitration(parts: Sequence[Layer], priorities: Sequence[float], arbiter: str) -> Arbitration:
    facts = tuple(
        PartFacts(
            part.behaviour.name,
            _in_numbers(part.behaviour.applies or "its trigger applies", part),
            _in_numbers(part.behaviour.does or "its action", part),
            priority,
            part.steps,
            part.can_be_interrupted,
        )
        for part, priority in zip(parts, priorities, strict=True)
    )
    return Arbitration(facts, arbiter, _acted)


def _in_numbers(sentence: str, part: Layer) -> str:
    """Replace the options that a sentence names in backquotes by a part's numbers."""
    values: dict[str, Any] = {"duration": int(part.steps) if np.isfinite(part.steps) else "all"}
    if part.behaviour.options is not None:
        values |= dataclasses.asdict(part.behaviour.options(**part.options))
    if "turn" in values:
        values["turn"] = TURN_WORDS[values["turn"]]
    words = {
        name: value if isinstance(value, str) else f"{value:g}" for name, value in values.items()
    }
    return in_words(sentence, words)
