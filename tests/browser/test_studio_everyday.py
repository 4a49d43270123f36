"""Everyday use of the studio: time on the board, documented keys, remembered choices."""

import pytest

from tests.helpers.browser import eventually, expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened, place
from worldgen import generate
from worldgen.files.grid import write_world
from worldgen.timeline import CellState

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
        expect(page.locator(".time-slider output")).not_to_have_text("0.0 s")
        eventually(page, lambda: pixels(page) != before)
        expect(page.locator(".time-slider .legend li:visible").first).to_have_text("burns later")

        # An empty field is automatic, and a parameter without effect is not shown.
        page.get_by_role("tab", name="Generate").click()
        page.get_by_label("Family", exact=True).select_option("maze")
        newest = page.get_by_label("Newest")
        expect(newest).to_be_hidden()
        page.get_by_label("Algorithm").select_option("growing-tree")
        expect(newest).to_be_visible()
        expect(newest).to_have_attribute("placeholder", "automatic")

        # Ctrl+M leads back to the board.
        page.keyboard.press("2")
        page.locator(".result").first.wait_for()
        page.keyboard.press("Control+m")
        expect(page.locator("#board")).to_be_focused()

        # The theme and the set-up, even one that has not been run, survive a reload.
        page.keyboard.press("2")
        page.get_by_label("Steps", exact=True).fill("321")
        page.locator("#run").click()
        page.locator("#run-said:empty").wait_for(state="attached")
        page.locator("#theme").click()
        page.locator("#play").get_by_label("thesis-3").check()
        page.reload()
        page.locator(".result").first.wait_for()
        expect(page.get_by_label("Steps", exact=True)).to_have_value("321")
        expect(page.locator("html")).to_have_attribute("data-theme", "dark")
        expect(page.locator("#play").get_by_label("thesis-3")).to_be_checked()
        assert page.complaints == []


def test_space_plays_whatever_was_clicked_before(browser, gate):
    with opened(browser, gate) as page:
        page.locator("#board").focus()
        page.keyboard.press("2")
        page.locator(".result").first.wait_for()
        plays = page.locator("#play-pause[aria-label=Pause]")
        stands = page.locator("#play-pause[aria-label=Play]")
        robot = page.locator("#play").get_by_label("thesis-3")

        def plays_after(act):
            page.keyboard.press("Home")
            stands.wait_for()
            act()
            page.keyboard.press("Space")
            plays.wait_for()
            page.locator("#stage").click()
            page.keyboard.press("Space")

        plays_after(robot.click)
        expect(robot).to_be_checked()
        plays_after(lambda: page.locator("#play .motion select").select_option("stepped"))
        plays_after(page.get_by_label("Steps", exact=True).click)
        plays_after(page.locator("#run").focus)
        # A message goes with its error.
        page.get_by_label("Steps", exact=True).fill("0")
        page.locator("#run").click()
        said = page.locator("#run-said", has_text="a setting is not valid")
        said.wait_for()
        page.get_by_label("Steps", exact=True).fill("321")
        page.keyboard.press("Tab")
        said.wait_for(state="hidden")
        # After Tab, Space presses what has the focus.
        page.locator("#theme").focus()
        page.keyboard.press("Shift+Tab")
        page.keyboard.press("Tab")
        page.keyboard.press("Space")
        page.locator("html[data-theme=dark]").wait_for()
        expect(stands).to_have_count(1)


def test_a_wall_that_burns_away_is_hatched_on_the_board(browser, gate):
    world = generate("fire", 3)
    x, y = first_door(world)
    with opened(browser, gate) as page:
        page.get_by_label("Path", exact=True).uncheck()
        where = [*place(page, x + 0.05, y + 0.05), *place(page, x + 0.95, y + 0.95)]
        eventually(page, lambda: colours_in(page, where), lambda count: count > 3)
        page.locator("#board-time").focus()
        page.keyboard.press("End")
        # Only floor, burnt or not, and its grid.
        eventually(page, lambda: colours_in(page, where), lambda count: count <= 3)


def first_door(world):
    """Return a wall cell that a fire opens."""
    _, columns, rows, states = world.timeline.columns
    opens = states == CellState.FREE
    found = zip(columns[opens].tolist(), rows[opens].tolist(), strict=True)
    return next((ix, iy) for ix, iy in found if world.walls[iy, ix])


def colours_in(page, box):
    """Return how many colours the board has in a box in the window."""
    return page.evaluate(
        """([left, bottom, right, top]) => {
          const canvas = document.querySelector("#board");
          const { x, y } = canvas.getBoundingClientRect();
          const context = canvas.getContext("2d");
          const image = context.getImageData(left - x, top - y, right - left, bottom - top);
          return new Set(new Uint32Array(image.data.buffer)).size;
        }""",
        box,
    )
