"""The studio's campaign page in a browser: a campaign from the form to its smallest failure in the player."""

import pytest

from tests.helpers.browser import missing_browser
from tests.helpers.studio import studio_of
from worldgen.grid_file import read_world

pytest.importorskip("playwright", reason="no playwright here: the studio is not tested in a browser")
pytestmark = pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "-")

from tests.helpers.studio_page import chromium_browser, opened  # noqa: E402

PATIENCE = 60_000  # ms that a campaign gets, for its process has to start and to compile


def begin(page, *, units):
    """Fills the form with the mouse and the keyboard, and begins."""
    page.get_by_label("Of these lanes and families").check()
    page.locator("#campaign-lanes").get_by_label("trap", exact=True).check()
    page.get_by_label("Units of work").check()
    page.locator("#campaign-amount").fill(str(units))
    page.get_by_text("More", exact=True).click()
    page.get_by_label("Draws a unit").fill("8")
    page.get_by_role("button", name="Begin").press("Enter")


def stands(page, words):
    page.locator("#campaign-state", has_text=words).wait_for(timeout=PATIENCE)


def units(page):
    return int(page.locator(".progress-line").inner_text().split("unit ")[1].split(" of")[0])


@pytest.fixture
def page(tmp_path):
    allowed = ["clipboard-read", "clipboard-write"]
    with (
        studio_of(tmp_path) as gate,
        chromium_browser() as browser,
        opened(browser, gate, permissions=allowed) as page,
    ):
        yield page


def test_a_campaign_from_the_form_is_watched_stopped_resumed_and_its_smallest_failure_is_played(page, tmp_path):
    page.keyboard.press("3")
    page.locator("#begin").wait_for()
    begin(page, units=5000)
    stands(page, "Running")
    page.locator(".card").first.wait_for(timeout=PATIENCE)
    page.reload()  # the campaign goes on, and is shown again
    stands(page, "Running")
    page.get_by_role("button", name="Stop").click()
    stands(page, "Stopped")
    before = units(page)
    page.get_by_role("button", name="Resume").click()
    stands(page, "Running")
    page.wait_for_function(
        "before => Number(document.querySelector('.progress-line').innerText.match(/unit (\\d+)/)[1]) > before",
        arg=before,
        timeout=PATIENCE,
    )
    page.get_by_role("button", name="Stop").click()
    stands(page, "Stopped")
    page.locator(".card").first.press("Enter")
    name = page.locator("#failure-panel td").last.inner_text()
    world = read_world(tmp_path / name)
    assert world.solid_cells == min(read_world(path).solid_cells for path in (tmp_path / name).parent.glob("*.grid"))
    page.get_by_role("button", name="Copy replay line").click()
    page.get_by_role("button", name="Copied").wait_for()
    assert page.evaluate("navigator.clipboard.readText()") == f"worldgen replay {tmp_path / name}"
    page.get_by_role("button", name="Mark as known").click()
    page.locator(".card .known").first.wait_for()
    page.locator("#open-play").click()
    page.locator(".digest", has_text=world.failure.trace_digest).wait_for()
    assert page.complaints == []
