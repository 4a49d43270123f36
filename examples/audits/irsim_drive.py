"""Drive the robot of an exported world in IR-SIM and record it for ``worldgen audit``.

python irsim_drive.py wall.yaml --speed 12 --out recorded.csv

It only needs ir-sim. The robot turns to the next point of its path, then drives there; the path
ends at the world's target. It prints one JSON object: versions, samples, and how many times IR-SIM
reported a collision.
"""

import argparse
import csv
import json
import math
import os
import sys
from importlib.metadata import version
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "Agg")

import irsim
import numpy as np


def drive(file, via, speed, steps):
    """Return the trajectory as rows t, x, y, heading, and the steps with a collision.

    Also return whether the robot arrived.
    """
    env = irsim.make(str(file), display=False, save_ani=False, log_level="ERROR")
    step = env.step_time
    robot = env.robot
    way = [*via, (float(robot.goal[0, 0]), float(robot.goal[1, 0]))]
    rows = []
    collisions = 0
    for k in range(steps + 1):
        x, y, heading = (float(value) for value in robot.state[:3, 0])
        rows.append((k * step, x, y, heading))
        # Drop every waypoint that was reached, but keep the goal.
        while len(way) > 1 and math.dist((x, y), way[0]) < max(0.05, 0.5 * speed * step):
            del way[0]
        if math.dist((x, y), way[0]) < max(0.05, 0.5 * speed * step):
            break
        # Turn on the spot first; a turn while driving would leave the straight path.
        turn = math.remainder(math.atan2(way[0][1] - y, way[0][0] - x) - heading, 2.0 * math.pi)
        ahead = speed if abs(turn) < 0.1 else 0.0
        env.step(np.array([[ahead], [max(-1.0, min(1.0, turn / step))]]))
        collisions += bool(robot.collision)
    env.end()
    return (
        rows,
        collisions,
        len(way) == 1 and math.dist(rows[-1][1:3], way[0]) < max(0.05, 0.5 * speed * step),
    )


def main():
    """Drive, write, and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("world", help="what `worldgen export --to irsim` wrote")
    parser.add_argument(
        "--via", nargs="*", default=[], metavar="X,Y", help="places on the way to the target, m"
    )
    parser.add_argument("--speed", type=float, default=1.0, help="m/s")
    parser.add_argument("--steps", type=int, default=500, help="at most")
    parser.add_argument("--out", required=True, help="CSV: t,x,y,heading")
    given = parser.parse_args()
    via = [tuple(float(number) for number in place.split(",")) for place in given.via]
    rows, collisions, arrived = drive(given.world, via, given.speed, given.steps)
    # The audit reads times, positions and headings from this table.
    with Path(given.out).open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(("t", "x", "y", "heading"))
        table.writerows([f"{value:.9g}" for value in row] for row in rows)
    said = {"simulator": f"ir-sim {version('ir-sim')}", "samples": len(rows), "arrived": arrived}
    sys.stdout.write(json.dumps(said | {"collisions": collisions}) + "\n")


if __name__ == "__main__":
    main()
