"""Draws the mazes of ``docs/families.md``: every algorithm, every mask, rooms and braids, on one sheet.

``python -m benchmarks.maze_pictures`` writes ``docs/pictures/mazes.png``; ``--out`` names another file.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from worldgen import generate
from worldgen.families._mazes import METHODS
from worldgen.render import Panel, draw_sheet
from worldgen.world import Value

__all__ = ["PANELS", "draw"]

SEED = 7
LOOK: dict[str, Value] = {"size": 53, "passage": 1, "robot_radius": 0.045}

PANELS: dict[str, dict[str, Value]] = {
    **{name: {"algorithm": name} for name in METHODS},
    "growing-tree, newest=0": {"algorithm": "growing-tree", "newest": 0.0},
    "growing-tree, newest=0 oldest=1": {"algorithm": "growing-tree", "newest": 0.0, "oldest": 1.0},
    **{f"mask={shape}": {"mask": shape, "algorithm": "backtracker"} for shape in ("disc", "ring", "cross", "diamond")},
    "rooms=6": {"rooms": 6},
    "braid=1": {"braid": 1.0},
    "passage=3 wall=2": {"passage": 3, "wall": 2},
}


def draw() -> bytes:
    """The sheet, as the bytes of a PNG file."""
    panels = [Panel(generate("maze", SEED, **{**LOOK, **params}), title, ()) for title, params in PANELS.items()]
    return draw_sheet(panels, (), columns=5)


def main() -> None:
    """Draws them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "pictures" / "mazes.png")
    parser.parse_args().out.write_bytes(draw())


if __name__ == "__main__":
    main()
