"""Scenarios: everything about a run except the world, and how the command line writes one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from sim.controllers.base import CompiledController
from sim.controllers.behaviours.arbitration import Arbitration
from sim.controllers.behaviours.catalogue import is_composition_name
from sim.controllers.catalogue import CONTROLLERS, own_words
from sim.controllers.fields import fields_of, parse_field, unknown_field
from sim.controllers.programs.process import PROGRAM_OPTIONS, is_process_name
from sim.motion import MOTIONS
from sim.options.robot import RobotOptions
from sim.options.run import (
    OF_EVERY_RUN,
    TARGET,
    USUAL_BUDGET,
    WORDS_OF_A_RUN,
    RunBudget,
    RunOptions,
    option_without_effect,
    step_budget,
    switch_class,
    switch_sets,
)
from sim.options.thesis import REPAIRS, ThesisOptions
from worldgen.errors import InvalidParameter
from worldgen.parameters import Parameter, split_options, with_options
from worldgen.plugins.trust import admit_argument, same_origin
from worldgen.world import Value, World


@dataclass(frozen=True)
class Scenario:
    """A controller and the options of its runs: everything about a run except the world.

    Args:
        controller: Name, as on the command line.
        run: Options of each run. The number of steps depends on the world, see :meth:`options`, so
            the number given here is ignored.
        budget: How long a run may take.
    """

    controller: str
    run: RunOptions = field(default_factory=RunOptions)
    budget: RunBudget = USUAL_BUDGET

    def __post_init__(self) -> None:
        admit_argument(self.controller)
        # Without this, two scenarios could differ in a budget that neither of them uses.
        object.__setattr__(self, "run", replace(self.run, steps=RunOptions.steps))

    @property
    def arbitration(self) -> Arbitration | None:
        """How its controller arbitrates among behaviours in these runs; ``None`` if it doesn't."""
        controller = CONTROLLERS.get(self.controller)
        rule = controller.thesis_rule if isinstance(controller, CompiledController) else 0
        # Under ``stepped`` the thesis's own program runs its robots, with options for each part.
        if rule and not MOTIONS.get(self.run.motion).on_lattice:
            from sim.controllers.library.thesis import thesis_arbitration  # noqa: PLC0415 - of these robots only

            return thesis_arbitration(rule, self.run.thesis)
        found: Arbitration | None = getattr(controller, "arbitration", None)
        return found

    @property
    def fields(self) -> tuple[Parameter, ...]:
        """The fields of its controller's class that its name may set; none for other kinds."""
        base = same_origin(self.controller, own_words(self.controller)[0])
        kind = None if CONTROLLERS.has_variants(base) else CONTROLLERS.class_of(base)
        return () if kind is None else fields_of(kind)

    def value_of(self, field: Parameter) -> Value:
        """Return the value of one of its fields: its name's, or else the class's."""
        _, words = own_words(self.controller)
        given = field.name in words
        value: Value = parse_field(field, words[field.name], field.name) if given else field.default
        return value

    @classmethod
    def parse(cls, text: str, **defaults: Any) -> Scenario:
        """Read a controller with variations.

        ``thesis-1``, ``thesis-1+noise+sensor_range=50``, ``mine+motion=swept``.

        Args:
            text: A name, then ``+option`` or ``+option=value`` as often as you like, see
                :func:`read_settings`.
            defaults: Fields of :class:`RunOptions`, used where the text doesn't set them.

        Raises:
            InvalidParameter: If the text names no controller, or an option is unknown or out of
                range.
        """
        admit_argument(text)
        controller, settings = read_settings(text, defaults.get("motion", RunOptions.motion))
        return cls(same_origin(text, controller), RunOptions(**(defaults | settings)))

    def label(self, motion: str | None = None, time_step: float | None = None) -> str:
        """Return the text from which :meth:`parse` reads this scenario, without the seed.

        Args:
            motion: Motion model that the reader uses by default; omitted from the text.
            time_step: Default duration of a step, s; left out of the text.
        """
        changed = self.run.changed()
        name = self.controller
        colon = ""
        command = ""
        # A command line may contain anything, so the options come before it.
        if _has_options_first(name):
            name, colon, command = name.partition(":")
        options: dict[str, str | None] = {}
        # Name only what differs from the defaults, so that labels stay short.
        if motion is not None and self.run.motion != motion:
            options["motion"] = self.run.motion
        if time_step is not None and self.run.time_step != time_step:
            options["time_step"] = repr(self.run.time_step)
        if self.run.task != TARGET:
            options["task"] = str(self.run.task)
        if self.run.frozen_time:
            options["frozen_time"] = None
        if self.run.thesis.repaired:
            options["repaired"] = None
            changed = {key: value for key, value in changed.items() if key not in REPAIRS}
        for key, value in changed.items():
            text = ":".join(map(repr, value)) if isinstance(value, list) else str(value)
            options[key] = None if value is True else text
        return same_origin(self.controller, with_options(name, options) + colon + command)

    def options(self, world: World, steps: int | None = None) -> RunOptions:
        """Return the options of a run in a world.

        Args:
            world: Its witness decides how long a run may take.
            steps: Budget to use instead.
        """
        if steps is None:
            steps = step_budget(world, self.run, self.budget)
        return replace(self.run, steps=steps)

    def with_run(self, **changes: Any) -> Scenario:
        """Return the same scenario with other values for some fields of its run options.

        Args:
            **changes: New values of fields of :class:`RunOptions`, by name.
        """
        return replace(self, run=replace(self.run, **changes))

    def with_option(self, name: str, value: Value) -> Scenario:
        """Return the same scenario with another value for one option.

        Args:
            name: Name of an option of the motion model, such as ``slip``, or of a field of the
                controller's class.
            value: Its new value, in the option's unit.

        Raises:
            InvalidParameter: If there is no such option, or the value is out of range.
        """
        if name not in WORDS_OF_A_RUN and name in {one.name for one in self.fields}:
            base, words = own_words(self.controller)
            changed = with_options(base, {**words, name: str(value)})
            return replace(self, controller=same_origin(self.controller, changed))
        options = self.run.changed() | {name: value}
        return self.with_run(**switch_sets(self.run.motion, options))


def read_settings(text: str, motion: str = RunOptions.motion) -> tuple[str, dict[str, Any]]:
    """Read a controller's name and the fields of :class:`RunOptions` that its text sets.

    Args:
        text: A name, then ``+option`` or ``+option=value`` as often as you like: ``motion``,
            ``time_step``, and the options of the motion model, which are those of
            :class:`ThesisOptions` or :class:`RobotOptions`. A program has them before the colon:
            ``cmd+motion=endpoint:./mine``.
        motion: Motion model, if the text names none.

    Raises:
        InvalidParameter: If the text names no controller, or an option is unknown or out of range.
    """
    controller, written = _split(same_origin(text, text.strip()))
    if not is_process_name(controller):
        _refuse_program_options(controller, written)
    settings = {
        name: option.parse(written.pop(name), "run")
        for name, option in OF_EVERY_RUN.items()
        if name in written
    }
    motion = settings.get("motion", motion)
    values: dict[str, Value] = {}
    for name, value in written.items():
        values |= _parsed(motion, name, value, controller)
    return controller, settings | (switch_sets(motion, values) if values else {})


def _split(text: str) -> tuple[str, dict[str, str | None]]:
    """Split a text into name and options.

    A program's command line begins at the first colon and contains no options. Behind a
    composition's colon, options belong to its parts.
    """
    if not _has_options_first(text):
        name, options = split_options(text, "thesis-1+noise, or ./mine.py:Robot")
        return _with_own(text, name, options)
    head, colon, command = text.partition(":")
    name, options = split_options(head, "cmd+motion=endpoint:./mine")
    own = {*OF_EVERY_RUN, *RobotOptions.words()}
    if is_composition_name(text):
        own |= ThesisOptions.words()
    of_the_run = {option: value for option, value in options.items() if option in own}
    others = {option: value for option, value in options.items() if option not in own}
    return with_options(name, others) + colon + command, of_the_run


def _with_own(
    text: str, name: str, options: dict[str, str | None]
) -> tuple[str, dict[str, str | None]]:
    """Move a controller's own options, such as ``places=16``, from the run's into its name."""
    if WORDS_OF_A_RUN.issuperset(options):
        return name, options
    own = CONTROLLERS.option_names(same_origin(text, name))
    of_its_own = {option: options.pop(option) for option in [*options] if option in own}
    return with_options(name, of_its_own), options


def _has_options_first(name: str) -> bool:
    """Return True if the options of a run stand before the colon of a controller's name."""
    return is_process_name(name) or is_composition_name(name)


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


def _parsed(motion: str, name: str, text: str | None, controller: str) -> dict[str, Value]:
    """Return one option as written; an option of another motion model raises an error."""
    own = switch_class(motion)
    other = RobotOptions if own is ThesisOptions else ThesisOptions
    if name in other.words() - own.words():
        raise option_without_effect(motion, name)
    if name in own.words() or _has_options_first(controller):
        return own.parse(name, text)
    plain = same_origin(controller, split_options(controller)[0])
    if ":" in plain and not CONTROLLERS.has_variants(plain):
        raise unknown_field(plain, CONTROLLERS.class_of(plain), name)
    return own.parse(name, text, CONTROLLERS.option_names(plain), f"{plain}'s run")
