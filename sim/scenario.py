"""Scenarios: everything about a run except the world, and how the command line writes one."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from sim.controllers.programs.process import PROGRAM_OPTIONS, is_process_name
from sim.options.robot import RobotOptions
from sim.options.run import RunOptions, step_budget, switch_class, switch_sets
from sim.thesis.options import REPAIRS, ThesisOptions
from worldgen.errors import InvalidParameter
from worldgen.world import Value, World

__all__ = ["Scenario"]

# ``./a+b/mine.py:Robot+noise`` ends in one variation; a ``+`` in a folder's name begins none.
_VARIATION = r"\+[A-Za-z][A-Za-z0-9_-]*(?:=[^+/\\]*)?"
_VARIED = re.compile(rf"(?P<name>.+?)(?P<variations>(?:{_VARIATION})*)", re.DOTALL)


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
        return cls(controller, options.motion, options.time_step, options.seed, options.thesis, options.robot)

    @classmethod
    def parse(
        cls, text: str, *, motion: str = "swept", time_step: float = RunOptions.time_step, seed: int = 0
    ) -> Scenario:
        """Reads a controller with variations: ``thesis-1``, ``thesis-1+noise+sensor_range=50``, ``mine+motion=swept``.

        Args:
            text: Name, then ``+option`` or ``+option=value`` as often as wanted: ``motion``, ``time_step``, and
                the motion model's options, :class:`ThesisOptions` or :class:`RobotOptions`. Of a program they stand
                before the colon: ``cmd+motion=endpoint:./mine``.
            motion: Motion model, unless the text names one.
            time_step: s, likewise.
            seed: Of the run's random numbers.

        Raises:
            InvalidParameter: If the text names no controller, or a variation is unknown or out of range.
        """
        controller, variations = _split(text.strip())
        given: list[tuple[str, str | None]] = []
        for variation in variations:
            name, equals, value = variation[1:].partition("=")
            said: str | None = value.strip() if equals else None
            if name in PROGRAM_OPTIONS and not is_process_name(controller):
                raise InvalidParameter(
                    "option-misplaced",
                    "+{name} is an option of programs and stands before the colon: write 'cmd{variation}:{controller}'",
                    name=name,
                    variation=variation,
                    controller=controller,
                )
            if name == "motion":
                motion = _said(name, said, "stepped")
            elif name in ("time_step", "time-step"):
                time_step = _seconds(_said(name, said, "0.03"))
            else:
                given.append((name, said))
        values: dict[str, Value] = {}
        for name, said in given:
            values |= _parsed(motion, name, said)
        return cls(controller, motion, time_step, seed, **(switch_sets(motion, values) if values else {}))

    def label(self, motion: str | None = None, time_step: float | None = None) -> str:
        """The scenario as :meth:`parse` reads it, without the seed.

        Args:
            motion: Motion model that need not be said.
            time_step: s, likewise.
        """
        changed = self.thesis.changed() | self.robot.changed()
        name, colon, command = self.controller, "", ""
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


def _split(text: str) -> tuple[str, list[str]]:
    """Name and variations; of a program's command line, which begins at the first colon, nothing is a variation."""
    if not is_process_name(text):
        parts = _VARIED.fullmatch(text)
        if parts is None:
            raise InvalidParameter(
                "empty-name", "an empty text names no controller", "give one, such as thesis-1 or ./mine.py:Robot"
            )
        return parts["name"], re.findall(_VARIATION, parts["variations"])
    head, colon, command = text.partition(":")
    variations = re.findall(_VARIATION, head)
    if "".join(["cmd", *variations]) != head:  # as it is, it will be refused with the way out
        return text, []
    own = ("motion", "time_step", *RobotOptions.names())
    of_the_run = [one for one in variations if one[1:].partition("=")[0].replace("-", "_") in own]
    of_the_program = [one for one in variations if one not in of_the_run]
    return "".join(["cmd", *of_the_program, colon, command]), of_the_run


def _said(name: str, text: str | None, example: str) -> str:
    if not text:
        raise InvalidParameter(
            "option-needs-value", "option {name!r} needs a value", "write +{name}={example}", name=name, example=example
        )
    return text


def _parsed(motion: str, name: str, text: str | None) -> dict[str, Value]:
    """One option as written; one of another motion model's gets a sentence that says so."""
    own = switch_class(motion)
    other = RobotOptions if own is ThesisOptions else ThesisOptions
    plain = name.replace("-", "_")
    if plain not in (*own.names(), *own.TOGETHER) and plain in (*other.names(), *other.TOGETHER):
        where = "swept or endpoint" if own is ThesisOptions else "stepped"
        raise InvalidParameter(
            "option-without-effect",
            "option {name!r} means nothing to motion {motion!r}",
            "take --motion {where}, or leave it out",
            at_terminal=True,
            name=name,
            motion=motion,
            where=where,
        )
    return own.parse(name, text)


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InvalidParameter(
            "not-a-number", "time_step={text!r} is no number", "write seconds, like 0.015", text=text
        ) from None
