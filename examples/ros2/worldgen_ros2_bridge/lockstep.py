"""The process protocol, and one exchange with the robot's driver per step.

It knows neither rclpy nor worldgen. ``docs/reference/controllers.md`` is the protocol's normative
text. A step consists of sending what the robot senses, waiting for a command, and answering.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Protocol, TextIO

from worldgen_ros2_bridge.messages import (
    Grid,
    Pose,
    Scan,
    Twist,
    composed,
    inverse,
    pose_in_map,
    scan_of,
    twist_between,
)

VERSION = 1
STILL = Twist()
# Seconds of simulated time between two episodes; time never goes back, because tf2 would forget
# everything.
_PAUSE = 1.0


@dataclass(frozen=True)
class Settings:
    """The options of the command line.

    Args:
        beam_range: The run's ``+beam_range``, m.
        beam_field: The run's ``+beam_field``, rad.
        timeout: Real time, s, to wait for a command in each step.
        keep: Simulated time, s, for which a command holds if no other comes; then the robot stops,
            as drivers do.
    """

    beam_range: float = 5.0
    beam_field: float = 0.0
    timeout: float = 0.2
    keep: float = 0.5


@dataclass(frozen=True)
class Situation:
    """The data published in a step.

    Args:
        time: Simulated time, s; it never goes back.
        base: Pose of the robot's base in ``map``.
        odometry: The pose measured by the wheels, in ``odom``.
        odom_in_map: Pose of ``odom`` in ``map``, as a perfect localisation would publish it.
        twist: Velocity measured by the wheels.
        scan: None if the robot has no beams.
        target: Target in ``map``, with the heading that the goal asks for; 0 if it asks for none.
        signal: Strength of the target's signal, 0 to 1.
        signal_heading: Heading towards the strongest signal, rad, in ``map``.
        bump: Whether a wall stopped or bent the last move.
    """

    time: float
    base: Pose
    odometry: Pose
    odom_in_map: Pose
    twist: Twist
    scan: Scan | None
    target: Pose
    signal: float
    signal_heading: float
    bump: bool


class Ports(Protocol):
    """The driver's side: ROS in use, a list in tests."""

    def begin(self, grid: Grid | None) -> None:
        """Begin an episode: publish the map, and ask the driver to forget the last episode."""
        ...

    def publish(self, situation: Situation) -> None:
        """Publish a step."""
        ...

    def wait(self, seconds: float) -> Twist | None:
        """Return the newest command since the last :meth:`publish`, waiting for one if necessary.

        Return None if none comes.
        """
        ...


@dataclass
class _Episode:
    """The state of the episode in progress."""

    # Simulated time at which it began, s.
    start: float
    # Odometry of the last step.
    before: Pose | None = None
    command: Twist = STILL
    # Simulated seconds since the last command.
    silent: float = math.inf


class Bridge:
    """Answers the protocol's lines.

    Args:
        ports: The driver.
        grid: The map to publish, if there is one.
        settings: See :class:`Settings`.
    """

    def __init__(
        self, ports: Ports, grid: Grid | None = None, settings: Settings = Settings()
    ) -> None:
        self._ports = ports
        self._grid = grid
        self._settings = settings
        self._time = 0.0
        self._episode = _Episode(0.0)

    def answer(self, line: str) -> str | None:
        """Return the answer to a line: nothing to a reset, a command to an observation.

        Raises:
            ValueError: If the line has an unknown version.
        """
        message: dict[str, Any] = json.loads(line)
        if "reset" in message:
            if message.get("worldgen") != VERSION:
                raise ValueError(
                    f"this bridge speaks version {VERSION} of the protocol, not "
                    f"{message.get('worldgen')}"
                )
            self._episode = _Episode(self._time + _PAUSE)
            self._ports.begin(self._grid)
            return None
        command = self._step(message)
        return json.dumps({"speed": command.speed, "turn_rate": command.turn_rate})

    def _step(self, seen: dict[str, Any]) -> Twist:
        episode = self._episode
        settings = self._settings
        situation = _situation(seen, episode, self._grid, settings)
        self._time = situation.time
        self._ports.publish(situation)
        said = self._ports.wait(settings.timeout)
        if said is not None:
            # A command arrived: it stays valid until the next one, or until it is too old.
            episode.command = said
            episode.silent = 0.0
        else:
            episode.silent += seen["time_step"]
            if episode.silent > settings.keep:
                episode.command = STILL
        episode.before = situation.odometry
        return episode.command


def _situation(
    seen: dict[str, Any], episode: _Episode, grid: Grid | None, settings: Settings
) -> Situation:
    true = Pose(seen["x"], seen["y"], seen["heading"])
    base = pose_in_map(true, grid)
    odometry = Pose(seen["odometry_x"], seen["odometry_y"], seen["odometry_heading"])
    way = seen["target_distance"]
    target = Pose(
        base.x + way * math.cos(seen["target_heading"]),
        base.y + way * math.sin(seen["target_heading"]),
        seen.get("goal_heading") or 0.0,
    )
    return Situation(
        time=episode.start + seen["time"],
        base=base,
        odometry=odometry,
        odom_in_map=composed(base, inverse(odometry)),
        twist=twist_between(episode.before, odometry, seen["time_step"])
        if episode.before
        else STILL,
        scan=scan_of(seen["beams"], settings.beam_range, settings.beam_field)
        if seen["beams"]
        else None,
        target=target,
        signal=seen["signal"],
        signal_heading=seen["signal_heading"],
        bump=seen["bump"],
    )


def serve(bridge: Bridge, lines: Iterable[str], answers: TextIO) -> None:
    """Answer line by line until there are no more."""
    for line in lines:
        said = bridge.answer(line)
        if said is not None:
            answers.write(said + "\n")
            answers.flush()
