"""A robot that the user drives by hand: its commands come from the page, not from a controller."""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from sim.controllers.base import Command, Memory, Observation
from worldgen.errors import InvalidParameter

# Limit on the steps of a drive, which is simulated again from the start several times a second: 5
# minutes at 15 ms, half a second of work.
MOST_DRIVEN = 20_000
# rad/s; the fastest turn that a key can command.
_FASTEST_TURN = 20.0


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
    def of(cls, commands: Sequence[object]) -> HandDriven:
        """Return the robot for a message's commands.

        Args:
            commands: Lists of a number of steps, a share of the top speed, and a turn rate, rad/s.

        Raises:
            InvalidParameter: If one of them is not of this form, or they are too many.
        """
        rows = [_checked(command) for command in commands]
        ends = tuple(itertools.accumulate(steps for steps, _, _ in rows))
        if not ends or ends[-1] > MOST_DRIVEN:
            raise InvalidParameter(
                "out-of-range",
                "the drive has {count} steps",
                "drive for 1 to {most}",
                count=ends[-1] if ends else 0,
                most=MOST_DRIVEN,
            )
        return cls(ends, tuple(row[1] for row in rows), tuple(row[2] for row in rows))

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


def _is_within(number: object, most: float) -> bool:
    return isinstance(number, int | float) and not isinstance(number, bool) and abs(number) <= most


def _checked(command: object) -> tuple[int, float, float]:
    if isinstance(command, list) and len(command) == 3:
        steps, speed, turn_rate = command
        is_count = type(steps) is int and 1 <= steps <= MOST_DRIVEN
        if is_count and _is_within(speed, 1.0) and _is_within(turn_rate, _FASTEST_TURN):
            return steps, float(speed), float(turn_rate)
    raise InvalidParameter(
        "wrong-type",
        "each command must be a number of steps, a share of the top speed, and a turn rate",
        "send [steps, -1 to 1, up to {fastest:g} rad/s]",
        fastest=_FASTEST_TURN,
    )
