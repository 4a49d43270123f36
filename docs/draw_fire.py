"""Draws the pictures of docs/reference/families.md: ``python docs/draw_fire.py``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from worldgen import generate
from worldgen.render import Panel, Trail, draw_sheet
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Value, Witness, World

PICTURES = Path(__file__).with_name("pictures")
SEED, SIZE = 3, 36

# What each strip of one world shows: its parameters, and its times in shares of the witness's.
STRIPS: dict[str, tuple[dict[str, Value], int]] = {
    "fire-strip": ({"over": "rooms", "margin": 1.0, "debris": 0.5, "ignite_at": "way"}, 7),
    "fire-race": (
        {"over": "rooms+plan=suite", "monotone": True, "margin": 1.0, "spread_cells": 600},
        SEED,
    ),
}
PANELS: list[dict[str, Value]] = [
    {"over": "maze+algorithm=eller+passage=3"},
    {"over": "forest", "wind": 0.8, "wind_to": 2, "spread_cells": 500},
    {"over": "cave", "ignite_at": "rim", "ignitions": 4},
    {"over": "rubble", "fuel": 0.5, "grain": 5},
    {"over": "rooms", "ignitions": 5, "apart": 2.0},
    {"over": "corridor+shape=junctions", "burn_through": 8},
    {"over": "trap+shape=comb", "ignite_cells": "3:3,32:32"},
    {"over": "maze+mask=disc", "monotone": True, "margin": 3.0},
]
AT = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)


def at_time(world: World, time: float) -> World:
    """Return the world as it is at one time, standing still but for the flames."""
    now = world.cells_at(time)
    burning = [
        Event(0.0, int(ix), int(iy), CellState.BURNING)
        for iy, ix in np.argwhere(now == CellState.BURNING)
    ]
    return replace(
        world, walls=now == CellState.SOLID, timeline=Timeline.of(burning), certificate=None
    )


def trail(witness: Witness, time: float) -> Trail:
    """Return the witness from its beginning to a time."""
    kept = witness.times < time
    x, y = (np.interp(time, witness.times, values) for values in (witness.x, witness.y))
    return Trail(np.append(witness.x[kept], x), np.append(witness.y[kept], y))


def strip(params: dict[str, Value], seed: int) -> bytes:
    """Return one world at several times, with the witness so far, as a PNG file's bytes."""
    world = generate("fire", seed, size=SIZE, **params)
    witness = world.certificate
    if not isinstance(witness, Witness):
        raise TypeError("a generated world has a witness")
    times = [round(share * witness.duration, 1) for share in AT]
    panels = [Panel(at_time(world, time), f"{time:g} s", (trail(witness, time),)) for time in times]
    return draw_sheet(panels, ["witness so far"], columns=3)


def options() -> bytes:
    """Return what the parameters make of one seed, as a PNG file's bytes."""
    panels = []
    for params in PANELS:
        world = generate("fire", SEED, size=SIZE, **params)
        way = world.certificate
        title = ", ".join(f"{name}={value}" for name, value in list(params.items())[:2])
        panels.append(
            Panel(world, title, (Trail(way.x, way.y) if isinstance(way, Witness) else None,))
        )
    return draw_sheet(panels, ["witness"], columns=4)


if __name__ == "__main__":
    for name, (params, seed) in STRIPS.items():
        (PICTURES / f"{name}.png").write_bytes(strip(params, seed))
    (PICTURES / "fire-options.png").write_bytes(options())
