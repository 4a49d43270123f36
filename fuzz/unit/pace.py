"""The time that a controller's own code takes, on which the size of a campaign's work depends."""

from __future__ import annotations

from dataclasses import dataclass

from sim.controllers import CompiledController, Controller, ProcessController

# Seconds of a step, and of beginning a run, from which a controller counts as slow.
_SLOW_STEP = 5e-5
_SLOW_RESET = 5e-3


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
        return self.step >= _SLOW_STEP or self.reset >= _SLOW_RESET


def usual_pace(controller: Controller) -> Pace:
    """Return the pace that is assumed of a controller of a kind that nobody has measured."""
    if isinstance(controller, CompiledController):
        return Pace(1e-6) if controller.slow else Pace(1e-7)
    if isinstance(controller, ProcessController):
        return Pace(4e-5, reset=4e-3)
    return Pace(2.4e-6)
