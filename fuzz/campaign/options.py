"""What a user says of a campaign: each option is declared once, here.

``worldgen fuzz`` takes them as options, the studio's page as fields, and :class:`CampaignConfig` is
what they come to. This module imports nothing heavy, for the help of the command is made from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from worldgen.parameters import Bounds, Parameter, Written, parameters_of_fields

__all__ = ["CampaignOptions", "SearchOptions"]


@dataclass(frozen=True, kw_only=True)
class SearchOptions:
    """Options that a campaign keeps as they are given.

    Args:
        oracles: Ask this oracle about each run: detour, repeat, turn, shift, scale, mirror, finer,
            wall, block, or ./file.py:name; may be repeated.
        examples: Draws a unit.
        epoch: Units that learn from the same earlier ones; at most twice as many are under way at a
            time.
        database: A Hypothesis database, such as .hypothesis/examples: what failed before is tried
            first, what fails is kept.
    """

    oracles: Annotated[tuple[str, ...], Written("--oracle", "NAME[=NUMBER]")] = ()
    examples: Annotated[int, Bounds(1, 100_000)] = 400
    epoch: Annotated[int, Bounds(1, 100_000)] = 16
    database: Annotated[str, Written(metavar="DIR", path="folder")] = ""


@dataclass(frozen=True, kw_only=True)
class CampaignOptions(SearchOptions):
    """Options that say what a campaign is, not how far it goes.

    Args:
        controller: Whom to test; ``+option=value`` varies the run.
        motion: Motion model.
        families: Draw worlds from this family; may be repeated.
        strategies: Search with this strategy only: native, archive, boundary, features, sealed, or
            a family; may be repeated.
        world: Keep this map; vary start, target and radius.
        vary: Draw robot_radius, robot_speed, time_step or an option of the motion model from these
            values, the simplest first; may be repeated.
        time_step: Duration of a step, s [default: the motion model's].
        detour: Arriving by a longer way than RATIO times the witness's is a failure too; the same
            as --oracle detour=RATIO.
        shrink: Shrink failures [default: yes, but not with --world].

    Raises:
        InvalidParameter: If a value is out of range or of the wrong type.
    """

    controller: str = ""
    motion: str = "swept"
    families: Annotated[tuple[str, ...], Written("--family")] = ()
    strategies: Annotated[tuple[str, ...], Written("--strategy", also="--lane")] = ()
    world: Annotated[Path | None, Written(path="file")] = None
    vary: Annotated[tuple[str, ...], Written(metavar="NAME=VALUE,...")] = ()
    time_step: float | None = None
    detour: Annotated[float | None, Bounds(1.0), Written(metavar="RATIO")] = None
    shrink: bool | None = None

    def __post_init__(self) -> None:
        for option in self.declared():
            object.__setattr__(
                self, option.name, option.accept(getattr(self, option.name), "campaign")
            )

    @classmethod
    def declared(cls) -> tuple[Parameter, ...]:
        """Return the options: first what is looked for, then how."""
        fields: Any = cls  # a type checker takes no dataclass's type for hashable
        found = parameters_of_fields(fields)
        kept = {option.name for option in parameters_of_fields(SearchOptions)}
        return tuple(sorted(found, key=lambda option: option.name in kept))

    @classmethod
    def named(cls, name: str) -> Parameter:
        """Return one of the options."""
        return next(option for option in cls.declared() if option.name == name)

    @property
    def asked_oracles(self) -> tuple[str, ...]:
        """All oracles, the one that ``--detour`` means among them."""
        if self.detour is None:
            return self.oracles
        return (f"detour={self.detour!r}".removesuffix(".0"), *self.oracles)
