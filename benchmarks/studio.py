"""Measure how smooth the studio is.

It measures frame times in headless Chromium, in a world of 2000 x 2000 cells and a long run. Run it
as ``python -m benchmarks.studio``.

The board is zoomed and drawn on in each frame; the player plays a million steps, with the whole
world in view and with the robot followed. A frame at 60 a second has 16.7 ms; headless Chromium
draws without a graphics card.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

import click

from tests.helpers.browser import chromium_browser
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import drag, opened
from worldgen import generate
from worldgen.files.grid import write_world

# The words of a round that takes seconds; the gate runs it.
TINY = ("--side", "60", "--steps", "1000")

# Cells.
SIDE = 2_000
STEPS = 1_000_000
_FRAMES = """async (act) => {
  const times = [];
  const board = document.querySelector("#board");
  let last = performance.now();
  for (let k = 0; k < 120; k += 1) {
    if (act) board.dispatchEvent(new WheelEvent("wheel", { deltaY: k % 2 ? 3 : -3, clientX: 400, clientY: 400 }));
    await new Promise(requestAnimationFrame);
    const now = performance.now();
    times.push(now - last);
    last = now;
  }
  times.sort((a, b) => a - b);
  return [times[60], times[114]];
}"""


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=SIDE, help=f"cells (default {SIDE})")
    parser.add_argument("--steps", type=int, default=STEPS, help=f"of the run (default {STEPS})")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as there:
        write_world(generate("cave", 3, size=given.side), Path(there) / "big.grid")
        with (
            studio_of(Path(there)) as gate,
            chromium_browser() as browser,
            opened(browser, gate) as page,
        ):
            page.set_default_timeout(300_000)
            click.echo(f"{'':32} median ms   19 in 20 below")
            _measure(page, given.steps)


def _measure(page: Any, steps: int) -> None:
    # Open the world, and measure the board.
    page.locator("#tab-files").click()
    page.locator(".file", has_text="big.grid").click()
    page.locator("#proof.good").wait_for()
    _say("board, zoomed", page.evaluate(_FRAMES, True))
    drag(page, (100, 100), (900, 900))
    _say("board, after a stroke", page.evaluate(_FRAMES, True))
    # Run a robot, and measure the player.
    page.keyboard.press("2")
    page.locator(".result").wait_for()
    page.locator("#play").get_by_label("Motion model").select_option("swept")
    page.locator("#play").get_by_label("random-walk").check()
    page.locator("input[type=checkbox][value=thesis-2]").first.uncheck()
    page.locator("#play").get_by_label("Steps", exact=True).fill(str(steps))
    page.keyboard.press("Control+Enter")
    page.locator(".result[data-controller=random-walk]").wait_for()
    run = page.locator(".result .quiet").first.inner_text()
    for name, key in (("player, whole world", "0"), ("player, robot followed", "r")):
        page.keyboard.press(key)
        page.keyboard.press("Home")
        page.keyboard.press(" ")
        _say(name, page.evaluate(_FRAMES, False))
        page.keyboard.press(" ")
    click.echo(f"the run: {run}")


def _say(name: str, times: list[float]) -> None:
    click.echo(f"{name:32} {times[0]:9.1f} {times[1]:16.1f}")


if __name__ == "__main__":
    main()
