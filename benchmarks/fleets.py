"""Measure the cost of several robots: steps per second and robot, for 10 and 100 of them.

``python -m benchmarks.fleets`` prints a table; ``--json`` prints one object, with the ratio of the
costs per robot. All numbers are from one run, in processor time; the best of all rounds counts.

The halls have the same density: a robot of 0.07 m radius for each square metre, which drives at
1 m/s to the place of another one. A step is 15 ms.

The peers navground, pyrvo (van den Berg's RVO2) and pogema step the same robots, and only their own
step is measured. For pogema, the hall is a grid of 0.2 m and the moves are random. No peer has
verdicts or exact contact. An option such as ``--pyrvo PYTHON`` names the interpreter in which a peer
is installed, by default this one. A peer that is not installed is skipped.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable
from typing import Any

import click

from benchmarks.peer_scripts import add_peer_options, run_peer
from sim._core import lib
from sim.controllers import CONTROLLERS
from sim.fleet import FleetRun
from sim.fleet.core_calls import CoreFleet
from sim.options.run import options_of
from sim.runners.core_calls import CoreEpisode
from sim.runners.lattice import LatticeRun
from worldgen.random_streams import RandomStream
from worldgen.world import Pose, Robot, Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--rounds", "1")

CONTROLLER_NAMES = ("naive", "right-hand", "orca", "turn-right")
PEERS = ("navground", "pogema", "pyrvo")
COUNTS = (1, 10, 100)
STEPS = 300
STEP = 0.015
RADIUS = 0.07
SPEED = 1.0
# Distance between two places, m.
APART = 1.0


def hall_of(count: int) -> World:
    """Return a hall with so many robots, each of which wants to the place of another one."""
    # Places on a lattice that is as square as it can be without an empty place, so that the density
    # is the same for any number of robots.
    rows = next(rows for rows in range(math.isqrt(count), 0, -1) if count % rows == 0)
    columns = count // rows
    per_place = round(APART / 0.1)
    rng = RandomStream(count)
    spots = [((k % columns + 0.5) * APART, (k // columns + 0.5) * APART) for k in range(count)]
    # Each robot wants to where another one starts, so that many paths cross.
    order = list(range(count))
    rng.shuffle(order)
    robots = [
        Robot(
            Pose(*(round(value, 3) for value in spots[k]), rng.uniform(-3.0, 3.0)),
            Target(*(round(value + 0.2, 3) for value in spots[order[k]]), 0.05),
            RADIUS,
            SPEED,
        )
        for k in range(count)
    ]
    return World([[False] * (columns * per_place)] * (rows * per_place), robots=robots)


def _ours(name: str, count: int) -> Callable[[], tuple[float, float]]:
    world = hall_of(count)
    options = options_of(world, {"steps": STEPS})
    run = FleetRun(world, [CONTROLLERS.get(name)] * count, [options] * count)

    # Making the fleet is not part of what is timed.
    def once() -> tuple[float, float]:
        drivers = [one.driver() for one in run.runs]
        fleet = CoreFleet(run.runs, drivers, STEPS, lib.WG_SEEK_LOOP)
        begin = time.process_time()
        fleet.run_to_the_end()
        seconds = time.process_time() - begin
        return sum(int(member.report.steps) for member in fleet.members), seconds

    return once


def _alone(name: str) -> Callable[[], tuple[float, float]]:
    """Return the same robot and controller in a run for one robot."""
    world = hall_of(1)
    options = options_of(world, {"steps": STEPS})
    run = LatticeRun(world, CONTROLLERS.get(name), options)
    run.settings.steps = STEPS
    run.settings.find_loop = lib.WG_SEEK_LOOP

    def once() -> tuple[float, float]:
        episode = CoreEpisode(run.arena(), run.settings, run.driver())
        begin = time.process_time()
        episode.run_to_the_end()
        return int(episode.report.steps), time.process_time() - begin

    return once


def _hall(count: int) -> dict[str, Any]:
    """Return a hall in the form that the script for peers reads."""
    world = hall_of(count)
    return {
        "starts": [(robot.start.x, robot.start.y) for robot in world.robots],
        "targets": [(robot.target.x, robot.target.y) for robot in world.robots],
        "width": world.width * world.cell_size,
        "height": world.height * world.cell_size,
        "radius": RADIUS,
        "speed": SPEED,
        "step": STEP,
        "steps": STEPS,
    }


def _peer(name: str, python: str) -> dict[str, dict[int, float]]:
    """Return a peer's rates by case and number of robots; none if it is not installed."""
    halls = "\n".join(json.dumps(_hall(count)) for count in COUNTS)
    found = run_peer("crowds.py", name, python, halls)
    if found is None:
        return {}
    return {
        f"{name} {found['version']}: {case}": dict(zip(COUNTS, rates, strict=True))
        for case, rates in found["rates"].items()
    }


def measure(rounds: int = 5, pythons: dict[str, str] | None = None) -> dict[str, dict[str, float]]:
    """Return steps per second and robot, by case and by number of robots.

    ``ratio`` is the cost per robot of 100 robots, as a multiple of the cost per robot of 10.

    Args:
        rounds: The best of all counts.
        pythons: Interpreter of each peer; this one's if omitted.
    """
    cases = {name: {count: _ours(name, count) for count in COUNTS} for name in CONTROLLER_NAMES}
    cases |= {f"{name}, alone": {1: _alone(name)} for name in CONTROLLER_NAMES}
    best: dict[str, dict[int, float]] = {name: dict.fromkeys(cases[name], 0.0) for name in cases}
    for _ in range(rounds):
        for name, counts in cases.items():
            for count, once in counts.items():
                steps, seconds = once()
                best[name][count] = max(best[name][count], steps / max(seconds, 1e-9))
        # The peers take turns with our cases, so that other work on the machine affects all alike.
        for peer in PEERS:
            for name, rates in _peer(peer, (pythons or {}).get(peer, sys.executable)).items():
                known = best.setdefault(name, dict.fromkeys(rates, 0.0))
                for count, rate in rates.items():
                    known[count] = max(known[count], rate)
    return {
        name: {
            **{str(count): rate for count, rate in rates.items()},
            **({"ratio": rates[10] / rates[100]} if 100 in rates else {}),
        }
        for name, rates in best.items()
    }


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fleets", description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--rounds", type=int, default=5)
    add_peer_options(parser, PEERS)
    given = parser.parse_args()
    found = measure(given.rounds, {peer: getattr(given, peer) for peer in PEERS})
    if given.json:
        click.echo(json.dumps({"rates": found}))
        return
    click.echo(
        "robots' steps a second".ljust(32) + "".join(f"{n:>14}" for n in COUNTS) + "   100:10"
    )
    for name, rates in found.items():
        columns = "".join(f"{rates[str(n)]:>14,.0f}" for n in COUNTS if str(n) in rates)
        ratio = f"{rates['ratio']:>9.2f}" if "ratio" in rates else ""
        click.echo(f"{name:<32}{columns}{ratio}")
    for peer in PEERS:
        if not any(name.startswith(peer) for name in found):
            click.echo(f"not measured: {peer} is not installed")


if __name__ == "__main__":
    main()
