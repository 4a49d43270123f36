"""Measure the cost of a frame of the player, drawn by the processor.

The worlds have 2000 x 2000 cells.

    python -m benchmarks.player

Each frame is drawn completely and read back, so that nothing is deferred; a frame at 60 a second
has 16.7 ms. One world changes 6,000 times a second; in the other a robot's path has 30,000 corners,
as many as the studio's page can hold. All of them are in view, even when the robot is followed.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np

from fuzz.player import drawn_world
from fuzz.player.streams import bits, numbers
from tests.helpers.browser import chromium_browser
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened
from worldgen.timeline import Timeline
from worldgen.world import Pose, Target, World

SIDE = 2_000  # cells
CHANGES = 60_000
CORNERS = 30_000
CASES = (
    ("changing world", CHANGES, 2, "forward"),
    ("long way", 0, CORNERS, "forward"),
    ("long way, robot followed", 0, CORNERS, "followed"),
    ("long way, zoomed each frame", 0, CORNERS, "zoomed"),
    ("long way, backwards", 0, CORNERS, "back"),
)
_DRAW = """async ([world, run, how]) => {
  const { drawScene } = await import("/player/map.js");
  const { fitView } = await import("/player/pen.js");
  const { poseAt } = await import("/player/decode.js");
  const canvas = document.querySelector("#board");
  const show = { trail: true, touched: true, sensors: true, signal: true, witness: false };
  const sensors = { beams: 36, range: 100, field: 0, signal: true };
  const whole = fitView(world, canvas.clientWidth, canvas.clientHeight);
  const times = [];
  for (let k = 0; k < 100; k += 1) {
    const share = how === "back" ? 1 - k / 100 : how === "forward" ? k / 100 : 0.9 + k / 10_000,
      step = share * run.steps;
    const views = {
      followed: () => ({ ...poseAt(run, step), scale: 1.5 * whole.scale }),
      zoomed: () => ({ ...whole, scale: whole.scale * (1 + k / 100) }),
    };
    const view = how in views ? views[how]() : null;
    const before = performance.now();
    drawScene(canvas, { world, run, sensors, show, step }, view);
    canvas.getContext("2d").getImageData(0, 0, 1, 1);
    times.push(performance.now() - before);
    await new Promise(requestAnimationFrame);
  }
  const [first, ...others] = times;
  others.sort((a, b) => a - b);
  return [first, others[50], others[94]];
}"""


def main() -> None:
    """Print a table."""
    click.echo(f"{'':28} first ms   median ms   19 in 20 below")
    with (
        tempfile.TemporaryDirectory() as there,
        studio_of(Path(there)) as gate,
        chromium_browser() as browser,
    ):
        for name, changes, corners, how in CASES:
            with opened(browser, gate) as page:
                first, median, most = page.evaluate(
                    _DRAW, [drawn_world(_world(changes)), _run(corners), how]
                )
                click.echo(f"{name:28} {first:8.1f} {median:11.1f} {most:16.1f}")


def _world(changes: int) -> World:
    chance = np.random.default_rng(1)
    walls = chance.random((SIDE, SIDE)) < 0.1
    walls[:5, :5] = walls[-5:, -5:] = False
    times = np.sort(chance.random(changes)) * 10.0
    ix, iy = (chance.integers(5, SIDE - 5, changes) for _ in range(2))
    line = Timeline(times, ix, iy, chance.integers(0, 3, changes).astype(np.uint8))
    end = (SIDE - 2.5) * 0.1
    return World(walls, Pose(0.25, 0.25, 0.0), Target(end, end, 0.1), timeline=line)


def _run(corners: int) -> dict[str, object]:
    """Return a run of 10 s that wanders through the world, up to 3 cells between corners."""
    chance = np.random.default_rng(2)
    walked = (chance.integers(-3 * 1_024, 3 * 1_024 + 1, corners).cumsum() for _ in range(2))
    x, y = (np.clip(way + SIDE * 512, 3_000, (SIDE - 3) * 1_024) for way in walked)
    at = np.linspace(0, 1_000 * 256, corners).astype(np.int64)
    columns = {
        "at": numbers(at),
        "x": numbers(x),
        "y": numbers(y),
        "heading": numbers(np.zeros(corners)),
    }
    return {
        "steps": 1_000,
        "dt": 0.01,
        **columns,
        "bump": bits(np.zeros(corners)),
        "loop": None,
        "marks": [],
    }


if __name__ == "__main__":
    main()
