"""Draws the pictures of docs/families.md: ``python docs/draw_families.py [FAMILY ...]``."""

from __future__ import annotations

import sys
from pathlib import Path

from worldgen.generation import generate
from worldgen.render import Panel, Trail, draw_sheet
from worldgen.world import Value, Witness

PANELS: dict[str, list[dict[str, Value]]] = {
    "corridor": [
        {"shape": "bends"},
        {"shape": "dead-ends"},
        {"shape": "junctions"},
        {"shape": "S"},
        {"shape": "T", "branches": 4},
        {"shape": "X", "branches": 4},
        {"shape": "tunnel"},
        {"shape": "S", "robot_widths": 3.5, "necks": 6},
    ],
    "cave": [
        {"shape": "caverns"},
        {"shape": "columns"},
        {"shape": "galleries", "size": 80},
        {"shape": "caverns", "size": 100, "robot_radius": 0.15},
    ],
    "forest": [
        {"growth": "even"},
        {"growth": "thickets", "size": 100},
        {"growth": "rows", "thickest": 3},
        {"thinnest": 3, "thickest": 9, "size": 80},
    ],
    "rooms": [
        {"plan": "wings"},
        {"plan": "spine"},
        {"plan": "suite", "closed": 0.4},
        {"plan": "wings", "size": 80, "door": 3},
    ],
    "rubble": [
        {"collapse": "quake"},
        {"collapse": "blast", "size": 80},
        {"collapse": "wing", "damage": 0.6},
        {"collapse": "quake", "size": 80, "debris": 0.5},
    ],
    "trap": [
        {"shape": "U"},
        {"shape": "L", "faces": "side"},
        {"shape": "spiral"},
        {"shape": "V"},
        {"shape": "comb"},
        {"shape": "nested", "inside": True},
        {"shape": "pair"},
        {"shape": "spiral", "angle": 30},
    ],
}
SIZE, SEED = 48, 3


def draw(family: str) -> bytes:
    """A sheet of worlds of one family, each with its witness, as a PNG file's bytes."""
    panels = []
    for settings in PANELS[family]:
        world = generate(family, SEED, **{"size": SIZE, **settings})
        title = ", ".join(f"{name}={value}" for name, value in settings.items())
        way = world.certificate
        trail = Trail(way.x, way.y) if isinstance(way, Witness) else None
        panels.append(Panel(world, title, (trail,)))
    return draw_sheet(panels, ["witness"], columns=4)


if __name__ == "__main__":
    for name in sys.argv[1:] or PANELS:
        Path(__file__).with_name("pictures").joinpath(f"family-{name}.png").write_bytes(draw(name))
