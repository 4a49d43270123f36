"""Scenarios: everything about a run except the world, and how the command line writes one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from sim.controllers.programs.process import PROGRAM_OPTIONS, is_process_name
from sim.options.robot import RobotOptions
from sim.options.run import (
    TIME_STEP,
    RunOptions,
    option_without_effect,
    step_budget,
    switch_class,
    switch_sets,
)
from sim.thesis.options import REPAIRS, ThesisOptions
from worldgen.errors import InvalidParameter
from worldgen.parameters import parameters_of_fields, split_options
from worldgen.world import Value, World

__all__ = ["Scenario"]

_MOTION = next(option for option in parameters_of_fields(RunOptions) if option.name == "motion")


@dataclass(frozen=True)
class Scenario:
    """Everything about a run except the world.

    Args:
        controller: Name, as the command line takes it.
        motion: Name of the motion model.
        time_step: s.
        seed: Of the run's random numbers.
        thesis: Switches of the motion model ``stepped``.
        robot: Dynamics and sensors under the other motion models.
    """

    controller: str
    motion: str = "swept"
    time_step: float = RunOptions.time_step
    seed: int = 0
    thesis: ThesisOptions = field(default_factory=ThesisOptions)
    robot: RobotOptions = field(default_factory=RobotOptions)

    @classmethod
    def of(cls, controller: str, options: RunOptions) -> Scenario:
        """A controller and everything in a run's options but the budget."""
        return cls(
            controller,
            options.motion,
            options.time_step,
            options.seed,
            options.thesis,
            options.robot,
        )

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        motion: str = "swept",
        time_step: float = RunOptions.time_step,
        seed: int = 0,
    ) -> Scenario:
        """Reads a controller with variations.

        ``thesis-1``, ``thesis-1+noise+sensor_range=50``, ``mine+motion=swept``.

        Args:
            text: Name, then ``+option`` or ``+option=value`` as often as wanted: ``motion``,
                ``time_step``, and the motion model's options, :class:`ThesisOptions` or
                :class:`RobotOptions`. Of a program they stand before the colon:
                ``cmd+motion=endpoint:./mine``.
            motion: Motion model, unless the text names one.
            time_step: s, likewise.
            seed: Of the run's random numbers.

        Raises:
            InvalidParameter: If the text names no controller, or a variation is unknown or out of
                range.
        """
        controller, options = _split(text.strip())
        if not is_process_name(controller):
            _refuse_program_options(controller, options)
        motion = _MOTION.parse(options.pop("motion"), "run") if "motion" in options else motion
        time_step = (
            TIME_STEP.parse(options.pop("time_step"), "run")
            if "time_step" in options
            else time_step
        )
        values: dict[str, Value] = {}
        for name, value in options.items():
            values |= _parsed(motion, name, value)
        return cls(
            controller, motion, time_step, seed, **(switch_sets(motion, values) if values else {})
        )

    def label(self, motion: str | None = None, time_step: float | None = None) -> str:
        """The scenario as :meth:`parse` reads it, without the seed.

        Args:
            motion: Motion model that need not be said.
            time_step: s, likewise.
        """
        changed = self.thesis.changed() | self.robot.changed()
        name = self.controller
        colon = ""
        command = ""
        if is_process_name(name):
            name, colon, command = name.partition(":")
        words = [name]
        if motion is not None and self.motion != motion:
            words.append(f"motion={self.motion}")
        if time_step is not None and self.time_step != time_step:
            words.append(f"time_step={self.time_step!r}")
        if self.thesis.repaired:
            words.append("repaired")
            changed = {name: value for name, value in changed.items() if name not in REPAIRS}
        for name, value in changed.items():
            text = ":".join(map(repr, value)) if isinstance(value, list) else value
            words.append(name if value is True else f"{name}={text}")
        return "+".join(words) + colon + command

    def options(self, world: World, steps: int | None = None) -> RunOptions:
        """Options with a budget: ``steps``, or what the world's witness gives."""
        budget = step_budget(world, self.time_step) if steps is None else steps
        return RunOptions(self.motion, budget, self.time_step, self.seed, self.thesis, self.robot)

    @property
    def random(self) -> bool:
        """Whether the simulator itself draws random numbers."""
        return self.thesis.random or self.robot.random

    def with_seed(self, seed: int) -> Scenario:
        """The same with another seed."""
        return replace(self, seed=seed)


def _split(text: str) -> tuple[str, dict[str, str | None]]:
    """Return name and options.

    In a program's command line, which begins at the first colon, nothing is an option.
    """
    if not is_process_name(text):
        return split_options(text, "thesis-1+noise, or ./mine.py:Robot")
    head, colon, command = text.partition(":")
    name, options = split_options(head, "cmd+motion=endpoint:./mine")
    own = ("motion", "time_step", *RobotOptions.names())
    of_the_run = {option: value for option, value in options.items() if option in own}
    words = [name]
    for option, value in options.items():
        if option not in own:
            words.append(option if value is None else f"{option}={value}")
    return "+".join(words) + colon + command, of_the_run


def _refuse_program_options(controller: str, options: Mapping[str, str | None]) -> None:
    for name in options:
        if name in PROGRAM_OPTIONS:
            value = "" if options[name] is None else f"={options[name]}"
            raise InvalidParameter(
                "option-misplaced",
                "+{name} is an option of programs and stands before the colon: write "
                "'cmd+{name}{value}:{controller}'",
                name=name,
                value=value,
                controller=controller,
            )


def _parsed(motion: str, name: str, text: str | None) -> dict[str, Value]:
    """Return one option as written; one of another motion model's gets a sentence that says so."""
    own = switch_class(motion)
    other = RobotOptions if own is ThesisOptions else ThesisOptions
    if name not in (*own.names(), *own.TOGETHER) and name in (*other.names(), *other.TOGETHER):
        raise option_without_effect(motion, name)
    return own.parse(name, text)
