"""A controller's own options, which are part of its name: ``topological+places=16``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from worldgen.parameters import parameters_of_fields, parse_options

if TYPE_CHECKING:
    from sim.controllers.base import CompiledController


class Variants(NamedTuple):
    """The options that a controller has, and how to make one with them.

    Args:
        options: A dataclass of options that declares bounds, defaults and help.
        make: Returns the controller with such options, under a name.
    """

    options: type
    make: Callable[[Any, str], CompiledController]

    def names(self) -> tuple[str, ...]:
        """Return the names of the options."""
        return tuple(one.name for one in parameters_of_fields(self.options))

    def named(self, words: Mapping[str, str | None], base: str, name: str) -> CompiledController:
        """Return the controller with options as the command line writes them.

        Args:
            words: The options' values as text.
            base: Name of the controller without them, for messages.
            name: Its name with them.

        Raises:
            InvalidParameter: If an option is unknown, or its value out of range.
        """
        values = parse_options(words, parameters_of_fields(self.options), f"controller {base}")
        return self.make(self.options(**values), name)
