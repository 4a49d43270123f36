"""Draw twenty failures as the cards of the pages and as a contact sheet, 190 px each.

``python -m benchmarks.failure_cards FOLDER`` writes ``cards.png``, as a browser draws them, and
``sheet.png``, as Pillow does. A reader who has not seen them should tell of each what repeats where,
and what blocks it, from the picture and the legend alone. ``FILE...`` draws other failures.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

import click

from fuzz.corpus import read_corpus
from fuzz.corpus.pictures import contact_sheet
from fuzz.failure import Failure
from fuzz.overview.describe import run_to_draw
from fuzz.player import drawn_robots, drawn_world, one_file, sensors_of
from sim.controllers.catalogue import CONTROLLERS
from tests.helpers.browser import chromium_browser, missing_browser

SIDE = 190
# The words of a round that takes seconds; the gate runs it.
TINY = (str(Path(tempfile.gettempdir()) / "worldgen-failure-cards"),)
_CORPORA = Path(__file__).parents[1] / "corpora"
_FAILURES = (
    "failures/bug1/swept/circles-an-obstacle.grid",
    "failures/bug1/swept/pushes-a-wall.grid",
    "failures/bug1/swept/returns-to-a-wall-3.grid",
    "failures/bug2/swept/caught-by-a-change.grid",
    "failures/bug2/swept/returns-to-a-wall.grid",
    "failures/dynamic-window/swept/goes-back-and-forth.grid",
    "failures/dynamic-window/swept/turns-on-the-spot.grid",
    "failures/mapper/swept/goes-back-and-forth.grid",
    "failures/mapper/swept/returns-to-a-wall.grid",
    "failures/potential-field/swept/stands-still.grid",
    "failures/q-learning/swept/drives-in-circles.grid",
    "failures/q-learning/swept/returns-to-a-wall.grid",
    "failures/random-walk/swept/drives-into-a-hazard.grid",
    "failures/tangent-bug/swept/returns-to-a-wall.grid",
    "failures/three-layer/swept/goes-back-and-forth.grid",
    "failures/turn-random/stepped/goes-through-a-wall.grid",
    "failures/turn-right/swept/returns-to-a-wall-2.grid",
    "failures/vfh/swept/goes-back-and-forth.grid",
    "failures/wall-left/swept/circles-an-obstacle.grid",
    "thesis-faults/thesis-1-loop-104.grid",
)
_STYLE = (
    "body { margin: 8px; width: 1010px; } "
    ".cards { display: grid; grid-template-columns: repeat(5, 190px); gap: 12px; } "
    "figure { margin: 0; } "
    f".cards canvas {{ width: {SIDE}px; height: {SIDE}px; }}"
)
_SCRIPT = """
import { byId, el } from "#player/dom.js";
import { legendOfMany } from "#player/legend.js";
import { drawSmall } from "#player/picture/map.js";
if (location.hash === "#dark") document.documentElement.dataset.theme = "dark";
const { failures } = JSON.parse(byId("data").textContent);
failures.forEach((failure, k) => {
  const canvas = el("canvas");
  byId("cards").append(el("figure", {}, el("figcaption", {}, String(k + 1)), canvas));
  drawSmall(canvas, failure);
});
const legend = legendOfMany(failures);
legend.open = true;
byId("cards").after(legend);
document.body.dataset.ready = "yes";
"""


def drawn_card(path: Path) -> dict[str, Any]:
    """Return what a page draws of a failure's file."""
    failure = Failure.read(path)
    world = failure.world
    shown, _ = run_to_draw(failure)
    controller = CONTROLLERS.get(failure.record.controller)
    return {
        "world": drawn_world(world),
        **drawn_robots(shown, world.cell_size, motion=failure.options.motion_model()),
        "sensors": sensors_of(controller, failure.options, world.cell_size),
    }


def cards_page(paths: list[Path]) -> bytes:
    """Return a page of the failures' cards; its body has ``data-ready`` once they are drawn."""
    return one_file(
        '<main id="cards" class="cards"></main>',
        "Cards",
        styles=_STYLE,
        scripts={"#cards/start.js": _SCRIPT},
        start="#cards/start.js",
        data={"failures": [drawn_card(path) for path in paths]},
    )


def main() -> int:
    """Write the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("files", type=Path, nargs="*")
    parser.add_argument("--dark", action="store_true")
    options = parser.parse_args()
    paths = options.files or [_CORPORA / name for name in _FAILURES]
    options.folder.mkdir(parents=True, exist_ok=True)
    page = options.folder / "cards.html"
    page.write_bytes(cards_page(paths))
    entries = [entry for path in paths for entry in read_corpus([path]).entries]
    (options.folder / "sheet.png").write_bytes(contact_sheet(entries))
    if missing := missing_browser():
        click.echo(
            f"wrote sheet.png and cards.html of {len(paths)} failures; no cards.png: {missing}"
        )
        return 0
    with chromium_browser() as browser:
        tab = browser.new_page(viewport={"width": 1030, "height": 850})
        tab.goto(page.resolve().as_uri() + ("#dark" if options.dark else ""))
        tab.wait_for_selector("body[data-ready]")
        tab.screenshot(path=options.folder / "cards.png", full_page=True)
    click.echo(f"wrote cards.png and sheet.png of {len(paths)} failures")
    return 0


if __name__ == "__main__":
    sys.exit(main())
