"""The options of a campaign, each declared once.

``worldgen fuzz`` offers them as options and the studio as fields of a form. Together they make a
:class:`CampaignConfig`. This module imports nothing heavy, because the command's help needs it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from worldgen.parameters import Parameter, Written, parameters_of_fields
from worldgen.parameters.bounds import Bounds
from worldgen.robot_overrides import RobotOverrides

MOST_ROBOTS = 100
"""Limit on the robots in a campaign's worlds; proving that more can arrive takes a long time."""

BASELINE_HELP = (
    "Known failures. Their causes are counted, but not shrunk or written, and do not affect the "
    "exit code. May be repeated."
)


@dataclass(frozen=True, kw_only=True)
class SearchOptions:
    """Options that a campaign keeps unchanged.

    Args:
        oracles: Check each run with this oracle: detour, repeat, turn, shift, scale, mirror, finer,
            wall or block; may be repeated.
        examples: Number of worlds that each unit of work tries; up to 80 times as many for compiled
            controllers.
        epoch: Number of units in a round. Each round learns from the rounds before it; at most two
            rounds run at a time.
    """

    oracles: Annotated[tuple[str, ...], Written("--oracle", "NAME[=NUMBER]")] = ()
    examples: Annotated[int, Bounds(1, 100_000)] = 400
    epoch: Annotated[int, Bounds(1, 100_000)] = 16


@dataclass(frozen=True, kw_only=True)
class CampaignOptions(SearchOptions, RobotOverrides):
    """Options that define a campaign, but not how long it runs.

    Those of the robot's body, drive and goal hold in all of its worlds.

    Args:
        controller: Controller to test; ``+option=value`` changes an option of the run.
        motion: Motion model: swept, endpoint or stepped.
        task: Reach the target, or cover every cell whose centre the robot can reach.
        families: Generate worlds with this family only; may be repeated.
        strategies: Search with this strategy only: native, archive, small, boundary, features,
            sealed, or a family; may be repeated. docs/explanation/search.md describes them.
        world: Search on this map: with other starts, targets and radii, in windows around its narrow
            places, and with doors closed, boxes, people and moved pieces of the walls.
        vary: Choose robot_radius, robot_speed, time_step, an option of the robot or of the motion
            model, or a field of your class at random from these values; list the simplest first.
            May be repeated.
        time_step: Duration of a step, s.  [default: the motion model's]
        shrink: Shrink failures.  [default: yes, but not with --world]
        pace: Milliseconds that a step of the controller takes, which sizes the units of work. With
            --budget it is measured, with --units it is the usual one of a controller's kind, so
            that the result depends only on the seed.
        robots: Number of robots in each world. Several robots are all driven by the same
            controller; the search then looks for deadlocks, livelocks and collisions.  [default: 1,
            or as many as --world has]

    Raises:
        InvalidParameter: If a value is out of range or of the wrong type.
    """

    controller: str = ""
    motion: str = "swept"
    task: Literal["target", "cover"] = "target"
    families: Annotated[tuple[str, ...], Written("--family")] = ()
    strategies: Annotated[tuple[str, ...], Written("--strategy")] = ()
    world: Annotated[Path | None, Written(path="file")] = None
    vary: Annotated[tuple[str, ...], Written(metavar="NAME=VALUE,...")] = ()
    time_step: float | None = None
    shrink: bool | None = None
    pace: Annotated[float | None, Bounds(1e-4, 100_000.0), Written(metavar="MS")] = None
    robots: Annotated[int | None, Bounds(1, MOST_ROBOTS)] = None

    def __post_init__(self) -> None:
        for option in self.declared():
            object.__setattr__(
                self, option.name, option.accept(getattr(self, option.name), "campaign")
            )

    @classmethod
    def declared(cls) -> tuple[Parameter, ...]:
        """Return the options: those that define the campaign, the robot's, then the others."""
        # Type checkers do not consider the type of a dataclass hashable.
        fields: Any = cls
        found = parameters_of_fields(fields)
        later = [
            {option.name for option in parameters_of_fields(kind)}
            for kind in (RobotOverrides, SearchOptions)
        ]
        return tuple(sorted(found, key=lambda option: [option.name in names for names in later]))

    @classmethod
    def named(cls, name: str) -> Parameter:
        """Return one of the options."""
        return next(option for option in cls.declared() if option.name == name)

    @property
    def robot(self) -> RobotOverrides:
        """The options of the robot's body, drive and goal."""
        return RobotOverrides.of(vars(self))
