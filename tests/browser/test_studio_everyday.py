"""Everyday use of the studio: time on the board, documented keys, remembered choices."""

import pytest

from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened
from worldgen import generate
from worldgen.files.grid import write_world

pytestmark = pytest.mark.gate


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("everyday")
    write_world(generate("fire", 3), folder / "fire.grid")
    with studio_of(folder, file="fire.grid") as gate:
        yield gate


def pixels(page, selector="#board"):
    """Return a digest of a canvas's picture."""
    return page.evaluate(
        """(selector) => {
          const canvas = document.querySelector(selector);
          return canvas.toDataURL();
        }""",
        selector,
    )


def test_time_on_the_board_keys_and_choices_that_stay(browser, gate):
    with opened(browser, gate) as page:
        # A moment of a world that changes, by mouse or keyboard.
        before = pixels(page)
        page.locator("#board-time").focus()
        page.keyboard.press("End")
        assert page.locator(".time-slider output").inner_text() != "0.0 s"
        assert pixels(page) != before
        assert page.locator(".time-slider .legend li:visible").first.inner_text() == "burns later"

        # An empty field is automatic, and a parameter without effect is not shown.
        page.get_by_role("tab", name="Generate").click()
        page.get_by_label("Family", exact=True).select_option("maze")
        newest = page.get_by_label("Newest")
        assert newest.is_hidden()
        page.get_by_label("Algorithm").select_option("growing-tree")
        assert newest.is_visible() and newest.get_attribute("placeholder") == "automatic"

        # Ctrl+M leads back to the board.
        page.keyboard.press("2")
        page.locator(".result").first.wait_for()
        page.keyboard.press("Control+m")
        assert page.evaluate("document.activeElement.id") == "board"

        # The theme and the set-up survive a reload.
        page.keyboard.press("2")
        page.get_by_label("Steps", exact=True).fill("321")
        page.locator("#run").click()
        page.locator("#run-said:empty").wait_for(state="attached")
        page.locator("#theme").click()
        page.reload()
        page.locator(".result").first.wait_for()
        assert page.get_by_label("Steps", exact=True).input_value() == "321"
        assert page.evaluate("document.documentElement.dataset.theme") == "dark"
        assert page.complaints == []
