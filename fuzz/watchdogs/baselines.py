"""Watchdogs as Nav2 has them, with its parameters and their defaults.

Source: Steve Macenski et al., Nav2, ``nav2_controller`` (SimpleProgressChecker,
    PoseProgressChecker) and ``dwb_critics`` (OscillationCritic). Parameters and rules are facts of
    their documentation; the code is ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim.controllers.base import Observation
from worldgen.parameters.bounds import check_at_least


@dataclass
class SimpleProgressChecker:
    """Raises the alarm if the robot stays near one place for too long.

    Args:
        required_movement_radius: m that count as progress.
        movement_time_allowance: s in which it has to be made.
    """

    required_movement_radius: float = 0.5
    movement_time_allowance: float = 10.0

    def __post_init__(self) -> None:
        """Reject a number below 0."""
        for name, value in vars(self).items():
            check_at_least(name, value, 0.0)

    def reset(self) -> None:
        """Forget where the robot was."""
        self._since: Observation | None = None

    def step(self, observation: Observation) -> bool:
        """Return True if no progress was made in the time allowed."""
        if self._since is None or self._has_moved(self._since, observation):
            self._since = observation
        return observation.time - self._since.time > self.movement_time_allowance

    def _has_moved(self, before: Observation, now: Observation) -> bool:
        return math.hypot(now.x - before.x, now.y - before.y) > self.required_movement_radius


@dataclass
class PoseProgressChecker(SimpleProgressChecker):
    """Like the simple checker, but turning counts as progress, too.

    Args:
        required_movement_radius: m that count as progress.
        movement_time_allowance: s in which it has to be made.
        required_movement_angle: rad that count as progress.
    """

    required_movement_angle: float = 0.5

    def _has_moved(self, before: Observation, now: Observation) -> bool:
        turned = abs(math.remainder(now.heading - before.heading, math.tau))
        return super()._has_moved(before, now) or turned > self.required_movement_angle


@dataclass
class OscillationCritic:
    """Raises the alarm if the robot drives or turns one way, the other way, and back again.

    What it did before is forgotten once it is far enough from where the first change of sign was.

    Args:
        oscillation_reset_dist: m from there after which it is.
        oscillation_reset_angle: rad from there after which it is.
        x_only_threshold: m/s, and rad/s, below which a speed has no sign. Nav2 does not turn a
            robot that is faster than that; ours may do both.
    """

    oscillation_reset_dist: float = 0.05
    oscillation_reset_angle: float = 0.2
    x_only_threshold: float = 0.05

    def __post_init__(self) -> None:
        """Reject a number below 0."""
        for name, value in vars(self).items():
            check_at_least(name, value, 0.0)

    def reset(self) -> None:
        """Forget what the robot did."""
        self._before: Observation | None = None
        self._signs = [0, 0]
        self._changes = [0, 0]
        self._since: Observation | None = None

    def step(self, observation: Observation) -> bool:
        """Return True if a speed has changed its sign twice near one place."""
        before, self._before = self._before, observation
        if before is None:
            return False
        dx, dy = observation.x - before.x, observation.y - before.y
        ahead = dx * math.cos(before.heading) + dy * math.sin(before.heading)
        turned = math.remainder(observation.heading - before.heading, math.tau)
        if self._since is not None and self._is_away_from(self._since, observation):
            self._since, self._changes = None, [0, 0]
        least = self.x_only_threshold * observation.time_step
        for n, value in enumerate((ahead, turned)):
            sign = (value > least) - (value < -least)
            if sign and sign == -self._signs[n]:
                self._changes[n] += 1
                self._since = self._since or before
            self._signs[n] = sign or self._signs[n]
        return max(self._changes) >= 2

    def _is_away_from(self, place: Observation, now: Observation) -> bool:
        turned = abs(math.remainder(now.heading - place.heading, math.tau))
        moved = math.hypot(now.x - place.x, now.y - place.y)
        return moved > self.oscillation_reset_dist or turned > self.oscillation_reset_angle
