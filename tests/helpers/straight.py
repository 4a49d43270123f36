"""A controller that drives straight to its target and never gives way."""

from __future__ import annotations

from dataclasses import dataclass

from sim.controllers.base import Command, Memory, Observation


@dataclass(frozen=True)
class Straight:
    """Turn to the target and drive, without any memory."""

    senses = ("target_heading",)

    def reset(self) -> Memory:
        """Begin without memory."""
        return ()

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Drive to the target at top speed."""
        turn = observation.target_heading - observation.heading
        return Command(observation.top_speed, turn / observation.time_step), memory
