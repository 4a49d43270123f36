"""A controller that drives many robots at once, with NumPy. Try it, change it, try it again:

worldgen run w.grid --controller ./example.py:Example --trail run.png
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim import Commands, Observations


@dataclass(frozen=True)
class Example:
    """Drives to the target; after a bump turns away and drives straight on for a while."""

    turn: float = 1.5  # rad, counter-clockwise, after each bump
    patience: int = 20  # steps for which it drives on before it looks at the target again
    senses = (
        "bump",
        "heading",
        "target_heading",
        "time_step",
        "top_speed",
    )  # all others are nan, and cost no time

    def reset(self) -> tuple[float, ...]:
        """Memory of each robot at the start of a run: here the steps still to drive on."""
        return (0.0,)

    def act_many(
        self, observation: Observations, memory: npt.NDArray[np.float64]
    ) -> tuple[Commands, npt.NDArray[np.float64]]:
        """One step of n robots: what they see and their memories in, commands and new memories out.

        Each field of the observation is an array (n,), of the beams (n, beams); the memory is an
        array (n, 1). Row i is robot i, and must depend on nothing but row i. ``sim.simulate_many``
        runs a thousand robots at once; one robot alone is an array with one row.
        """
        bump = observation.bump
        waiting = memory[:, 0]
        ahead = _shortest(observation.target_heading - observation.heading)
        turn = np.where(bump, self.turn, np.where(waiting > 0.0, 0.0, ahead))
        waiting = np.where(bump, float(self.patience), np.maximum(waiting - 1.0, 0.0))
        return Commands(
            speed=observation.top_speed, turn_rate=turn / observation.time_step
        ), waiting[:, np.newaxis]


def _shortest(turn: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The same turns, rad, at most half a turn either way."""
    return (turn + math.pi) % (2 * math.pi) - math.pi
