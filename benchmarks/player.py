"""Measure the cost of a frame of the player, drawn by the processor.

The worlds have 2000 x 2000 cells.

    python -m benchmarks.player

Each frame is drawn completely and read back, so that nothing is deferred; a frame at 60 a second
has 16.7 ms. One world changes 6,000 times a second; in the other a robot's path has 30,000 corners,
as many as the studio's page can hold. All of them are in view, even when the robot is followed.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import click
import numpy as np

from fuzz.player import drawn_world
from fuzz.player.runs import SHARE
from fuzz.player.streams import bits, numbers
from tests.helpers.browser import chromium_browser
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened
from worldgen.lattice import TURN, UNIT
from worldgen.timeline import Timeline
from worldgen.world import Pose, Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--side", "60", "--changes", "100", "--corners", "100")

SIDE = 2_000  # cells
CHANGES = 60_000
CORNERS = 30_000
# Whether the world changes and the way is long, and how the run is shown.
CASES = (
    ("changing world", True, False, "forward"),
    ("long way", False, True, "forward"),
    ("long way, robot followed", False, True, "followed"),
    ("long way, zoomed each frame", False, True, "zoomed"),
    ("long way, backwards", False, True, "back"),
)
_DRAW = """async ([world, run, how]) => {
  const { drawScene } = await import("#player/picture/map.js");
  const { fitView } = await import("#player/picture/pen.js");
  const { poseAt } = await import("#player/decode.js");
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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=SIDE, help=f"cells (default {SIDE})")
    parser.add_argument("--changes", type=int, default=CHANGES, help=f"(default {CHANGES})")
    parser.add_argument("--corners", type=int, default=CORNERS, help=f"(default {CORNERS})")
    given = parser.parse_args()
    click.echo(f"{'':28} first ms   median ms   19 in 20 below")
    with (
        tempfile.TemporaryDirectory() as there,
        studio_of(Path(there)) as gate,
        chromium_browser() as browser,
    ):
        for name, changes, is_long, how in CASES:
            world = _world(given.side, given.changes if changes else 0)
            run = _run(given.side, given.corners if is_long else 2)
            with opened(browser, gate, bypass_csp=True) as page:
                first, median, most = page.evaluate(_DRAW, [drawn_world(world), run, how])
                click.echo(f"{name:28} {first:8.1f} {median:11.1f} {most:16.1f}")


def _world(side: int, changes: int) -> World:
    chance = np.random.default_rng(1)
    walls = chance.random((side, side)) < 0.1
    walls[:5, :5] = walls[-5:, -5:] = False
    times = np.sort(chance.random(changes)) * 10.0
    ix, iy = (chance.integers(5, side - 5, changes) for _ in range(2))
    line = Timeline(times, ix, iy, chance.integers(0, 3, changes).astype(np.uint8))
    end = (side - 2.5) * 0.1
    return World(walls, Pose(0.25, 0.25, 0.0), Target(end, end, 0.1), timeline=line)


def _run(side: int, corners: int) -> dict[str, object]:
    """Return a run of 10 s that wanders through the world, up to 3 cells between corners."""
    chance = np.random.default_rng(2)
    walked = (chance.integers(-3 * UNIT, 3 * UNIT + 1, corners).cumsum() for _ in range(2))
    x, y = (np.clip(way + side * UNIT // 2, 3 * UNIT, (side - 3) * UNIT) for way in walked)
    at = np.linspace(0, 1_000 * SHARE, corners).astype(np.int64)
    columns = {
        "per": {"step": SHARE, "cell": UNIT, "turn": TURN},
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
