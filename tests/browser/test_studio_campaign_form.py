"""The studio's campaign page before a campaign has begun:

its form, and the failures that are already in the folder.
"""

import shutil
from pathlib import Path

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_held import hold, let_go
from tests.helpers.studio_page import opened

pytestmark = pytest.mark.gate

FAILURE = next(Path(__file__).parents[2].glob("corpora/failures/**/*.grid"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Make a folder with more failures than fit into a window, and a damaged file."""
    folder = tmp_path_factory.mktemp("form")
    (folder / "mine/deep").mkdir(parents=True)
    for number in range(300):
        shutil.copy(FAILURE, folder / f"mine/deep/{number}.grid")
    (folder / "mine/cut.grid").write_bytes(FAILURE.read_bytes()[:200])
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder) as gate:
        yield gate


@pytest.fixture
def page(browser, gate):
    allowed = ["clipboard-read", "clipboard-write"]
    with opened(browser, gate, until=None, permissions=allowed) as page:
        yield page


@pytest.mark.nightly
def test_the_form_says_at_the_field_what_is_wrong_and_gives_the_line_for_a_terminal(page, folder):
    page.keyboard.press("3")
    page.locator("#begin").wait_for()
    expect(page.locator("#save-drawn")).to_be_hidden()
    seed = page.get_by_role("textbox", name="Seed")
    seed.fill("one")
    page.locator("#campaign-amount").fill("-3")
    page.get_by_role("button", name="Begin").click()
    page.wait_for_function("() => document.activeElement.id === 'campaign-amount'")
    expect(page.locator(".campaign-form small.fault:visible")).to_have_text(
        ["Enter a whole number from 1 to 604,800.", "Enter a whole number of at least 0."]
    )
    page.locator("#campaign-amount").fill("20")
    seed.fill("7")
    page.get_by_role("button", name="Copy command").click()
    page.get_by_role("button", name="Copied").wait_for()
    line = page.evaluate("navigator.clipboard.readText()")
    assert line.startswith(
        "worldgen fuzz --controller turn-right --motion swept --seed 7 --budget 20s --workers"
    )
    assert line.endswith(f"--out {folder}/turn-right-swept") and page.complaints == []


def test_a_campaign_of_several_robots_is_set_up_in_the_form(page):
    page.keyboard.press("3")
    page.locator("#begin").wait_for()
    robots = page.get_by_role("spinbutton", name="Robots")
    robots.fill("101")
    page.get_by_role("button", name="Copy command").click()
    page.locator(".campaign-form small.fault", has_text="from 1 to 100").wait_for()
    robots.fill("3")
    page.get_by_role("button", name="Copy command").click()
    page.get_by_role("button", name="Copied").wait_for()
    assert " --robots 3 " in page.evaluate("navigator.clipboard.readText()")
    # The number is kept for the folder.
    page.reload()
    page.wait_for_function("() => document.querySelector('input[name=robots]')?.value === '3'")
    robots.fill("")
    page.get_by_role("button", name="Copy command").click()
    page.get_by_role("button", name="Copied").wait_for()
    assert "--robots" not in page.evaluate("navigator.clipboard.readText()")


def test_of_many_failures_only_those_in_sight_are_drawn_and_damaged_files_are_told(page, folder):
    page.keyboard.press("3")
    page.locator("#campaign-folder").select_option("mine")
    page.locator("#wall-count", has_text="300 failures").wait_for()
    page.locator(".wall-part .notice", has_text="cut.grid").wait_for()
    expect(page.locator(".card")).to_have_count(120)
    page.get_by_role("button", name="Show more (180)").click()
    expect(page.locator(".card")).to_have_count(240)
    expect(page.locator("#name")).to_have_text("mine")


@pytest.mark.nightly
def test_the_page_has_words_and_the_form_before_the_folder_has_been_read(page):
    hold(page, "campaigns")
    page.keyboard.press("3")
    page.reload()
    page.locator(".wall .empty", has_text="Looking through the opened folder …").wait_for()
    expect(page.locator("#name")).to_have_text("looking …")
    page.locator("#campaign-controller").wait_for()
    page.get_by_role("button", name="Begin").wait_for()
    let_go(page)
    page.locator("#campaign-folder option", has_text="mine").first.wait_for(state="attached")


def test_begin_is_in_sight_however_long_the_form_is(page):
    page.keyboard.press("3")
    page.get_by_text("More", exact=True).click()
    box = page.locator("#begin").bounding_box()
    assert box["y"] > 0 and box["y"] + box["height"] <= page.viewport_size["height"]
