#!/usr/bin/env python3
"""A controller as a separate program; any language will do. Edit it and try it with:

worldgen run w.grid --controller cmd:./example.py --picture run.png

It reads lines of JSON and must answer each observation within a second, with one line that holds
the command. Its stderr is kept, and shown if it fails. docs/reference/controllers.md describes the
protocol.
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import json
import math
import sys
from typing import Any

# How far to turn after a bump, rad, counter-clockwise.
TURN = 1.5

# Steps to drive straight on after a turn, before heading for the target again.
PATIENCE = 20


class Robot:
    """Heads for the target; after a bump, turns away and drives straight on for a while."""

    def __init__(self, reset: dict[str, Any]) -> None:
        # The reset also has "radius", the robot's, in m.
        self.time_step = reset["time_step"]  # s
        self.top_speed = reset["top_speed"]  # m/s
        self.waiting = 0  # steps left to drive straight on

    def act(self, observation: dict[str, Any]) -> dict[str, Any]:
        """Return the command for the next step, given what the robot observes."""
        # After a bump, turn away, and then drive straight on for some steps.
        if observation["bump"]:
            turn = TURN
            self.waiting = PATIENCE
        elif self.waiting > 0:
            turn = 0.0
            self.waiting = self.waiting - 1
        else:
            # Turn towards the target, the shorter way around.
            turn = observation["target_heading"] - observation["heading"]
            turn = (turn + math.pi) % (2 * math.pi) - math.pi
        # A turn rate of turn / time_step completes the turn within this step.
        return {"speed": self.top_speed, "turn_rate": turn / self.time_step}


def main() -> None:
    """Serve one episode after another until the input ends."""
    robot = None
    for line in sys.stdin:
        message = json.loads(line)
        if "reset" in message:
            # A new episode begins: forget everything, and do not answer this line.
            if message["worldgen"] != 1:
                sys.exit(
                    f"this program speaks version 1 of the protocol, not {message['worldgen']}"
                )
            robot = Robot(message["reset"])
        elif robot is not None:
            sys.stdout.write(json.dumps(robot.act(message)) + "\n")
            # Without a flush the line stays in a buffer, and the verdict is a hang.
            sys.stdout.flush()


if __name__ == "__main__":
    main()
