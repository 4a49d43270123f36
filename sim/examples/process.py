#!/usr/bin/env python3
"""A controller as a program of its own, in any language. Try it, change it, try it again:

worldgen run w.grid --controller cmd:./example.py --trail run.png

It reads lines of JSON and answers each observation with one line, the command, within a second.
What it writes to stderr is kept and shown if it fails. docs/controllers.md has the whole protocol.
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import json
import math
import sys
from typing import Any

TURN = 1.5  # rad, counter-clockwise, after each bump
PATIENCE = 20  # steps for which it drives on before it looks at the target again


class Robot:
    """Drives to the target; after a bump turns away and drives straight on for a while."""

    def __init__(self, reset: dict[str, Any]) -> None:
        # s, m/s; "radius", m, is there, too
        self.time_step = reset["time_step"]
        self.top_speed = reset["top_speed"]
        self.waiting = 0  # steps still to drive on

    def act(self, observation: dict[str, Any]) -> dict[str, Any]:
        """One step: what the robot sees in, the command out."""
        if observation["bump"]:
            turn = TURN
            self.waiting = PATIENCE
        elif self.waiting > 0:
            turn = 0.0
            self.waiting = self.waiting - 1
        else:
            turn = observation["target_heading"] - observation["heading"]
            turn = (turn + math.pi) % (2 * math.pi) - math.pi
        return {"speed": self.top_speed, "turn_rate": turn / self.time_step}


def main() -> None:
    """Serves one episode after another, until there is nothing more to read."""
    robot = None
    for line in sys.stdin:
        message = json.loads(line)
        if "reset" in message:  # a new episode: all memory begins afresh, and nothing is answered
            if message["worldgen"] != 1:
                sys.exit(
                    f"this program speaks version 1 of the protocol, not {message['worldgen']}"
                )
            robot = Robot(message["reset"])
        elif robot is not None:
            sys.stdout.write(json.dumps(robot.act(message)) + "\n")
            sys.stdout.flush()  # or the line waits in a buffer, and the verdict is hang


if __name__ == "__main__":
    main()
