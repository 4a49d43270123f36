"""A controller that drives many robots at once, with NumPy. Edit it and try it with:

worldgen run w.grid --controller ./example.py:Example --picture run.png
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim import Commands, Observations


@dataclass(frozen=True)
class Example:
    """Heads for the target; after a bump, turns away and drives straight on for a while."""

    # How far to turn after a bump, rad, counter-clockwise.
    turn: float = 1.5

    # Steps to drive straight on after a turn, before heading for the target again.
    patience: int = 20

    # The observations that act_many() reads. The others are nan, and cost no time.
    senses = ("bump", "heading", "target_heading", "time_step", "top_speed")

    def reset(self) -> tuple[float, ...]:
        """Return each robot's memory at the start of a run: its steps left to drive straight on."""
        return (0.0,)

    def act_many(
        self, observation: Observations, memory: npt.NDArray[np.float64]
    ) -> tuple[Commands, npt.NDArray[np.float64]]:
        """Return the commands for the next step of n robots, and their new memories.

        Each field of the observation is an array (n,), except ``beams``, which is (n, beams). The
        memory is an array (n, 1). Row i belongs to robot i and must depend on nothing but row i.
        ``sim.simulate_many`` runs a thousand robots at once; a single robot has one row.
        """
        bump = observation.bump
        waiting = memory[:, 0]

        # After a bump turn away, then drive straight on for some steps, else head for the target.
        ahead = _shortest(observation.target_heading - observation.heading)
        turn = np.where(bump, self.turn, np.where(waiting > 0.0, 0.0, ahead))
        waiting = np.where(bump, float(self.patience), np.maximum(waiting - 1.0, 0.0))

        # A turn rate of turn / time_step completes the turn within this step.
        commands = Commands(speed=observation.top_speed, turn_rate=turn / observation.time_step)
        return commands, waiting[:, np.newaxis]


def _shortest(turn: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return equivalent turns of at most half a circle, rad."""
    return (turn + math.pi) % (2 * math.pi) - math.pi
