"""The time that a controller takes, on which the size of a campaign's work depends."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim.controllers import CompiledController, Controller, ProcessController, VectorController
from sim.controllers.answers import SLOW_STEP

# Seconds of beginning a run above which a controller counts as slow.
_SLOW_RESET = 5e-3
# Steps of a typical run in a search.
_STEPS = 300
# Seconds of a typical run, up to which a unit makes as many runs as with a compiled controller.
_QUICK_RUN = 1e-4
# Seconds of a typical run, up to which a unit makes an eighth of them: about a second of work.
_USUAL_RUN = 0.02
_EIGHTH = 8
# Seconds of a typical run above which the work on one failure is limited; a program's takes them.
_LIMITED_RUN = 0.01
# A busy machine measures a pace up to this many times too slow, plus these seconds for each step
# and each run. Below that, a measured pace counts as the usual one.
_NOISE = 4.0
_NOISE_OF_STEP = 1e-5
_NOISE_OF_RESET = 2e-3


@dataclass(frozen=True)
class Pace:
    """The time that a controller takes.

    Args:
        step: Seconds of a step.
        reset: Seconds to begin a run.
    """

    step: float
    reset: float = 0.0

    @property
    def is_slow(self) -> bool:
        """True if a run costs so much that worlds must be chosen with care."""
        return self.step > SLOW_STEP or self.reset > _SLOW_RESET

    @property
    def run(self) -> float:
        """Seconds of a typical run."""
        return self.reset + _STEPS * self.step

    def steps_in(self, seconds: float) -> float:
        """Return how many steps a piece of work may take; no limit if a run takes little.

        Without a time limit, the work that a slow controller or a program gets depends on its pace
        instead of the clock, so that the result depends only on the seed.
        """
        if self.is_slow:
            return seconds / self.step
        return seconds * _STEPS / self.run if self.run > _LIMITED_RUN else math.inf

    @property
    def slower(self) -> int:
        """Factor by which a unit does less work than with a fast compiled controller."""
        if self.run <= _QUICK_RUN:
            return 1
        return max(_EIGHTH, round(_EIGHTH * self.run / _USUAL_RUN))


def usual_pace(controller: Controller) -> Pace:
    """Return the pace that is assumed of a controller of a kind that nobody has measured."""
    if isinstance(controller, CompiledController):
        return Pace(8e-7) if controller.slow else Pace(1e-7)
    if isinstance(controller, ProcessController):
        return Pace(4e-5, reset=4e-3)
    if isinstance(controller, VectorController):
        return Pace(4e-7)
    return Pace(2.4e-6)


def measured_pace(controller: Controller, step: float, reset: float) -> Pace | None:
    """Return the pace to record for a measured controller; ``None`` if it is about the usual one.

    Args:
        controller: The controller.
        step: Seconds of a step.
        reset: Seconds to begin a run.
    """
    usual = usual_pace(controller)
    if (
        step <= _NOISE * usual.step + _NOISE_OF_STEP
        and reset <= _NOISE * usual.reset + _NOISE_OF_RESET
    ):
        return None
    return Pace(float(f"{step:.1e}"), float(f"{reset:.1e}"))
