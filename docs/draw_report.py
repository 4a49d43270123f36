"""Draw the report's pictures: ``python -m docs.draw_report``.

Each shows a report that is opened from disk in Debian's Chromium: the first screen and a failure of
the first tutorial's controller, and a world in which a target was dragged into a closed room.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from tests.browser.test_report_change import ROOM, begin, drag, write_failure
from tests.helpers.browser import chromium_browser, page_in

PICTURES = Path(__file__).parent / "pictures"
STILL = 1000  # ms until nothing on the page moves
TARGET = (12, 3)
FUZZ = ("fuzz", "--controller", "turn-right", "--units", "1", "--seed", "1", "--out", "failures")
REPORT = ("report", "failures", "--out", "report.html")


def main() -> None:
    """Write all of them."""
    with chromium_browser() as browser, tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        worldgen(folder, *FUZZ)
        worldgen(folder, *REPORT)
        with page_in(browser, viewport={"width": 1280, "height": 800}) as page:
            page.goto((folder / "report.html").as_uri())
            page.locator("a.card canvas").first.wait_for()
            keep(page, "report-failures")
            page.set_viewport_size({"width": 1165, "height": 1400})
            page.locator("a.card").first.click()
            page.locator("#stage").wait_for()
            keep(page, "report-replay")
        (folder / "change").mkdir()
        address, failure = write_failure(folder / "change", "turn-right")
        with page_in(browser, viewport={"width": 800, "height": 600}) as page:
            page.goto(f"{address}#{failure.digest[:12]}")
            begin(page)
            drag(page, TARGET, ROOM)
            page.locator("#change-proof.bad", has_text="blocked").wait_for()
            page.locator("#change-verdict").scroll_into_view_if_needed()
            keep(page, "report-change")


def worldgen(folder: Path, *words: str) -> None:
    """Run a command in a folder; ``fuzz`` ends with code 1 because it finds failures."""
    subprocess.run([sys.executable, "-m", "worldgen", *words], cwd=folder, check=False)


def keep(page: Any, name: str) -> None:
    """Take the picture."""
    page.wait_for_timeout(STILL)
    page.screenshot(path=PICTURES / f"{name}.png")


if __name__ == "__main__":
    main()
