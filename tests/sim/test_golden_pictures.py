"""Golden pictures of runs: a digest of the SVG, and of the pixels that Pillow draws from it.

If a picture should change, look at it, then replace its digests by those in the message.
"""

import hashlib
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from sim.drawing.picture import trails_of
from sim.episode import simulate
from worldgen import read_world
from worldgen.render import draw_png, draw_svg

CORPORA = Path(__file__).parents[2] / "corpora"
RUNS = {
    "a loop": (
        "failures/tangent-bug/swept/returns-to-a-wall.grid",
        "tangent-bug",
        "fbd049f9ac98bc72",
    ),
    "on one spot": ("failures/bug1/swept/pushes-a-wall.grid", "bug1", "b148468ad988074d"),
    "a run without a loop": (
        "failures/bug2/swept/caught-by-a-change.grid",
        "bug2",
        "bde45a698aeab61f",
    ),
}


@pytest.mark.parametrize(("name", "controller", "digest"), RUNS.values(), ids=RUNS.keys())
def test_golden_picture(name, controller, digest):
    world = read_world(CORPORA / name)
    trails = trails_of(simulate(world, controller, record=True), world)
    svg = draw_svg(world, trail=trails, title=controller)
    assert hashlib.sha256(svg.encode()).hexdigest()[:16] == digest


# How bright parts of the picture are, a hexadecimal digit each, the top row first.
COARSE = """
ffddddddddddddff
ffdffffffffffdff
ffdffffffffffdff
ffdffdeeeedffdff
ffdffeefffeffdff
ffdffdeddedefdff
ffdfffffedceedff
ffdfffffeeceecff
ffcff988dddeecff
ffcff645eceeecff
ffcff878feeefdff
ffcffffffffffcff
ffcffffffffffcff
ffcffeddfffffcff
ffcffdddfffffcff
ffaccbbbcccccaff
ffffffeffffeffff
ffefffffffffffff
fefeefeeffffffff
eddedeeededdffff
eeeeeeeeefffffff
feeeeeeeeeeeeeef
feeeeeeeeeeeeeff
edeeefffffffffff
"""


def test_a_png_shows_what_it_showed():
    """The pixels depend on Pillow's version, so only what they show on average is compared."""
    world = read_world(CORPORA / RUNS["a loop"][0])
    trails = trails_of(simulate(world, "tangent-bug", record=True), world)
    picture = Image.open(io.BytesIO(draw_png(world, trail=trails, signal=False, pixels=300)))
    coarse = np.asarray(picture.convert("L").resize((16, 24), Image.Resampling.BOX)) / 16.0
    golden = [[int(digit, 16) + 0.5 for digit in row] for row in COARSE.split()]
    assert np.abs(coarse - golden).max() < 1.0, "\n".join(
        "".join(f"{int(value):x}" for value in row) for row in coarse
    )
