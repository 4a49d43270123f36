"""The marks of named cells in the canvases of pages."""

import pytest

from tests.helpers.browser import eventually

# The middle of the yellow pixels of a canvas, and its size.
YELLOW = """canvas => {
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  const found = [];
  for (let k = 0; k < width * height; k += 1)
    if (data[4 * k] === 240 && data[4 * k + 1] === 228 && data[4 * k + 2] === 66) found.push(k);
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  const middle = [mean(found.map((k) => k % width)), mean(found.map((k) => Math.floor(k / width)))];
  return { count: found.length, middle, width: canvas.clientWidth, height: canvas.clientHeight };
}"""


def check_in_place(canvas, world, cell):
    """Check that a canvas that shows the whole world has a yellow mark on a cell."""
    canvas.scroll_into_view_if_needed()
    seen = eventually(canvas.page, lambda: canvas.evaluate(YELLOW), lambda seen: seen["count"] > 20)
    edge = 2 * (9 if seen["width"] < 400 else 16)
    height = seen["height"] - 18  # the scale bar is below the world
    scale = min((seen["width"] - edge) / world.width, (height - edge) / world.height)
    across = seen["width"] / 2 + (cell[0] + 0.5 - world.width / 2) * scale
    down = height / 2 - (cell[1] + 0.5 - world.height / 2) * scale
    assert seen["middle"] == pytest.approx([across, down], abs=3)
