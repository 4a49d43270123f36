"""The pages and the files draw the same marks at the same places, coarsely compared."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.failure_cards import SIDE, cards_page
from fuzz.failure import Failure
from sim.drawing.picture import trails_of
from worldgen.render.frame import Frame
from worldgen.render.marks import hue, rgb
from worldgen.render.png import draw_parts
from worldgen.render.primitives import Text
from worldgen.render.scene import card_content, card_parts

pytestmark = pytest.mark.gate

CORPORA = Path(__file__).parents[2] / "corpora"
FAILURES = [
    "failures/tangent-bug/swept/returns-to-a-wall.grid",
    "failures/wall-left/swept/circles-an-obstacle.grid",
    "failures/turn-random/stepped/goes-through-a-wall.grid",
]
# Marks that every picture of a failure has: start and path, period, target, end.
COLOURS = ["start", "loop", "target", "robot", "wall", "touched"]
GRID = 16  # squares along the longer side of the world in which a mark is looked for
# Words go where they hide the least, which depends on their size, so they are not compared.
WITHOUT_WORDS = "CanvasRenderingContext2D.prototype.fillText = () => {};"


def squares_with(pixels, colour, places):
    """The squares of the world, as (column, row), in which some pixels have about this colour."""
    near = np.abs(pixels.astype(int) - rgb(hue(colour))).max(axis=2) <= 24
    inside = ((places >= 0) & (places < GRID)).all(axis=2)  # a scale bar is outside
    found, counts = np.unique(places[near & inside], axis=0, return_counts=True)
    return {(int(x), int(y)) for (x, y), count in zip(found, counts, strict=True) if count > 2}


def places_in(shape, scale, left, bottom, longest):
    """(height, width, 2) int: the square of the world in which each pixel is."""
    y, x = np.indices(shape[:2])
    cells = np.stack(((x + 0.5 - left) / scale, (bottom - y - 0.5) / scale), axis=2)
    return np.floor(cells * GRID / longest).astype(int)


def far_from(some, others):
    """The squares that have none of the others next to them."""
    return {
        (x, y) for x, y in some if not any(abs(x - u) <= 1 and abs(y - v) <= 1 for u, v in others)
    }


@pytest.mark.parametrize("name", FAILURES)
def test_a_failure_has_the_same_marks_at_the_same_places_on_a_page_and_in_a_file(
    browser, tmp_path, name
):
    failure = Failure.read(CORPORA / name)
    world = failure.world
    longest = max(world.width, world.height)
    # As a page draws it: the whole world, above a scale bar (picture/pen.js).
    page = browser.new_page(viewport={"width": 1030, "height": 400}, device_scale_factor=2)
    file = tmp_path / "cards.html"
    file.write_bytes(cards_page([CORPORA / name]))
    page.add_init_script(WITHOUT_WORDS)
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-ready]")
    shot = np.asarray(
        Image.open(io.BytesIO(page.locator("#cards canvas").screenshot())).convert("RGB")
    )
    page.close()
    scale = min((SIDE - 18) / world.width, (SIDE - 18 - 18) / world.height)
    left = SIDE / 2 - world.width / 2 * scale
    bottom = SIDE / 2 + (world.height / 2) * scale - 18 / 2
    on_page = places_in(shot.shape, 2 * scale, 2 * left, 2 * bottom, longest)
    # As a contact sheet draws it.
    frame = Frame.of(world, 2 * SIDE)
    trails = trails_of(failure.run(through_walls=failure.is_breach), world)
    size = (frame.picture_width, frame.bottom + frame.top)
    parts = card_parts(card_content(world, trails, frame))
    marks = [part for part in parts if not isinstance(part, Text)]
    sheet = np.asarray(draw_parts(marks, frame, size))
    in_file = places_in(sheet.shape, frame.cell, frame.left, frame.bottom, longest)
    for colour in COLOURS:
        one, other = squares_with(shot, colour, on_page), squares_with(sheet, colour, in_file)
        assert bool(one) == bool(other), colour
        strays = far_from(one, other) | far_from(other, one)
        # The dashes of a path need not begin at the same place.
        assert len(strays) <= max(2, 0.1 * len(one | other)), (colour, sorted(strays))
