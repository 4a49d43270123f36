"""Draw the pictures of ``docs/reference/families.md``: ``python docs/draw_gallery.py [FAMILY ...]``.

A picture carries the ids of the worlds that it shows, and the page's gallery lists them; a test
makes the worlds by the gallery's commands and compares.
"""

from __future__ import annotations

import io
import shlex
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from worldgen import generate, world_digest
from worldgen.family import FAMILIES
from worldgen.render import Panel, draw_sheet
from worldgen.world import Value, World

DOCS = Path(__file__).parent
FIRST, EACH = 1, 3  # seeds of every kind
LOOK = {"columns": 6, "pixels": 150}  # panels across; 5 px for each cell of a world of 30
COLOURS = 48
ID = 8  # hex digits of a world's id that the page and the picture name


@dataclass(frozen=True)
class Kind:
    """Worlds of one family with the same parameters.

    Args:
        label: Text above the pictures.
        params: Those that are not defaults.
    """

    label: str
    params: dict[str, Value]


def _words(parameter: str, *words: str, before: str = "", **others: Value) -> list[Kind]:
    return [Kind(before + word, {**others, parameter: word}) for word in words]


GALLERY: dict[str, list[Kind]] = {
    "corridor": [
        *_words("shape", "bends", "dead-ends", "junctions", "S", "T", "X", "tunnel"),
        Kind("S with necks", {"shape": "S", "robot_widths": 3.5, "necks": 6}),
    ],
    "trap": [
        *_words("shape", "U", "L", "spiral", "V", "comb", "nested", "pair"),
        Kind("spiral at 30 degrees", {"shape": "spiral", "angle": 30}),
        Kind("U, faces target", {"faces": "target"}),
        Kind("L, faces side", {"shape": "L", "faces": "side"}),
        Kind("nested, start inside", {"shape": "nested", "inside": True, "size": 40}),
        Kind("comb at 45 degrees", {"shape": "comb", "angle": 45, "size": 40}),
    ],
    "maze": [
        *_words(
            "algorithm",
            "wilson",
            "aldous-broder",
            "backtracker",
            "hunt-and-kill",
            "kruskal",
            size=50,
        ),
        *_words("algorithm", "prim", "growing-tree", "eller", "sidewinder", "binary-tree", size=50),
        *_words("algorithm", "recursive-division", size=50),
        Kind(
            "growing-tree, oldest 1",
            {"algorithm": "growing-tree", "newest": 0.0, "oldest": 1.0, "size": 50},
        ),
        *_words("mask", "disc", "ring", "cross", "diamond", size=50),
        Kind("braid 1", {"braid": 1.0, "size": 50}),
        Kind("rooms 3", {"rooms": 3, "size": 50}),
        Kind("the default size", {}),
        Kind("passage 4, wall 2", {"passage": 4, "wall": 2}),
    ],
    "rooms": [
        *_words("plan", "wings", "spine", "suite", size=50),
        Kind("suite, 40 % shut", {"plan": "suite", "closed": 0.4}),
    ],
    "cave": [
        *_words("shape", "caverns", "columns", "galleries", size=50),
        Kind("the default size", {}),
    ],
    "forest": [
        *_words("growth", "even", "thickets", "rows", size=50),
        Kind("thick", {"thinnest": 3, "thickest": 7}),
    ],
    "rubble": [
        *_words("collapse", "quake", "blast", "wing", size=50),
        Kind("more debris", {"debris": 0.5}),
    ],
    "fire": [
        *_words(
            "over", "maze", "corridor", "trap", "rooms", "cave", "forest", "rubble", before="over "
        ),
        *_words("ignite_at", "way", "anywhere", "rim", before="ignites at: ", over="rooms"),
        Kind("monotone, margin 2 s", {"over": "rooms", "monotone": True, "margin": 2.0}),
        Kind("wind", {"over": "forest", "wind": 0.8, "spread_cells": 600}),
    ],
    "shift": _words("over", "trap", "corridor", "maze", "rooms", before="over ", chance=1.0),
    "doorway": [Kind("2 robots", {}), Kind("6 robots", {"robots": 6})],
    "junction": _words("shape", "X", "T"),
    "alley": [Kind("2 robots", {}), Kind("4 robots", {"robots": 4})],
    "crossing": [Kind("4 robots", {}), Kind("street 6", {"street": 6})],
    "warehouse": [Kind("4 robots", {}), Kind("6 robots, size 50", {"robots": 6, "size": 50})],
}


SETS = ("--seed", str(FIRST), "--count", str(EACH), "--out", "worlds/")
"""Options that make a set of the worlds of one kind; the page names them once."""


def command(family: str, kind: Kind) -> str:
    """Return what makes worlds of one kind."""
    made_by = FAMILIES.get(family)
    return shlex.join(["worldgen", family, *made_by.options(made_by.complete(kind.params))])


def worlds(family: str, kind: Kind) -> Iterator[World]:
    """Yield the worlds of one kind."""
    for seed in range(FIRST, FIRST + EACH):
        yield generate(family, seed, **kind.params)


def draw(family: str) -> bytes:
    """Return the picture of a family, as a PNG file's bytes; it names the worlds that it shows."""
    panels: list[Panel] = []
    for kind in GALLERY[family]:
        for seed, world in enumerate(worlds(family, kind), FIRST):
            panels.append(Panel(world, kind.label if seed == FIRST else f"seed {seed}", ()))
    picture = Image.open(io.BytesIO(draw_sheet(panels, (), **LOOK)))
    about = PngInfo()
    about.add_text("worlds", " ".join(world_digest(panel.world)[:ID] for panel in panels))
    stream = io.BytesIO()
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(
        stream, "PNG", optimize=True, pnginfo=about
    )
    return stream.getvalue()


def section() -> str:
    """Return the commands that make the worlds of the pictures; it relies on the ids in them."""
    rows = []
    for family, kinds in GALLERY.items():
        names = iter(shown(family))
        rows += [
            f"| {family}, {kind.label} | `{command(family, kind)}` | "
            f"{' '.join(next(names) for _ in range(EACH))} |"
            for kind in kinds
        ]
    return "\n".join(["| worlds | command | ids |", "| --- | --- | --- |", *rows]) + "\n"


def picture_of(family: str) -> Path:
    """Return where a family's picture is."""
    return DOCS / "pictures" / f"gallery-{family}.png"


def shown(family: str) -> list[str]:
    """Return the ids of the worlds that a picture says it shows."""
    with Image.open(picture_of(family)) as picture:
        return str(picture.info["worlds"]).split()


if __name__ == "__main__":
    for name in sys.argv[1:] or GALLERY:
        picture_of(name).write_bytes(draw(name))
