"""A controller as a Python class. Try it, change it, try it again:

worldgen run w.grid --controller ./example.py:Example --trail run.png
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import math
from dataclasses import dataclass

from sim import Command, Observation


@dataclass(frozen=True)
class Example:
    """Drives to the target; after a bump turns away and drives straight on for a while."""

    turn: float = 1.5  # rad, counter-clockwise, after each bump
    patience: int = 20  # steps for which it drives on before it looks at the target again

    def reset(self) -> tuple[float, ...]:
        """Memory at the start of a run: here the steps still to drive on."""
        return (0.0,)

    def act(
        self, observation: Observation, memory: tuple[float, ...]
    ) -> tuple[Command, tuple[float, ...]]:
        """One step: what the robot sees and its memory in, command and new memory out.

        All state is in the memory, whose length stays the same; an attribute of self that changes
        would be state too, and then no loop could be proved.
        """
        (waiting,) = memory
        if observation.bump:
            turn = self.turn
            waiting = float(self.patience)
        elif waiting > 0.0:
            turn = 0.0
            waiting = waiting - 1.0
        else:
            turn = _shortest(observation.target_heading - observation.heading)
        return Command(speed=observation.top_speed, turn_rate=turn / observation.time_step), (
            waiting,
        )


def _shortest(turn: float) -> float:
    """The same turn, rad, at most half a turn either way."""
    return (turn + math.pi) % (2 * math.pi) - math.pi
