"""The studio's campaign page in a browser.

A campaign from the form to its smallest failure in the player.
"""

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_campaign import HANGS, acts
from tests.helpers.studio_page import CAMPAIGN, opened
from worldgen.files.grid import read_world

pytestmark = pytest.mark.nightly


def begin(page, *, units):
    """Fills the form with the mouse and the keyboard, and begins."""
    page.get_by_label("From these strategies and families").check()
    page.locator("#campaign-strategies").get_by_label("trap", exact=True).check()
    page.get_by_label("Units of work").check()
    page.locator("#campaign-amount").fill(str(units))
    page.get_by_text("More", exact=True).click()
    page.get_by_label("Worlds per unit").fill("8")
    page.get_by_role("button", name="Begin").press("Enter")


def stands(page, words):
    page.locator("#campaign-state", has_text=words).wait_for(timeout=CAMPAIGN)


def units(page):
    return int(page.locator(".progress-line").inner_text().split("unit ")[1].split(" of")[0])


@pytest.fixture
def page(browser, tmp_path):
    allowed = ["clipboard-read", "clipboard-write"]
    with (
        studio_of(tmp_path) as gate,
        opened(browser, gate, until=None, permissions=allowed) as page,
    ):
        yield page


def test_what_never_begins_is_stopped_by_keyboard_and_another_can_begin(browser, tmp_path):
    (tmp_path / "mine.py").write_text(HANGS)
    with (
        studio_of(tmp_path, named=[f"{tmp_path}/mine.py:Robot"]) as gate,
        opened(browser, gate, until=None) as page,
    ):
        page.keyboard.press("3")
        page.locator(".wall .empty", has_text="Start a campaign on the right").wait_for()
        expect(page.locator("#name")).to_have_text("no failures yet")
        page.locator("#begin").press("Enter")
        page.locator("#stop-beginning").wait_for()
        acts(tmp_path)
        page.keyboard.press("Tab")
        expect(page.locator("#stop-beginning")).to_be_focused()
        page.keyboard.press("Enter")
        page.locator("#form-said", has_text="stopped before it began").wait_for()
        expect(page.locator("#stop-beginning")).to_be_hidden()
        page.wait_for_function("() => document.activeElement.id === 'begin'")
        page.locator("#campaign-controller").select_option("turn-right")
        begin(page, units=1)
        page.locator("#campaign-state").wait_for(timeout=CAMPAIGN)
        assert page.complaints == []


def test_a_campaign_from_the_form_is_watched_stopped_resumed_and_its_smallest_failure_is_played(
    page, tmp_path
):
    page.keyboard.press("3")
    page.locator("#begin").wait_for()
    begin(page, units=5000)
    stands(page, "ing")  # preparing, searching, shrinking or explaining
    page.locator(".card").first.wait_for(timeout=CAMPAIGN)
    page.reload()  # the campaign continues, and is shown again
    stands(page, "ing")
    page.get_by_role("button", name="Stop").click()
    stands(page, "Stopped")
    before = units(page)
    page.get_by_role("button", name="Resume").click()
    stands(page, "ing")
    page.wait_for_function(
        "before => Number(document.querySelector('.progress-line').innerText.match(/unit "
        "(\\d+)/)?.[1]) > before",
        arg=before,
        timeout=CAMPAIGN,
    )
    page.get_by_role("button", name="Stop").click()
    stands(page, "Stopped")
    page.locator("[data-filter=sort]").select_option("size")
    page.locator(".card").first.press("Enter")
    name = page.locator("#failure-panel td").last.inner_text()
    world = read_world(tmp_path / name)
    assert world.solid_cells == min(
        read_world(path).solid_cells for path in (tmp_path / name).parent.glob("*.grid")
    )
    page.get_by_role("button", name="Copy replay line").click()
    page.get_by_role("button", name="Copied").wait_for()
    assert page.evaluate("navigator.clipboard.readText()") == f"worldgen replay {tmp_path / name}"
    page.get_by_role("button", name="Mark as known").click()
    page.locator(".card .known").first.wait_for()
    page.locator("#open-play").click()
    page.locator(".digest", has_text=world.failure.trace_digest).wait_for()
    assert page.complaints == []
