"""The definition of a campaign."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from fuzz.layouts.variation import Variation
from fuzz.unit.constraint import Constraint
from fuzz.unit.options import SearchOptions
from fuzz.unit.pace import Pace, usual_pace
from sim.controllers import CONTROLLERS
from sim.options.run import COSTLY_BUDGET, USUAL_BUDGET, RunOptions
from sim.scenario import Scenario
from worldgen.world import Value, World

# Units of a round in a campaign for a slow controller.
_COSTLY_EPOCH = 2
# Shares of the radius of a map's robot: that of the robots that a campaign puts on the map.
_SHARES_ON_A_MAP = (1.0, 0.75, 0.5)


@dataclass(frozen=True)
class CampaignConfig(SearchOptions):
    """The definition of a campaign.

    Together with a unit's number and the search state, it determines the unit's result. The
    units of an epoch know the findings of earlier epochs, except the one just before. ``examples``,
    ``oracles`` and the other fields that are not listed here are described in
    :class:`SearchOptions`.

    Args:
        scenario: Controller, motion model and options; each draw has its own seed and time step.
        seed: Seed of the whole campaign.
        families: Families and other strategies to search with; empty for all that fit.
        time_steps: Durations of a step to draw from, s.
        vary: Quantities of the robot and options of the motion model to draw from; those of the
            robot's body, drive and goal that the user fixed have one value each.
        fixed_map: A map to search on: poses on it, windows of it, and variations of them.
        shrink: Whether to shrink failures; on a user's own map they are more useful unshrunk.
        robots: Number of robots in each world.
        fixes_time_step: Whether the user gave the time step, so that every failure must have it.
        measured: The controller's measured pace; ``None`` for the usual one of its kind.
    """

    scenario: Scenario
    seed: int = 0
    families: tuple[str, ...] = ()
    time_steps: tuple[float, ...] = (RunOptions.time_step,)
    vary: tuple[Variation, ...] = ()
    fixed_map: World | None = None
    shrink: bool = True
    robots: int = 1
    fixes_time_step: bool = False
    measured: Pace | None = None

    def __post_init__(self) -> None:
        is_slow = self.measured is not None and self.measured.is_slow
        budget = COSTLY_BUDGET if is_slow else USUAL_BUDGET
        if self.scenario.budget != budget:
            object.__setattr__(self, "scenario", replace(self.scenario, budget=budget))

    @property
    def units_of_a_round(self) -> int:
        """Number of units that know the same earlier ones; few if each of them proves failures.

        A unit of a slow controller spends most of its time on proofs, which the next units should
        not repeat.
        """
        return min(self.epoch, _COSTLY_EPOCH) if self.pace.is_slow else self.epoch

    @cached_property
    def pace(self) -> Pace:
        """The time that the controller takes: as measured, or as usual for its kind."""
        return self.measured or usual_pace(CONTROLLERS.get(self.scenario.controller))

    @cached_property
    def constraint(self) -> Constraint:
        """What every failure must keep: each option that was given, and each varied one's values.

        On a map, also the robots and the targets' radii that the map allows.
        """
        allowed: dict[str, tuple[Value, ...]] = {}
        if self.fixed_map is not None:
            robots = self.fixed_map.robots
            allowed["robot_radius"] = radii_on(self.fixed_map)
            allowed["robot_speed"] = tuple(robot.speed for robot in robots)
            allowed["robot_target_radius"] = tuple(robot.target.radius for robot in robots)
        if self.fixes_time_step:
            allowed["time_step"] = (self.scenario.run.time_step,)
        # Nothing ever changes an option that is a list, so no failure needs to repeat it.
        for name, value in self.scenario.run.changed().items():
            if not isinstance(value, list):
                allowed[name] = (value,)
        for one in self.vary:
            allowed[one.name] = one.values
        return Constraint.of(allowed)


def radii_on(world: World) -> tuple[float, ...]:
    """Return the radii, m, of the robots that a campaign puts on a map, the map's own first.

    A robot with a footprint keeps it.
    """
    if not world.robots[0].is_disc:
        return (world.robot_radius,)
    own = dict.fromkeys(robot.radius for robot in world.robots)
    return tuple(_scaled(radius, share) for share in _SHARES_ON_A_MAP for radius in own)


def radius_next_to(first: float, like: World, number: int) -> float:
    """Return the radius, m, of another robot on a map, which shrinks as the first one does.

    Args:
        first: Radius of the first robot, m; one of :func:`radii_on`.
        like: The map.
        number: Number of the robot on the map, from 1.
    """
    share = next(one for one in _SHARES_ON_A_MAP if _scaled(like.robot_radius, one) == first)
    return _scaled(like.robots[number - 1].radius, share)


def _scaled(radius: float, share: float) -> float:
    """Return a share of a radius, m, without the digits that rounding errors add."""
    return radius if share == 1.0 else round(radius * share, 6)
