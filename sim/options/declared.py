"""Dataclasses of declared options.

They are checked when created, stored if they differ from their defaults, and parsed from text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from worldgen.parameters import Parameter, find_parameter, parameters_of_fields
from worldgen.world import Value


@dataclass(frozen=True)
class OptionSet:
    """Base of option sets: dataclasses whose fields declare bounds, choices, heading and help.

    A field is ``slip: Annotated[float, Bounds(0, 1), Group("Forces")] = 0.0``, and its help is its
    entry in the docstring's ``Args``. Nothing else is needed for a new option.
    """

    OWNER: ClassVar[str] = "options"
    """Name of the set in messages."""
    TOGETHER: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Names that switch on several options."""

    def __post_init__(self) -> None:
        for parameter in self.declared():
            value = parameter.accept(getattr(self, parameter.name), self.OWNER)
            object.__setattr__(self, parameter.name, value)

    def changed(self) -> dict[str, Value]:
        """Return the options that differ from their defaults, in order of declaration."""
        return {
            one.name: list(value) if isinstance(value, tuple) else value
            for one in self.declared()
            if (value := getattr(self, one.name)) != one.default
        }

    @classmethod
    def declared(cls) -> tuple[Parameter, ...]:
        """Return the options, in order of declaration."""
        # Type checkers do not consider the type of a dataclass hashable.
        fields: Any = cls
        found: tuple[Parameter, ...] = parameters_of_fields(fields)
        return found

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the options' names."""
        return tuple(one.name for one in cls.declared())

    @classmethod
    def words(cls) -> frozenset[str]:
        """Return the options' names, and the names that switch on several."""
        return frozenset((*cls.names(), *cls.TOGETHER))

    @classmethod
    def of(cls, values: Mapping[str, Value]) -> Self:
        """Return options from names and values.

        Raises:
            InvalidParameter: If a name is unknown, or a value has the wrong type or is out of
                range.
        """
        found = {name: find_parameter(name, cls.declared(), cls.OWNER).name for name in values}
        return cls(**{found[name]: value for name, value in values.items()})

    @classmethod
    def parse(
        cls, name: str, text: str | None, also: tuple[str, ...] = (), owner: str = ""
    ) -> dict[str, Value]:
        """Return the values of one option as written on the command line.

        Args:
            name: Name of the option, or of several that are switched on together.
            text: Its value; ``None`` for a switch.
            also: Options of the controller's own, to suggest as well.
            owner: What has the options, if it isn't the robot or the thesis's simulator.

        Raises:
            InvalidParameter: If the option is unknown, or the text is not a valid value.
        """
        if name in cls.TOGETHER and text in (None, "true"):
            return dict.fromkeys(cls.TOGETHER[name], True)
        others = (*also, "motion", "time_step", *cls.TOGETHER)
        found = find_parameter(name, cls.declared(), owner or cls.OWNER, also=others)
        return {found.name: found.parse(text, cls.OWNER)}
