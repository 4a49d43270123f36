"""Driving by hand on the page Play: with real keys, next to a controller."""

from pathlib import Path

import pytest

from tests.fuzz.test_studio_driving import CORRIDOR
from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened
from worldgen.files.grid import write_world

pytestmark = pytest.mark.gate


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder: Path = tmp_path_factory.mktemp("driving")
    write_world(CORRIDOR, folder / "corridor.grid")
    with studio_of(folder, file="corridor.grid") as gate:
        yield gate


def begin(page, by_key=True):
    """Begin to drive on the page Play, once its first run is done."""
    page.keyboard.press("2")
    page.locator(".result").first.wait_for()
    if by_key:
        page.keyboard.press("h")
    else:
        page.locator("#drive").click()
    page.locator("#drive", has_text="Stop").wait_for()


def test_a_robot_is_driven_to_the_target_next_to_a_controller(browser, gate):
    with opened(browser, gate) as page:
        begin(page)
        expect(page.locator("#run-said")).to_contain_text("arrow keys")
        # Nothing happens before the first key, however long the user waits.
        page.wait_for_timeout(400)
        expect(page.locator(".result")).to_have_count(1)
        page.keyboard.down("ArrowUp")
        page.locator("#run-said", has_text="You drove").wait_for()
        page.keyboard.up("ArrowUp")
        expect(page.locator("#run-said")).to_contain_text("reached")
        expect(page.locator("#drive")).to_have_text("Drive")
        expect(page.locator(".result")).to_have_count(2)
        for number, name in enumerate(("thesis-2", "you")):
            result = page.locator(".result").nth(number)
            expect(result).to_have_attribute("data-controller", name)
        # The page's keys work again.
        page.keyboard.press("ArrowLeft")
        expect(page.locator("[aria-current] .result")).to_have_attribute("data-controller", "you")


def test_escape_ends_a_drive_and_a_new_run_forgets_it(browser, gate):
    with opened(browser, gate) as page:
        begin(page, by_key=False)
        page.keyboard.down("s")
        page.locator(".result[data-controller=you]").wait_for()
        page.keyboard.up("s")
        page.keyboard.press("Escape")
        page.locator("#drive", has_text="Drive").wait_for()
        page.locator(".result[data-controller=you]", has_text="stopped by you").wait_for()
        page.locator("#run").click()
        page.locator(".result[data-controller=you]").wait_for(state="detached")


def test_another_page_ends_a_drive_so_that_its_keys_act_there(browser, gate):
    with opened(browser, gate) as page:
        begin(page)
        page.locator("#tabs a", has_text="Draw").click()
        page.locator("#board").wait_for()
        # On the board, W shows the path or hides it.
        shown = page.get_by_label("Path", exact=True)
        before = shown.is_checked()
        page.keyboard.press("w")
        expect(shown).to_be_checked(checked=not before)
        page.keyboard.press("2")
        page.locator("#drive", has_text="Drive").wait_for()


def test_a_finger_drives_with_the_arrows_in_the_picture(browser, gate):
    size = {"width": 412, "height": 900}
    with opened(browser, gate, has_touch=True, viewport=size) as page:
        begin(page, by_key=False)
        forward = page.get_by_role("button", name="Forward", exact=True)
        forward.scroll_into_view_if_needed()
        box = forward.bounding_box()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.mouse.down()
        page.locator("#run-said", has_text="You drove").wait_for()
        page.mouse.up()
        expect(page.locator("#run-said")).to_contain_text("reached")
        expect(forward).to_be_hidden()
        assert page.complaints == []
