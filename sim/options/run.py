"""Options of a run: everything except world and controller that determines its result."""

from __future__ import annotations

import math
import typing
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeGuard

import numpy as np

from sim.motion import MOTIONS, Motion
from sim.options.disturbances import delay_of
from sim.options.robot import RobotOptions
from sim.options.thesis import ThesisOptions
from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter
from worldgen.lattice import exact
from worldgen.parameters import parameters_of_fields
from worldgen.parameters.bounds import Bounds, check_choice
from worldgen.reach.still.cells import reachable_cells
from worldgen.support.arrays import Words
from worldgen.support.plain_text import quote
from worldgen.world import JointWitness, Pose, Value, Witness, World

Task = Literal["target", "cover"]
TASKS: tuple[Task, ...] = typing.get_args(Task)
TARGET: Task = "target"
COVER: Task = "cover"
# Seconds: the thesis's time step.
DEFAULT_TIME_STEP = 0.015
# Smallest and largest time step, s.
TIME_STEPS = (0.001, 10.0)
MAX_STEPS = 100_000_000
# Maximum number of steps; a recorded one takes about 300 bytes.
MAX_RECORDED = 4_000_000
# Settings of every run that a failure stores.
_OF_THE_RUN = ("steps", "time_step", "task", "frozen_time")
# The budget of a coverage task, as a multiple of a tour of all cells and back.
_COVER_FACTOR = 10
# A budget grows at most this many times for a drift.
_MOST_OF_A_DRIFT = 10
# Cells: the tolerated overlap if the model should have none.
_ROUNDING = 1e-6
# Cells: larger steps would come near the limits of 64-bit lattice arithmetic.
_LONGEST_STEP = 1_000
_STEPS_WITHOUT_WITNESS = 20_000
_MOST_SEEDS = 100_000_000


class RunBudget(NamedTuple):
    """How long a run may take before it counts as stalled or timed out.

    Args:
        witnesses: Times the witness's time.
        fewest: Steps at least, however short the witness.
    """

    witnesses: int
    fewest: int


USUAL_BUDGET = RunBudget(50, 4_000)
COSTLY_BUDGET = RunBudget(20, 600)
"""The same where each step is expensive."""


@dataclass(frozen=True)
class RunOptions:
    """Options of a run; a failure file stores them so that it can be replayed.

    Args:
        motion: Name of the motion model.
        steps: Budget in steps.
        time_step: Duration of a step, s, 0.001 to 10.
        seed: Seed of the run's random numbers.
        thesis: Options of the motion model ``stepped``.
        robot: Dynamics and sensors under the other motion models.
        task: Reach the ``target``, or ``cover`` every cell whose centre the robot can reach.
        frozen_time: Whether a Python class sees simulated time instead of the clock, and chance
            that begins with the seed.

    Raises:
        InvalidParameter: If a value is out of range or of the wrong type.
    """

    motion: str = "swept"
    steps: Annotated[int, Bounds(1, MAX_STEPS)] = _STEPS_WITHOUT_WITNESS
    time_step: Annotated[float, Bounds(0.001, 10.0, "s")] = DEFAULT_TIME_STEP
    seed: int = 0
    thesis: ThesisOptions = field(default_factory=ThesisOptions)
    robot: RobotOptions = field(default_factory=RobotOptions)
    task: Task = TARGET
    frozen_time: bool = False

    def __post_init__(self) -> None:
        for name, kind in (("motion", str), ("thesis", ThesisOptions), ("robot", RobotOptions)):
            if not isinstance(getattr(self, name), kind):
                wanted = "a motion model's name" if kind is str else kind.__name__
                raise InvalidParameter(
                    "wrong-type",
                    "{name}={value} is not {wanted}",
                    "use one",
                    name=name,
                    value=quote(getattr(self, name)),
                    wanted=wanted,
                )
        check_choice("task", str(self.task), TASKS)
        if self.task != TARGET and switch_class(self.motion) is ThesisOptions:
            raise option_without_effect(self.motion, "task")
        if self.frozen_time and switch_class(self.motion) is ThesisOptions:
            raise option_without_effect(self.motion, "frozen_time")
        object.__setattr__(
            self, "frozen_time", OF_EVERY_RUN["frozen_time"].accept(self.frozen_time, "run")
        )
        object.__setattr__(self, "time_step", TIME_STEP.accept(self.time_step, "run"))
        object.__setattr__(self, "steps", whole("steps", self.steps, 1, MAX_STEPS))
        object.__setattr__(self, "seed", whole("seed", self.seed, 0, MASK64))

    def motion_model(self) -> Motion:
        """Return the motion model, with the tolerance that these options leave it.

        Raises:
            InvalidParameter: If no motion model has that name.
        """
        motion = MOTIONS.get(self.motion)
        return replace(motion, overlap_tolerance=_ROUNDING) if self.thesis.repaired else motion

    def changed(self) -> dict[str, Value]:
        """Return the options of the motion model that differ from their defaults."""
        return self.thesis.changed() | self.robot.changed()

    def parameters(self) -> dict[str, Value]:
        """Return what a failure file stores in addition to motion model and seed."""
        task = {} if self.task == TARGET else {"task": self.task}
        frozen: dict[str, Value] = {"frozen_time": True} if self.frozen_time else {}
        own: dict[str, Value] = {"steps": self.steps, "time_step": self.time_step}
        return {**own, **task, **frozen, **self.changed()}

    @classmethod
    def of(cls, motion: str, seed: int, parameters: Mapping[str, Value]) -> RunOptions:
        """Read back what :meth:`parameters` stored.

        Raises:
            InvalidParameter: If a name is unknown or a value has the wrong type.
        """
        switches = dict(parameters)
        own = {name: switches.pop(name) for name in _OF_THE_RUN if name in switches}
        return cls(motion, seed=seed, **own, **switch_sets(motion, switches))  # type: ignore[arg-type]


OF_EVERY_RUN = {
    option.name: option
    for option in parameters_of_fields(RunOptions)
    if option.name in ("motion", "time_step", "task", "frozen_time")
}
"""The options of a run that no motion model owns and that a controller's name may set."""

WORDS_OF_A_RUN = frozenset({*OF_EVERY_RUN, *RobotOptions.words(), *ThesisOptions.words()})
"""The names of all options of a run; an option of a controller cannot have one of them."""

TIME_STEP = next(
    option for option in parameters_of_fields(RunOptions) if option.name == "time_step"
)
"""The option, for code that parses one from text."""


def switch_class(motion: str) -> type[ThesisOptions] | type[RobotOptions]:
    """Return the set of options that goes with a motion model.

    Raises:
        InvalidParameter: If no motion model has that name.
    """
    return RobotOptions if MOTIONS.get(motion).on_lattice else ThesisOptions


def switch_sets(motion: str, values: Mapping[str, Value]) -> dict[str, Any]:
    """Return named options as the arguments ``thesis`` and ``robot`` of :class:`RunOptions`.

    Raises:
        InvalidParameter: If no motion model has that name, or it has no such option.
    """
    own = switch_class(motion)
    other = RobotOptions if own is ThesisOptions else ThesisOptions
    strange = [name for name in values if name not in own.names() and name in other.names()]
    if strange:
        raise option_without_effect(motion, strange[0])
    return {own.OWNER: own.of(values)}


def option_without_effect(motion: str, name: str) -> InvalidParameter:
    """Return the error for an option of another motion model."""
    return InvalidParameter(
        "option-without-effect",
        "option {option!r} has no effect under motion {motion!r}",
        "use --motion {where}, or omit it",
        at_terminal=True,
        option=name,
        motion=motion,
        where="swept or endpoint" if switch_class(motion) is ThesisOptions else "stepped",
    )


def check_recordable(steps: int) -> None:
    """Reject a recording that takes too much memory.

    Raises:
        InvalidParameter: If the run has more than ``MAX_RECORDED`` steps.
    """
    if steps > MAX_RECORDED:
        raise InvalidParameter(
            "run-too-long",
            "this run takes {steps} steps, and at most {most} can be recorded to show or prove "
            "them",
            "use a smaller --steps",
            at_terminal=True,
            steps=steps,
            most=MAX_RECORDED,
        )


def check_step_length(world: World, time_step: float, shortest: Fraction) -> None:
    """Reject a top speed that the simulator cannot represent at this time step.

    Args:
        world: World of the robot.
        time_step: Time step, s.
        shortest: Minimum length of a step at top speed, cells.

    Raises:
        InvalidParameter: If a step is longer than 1,000 cells, or shorter than ``shortest``.
    """
    cells = exact(world.robot_speed) * exact(time_step) / exact(world.cell_size)
    moves = "robot_speed={robot_speed:g} m/s moves {cells:.3g} cells in a step of {time_step:g} s"
    facts = {"robot_speed": world.robot_speed, "cells": float(cells), "time_step": time_step}
    if cells > _LONGEST_STEP:
        raise InvalidParameter(
            "step-too-long",
            f"{moves}, and at most {{most}} can be simulated",
            "use a shorter --time-step",
            at_terminal=True,
            **facts,
            most=_LONGEST_STEP,
        )
    if cells < shortest:
        raise InvalidParameter(
            "step-too-short",
            f"{moves}, less than the smallest step of {{least}} cell",
            "use a longer --time-step",
            at_terminal=True,
            **facts,
            least=str(shortest),
        )


def step_budget(world: World, run: RunOptions, budget: RunBudget = USUAL_BUDGET) -> int:
    """Return the steps that a run gets.

    Usually they are 50 times the witness's time, at least 4,000; 20,000 without a witness. To cover a
    world, the time to drive from each cell to the next and back replaces the witness's time. Time lost
    to pushes and drift is added first.

    Args:
        world: The world, with its certificate.
        run: Options of the run; its own budget is ignored.
        budget: How long it may take.

    Raises:
        InvalidWorld: If a world that changes is to be covered.
    """
    # The time to cover an area is the time to drive through every cell, not the witness's.
    if run.task == COVER:
        cells = int(np.count_nonzero(reachable_cells(world)))
        duration = 2 * cells * exact(world.cell_size) / exact(world.robot_speed)
        factor = _COVER_FACTOR
    elif isinstance(world.certificate, Witness | JointWitness):
        duration = exact(world.certificate.duration)
        factor = budget.witnesses
    else:
        return _STEPS_WITHOUT_WITNESS
    # Disturbances cost time.
    if run.robot.moved:
        delay, slower = delay_of(world, run.robot)
        duration = min(slower, Fraction(_MOST_OF_A_DRIFT)) * duration + exact(delay)
    wanted = math.ceil(factor * duration / exact(run.time_step))
    return min(max(wanted, budget.fewest), MAX_STEPS)


def recorded_budget(world: World, run: RunOptions) -> RunBudget:
    """Return the budget with which a run has got its steps; the usual one, or less, if none fits.

    Args:
        world: The world, with its certificate.
        run: Options of the run, with its steps.
    """
    if run.task != COVER:
        for budget in (USUAL_BUDGET, COSTLY_BUDGET):
            if step_budget(world, run, budget) == run.steps:
                return budget
    return RunBudget(USUAL_BUDGET.witnesses, min(run.steps, USUAL_BUDGET.fewest))


def options_of(world: World, settings: Mapping[str, Value]) -> RunOptions:
    """Return the options from single settings: those of a run, and those of its motion model.

    Raises:
        InvalidParameter: If a name or a value is unknown or out of range.
    """
    own = {
        name: value for name, value in settings.items() if name in ("motion", "seed", *_OF_THE_RUN)
    }
    rest = {name: value for name, value in settings.items() if name not in own}
    options = RunOptions(**own)  # type: ignore[arg-type]
    if rest:
        options = replace(options, **switch_sets(options.motion, rest))
    if "steps" in own:
        return options
    return replace(options, steps=step_budget(world, options))


def options_from(
    world: World, options: RunOptions | None, settings: Mapping[str, Value]
) -> RunOptions:
    """Return the options that a caller gave, together or as single settings.

    Raises:
        InvalidParameter: If both are given, or a name or a value is unknown or out of range.
    """
    if options is None:
        return options_of(world, settings)
    if not isinstance(options, RunOptions):
        raise InvalidParameter(
            "wrong-type",
            "{options!r} is not RunOptions",
            "use this object, or single settings: steps=3000, seed=3",
            options=options,
        )
    if settings:
        raise InvalidParameter(
            "options-given-twice", "use options or {settings!l}, not both", settings=list(settings)
        )
    return options


def check_world(world: object) -> World:
    """Return the world, and reject anything else.

    Raises:
        InvalidParameter: If it isn't a world.
    """
    if isinstance(world, World):
        return world
    is_path = isinstance(world, str | Path)
    way = "read it: worldgen.read_world({path!r})" if is_path else "use a World"
    raise InvalidParameter(
        "wrong-type", "{world} is not a world", way, world=quote(world), path=str(world)
    )


def worlds_of(worlds: object) -> list[World]:
    """Return one world or many as a list.

    Raises:
        InvalidParameter: If one of them isn't a world.
    """
    found = (
        list(worlds) if isinstance(worlds, Iterable) and not isinstance(worlds, str) else [worlds]
    )
    return [check_world(world) for world in found]


def poses_of(starts: object) -> tuple[Pose, ...]:
    """Return the starts as a tuple.

    Raises:
        InvalidParameter: If they are not a list of poses of finite numbers.
    """
    if not isinstance(starts, Iterable):
        raise InvalidParameter(
            "wrong-type",
            "starts={starts} is not a list",
            "use a list of poses",
            starts=quote(starts),
        )
    poses = tuple(starts)
    for pose in poses:
        numbers = (pose.x, pose.y, pose.heading) if isinstance(pose, Pose) else ()
        if not numbers or not all(
            _is_number(number) and math.isfinite(number) for number in numbers
        ):
            raise InvalidParameter(
                "not-a-pose",
                "start {pose} is not a pose of finite numbers",
                "use one such as Pose(0.35, 0.35, 0.0)",
                pose=quote(pose),
            )
    return poses


def seeds_of(seeds: object) -> Words:
    """Return the given seeds, or those from 0 if a count is given.

    Raises:
        InvalidParameter: If a seed, or their number, isn't a whole number or is out of range.
    """
    if isinstance(seeds, Iterable) and not isinstance(seeds, str):
        return np.array([whole("seed", seed, 0, MASK64) for seed in seeds], np.uint64)
    return np.arange(whole("seeds", seeds, 0, _MOST_SEEDS), dtype=np.uint64)


def whole(name: str, value: object, low: int, high: int) -> int:
    """Return an integer, Python's or NumPy's, from low to high.

    Raises:
        InvalidParameter: If it isn't one.
    """
    if not isinstance(value, int | np.integer) or isinstance(value, bool):
        raise InvalidParameter(
            "not-a-whole-number",
            "{name}={value} is not a whole number",
            "use one from {low} to {high}",
            name=name,
            value=quote(value),
            low=low,
            high=high,
        )
    if not low <= value <= high:
        raise InvalidParameter(
            "out-of-range",
            "{name}={value!q} is outside {low} to {high}",
            "use one between",
            name=name,
            value=value,
            low=low,
            high=high,
        )
    return int(value)


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
