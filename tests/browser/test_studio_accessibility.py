"""The studio for people who only use the keyboard, a screen reader or a finger, or who see colours
differently.
"""

import re
import shutil
from pathlib import Path

import pytest

from tests.helpers.accessibility import COARSE, FINE, complaints, tab_through
from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import CAMPAIGN, expect_solid_cells, opened
from worldgen.files.grid import read_world

CORPORA = Path(__file__).parents[2] / "corpora"
BORDER = 156  # solid cells of an empty world of 40 x 40
TABLET = {"viewport": {"width": 1024, "height": 768}, "has_touch": True}
UPRIGHT = {"viewport": {"width": 768, "height": 1024}, "has_touch": True}


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("accessible")
    shutil.copy(CORPORA / "thesis/config-05.grid", folder)
    (folder / "found").mkdir()
    for name in ("thesis-1-loop-104", "thesis-2-corner-tunnel"):
        shutil.copy(CORPORA / f"thesis-faults/{name}.grid", folder / "found")
    with studio_of(folder) as gate:
        yield gate


def go(page, name):
    """Go to another page by its link, because a focused field would take the keys."""
    page.locator("#tabs").get_by_role("link", name=name).click()


def states(page):
    """Go through the studio's views, and name each one."""
    yield "the board and its world"
    page.locator("#tab-maker").click()
    page.locator("#tools").get_by_role("button", name="Keys").click()
    yield "the keys"
    page.keyboard.press("Escape")
    yield "the generator"
    page.locator("#tab-files").click()
    page.get_by_text("Import and export").click()
    page.locator(".palette [data-tool=select]").click()
    page.locator(".file", has_text="config-05.grid").click()
    page.get_by_text("Opened config-05.grid").first.wait_for()
    yield "files, and a selection"
    go(page, "Play")
    page.get_by_role("checkbox", name="thesis-1 (turn-right)").check()
    page.locator("#run").click()
    page.locator(".result").nth(1).wait_for()
    page.locator("#show-arbitration").click()
    page.locator(".save summary").click()
    yield "two robots, the flow chart of one, and what can be saved"
    go(page, "Campaign")
    page.locator(".card").nth(1).wait_for()
    page.get_by_label("From these strategies and families").check()
    page.get_by_text("More", exact=True).click()
    yield "the form of a campaign"
    page.locator(".card").first.click()
    page.locator("#failure-panel .actions").wait_for()
    yield "a failure"


@pytest.mark.parametrize(
    ("how", "least"),
    [
        pytest.param({"color_scheme": "light"}, FINE, marks=pytest.mark.gate, id="light"),
        pytest.param({"color_scheme": "dark"}, FINE, marks=pytest.mark.nightly, id="dark"),
        pytest.param(
            {"color_scheme": "light", **TABLET}, COARSE, marks=pytest.mark.nightly, id="tablet"
        ),
        pytest.param(
            {"color_scheme": "dark", **UPRIGHT},
            COARSE,
            marks=pytest.mark.nightly,
            id="tablet-upright",
        ),
    ],
)
def test_names_contrast_and_sizes_are_right_on_every_page(browser, gate, how, least):
    with opened(browser, gate, **how) as page:
        found = {state: complaints(page, least=least) for state in states(page)}
        assert {state: said for state, said in found.items() if said} == {}
        expect(page.locator("html")).to_have_attribute("data-theme", how["color_scheme"])
        assert page.complaints == []


@pytest.mark.nightly
def test_tab_reaches_every_control_and_the_focus_is_seen(page):
    found = {state: tab_through(page) for state in states(page)}
    assert {state: said for state, said in found.items() if said} == {}


@pytest.mark.gate
def test_the_first_tab_offers_to_skip_to_the_board(page):
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.locator("#board")).to_be_focused()


@pytest.mark.gate
def test_a_wall_is_drawn_the_start_moved_and_a_run_scrubbed_by_keys_alone(page):
    page.locator("#board").focus()
    page.keyboard.press("l")
    for key in ("Space", "Shift+ArrowRight", "Shift+ArrowRight", "Space"):
        page.keyboard.press(key)
    page.keyboard.press("a")
    for key in ("Shift+ArrowUp", "Space", "Space"):
        page.keyboard.press(key)
    expect(page.locator("#said")).to_contain_text("start")
    page.keyboard.press("2")
    page.locator(".result").wait_for()
    for key in ("Home", "Shift+ArrowRight", "ArrowLeft"):
        page.keyboard.press(key)
    page.locator("#readout", has_text="step 9 of").wait_for()
    page.keyboard.press("1")
    expect_solid_cells(page, BORDER + 11)


@pytest.mark.nightly
def test_a_campaign_is_begun_and_its_failure_opened_by_keys_alone(page):
    page.keyboard.press("3")
    page.locator("#campaign-amount").focus()
    page.keyboard.press("Control+a")
    page.keyboard.type("2")
    page.keyboard.press("Enter")
    page.locator("#campaign-state", has_text="Done").wait_for(timeout=CAMPAIGN)
    page.locator("#campaign-folder").focus()
    page.keyboard.type("found")
    page.locator(".card[data-failure='found/thesis-1-loop-104.grid']").focus()
    page.keyboard.press("Enter")
    page.locator("#open-play").focus()
    page.keyboard.press("Enter")
    record = read_world(CORPORA / "thesis-faults/thesis-1-loop-104.grid").failure
    page.locator(".digest", has_text=record.trace_digest).wait_for()


@pytest.mark.nightly
def test_the_thesis_s_keys_that_a_browser_leaves_to_a_page_do_what_they_did(page):
    page.keyboard.press("Control+i")  # the map into the simulator
    page.locator(".result").wait_for()
    page.keyboard.press("Home")
    page.keyboard.press("Control+p")  # plays; again: pauses
    page.locator("#play-pause[aria-label=Pause]").wait_for()
    page.keyboard.press("Control+p")
    page.locator("#play-pause[aria-label=Play]").wait_for()
    page.keyboard.press("Control+m")  # the map editor
    page.locator("#board").wait_for()
    page.keyboard.press("Control+b")  # the behaviours' settings
    page.get_by_label("Collide ticks").and_(page.locator(":focus")).wait_for()
    page.keyboard.press("Control+l")  # a map from a file
    page.locator("#tab-files:focus").wait_for()


@pytest.mark.gate
def test_what_is_seen_to_change_is_also_said(page):
    expect(page.locator("#proof")).to_have_attribute("role", "status")
    described = page.locator("#board").get_attribute("aria-describedby").split()
    for name, words in zip(described, ("40 x 40 cells", "reachable", "Arrow keys"), strict=True):
        expect(page.locator(f"#{name}")).to_contain_text(words)
    page.keyboard.press("2")
    page.locator("#said", has_text="thesis-2: reached").wait_for(state="attached")
    expect(page.locator("#stage")).to_have_attribute("aria-label", re.compile("thesis-2: reached"))


@pytest.mark.gate
def test_nothing_moves_by_itself(browser, gate):
    with opened(browser, gate, reduced_motion="reduce") as page:
        page.keyboard.press("2")
        page.locator(".result").wait_for()
        assert page.evaluate("document.getAnimations().length") == 0
        expect(page.locator("#play-pause")).to_have_attribute("aria-label", "Play")


@pytest.mark.nightly
def test_undo_is_offered_only_where_one_draws(page):
    expect(page.locator("#undo")).to_be_visible()
    go(page, "Play")
    page.locator("#undo").wait_for(state="hidden")
    expect(page.locator("#save-drawn")).to_be_visible()
