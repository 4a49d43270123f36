"""Pack a world as the page draws it, in cells."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzz.player.streams import bits, numbers
from worldgen.lattice import UNIT
from worldgen.world import Cut, Witness, World

__all__ = ["MOST_CELLS", "drawn_certificate", "drawn_world"]

MOST_CELLS = 1 << 22  # of a world that can be drawn; 700 kB in the page


def drawn_world(world: World) -> dict[str, Any] | None:
    """Return a world's cells, events, start, target and certificate; ``None`` if it is too large.

    Returns:
        ``cells`` as bits, row by row from the lowest y; ``start`` (x, y in cells, heading in rad)
        and ``target`` (x, y, radius in cells); ``events`` in columns, with times rounded to ms;
        ``witness`` in columns, ms and lattice units; ``cut``, a chain of cells.
    """
    if world.width * world.height > MOST_CELLS:
        return None
    side = world.cell_size
    line = world.timeline
    return {
        "width": world.width,
        "height": world.height,
        "cell": side,
        "radius": world.robot_radius / side,
        "cells": bits(world.walls),
        "start": [world.start.x / side, world.start.y / side, world.start.heading],
        "target": [world.target.x / side, world.target.y / side, world.target.radius / side],
        "events": {
            "ms": numbers(np.rint(line.times * 1000.0)),
            "ix": numbers(line.ix),
            "iy": numbers(line.iy),
            "state": numbers(line.states),
        }
        if world.is_dynamic
        else None,
        **drawn_certificate(world),
    }


def drawn_certificate(world: World) -> dict[str, Any]:
    """Return a world's witness in columns, ms and lattice units, or its cut, or nothing."""
    proof = world.certificate
    if isinstance(proof, Witness):
        across, up = (np.rint(values / world.cell_size * UNIT) for values in (proof.x, proof.y))
        return {
            "witness": {
                "ms": numbers(np.rint(proof.times * 1000.0)),
                "x": numbers(across),
                "y": numbers(up),
            }
        }
    if isinstance(proof, Cut):
        return {"cut": proof.cells.tolist()}
    return {}
