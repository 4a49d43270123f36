"""Measure how fast reachability is decided for footprints, and how often it stays undecided.

``python -m benchmarks.bodies`` prints tables; ``--json`` prints one object. Times are milliseconds of
processor time on one core, with the proof; the checker's time is measured apart.

``families``: worlds of 30 x 30 and of 60 x 60 cells. The bodies are rectangles with proportions from
0.62 x 0.9 to 1 x 7. Each is scaled so that its inner disc is smaller and its outer disc is larger than
the disc for which the family made the world. Worlds that one of these discs decides are not counted, nor
are those in which the body overlaps a wall at the start at each of eight headings.

``tight``: bends and straight aisles with a body from 0.95 to 1.05 of the size that just fits, which is
known in closed form. In a bend of two aisles of width g, the longest rectangle of width w has the length
2 (sqrt(2) g - w); in a straight aisle it is as wide as the aisle. Aisles have walls on borders of cells,
and bodies of different shapes.

``cars``: the disc's own worlds of these families, for cars whose turning circle has a radius of 1.5 to 8 of
the disc's radii.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import click
import numpy as np

from worldgen import generate
from worldgen.errors import WorldgenError
from worldgen.reach import REACHABLE, UNDECIDED, check_certificate, decide
from worldgen.reach.check.car_confinement import check_car_confinement
from worldgen.reach.decision import CarConfinement
from worldgen.robot import Corner, Drive, Pose, Robot, Target
from worldgen.world import Cut, Witness, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--worlds", "1", "--shares", "0.98,1.02", "--sides", "30")

FAMILIES = ("maze", "rooms", "cave", "forest", "rubble", "corridor", "trap", "warehouse")
SHARES = (0.95, 0.98, 0.99, 0.995, 0.999, 1.001, 1.005, 1.01, 1.02, 1.05)
# Widths of bodies, as shares of the radius of a disc that gets through, and lengths as shares of widths.
SHAPES = ((1.7, 0.9 / 0.62), (1.95, 0.9 / 0.62), (1.2, 3.5), (0.8, 7.0))
# Turning radii of cars, as shares of their discs' radii.
TURNING = (1.5, 4.0, 8.0)
# Cells, and the side of one, m.
_SIZE = 0.1


def rectangle(length: float, width: float, ahead: float = 0.0) -> tuple[Corner, ...]:
    """Return the corners of a rectangle whose middle is ``ahead`` of its axle, m."""
    a = length / 2
    b = width / 2
    return ((ahead - a, -b), (ahead + a, -b), (ahead + a, b), (ahead - a, b))


def family_worlds(name: str, side: int, count: int) -> Iterator[World]:
    """Yield worlds of a family with bodies that no disc decides."""
    for seed in range(count):
        world = generate(name, seed, size=side)
        if not isinstance(world.certificate, Witness):
            continue
        # The half width is below the disc's radius, and the half diagonal above.
        wide, aspect = SHAPES[seed % len(SHAPES)]
        width = wide * world.certificate.clearance
        robot = replace(world.robots[0], footprint=rectangle(aspect * width, width))
        for eighth in range(8):
            posed = World(
                world.walls,
                robots=[replace(robot, start=replace(robot.start, heading=eighth * math.pi / 4))],
                cell_size=world.cell_size,
                timeline=world.timeline,
            )
            # A cut of one box says that the start is covered; without headings, a disc decides.
            proof = decide(posed).certificate
            boxes = getattr(proof, "boxes", None)
            if boxes is not None and len(boxes) == 1:
                continue
            around = decide(posed, radius=posed.robot_radius, certificate=False)
            if boxes is not None or (around.result != REACHABLE and not isinstance(proof, Cut)):
                yield posed
            break


def _world(
    free: list[tuple[float, ...]], start: Pose, target: Target, body: tuple[Corner, ...]
) -> World:
    height, width = (round(max(box[k] for box in free) / _SIZE) + 2 for k in (3, 2))
    walls = np.ones((height, width), np.bool_)
    for box in free:
        left, low, right, high = (round(value / _SIZE) for value in box)
        walls[low:high, left:right] = False
    return World(walls, robots=[Robot(start, target, footprint=body)])


def bend(gap: float, width: float, share: float) -> World:
    """Return a bend, and a rectangle that is ``share`` of the longest that gets around it."""
    length = round(share * 2 * (math.sqrt(2) * gap - width), 5)
    reach = math.hypot(length, width) / 2
    far = round(2.0 + 2 * reach + 2 * gap, 1)
    free = [(0.5, 0.5, far, 0.5 + gap), (far - gap, 0.5, far, far)]
    start = Pose(round(0.6 + reach, 3), 0.5 + gap / 2)
    target = Target(far - gap / 2, round(far - reach - 0.3, 3), 0.2)
    return _world(free, start, target, rectangle(length, width))


def aisle(gap: float, length: float, share: float) -> World:
    """Return a straight aisle, and a rectangle ``share`` as wide, with its axle near its rear."""
    side = 2.6 + gap + length
    middle = 0.2 + side / 2
    low = round(middle - gap / 2, 1)
    left = 0.2 + side
    free = [
        (0.2, 0.2, left, 0.2 + side),
        (left + 3.0, 0.2, left + 3.0 + side, 0.2 + side),
        (left - 0.5, low, left + 3.5, low + gap),
    ]
    body = rectangle(length, round(share * gap, 5), 0.4 * length)
    start = Pose(0.2 + side / 2, low + gap / 2, 0.3)
    return _world(free, start, Target(left + 3.0 + side / 2, low + gap / 2, 0.2), body)


def tight_worlds(share: float) -> Iterator[World]:
    """Yield bends and aisles."""
    for gap in (0.6, 1.0, 1.4):
        for part in (0.2, 0.4, 0.6, 0.778):
            yield bend(gap, part * gap, share)
            yield aisle(gap, round((1.1 + part) * gap, 3), share)


def car_worlds(turning: float, reverse: bool, count: int) -> Iterator[World]:
    """Yield worlds of the families with a car; its turning radius is in radii of its disc."""
    for name in FAMILIES:
        for seed in range(count):
            world = generate(name, seed)
            drive = Drive(turning * world.robot_radius, reverse)
            yield World(
                world.walls,
                robots=[replace(world.robots[0], drive=drive)],
                cell_size=world.cell_size,
                timeline=world.timeline,
            )


def measure(worlds: Iterator[World]) -> dict[str, Any]:
    """Decide worlds, check their proofs, and return counts and times, ms."""
    results: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    decided = []
    checked = []
    for world in worlds:
        begin = time.process_time()
        decision = decide(world)
        decided.append(1000 * (time.process_time() - begin))
        results[decision.result] += 1
        proof = decision.certificate
        confinement = decision.confinement
        begin = time.process_time()
        if proof is not None:
            report = check_certificate(world, proof)
        elif isinstance(confinement, CarConfinement):
            report = check_car_confinement(world, confinement)
        else:
            continue
        checked.append(1000 * (time.process_time() - begin))
        if not report.valid:
            raise WorldgenError("invalid-proof", report.reason)
        boxes = getattr(proof, "boxes", None)
        cut = "chain" if boxes is None else "boxes"
        other = "confinement" if proof is None else cut
        kinds["witness" if isinstance(proof, Witness) else other] += 1
    return {
        "worlds": sum(results.values()),
        "results": dict(sorted(results.items())),
        "proofs": dict(sorted(kinds.items())),
        "undecided": results[UNDECIDED] / max(1, sum(results.values())),
        "median": statistics.median(decided) if decided else None,
        "most": max(decided, default=None),
        "check": statistics.median(checked) if checked else None,
    }


def _line(name: str, one: dict[str, Any]) -> str:
    if not one["worlds"]:
        return f"{name:16}      0 worlds"
    results = ", ".join(f"{count} {result}" for result, count in one["results"].items())
    check = "" if one["check"] is None else f"{one['check']:9.1f}"
    return (
        f"{name:16} {one['worlds']:6} {one['median']:9.1f} {one['most']:9.1f} {check:>9} "
        f"{100 * one['undecided']:8.1f} %  {results}"
    )


def main() -> None:
    """Run all and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--worlds", type=int, default=20, help="worlds of a family (default 20)")
    parser.add_argument("--sides", default="30,60", help="cells a side (default 30,60)")
    parser.add_argument("--shares", default=",".join(map(str, SHARES)), help="of what fits")
    arguments = parser.parse_args()
    sides = [int(side) for side in arguments.sides.split(",")]
    shares = [float(share) for share in arguments.shares.split(",")]
    families = {
        f"{name} {side}": measure(family_worlds(name, side, arguments.worlds))
        for side in sides
        for name in FAMILIES
    }
    tight = {f"{share:g} of what fits": measure(tight_worlds(share)) for share in shares}
    cars = {
        f"{'both ways' if reverse else 'forward'}, {turning:g} r": measure(
            car_worlds(turning, reverse, arguments.worlds)
        )
        for reverse in (False, True)
        for turning in TURNING
    }
    if arguments.json:
        click.echo(json.dumps({"families": families, "tight": tight, "cars": cars}))
        return
    heads = (
        f"{'':16} {'worlds':>6} {'median ms':>9} {'most ms':>9} {'check ms':>9} {'undecided':>10}"
    )
    rows = [_line(name, one) for name, one in (families | tight | cars).items()]
    click.echo("\n".join([heads, *rows]))


if __name__ == "__main__":
    main()
