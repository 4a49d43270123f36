"""Options that cannot change a run, and range beams that a controller reads but does not have."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterable, Sequence

from sim.controllers.base import CompiledController, robot_for, wants_world
from sim.controllers.catalogue import CONTROLLERS, own_words
from sim.controllers.fields import hidden_fields
from sim.controllers.instances import origin_of
from sim.controllers.library.thesis import RANDOM
from sim.controllers.noise import is_random
from sim.options.run import OF_EVERY_RUN, switch_class
from sim.options.thesis import ThesisOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.plugins.registry import user_code

_SIGNAL = ("signal", "signal_heading")
_SENSOR = (
    "sensor_cells",
    "sensor_range",
    "sensor_field",
    "sensor_noise",
    "signal",
    "smoke",
    "smoke_reach",
)
_BEAMS = ("beams", "beam_range", "beam_field", "beam_noise", "beam_dropout")
# An option matters only if the controller reads one of these fields of its observation.
_NEIGHBOURS = ("neighbour_range", "neighbours", "message")
_READ_BY = {
    **dict.fromkeys(_SENSOR, _SIGNAL),
    **dict.fromkeys(_BEAMS, ("beams",)),
    **dict.fromkeys(_NEIGHBOURS, ("neighbours",)),
    "sensor_cells": ("signal_heading",),
    "decoys": _SIGNAL,
    "odometry_noise": ("odometry_x", "odometry_y", "odometry_heading"),
}
# Options that only adjust another one, by name; they do nothing if that one is off.
_SHAPES = (
    dict.fromkeys(_BEAMS[1:], "beams")
    | dict.fromkeys(_NEIGHBOURS[1:], "neighbour_range")
    | {"smoke_reach": "smoke", "drift_heading": "drift"}
)


def ineffective(scenarios: Iterable[Scenario], *, seeds: Sequence[str] = ()) -> list[str]:
    """Return a sentence for each option that has no effect on these runs, or less than expected.

    Add one for each controller that reads range beams without having any.

    Args:
        scenarios: The scenarios that are run.
        seeds: Names of the options for seeds that were given; the first is reported as unused
            if no run draws numbers.
    """
    runs = tuple(scenarios)
    sentences = [
        one
        for scenario in runs
        for tell in (unused_options, unset_fields, overwritten_fields, coarse_forces, missing_beams)
        for one in tell(scenario)
    ]
    if seeds and not any(map(random_run, runs)):
        these = "this run" if len(runs) == 1 else "these runs"
        sentences.append(f"--{seeds[0]} has no effect: nothing in {these} is random")
    return list(dict.fromkeys(sentences))


def unused_options(scenario: Scenario) -> list[str]:
    """Return a sentence for each option that is set and cannot change any run of the scenario.

    A controller that does not declare its senses is assumed to read everything but the clock.

    Raises:
        InvalidParameter: If no controller or motion model has that name.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if scenario.run.frozen_time and isinstance(controller, CompiledController):
        return [
            f"+frozen_time has no effect: {scenario.controller} is compiled, not a Python class"
        ]
    if switch_class(scenario.run.motion) is ThesisOptions:
        return _unused_in_the_thesis(controller, scenario)
    senses = getattr(controller, "senses", None)
    changed = scenario.run.robot.changed()
    # The controller itself may switch on the feature that an option adjusts.
    robot = robot_for(controller, scenario.run.robot)
    sentences = []
    # An option has no effect if the feature that it adjusts is off, or if nobody reads what it
    # changes.
    for name in changed:
        needed = _READ_BY.get(name, ())
        shaped = _SHAPES.get(name)
        if shaped is not None and not getattr(robot, shaped):
            sentences.append(f"+{name} has no effect without +{shaped}")
        elif senses is not None and needed and not set(needed) & set(senses):
            sentences.append(
                f"+{name} has no effect: {scenario.controller} does not read {' or '.join(needed)}"
            )
    return sentences


def unset_fields(scenario: Scenario) -> list[str]:
    """Return a sentence for each option of the run whose name a field of the class has, too."""
    base, _ = own_words(scenario.controller)
    kind = CONTROLLERS.class_of(base)
    hidden = () if kind is None else hidden_fields(kind)
    if not hidden:
        return []
    changed = {
        one for one, option in OF_EVERY_RUN.items() if getattr(scenario.run, one) != option.default
    }
    set_here = {*scenario.run.changed(), *changed}
    return [
        f"+{one.name} sets the run's option, and the field {one.name} of {base} keeps "
        f"{one.default!r}: rename the field to set it"
        for one in hidden
        if one.name in set_here
    ]


def overwritten_fields(scenario: Scenario) -> list[str]:
    """Return a sentence for each field in the controller's name that ``reset`` sets again."""
    _, words = own_words(scenario.controller)
    given = [one for one in scenario.fields if one.name in words]
    controller = CONTROLLERS.get(scenario.controller) if given else None
    origin = origin_of(controller)
    if origin is None or wants_world(controller):
        return []
    try:
        made = origin.another()
        before = {one.name: getattr(made, one.name, None) for one in given}
        with user_code(f"controller {scenario.controller!r}: reset()"):
            made.reset()
    except InvalidParameter:  # The run itself shows what fails.
        return []
    after = {name: getattr(made, name, None) for name in before}
    return [
        f"+{name} has no effect: reset() of {scenario.controller} sets {name} to {after[name]!r}; "
        "set it in the class, or in __init__"
        for name, value in before.items()
        if isinstance(after[name], bool | int | float | str) and after[name] != value
    ]


def coarse_forces(scenario: Scenario) -> list[str]:
    """Return a sentence about forces under a motion model that rounds every move to whole pixels.

    It is empty otherwise.
    """
    if switch_class(scenario.run.motion) is not ThesisOptions:
        return []
    known = {one.name for one in ThesisOptions.declared() if one.group == "Forces"}
    forces = [name for name in scenario.run.thesis.changed() if name in known]
    if not forces:
        return []
    options = ", ".join(f"+{name}" for name in forces)
    return [
        f"{options}: {scenario.run.motion} moves by whole pixels (a tenth of a cell) and drops the "
        "rest of each tick's motion, so a robot that moves less than a pixel per tick stands "
        "still: with cells of 0.1 m and ticks of 15 ms, one below 0.67 m/s"
    ]


def missing_beams(scenario: Scenario) -> list[str]:
    """Return a sentence if the code of a Python controller reads beams that its robot lacks.

    It is empty otherwise.
    """
    controller = CONTROLLERS.get(scenario.controller)
    # Our own wrappers pass on whatever beams there are.
    ours = type(controller).__module__.startswith("sim.")
    if isinstance(controller, CompiledController) or ours:
        return []
    if robot_for(controller, scenario.run.robot).beams or not _reads_beams(type(controller)):
        return []
    return [
        f"{scenario.controller} reads observation.beams, but its robot has no range beams: add "
        "+beams=36 to its name, or needs = RobotOptions(beams=36) to its class"
    ]


def _reads_beams(kind: type) -> bool:
    """Return True if the source of a class reads ``beams`` of a variable other than self."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(kind)))
    except (OSError, SyntaxError, TypeError):
        # The class has no source, for example because it was made at run time.
        return False
    return any(
        isinstance(part, ast.Attribute)
        and part.attr == "beams"
        and isinstance(part.value, ast.Name)
        and part.value.id != "self"
        for part in ast.walk(tree)
    )


def random_run(scenario: Scenario) -> bool:
    """Return True if a seed can change a run of the scenario.

    For a Python class or a program, this is unknown.
    """
    controller = CONTROLLERS.get(scenario.controller)
    return not isinstance(controller, CompiledController) or is_random(controller, scenario.run)


def _unused_in_the_thesis(controller: object, scenario: Scenario) -> list[str]:
    changed = scenario.run.thesis.changed()
    random = isinstance(controller, CompiledController) and controller.thesis_rule == RANDOM
    sentences = []
    if "draws" in changed and not random:
        sentences.append(f"+draws has no effect: {scenario.controller} draws no random numbers")
    if "turn_angle" in changed and random:
        sentences.append(f"+turn_angle has no effect: {scenario.controller} draws its angles")
    return sentences
