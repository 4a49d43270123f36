"""Pack a world as the page draws it, in cells."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzz.player.streams import bits, numbers
from worldgen.lattice import UNIT
from worldgen.render.certificate_parts import blocked_share
from worldgen.world import Cut, JointWitness, Robot, Witness, World

MOST_CELLS = 1 << 22  # limit on a world that can be drawn; 700 kB in the page


def drawn_world(world: World) -> dict[str, Any] | None:
    """Return a world's cells, events, start, target and certificate; ``None`` if it is too large.

    Returns:
        ``cells`` as bits, row by row from the lowest y; ``start`` (x, y in cells, heading in rad)
        and ``target`` (x, y, radius in cells); ``events`` in columns, with times rounded to ms;
        ``witness`` in columns, ms and parts of a cell, of which there are ``per_cell``; ``cut``, a
        chain of cells, or ``cut_poses``, bits of the places where the body fits in no heading and
        of those where it fits in some only, ``fineness`` of them along a cell. ``start``,
        ``target``, ``radius`` and ``witness`` are about the first robot, and so are ``footprint``,
        its corners in cells, and ``aim``, its goal's heading in rad, if it has them; ``others`` has
        the same for each of the others.
    """
    if world.width * world.height > MOST_CELLS:
        return None
    side = world.cell_size
    times, ix, iy, states = world.timeline.columns
    return {
        "width": world.width,
        "height": world.height,
        "cell": side,
        "radius": world.robot_radius / side,
        "cells": bits(world.walls),
        "start": [world.start.x / side, world.start.y / side, world.start.heading],
        "target": [world.target.x / side, world.target.y / side, world.target.radius / side],
        "events": {
            "ms": numbers(np.rint(times * 1000.0)),
            "ix": numbers(ix),
            "iy": numbers(iy),
            "state": numbers(states),
        }
        if world.is_dynamic
        else None,
        **drawn_certificate(world),
        **_drawn_kind(world.robots[0], side),
        "others": drawn_others(world),
    }


def drawn_others(world: World) -> list[dict[str, Any]]:
    """Return the start, target, radius and witness of each robot after the first."""
    side = world.cell_size
    proof = world.certificate
    found = []
    for number, robot in enumerate(world.robots[1:], start=1):
        start = robot.start
        target = robot.target
        path = proof.paths[number] if isinstance(proof, JointWitness) else None
        found.append(
            {
                "start": [start.x / side, start.y / side, start.heading],
                "target": [target.x / side, target.y / side, target.radius / side],
                "radius": robot.radius / side,
                "witness": None if path is None else _columns(path, side),
                **_drawn_kind(robot, side),
            }
        )
    return found


def _drawn_kind(robot: Robot, side: float) -> dict[str, Any]:
    """Return a robot's footprint in cells and its goal's heading, if it has them."""
    found: dict[str, Any] = {}
    if not robot.is_disc:
        found["footprint"] = [[x / side, y / side] for x, y in robot.footprint]
    if robot.target.heading is not None:
        found["aim"] = robot.target.heading
    if robot.waypoints:
        found["waypoints"] = [
            [goal.x / side, goal.y / side, goal.radius / side] for goal in robot.waypoints
        ]
    return found


def _columns(path: Witness, side: float) -> dict[str, Any]:
    """Return a witness in columns, ms and parts of a cell."""
    return {
        "ms": numbers(np.rint(path.times * 1000.0)),
        "x": numbers(np.rint(path.x / side * UNIT)),
        "y": numbers(np.rint(path.y / side * UNIT)),
        "per_cell": UNIT,
    }


def drawn_certificate(world: World) -> dict[str, Any]:
    """Return a world's witness in columns, ms and parts of a cell, or its cut, or None."""
    proof = world.certificate
    if isinstance(proof, JointWitness):
        return {"witness": _columns(proof.paths[0], world.cell_size)}
    if isinstance(proof, Witness):
        return {"witness": _columns(proof, world.cell_size)}
    if isinstance(proof, Cut) and proof.boxes is None:
        return {"cut": proof.cells.tolist()}
    if isinstance(proof, Cut):
        assert proof.boxes is not None
        shares = blocked_share(world, proof.boxes)
        places = {"all": bits(shares >= 1.0), "some": bits((shares > 0.0) & (shares < 1.0))}
        return {"cut_poses": places | {"fineness": shares.shape[1] // world.width}}
    return {}
