"""The options of both environments, and their checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict

from sim.options.robot import RobotOptions
from sim.options.run import DEFAULT_TIME_STEP, RunOptions
from worldgen.errors import InvalidParameter
from worldgen.family import Family
from worldgen.parameters.known_names import unknown_name
from worldgen.world import Value, World
from worldgen_plugins.for_gymnasium.interface import Interface
from worldgen_plugins.for_gymnasium.supply import SOURCES, Supply

__all__ = ["REWARD", "Options", "Rules", "resolve", "sources_in"]

REWARD: Mapping[str, float] = {
    "progress": 1.0,
    "time": -0.1,
    "contact": -0.01,
    "reached": 1.0,
    "burned": -1.0,
}
"""Rewards: per metre nearer to the target, per second, per step with contact, and for both ends."""

_INTERFACE = ("sensors", "actions", "turn_rate", "reverse", "extent", "robot")


class Options(TypedDict, total=False):
    """Keywords of both environments.

    Args:
        world: The only world, or its file.
        worlds: Worlds, or files, or a folder or archive of them.
        family: Name of a family, whose worlds get rising seeds.
        params: The family's parameters.
        difficulty: Smallest and largest difficulty of the family's worlds, 0 to 1.
        pool: Number of worlds of the family; each episode is in one of them.
        pool_seed: Seed of the first.
        sensors: See :class:`worldgen_plugins.for_gymnasium.Interface`, also for the next ones down
            to ``robot``.
        actions: ``continuous`` or ``discrete``.
        turn_rate: Largest turn rate, rad/s.
        reverse: Whether actions may drive backwards.
        extent: Length that distances are given as fractions of, m.
        robot: The robot's dynamics and sensors.
        observation: ``box`` for one flat array, ``dict`` for one array per sensor.
        time_step: Duration of a step, s.
        reward: The entries of :data:`REWARD` to change.
        distance: Measure of progress: ``straight``, or ``way`` for the shortest path.
    """

    world: World | str | Path | None
    worlds: Sequence[World | str | Path] | str | Path | None
    family: str | Family | None
    params: Mapping[str, Value] | None
    difficulty: tuple[float, float] | None
    pool: int | None
    pool_seed: int | None
    sensors: Sequence[str]
    actions: str
    turn_rate: float
    reverse: bool
    extent: float
    robot: RobotOptions | Mapping[str, Value]
    observation: str
    time_step: float
    reward: Mapping[str, float]
    distance: str


@dataclass(frozen=True)
class Rules:
    """The rules of an episode, apart from its world.

    Args:
        interface: Sensors and actions.
        observation: ``box`` or ``dict``.
        time_step: Duration of a step, s.
        reward: All entries of :data:`REWARD`.
        by_way: Whether progress is measured by the shortest path.
    """

    interface: Interface
    observation: str = "box"
    time_step: float = DEFAULT_TIME_STEP
    reward: Mapping[str, float] = field(default_factory=lambda: REWARD)
    by_way: bool = False

    def numbers(self, limit: int, autoreset: int) -> Any:
        """Return the rules as a WgRules for the core.

        Args:
            limit: Steps after which an episode is truncated; 0 for never.
            autoreset: WG_NEXT_STEP, WG_SAME_STEP or WG_NO_AUTORESET.
        """
        rules = self.interface.rules()
        for name in REWARD:
            setattr(rules, name, self.reward[name])
        rules.limit = limit
        rules.autoreset = autoreset
        return rules

    def run_options(self) -> RunOptions:
        """Return the same rules as options of a run of the simulator."""
        return RunOptions("swept", 1, self.time_step, robot=self.interface.needs)


def resolve(options: Mapping[str, Any]) -> tuple[Rules, Supply]:
    """Return rules and worlds from the keywords of an environment.

    Raises:
        InvalidParameter: If a keyword is unknown or its value is out of range.
    """
    known = tuple(Options.__annotations__)
    _check_names(options, known, "option")
    interface = {name: options[name] for name in _INTERFACE if name in options}
    form = options.get("observation", "box")
    if form not in ("box", "dict"):
        raise InvalidParameter(
            "unknown-name",
            "observation={observation!r} is neither 'box' nor 'dict'",
            "use one of them",
            observation=form,
        )
    distance = options.get("distance", "straight")
    if distance not in ("straight", "way"):
        raise InvalidParameter(
            "unknown-name",
            "distance={distance!r} is neither 'straight' nor 'way'",
            "use one of them",
            distance=distance,
        )
    rules = Rules(
        interface=Interface(**interface),
        observation=form,
        time_step=options.get("time_step", DEFAULT_TIME_STEP),
        reward=_reward(options.get("reward", {})),
        by_way=distance == "way",
    )
    # Making run options refuses a time step that is out of range.
    rules.run_options()
    return rules, Supply({name: options[name] for name in SOURCES if name in options})


def sources_in(options: Mapping[str, Any] | None, *others: str) -> dict[str, Any]:
    """Return the options of a reset that determine the source of worlds.

    Args:
        options: The options.
        *others: Names of other options that are allowed.

    Raises:
        InvalidParameter: If an option is unknown.
    """
    given = {} if options is None else options
    _check_names(given, (*SOURCES, *others), "reset option")
    return {name: given[name] for name in SOURCES if name in given}


def _check_names(given: Mapping[str, Any], known: Sequence[str], what: str) -> None:
    for name in given:
        if name not in known:
            raise InvalidParameter.of(
                unknown_name("no {noun} is called {name!r}", str(name), known, noun=what)
            )


def _reward(given: object) -> dict[str, float]:
    if not isinstance(given, Mapping):
        raise InvalidParameter(
            "wrong-type",
            "reward={given} is not a dict",
            "write one such as {{'time': -0.2}}",
            given=repr(given),
        )
    _check_names(given, tuple(REWARD), "part of the reward")
    for name, value in given.items():
        if not isinstance(value, int | float) or isinstance(value, bool) or not abs(value) <= 1e9:
            raise InvalidParameter(
                "not-a-number",
                "reward: {name}={value!r} is not a number within 1e9 of 0",
                "use one",
                name=name,
                value=value,
            )
    return {**REWARD, **{name: float(value) for name, value in given.items()}}
