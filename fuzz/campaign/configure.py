"""Check a campaign's options before any work begins."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable
from dataclasses import fields, replace

from fuzz.facts.proofs import certified
from fuzz.layouts.features import arena_for
from fuzz.layouts.variation import OVERRIDES, Variation, quantities_of, with_robot
from fuzz.oracles import NamedOracle, Trial
from fuzz.search.registry import check_strategy
from fuzz.unit.config import CampaignConfig
from fuzz.unit.names import TIME_STEPS
from fuzz.unit.options import MOST_ROBOTS, CampaignOptions, SearchOptions
from fuzz.unit.pace import Pace, measured_pace
from sim.controllers import CONTROLLERS
from sim.controllers.answers import SLOW_STEP
from sim.episode.try_out import EMPTY_ARENA, step_times, try_out
from sim.fleet.assignment import is_numbered
from sim.motion import MOTIONS
from sim.options.run import RunOptions
from sim.runners.controller_host import host_of
from sim.scenario import Scenario, read_settings
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.files.worlds import read_whole_world
from worldgen.plugins.trust import admit_argument
from worldgen.support.progress import working
from worldgen.world import World

_VARY = "--vary"
# Share of the budget in which the controller's pace is measured.
_TO_MEASURE = 0.03
# Seconds for the same where the pace is only mentioned.
_TO_MENTION = 1.0


def configure(options: CampaignOptions, seed: int, seconds: float | None = None) -> CampaignConfig:
    """Check a campaign's parts before any work begins.

    Args:
        options: Options as given.
        seed: Seed of the whole campaign.
        seconds: Limit in seconds for trying out the controller, whose pace is measured then; None
            for no limit, and for a configuration that no clock decides.

    Raises:
        InvalidParameter: If a name is unknown, or controller and motion model do not fit together.
        InvalidWorld: If the map has no room.
    """
    # Read the controller with its options, and check that the strategies fit it.
    if is_numbered(options.controller):
        raise InvalidParameter(
            "one-controller-for-all",
            "{controller!r} gives each robot its own controller, but a campaign has one "
            "controller for all robots",
            "write --robots 2 --controller bug2",
            at_terminal=True,
            controller=options.controller,
        )
    usual = RunOptions.time_step
    robot = options.robot
    fixed_map = None if options.world is None else read_whole_world(options.world)
    if fixed_map is not None:
        fixed_map = robot.applied_to(fixed_map)
    scenario = Scenario.parse(
        options.controller,
        motion=options.motion,
        time_step=usual if options.time_step is None else options.time_step,
        task=options.task,
    )
    families = (*options.families, *options.strategies)
    admit_argument(*families, *options.oracles)
    robots = (options.robots or 1) if fixed_map is None else _robots_on(fixed_map, options)
    for name in families:
        check_strategy(name, scenario, robots)
    time_steps: tuple[float, ...] = (scenario.run.time_step,)
    # Omitted options are None, whether a command, its settings or a form would have given them.
    _, settings = read_settings(options.controller, options.motion)
    fixes_time_step = options.time_step is not None or "time_step" in settings
    if not fixes_time_step and MOTIONS.get(scenario.run.motion).name == "endpoint":
        time_steps = TIME_STEPS
    # Read the quantities that vary; each may be named only once. The robot's options vary, too, each
    # with one value.
    quantities = quantities_of(robot)
    fixed = tuple(Variation(name, (value,)) for name, value in quantities.items())
    varied = tuple(Variation.parse(text, scenario) for text in options.vary)
    given = {"time_step"} if fixes_time_step else set()
    _refuse_both(varied, given | scenario.run.changed().keys() | quantities.keys())
    names = [one.name for one in varied]
    if twice := {name for name in names if names.count(name) > 1}:
        raise InvalidParameter(
            "twice",
            "{option} {name} is given twice",
            "use all of its values in one option, separated by commas",
            option=_VARY,
            name=min(twice),
        )
    varied = (*fixed, *varied)
    _check_robot(varied, fixed_map, robots)
    kept = {field.name: getattr(options, field.name) for field in fields(SearchOptions)}
    config = CampaignConfig(
        scenario,
        seed,
        families,
        time_steps,
        varied,
        fixed_map,
        shrink=fixed_map is None if options.shrink is None else options.shrink,
        robots=robots,
        fixes_time_step=fixes_time_step,
        measured=None if options.pace is None else Pace(options.pace / 1e3),
        **kept,
    )
    with working("loading the simulator and the controller"):
        _try_out(config, seconds, [NamedOracle.parse(text) for text in config.oracles])
        if seconds is None or config.measured is not None:
            return config
        begins_on = None if fixed_map is None else fixed_map.alone(1)
        spent = step_times(scenario, at_most=_TO_MEASURE * seconds, world=begins_on)
    pace = spent and measured_pace(CONTROLLERS.get(scenario.controller), *spent)
    return replace(config, measured=pace)


def unstated_pace(config: CampaignConfig) -> Pace | None:
    """Return the pace of a slow Python class for which nobody has stated or measured it.

    Without a time limit the campaign must not depend on it, so this only serves to mention it.
    """
    controller = CONTROLLERS.get(config.scenario.controller)
    if config.measured is not None or not host_of(controller).in_python:
        return None
    spent = step_times(config.scenario, at_most=_TO_MENTION)
    pace = spent and measured_pace(controller, *spent)
    return pace if pace and pace.step > SLOW_STEP else None


def _check_robot(varied: Collection[Variation], fixed_map: World | None, robots: int) -> None:
    """Refuse bodies, drives and goals that no robot of the campaign can have."""
    chosen = {one.name: one.values for one in varied if one.name in OVERRIDES}
    radius = next((one for one in varied if one.name == "robot_radius"), None)
    if chosen and robots > 1:
        raise InvalidParameter(
            "not-for-fleets",
            "{option} is for worlds of one robot, and this campaign has {robots}",
            "omit it",
            option=OVERRIDES[next(iter(chosen))].flag,
            robots=robots,
        )
    if radius is not None and "robot_footprint" in chosen:
        raise InvalidParameter(
            "no-effect",
            "{option} robot_radius has no effect on a robot with a footprint",
            "omit one of the two",
            option=_VARY,
        )
    for values in itertools.product(*chosen.values()):
        overrides = dict(zip(chosen, values, strict=True))
        if fixed_map is None:
            arena_for(overrides)
        else:
            with_robot(fixed_map, overrides)


def _refuse_both(varied: Iterable[Variation], given: Collection[str]) -> None:
    """Refuse a quantity that has a fixed value and is to vary."""
    both = next((one.name for one in varied if one.name in given), None)
    if both is not None:
        raise InvalidParameter(
            "twice",
            "{name} is both fixed and in {option}",
            "omit one of the two",
            option=_VARY,
            name=both,
        )


def _robots_on(fixed_map: World, options: CampaignOptions) -> int:
    """Return the number of robots in a campaign on a map: at least as many as the map has."""
    own = len(fixed_map.robots)
    if options.robots is not None and options.robots < own:
        raise InvalidParameter(
            "fewer-robots",
            "{path} has {own} robots, not {robots}",
            "omit --robots, or use a higher number to add robots",
            at_terminal=True,
            robots=options.robots,
            path=options.world,
            own=own,
        )
    if own > MOST_ROBOTS:
        raise InvalidParameter(
            "too-many-robots",
            "{path} has {own} robots; a campaign has at most {most}",
            "leave some out",
            path=options.world,
            own=own,
            most=MOST_ROBOTS,
        )
    return max(own, options.robots or 1)


def _try_out(config: CampaignConfig, seconds: float | None, oracles: list[NamedOracle]) -> None:
    """Do one short run in an empty arena, judged by each oracle.

    It reveals a wrong name or a compile error immediately.
    """
    scenario = config.scenario
    first = {one.name: one.values[0] for one in config.vary if one.name in OVERRIDES}
    arena = arena_for(first) if first and config.fixed_map is None else EMPTY_ARENA
    outcome = try_out(scenario, arena, seconds=seconds)
    # Every other run would fail too, each after the whole start-up deadline.
    if outcome.fault is not None and outcome.verdict == Verdict.HANG and outcome.steps == 1:
        raise InvalidParameter(
            "no-first-answer",
            "{controller} does not answer its first observation within {seconds} s",
            "does it flush its output after each line? docs/reference/controllers.md describes "
            "the protocol",
            controller=scenario.controller,
            seconds=outcome.fault.deadline,
        )
    proved = certified(arena) or arena
    for oracle in oracles:
        oracle.check(Trial(proved, scenario.controller, scenario.options(arena, 2)))
