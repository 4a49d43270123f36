"""How a run is done: everything beside world and controller that decides what happens."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from sim.motion import MOTIONS
from sim.motion.base import THESIS, Motion
from sim.robot_options import RobotOptions
from sim.thesis_options import ThesisOptions
from worldgen.errors import InvalidParameter
from worldgen.lattice import exact
from worldgen.world import Value, Witness, World

__all__ = [
    "BUDGET_FACTOR",
    "DEFAULT_TIME_STEP",
    "MAX_RECORDED",
    "MAX_STEPS",
    "RunOptions",
    "check_step_length",
    "options_of",
    "step_budget",
    "switch_class",
    "switch_sets",
]

DEFAULT_TIME_STEP = 0.015  # s: the thesis's
MAX_STEPS = 100_000_000
MAX_RECORDED = 4_000_000  # steps; a recorded one takes about 300 bytes
BUDGET_FACTOR = 50  # a run may take this many times the witness's time before it counts as stalled or timed out
_ROUNDING = 1e-6  # cells: the tolerated overlap where the model should have none
_LONGEST_STEP = 1_000  # cells: beyond that, lattice arithmetic nears the end of 64 bits
_FEWEST_STEPS = 4_000
_STEPS_WITHOUT_WITNESS = 20_000


@dataclass(frozen=True)
class RunOptions:
    """Options of a run; a failure file stores them, so that it replays.

    Args:
        motion: Name of the motion model.
        steps: Budget in steps.
        time_step: Duration of a step, s, 0.001 to 10.
        seed: Seed of the run's random numbers.
        thesis: Switches of the motion model ``stepped``.
        robot: Dynamics and sensors under the other motion models.
    """

    motion: str = "swept"
    steps: int = _STEPS_WITHOUT_WITNESS
    time_step: float = DEFAULT_TIME_STEP
    seed: int = 0
    thesis: ThesisOptions = field(default_factory=ThesisOptions)
    robot: RobotOptions = field(default_factory=RobotOptions)

    def __post_init__(self) -> None:
        if not 1 <= self.steps <= MAX_STEPS:
            raise InvalidParameter(f"steps={self.steps} is outside 1 to {MAX_STEPS}")
        if not (math.isfinite(self.time_step) and 0.001 <= self.time_step <= 10.0):
            raise InvalidParameter(f"time_step={self.time_step} s is outside 0.001 to 10 s")
        if not 0 <= self.seed < 2**64:
            raise InvalidParameter(f"seed={self.seed} is outside 0 to 2**64 - 1")

    def motion_model(self) -> Motion:
        """The motion model, with the tolerance that these options leave it.

        Raises:
            InvalidParameter: If no motion model has that name.
        """
        motion = MOTIONS.get(self.motion)
        return replace(motion, overlap_tolerance=_ROUNDING) if self.thesis.repaired else motion

    def parameters(self) -> dict[str, Value]:
        """What a failure file stores beside motion and seed: the switches that are not at their default."""
        return {"steps": self.steps, "time_step": self.time_step, **self.thesis.changed(), **self.robot.changed()}

    @classmethod
    def of(cls, motion: str, seed: int, parameters: Mapping[str, Value]) -> RunOptions:
        """Reads back what :meth:`parameters` stored.

        Raises:
            InvalidParameter: If a name is unknown or a value has the wrong type.
        """
        switches = dict(parameters)
        steps = switches.pop("steps", _STEPS_WITHOUT_WITNESS)
        time_step = switches.pop("time_step", DEFAULT_TIME_STEP)
        if type(steps) is not int:
            raise InvalidParameter(f"run parameter steps={steps!r} must be an int")
        if type(time_step) not in (int, float):
            raise InvalidParameter(f"run parameter time_step={time_step!r} must be a float")
        return cls(motion, steps, time_step, seed, **switch_sets(motion, switches))  # type: ignore[arg-type]


def switch_class(motion: str) -> type[ThesisOptions] | type[RobotOptions]:
    """The set of options that goes with a motion model.

    Raises:
        InvalidParameter: If no motion model has that name.
    """
    return ThesisOptions if MOTIONS.get(motion).kernel == THESIS else RobotOptions


def switch_sets(motion: str, values: Mapping[str, Value]) -> dict[str, Any]:
    """Named options as the arguments ``thesis`` and ``robot`` of :class:`RunOptions`.

    Raises:
        InvalidParameter: If no motion model has that name, or it has no such option.
    """
    own = switch_class(motion)
    other = RobotOptions if own is ThesisOptions else ThesisOptions
    strange = [name for name in values if name not in own.names() and name in other.names()]
    if strange:
        where = "swept or endpoint" if own is ThesisOptions else "stepped"
        raise InvalidParameter(
            f"option {strange[0]!r} means nothing to motion {motion!r}; take --motion {where}, or leave it out"
        )
    return {"thesis" if own is ThesisOptions else "robot": own.of(values)}


def check_step_length(world: World, time_step: float, shortest: Fraction) -> None:
    """Refuses a top speed that the simulator cannot represent at this time step.

    Args:
        world: Whose robot it is.
        time_step: s.
        shortest: Least length of a step at top speed, cells.

    Raises:
        InvalidParameter: If a step is longer than 1,000 cells, or shorter than ``shortest``.
    """
    cells = exact(world.robot_speed) * exact(time_step) / exact(world.cell_size)
    what = f"robot_speed={world.robot_speed:g} m/s moves {float(cells):.3g} cells in a step of {time_step:g} s"
    if cells > _LONGEST_STEP:
        raise InvalidParameter(f"{what}, and at most {_LONGEST_STEP} can be simulated; give a shorter --time-step")
    if cells < shortest:
        raise InvalidParameter(f"{what}, less than the smallest step of {shortest} cell; give a longer --time-step")


def step_budget(world: World, time_step: float = DEFAULT_TIME_STEP) -> int:
    """Steps that a run gets: ``BUDGET_FACTOR`` times the witness's time, at least 4,000; 20,000 without one."""
    if not isinstance(world.certificate, Witness):
        return _STEPS_WITHOUT_WITNESS
    wanted = math.ceil(BUDGET_FACTOR * exact(world.certificate.duration) / exact(time_step))
    return min(max(wanted, _FEWEST_STEPS), MAX_STEPS)


def options_of(world: World, settings: Mapping[str, Value]) -> RunOptions:
    """Options from single settings: those of a run, and those of its motion model.

    Raises:
        InvalidParameter: If a name or a value is unknown or out of range.
    """
    own = {name: value for name, value in settings.items() if name in ("motion", "steps", "time_step", "seed")}
    rest = {name: value for name, value in settings.items() if name not in own}
    time_step = own.get("time_step", DEFAULT_TIME_STEP)
    budget = step_budget(world, float(time_step)) if isinstance(time_step, int | float) else 1
    switches = switch_sets(str(own.get("motion", RunOptions.motion)), rest) if rest else {}
    return RunOptions(**{"steps": budget, **own}, **switches)  # type: ignore[arg-type]
