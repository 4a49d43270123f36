"""Draw the pictures of docs/howto/studio.md: ``python -m docs.draw_studio``.

Each shows the studio in Debian's Chromium at 1280 x 720, and is made as a person would make it: by
mouse and keyboard. Those of the walk are taken on the walk itself.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

from tests.helpers.browser import chromium_browser
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened
from tests.helpers.studio_walk import Walker, sentences
from worldgen import generate, write_world

HERE = Path(__file__).parent
PICTURES = HERE / "pictures"
STILL = 1500  # ms until nothing on the page moves

# The walk's pictures: taken when the step is done.
ON_THE_WALK = {2: "studio-cut", 6: "studio-draw", 8: "studio-play", 14: "studio-beside"}
GENERATED = """
Click the tab **Generate**. Choose `cave` in **Family**. Click the button **Generate**.
The page says *Made by cave*. The page says *✓ reachable*. Press `i`
"""
COMPOSED = "behaviours:escape,follow,approach"
FOLLOWS = 100  # a step in which it follows a wall
CAMPAIGN = """
Click the link **Campaign**. Click **From these strategies and families**.
Tick **trap**. Tick **rooms**. Tick **forest**.
Click **Units of work**. Type `3` into **Units**. Click **More**. Type `60` into **Worlds per unit**. Click **Begin**.
The page says *Done*. Click the first picture of a failure
"""


def main() -> None:
    """Write all of them."""
    with chromium_browser() as browser:
        with (
            tempfile.TemporaryDirectory() as folder,
            studio_of(Path(folder)) as gate,
            opened(browser, gate) as page,
        ):
            walk(page)
        with (
            tempfile.TemporaryDirectory() as folder,
            studio_of(Path(folder)) as gate,
            opened(browser, gate) as page,
        ):
            go(page, CAMPAIGN)
            keep(page, "studio-campaign")
            page.emulate_media(color_scheme="dark")
            page.keyboard.press("1")
            go(page, GENERATED)
            keep(page, "studio-generate")
        with (
            tempfile.TemporaryDirectory() as folder,
            studio_of(Path(folder), named=(COMPOSED,), file="trap.grid") as gate,
        ):
            write_world(generate("trap", 3, size=24), Path(folder) / "trap.grid")
            with opened(browser, gate) as page:
                flow_chart(page)


def flow_chart(page: Any) -> None:
    """A composition while it follows a wall, and its flow chart."""
    page.keyboard.press("2")
    page.locator(".result").wait_for()
    for key in ("b", "Home", *["ArrowRight"] * FOLLOWS):
        page.keyboard.press(key)
    page.locator(".acts[data-part=follow]").wait_for()
    keep(page, "studio-flow-chart")


def walk(page: Any) -> None:
    """The walk, with a picture after some of its steps."""
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    text = (HERE / "howto" / "studio.md").read_text(encoding="utf-8")
    steps = sentences(text.partition("<!-- new folder -->")[2])
    walker = Walker(page)
    for k, (number, sentence) in enumerate(steps):
        walker.perform(sentence)
        last = k + 1 == len(steps) or steps[k + 1][0] > number
        if last and number in ON_THE_WALK:
            keep(page, ON_THE_WALK[number])


def go(page: Any, text: str) -> None:
    """Some sentences, as a step of the walk has them."""
    for _, sentence in sentences(f"1. {' '.join(text.split())}."):
        Walker(page).perform(sentence)


def keep(page: Any, name: str) -> None:
    """Take the picture."""
    page.mouse.move(640, 4)
    page.locator("#widest", has_text=re.compile("[a-z]")).wait_for(state="attached")
    page.wait_for_timeout(STILL)
    page.screenshot(path=PICTURES / f"{name}.png")


if __name__ == "__main__":
    main()
