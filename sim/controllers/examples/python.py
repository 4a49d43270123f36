"""A controller as a Python class. Edit it and try it with:

worldgen run w.grid --controller ./example.py:Example --picture run.png
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import math
from dataclasses import dataclass

from sim import Command, Observation


@dataclass(frozen=True)
class Example:
    """Heads for the target; after a bump, turns away and drives straight on for a while."""

    # How far to turn after a bump, rad, counter-clockwise.
    turn: float = 1.5

    # Steps to drive straight on after a turn, before heading for the target again.
    patience: int = 20

    def reset(self) -> tuple[float, ...]:
        """Return the memory at the start of a run: the steps left to drive straight on."""
        return (0.0,)

    def act(
        self, observation: Observation, memory: tuple[float, ...]
    ) -> tuple[Command, tuple[float, ...]]:
        """Return the command for the next step, and the new memory.

        Keep all state in the memory, which must not change its length. State in attributes of self
        is invisible to the simulator, which could then no longer prove that the robot loops.
        """
        (waiting,) = memory
        # After a bump, turn away, and then drive straight on for some steps.
        if observation.bump:
            turn = self.turn
            waiting = float(self.patience)
        elif waiting > 0.0:
            turn = 0.0
            waiting = waiting - 1.0
        else:
            turn = _shortest(observation.target_heading - observation.heading)

        # A turn rate of turn / time_step completes the turn within this step.
        command = Command(speed=observation.top_speed, turn_rate=turn / observation.time_step)
        return command, (waiting,)


def _shortest(turn: float) -> float:
    """Return an equivalent turn of at most half a circle, rad."""
    return (turn + math.pi) % (2 * math.pi) - math.pi
