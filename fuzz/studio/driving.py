"""A robot that the user drives by hand: its commands come from the page, not from a controller."""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from fuzz.studio.requests.limits import MOST_DRIVEN
from sim.controllers.base import Command, Memory, Observation
from worldgen.errors import InvalidParameter


@dataclass(frozen=True)
class HandDriven:
    """Gives the commands of a script in order; its memory is the number of the step.

    Args:
        ends: For each command, the step before which it ends, in ascending order.
        speeds: Shares of the robot's top speed, -1 to 1.
        turn_rates: rad/s.
    """

    ends: tuple[int, ...]
    speeds: tuple[float, ...]
    turn_rates: tuple[float, ...]
    senses = ("top_speed",)

    @classmethod
    def of(cls, commands: Sequence[tuple[int, float, float]]) -> HandDriven:
        """Return the robot for commands: number of steps, share of the top speed, turn rate.

        Raises:
            InvalidParameter: If they have too many steps.
        """
        steps, speeds, turn_rates = zip(*commands, strict=True)
        ends = tuple(itertools.accumulate(steps))
        if ends[-1] > MOST_DRIVEN:
            raise InvalidParameter(
                "out-of-range",
                "the drive has {count} steps",
                "drive for 1 to {most}",
                count=ends[-1],
                most=MOST_DRIVEN,
            )
        return cls(ends, speeds, turn_rates)

    @property
    def steps(self) -> int:
        """Number of steps for which there are commands."""
        return self.ends[-1]

    def reset(self) -> Memory:
        """Return the number of the first step."""
        return (0.0,)

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command of this step; the robot stops when the commands run out."""
        (step,) = memory
        k = bisect_right(self.ends, int(step))
        if k == len(self.ends):
            return Command(), memory
        speed = self.speeds[k] * observation.top_speed
        return Command(speed, self.turn_rates[k]), (step + 1.0,)
