"""Make a controller start with what it, or another run of it, has learned."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from sim.controllers.base import (
    DEFAULT_SENSES,
    CompiledController,
    Controller,
    VectorController,
    wants_world,
)
from sim.controllers.learning import Learning
from worldgen.errors import InvalidParameter
from worldgen.plugins.registry import user_code


def learning_of(controller: Controller, name: str) -> Learning:
    """Return what a controller learns.

    Raises:
        InvalidParameter: If it learns nothing, or its declaration does not fit its memory.
    """
    learning: Any = getattr(controller, "learning", None)
    if learning is None:
        raise InvalidParameter(
            "does-not-learn",
            "controller {name!r} does not learn",
            "use q-learner, or behaviours+by=learning:avoid,follow,approach",
            name=name,
        )
    size = len(memory_at_reset(controller, name))
    fits = isinstance(learning, Learning) and learning.first >= 0 and learning.count >= 1
    if not fits or max(learning.first + learning.count, learning.explore + 1) > size:
        raise InvalidParameter(
            "wrong-declaration",
            "controller {name!r} has learning={learning!r} and {size} numbers of memory",
            "declare Learning(first, count) within its memory",
            name=name,
            learning=learning,
            size=size,
        )
    return learning  # type: ignore[no-any-return]


def memory_at_reset(controller: Controller, name: str) -> tuple[float, ...]:
    """Return the memory with which a controller starts.

    Raises:
        InvalidParameter: If its ``reset`` fails, or needs a world: a learner starts the same
            everywhere.
    """
    if isinstance(controller, CompiledController):
        return tuple(controller.memory)
    if wants_world(controller):
        raise InvalidParameter(
            "does-not-learn",
            "controller {name!r} plans with the world first, so it cannot start from learned "
            "numbers",
            "write reset(self) without a world",
            name=name,
        )
    with user_code(f"controller {name!r}: reset()"):
        return tuple(map(float, controller.reset()))


def restarted(
    controller: Controller, memory: tuple[float, ...], name: str, *, draws: bool = False
) -> Controller:
    """Return a controller that starts with another memory.

    Args:
        controller: The controller.
        memory: The memory at the start of each run.
        name: Its name from now on.
        draws: Whether it reads random numbers, too.
    """
    senses = getattr(controller, "senses", DEFAULT_SENSES)
    if draws:
        senses = tuple(dict.fromkeys((*senses, "random")))
    if isinstance(controller, CompiledController):
        randomised = controller.randomised or draws
        return replace(controller, name=name, memory=memory, senses=senses, randomised=randomised)
    kind = _TaughtMany if isinstance(controller, VectorController) else _Taught
    return kind(controller, memory, name, senses)


@dataclass(frozen=True)
class _TaughtClass:
    """A controller in Python that starts with another memory, and is otherwise unchanged."""

    controller: Any
    memory: tuple[float, ...]
    name: str
    senses: tuple[str, ...]

    @property
    def made_of(self) -> tuple[object, ...]:
        """The object whose class may keep state outside the memory."""
        return (self.controller,)

    def reset(self) -> tuple[float, ...]:
        """Return the memory at the start of an episode."""
        return self.memory

    def __getattr__(self, name: str) -> Any:
        # What it declares: needs, memory_map and so on. A copy being made has no fields yet.
        if name.startswith("_") or name == "controller":
            raise AttributeError(name)
        return getattr(self.controller, name)


class _Taught(_TaughtClass):
    def act(self, observation: Any, memory: Any) -> Any:
        return self.controller.act(observation, memory)


class _TaughtMany(_TaughtClass):
    def act_many(self, observation: Any, memory: Any) -> Any:
        return self.controller.act_many(observation, memory)


def with_numbers(controller: Controller, numbers: tuple[float, ...], name: str) -> Controller:
    """Return a controller that starts with learned numbers.

    Args:
        controller: One that learns.
        numbers: The learned numbers.
        name: Its name from now on.

    Raises:
        InvalidParameter: If it does not learn, or has a different number of learned values, or a
            number cannot be in its memory.
    """
    learning = learning_of(controller, name)
    if len(numbers) != learning.count:
        raise InvalidParameter(
            "wrong-size",
            "{name} has {came} numbers, but the controller expects {count}",
            "train it again with this version",
            name=name,
            came=len(numbers),
            count=learning.count,
        )
    if learning.whole and any(number < 0.0 or number != math.floor(number) for number in numbers):
        raise InvalidParameter(
            "out-of-range",
            "{name} has numbers that are not whole, or below 0",
            "train it again",
            name=name,
        )
    memory = list(memory_at_reset(controller, name))
    memory[learning.places] = numbers
    return restarted(controller, tuple(memory), name)


def with_exploration(controller: Controller, thousandths: int, name: str) -> Controller:
    """Return a controller that makes this share of its decisions at random, in thousandths."""
    learning = learning_of(controller, name)
    if learning.explore < 0 or thousandths == 0:
        return controller
    memory = list(memory_at_reset(controller, name))
    memory[learning.explore] = float(thousandths)
    return restarted(controller, tuple(memory), name, draws=True)
