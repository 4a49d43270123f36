"""Draws the picture of ``docs/howto/difficulty.md``: pockets by their depth.

``python docs/draw_difficulty.py`` writes it to ``docs/pictures``.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from worldgen.difficulty.nodes import Nodes, nodes_of
from worldgen.generation import generate
from worldgen.world import Witness, World

FOLDER = Path(__file__).parent / "pictures"
CELL = 12  # pixels
DEEP = 1.5  # m: the strongest colour
WALL, WAY = (60, 64, 72), (30, 110, 190)


def depths(world: World, nodes: Nodes) -> npt.NDArray[np.float64]:
    """Return how much farther from the target a robot at each node has to go, m.

    Nan where the robot cannot be.
    """
    rows, columns = np.indices(nodes.graph.clear.shape)
    x, y = (2 * value / world.cell_size for value in (world.target.x, world.target.y))
    away = np.sqrt((columns - x) ** 2 + (rows - y) ** 2)
    level = np.full(away.shape, np.nan)
    heap = [
        (float(away[j, i]), int(j), int(i))
        for j, i in np.argwhere(nodes.graph.clear & (away <= 1.0))
    ]
    while heap:
        high, j, i = heapq.heappop(heap)
        if np.isnan(level[j, i]):
            level[j, i] = high
            for dj, di in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                if nodes.graph.clear[j + dj, i + di]:
                    heapq.heappush(heap, (max(high, float(away[j + dj, i + di])), j + dj, i + di))
    found: npt.NDArray[np.float64] = (level - away) * world.cell_size / 2
    return found


def picture(world: World) -> Image.Image:
    """Return one world with its pockets and its witness."""
    # Scale the map to pixels.
    nodes, wide, high = nodes_of(world, world.walls), world.width * CELL, world.height * CELL
    image = Image.new("RGB", (wide, high), "white")
    draw = ImageDraw.Draw(image)
    half = CELL / 2
    # Tint the pockets by their depth.
    depth = depths(world, nodes)
    for j, i in np.argwhere(depth > 0.01):
        share = min(1.0, float(depth[j, i]) / DEEP)
        x, y = i * half, high - j * half
        draw.rectangle((x - half / 2, y - half / 2, x + half / 2, y + half / 2), fill=_tint(share))
    # Draw the walls.
    for iy, ix in np.argwhere(world.walls):
        draw.rectangle(
            (ix * CELL, high - (iy + 1) * CELL, (ix + 1) * CELL - 1, high - iy * CELL - 1),
            fill=WALL,
        )
    # Draw the witness.
    witness = world.certificate
    if isinstance(witness, Witness):
        scale = CELL / world.cell_size
        line = [
            (x * scale, high - y * scale)
            for x, y in zip(witness.x.tolist(), witness.y.tolist(), strict=True)
        ]
        draw.line(line, fill=WAY, width=2)
        draw.ellipse(_box(*line[0], 4), fill=WAY)
        draw.ellipse(_box(*line[-1], 4), outline=WAY, width=2)
    return image


def _tint(share: float) -> tuple[int, int, int]:
    return (255 - int(20 * share), 245 - int(130 * share), 230 - int(190 * share))


def _box(x: float, y: float, radius: float) -> tuple[float, float, float, float]:
    return (x - radius, y - radius, x + radius, y + radius)


def sheet(images: Sequence[Image.Image], path: Path) -> None:
    """Images side by side."""
    gap = 8
    whole = Image.new(
        "RGB", (sum(image.width + gap for image in images) - gap, images[0].height), "white"
    )
    at = 0
    for image in images:
        whole.paste(image, (at, 0))
        at += image.width + gap
    whole.save(path, optimize=True)


def main() -> None:
    """Write the picture."""
    traps = [
        generate("trap", 4, shape="U", size=24),
        generate("maze", 2, size=24),
        generate("cave", 11, size=24),
    ]
    sheet([picture(world) for world in traps], FOLDER / "difficulty-pockets.png")


if __name__ == "__main__":
    main()
