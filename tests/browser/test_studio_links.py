"""The first minute, and links to what a page shows."""

import re
import shutil
from pathlib import Path

import pytest

from tests.helpers.browser import eventually, expect
from tests.helpers.fleets import passage
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened
from worldgen import generate
from worldgen.files.grid import write_world

CORPORA = Path(__file__).parents[2] / "corpora"


@pytest.mark.gate
def test_an_example_and_the_tour_are_there_to_begin_with_and_links_lead_to_run_and_failure(
    browser, tmp_path
):
    (tmp_path / "found").mkdir()
    shutil.copy(CORPORA / "thesis/config-05.grid", tmp_path)
    shutil.copy(CORPORA / "thesis-faults/thesis-1-loop-104.grid", tmp_path / "found")
    with studio_of(tmp_path) as gate, opened(browser, gate) as page:
        base = page.url.partition("#")[0]
        page.locator("#start-menu summary").click()
        page.locator("#take-tour").click()
        page.locator("#tour-next", has_text="Next").click()
        page.locator("#proof.toured").wait_for()
        page.keyboard.press("Escape")
        expect(page.locator(".tour")).to_be_hidden()

        page.goto(f"{base}#campaign?folder=found&failure=found/thesis-1-loop-104.grid")
        page.locator("#failure-cause b").wait_for()
        page.goto(
            f"{base}#play?world=config-05.grid&robots=thesis-1,thesis-2&motion=stepped&step=500"
        )
        page.locator(".result").nth(1).wait_for()
        page.locator("#readout", has_text="step 500 of").wait_for()
        expect(page).to_have_url(
            f"{base}#play?world=config-05.grid&robots=thesis-1,thesis-2&motion=stepped"
        )

        # A failure sets its own robot, whichever one ran before.
        page.goto(f"{base}#campaign?folder=found&failure=found/thesis-1-loop-104.grid")
        page.locator("#open-play").click()
        page.locator("#name", has_text="thesis-1-loop-104.grid").wait_for()
        page.wait_for_function("() => document.querySelectorAll('.result').length === 1")
        expect(page.locator("#play .robots input:checked")).to_have_count(1)
        expect(page.locator("#play .robots input:checked")).to_have_value("thesis-1")

        page.locator("#start-menu summary").click()
        page.locator("[data-example=fire]").first.click()
        page.locator("#board-time").wait_for()
        assert page.complaints == []


@pytest.mark.gate
def test_a_link_shows_the_same_in_a_fresh_browser_or_says_what_is_missing(browser, tmp_path):
    (tmp_path / "found").mkdir()
    shutil.copy(CORPORA / "thesis/config-05.grid", tmp_path)
    shutil.copy(CORPORA / "thesis-faults/thesis-1-loop-104.grid", tmp_path / "found")
    with studio_of(tmp_path) as gate:
        with opened(browser, gate) as page:
            base = page.url.partition("#")[0]
            page.locator("#start-menu summary").click()
            page.locator("[data-example=trap]").first.click()
            page.wait_for_function("() => location.hash.includes('family=trap')")
            page.locator(".status", has_text="30 x 30 cells").wait_for()
            words = page.locator(".status .place").inner_text()
            made = page.url.partition("#")[2]
            # Drawing on makes it another world.
            page.locator("#board").focus()
            page.keyboard.press("Space")
            page.keyboard.press("Space")
            page.wait_for_function("() => !location.hash.includes('family')")

        def fresh(link, until):
            with opened(browser, gate, until=None) as page:
                page.goto(f"{base}#{link}")
                page.locator(*until[:1], **until[1]).first.wait_for()
                assert page.complaints == []
                return page.locator(until[0]).first.inner_text()

        assert fresh(made, (".status .place", {"has_text": "30 x 30 cells"})) == words
        # A link without robots runs the usual one.
        assert "loop" in fresh("play?world=config-05.grid", (".result", {}))
        gone = fresh(
            "play?world=config-05.grid&robots=gone,thesis-1", ("#gone", {"has_text": "gone"})
        )
        assert gone.startswith("This studio cannot run gone from the link.")
        nothing = "campaign?folder=found&failure=found/nothing.grid"
        assert fresh(nothing, (".wall-part .notice", {"has_text": "is not in found"}))
        assert fresh("campaign?folder=lost", ("#campaign .said", {"has_text": "no folder lost"}))


@pytest.mark.nightly
def test_a_message_about_a_link_goes_with_the_next_world(browser, tmp_path):
    with studio_of(tmp_path) as gate, opened(browser, gate) as page:
        page.goto(f"{page.url.partition('#')[0]}#draw?world=nothing.grid")
        page.locator("#gone", has_text="nothing.grid").wait_for()
        page.locator("#start-menu summary").click()
        page.locator("[data-example=maze]").first.click()
        page.locator("#gone").wait_for(state="hidden")


@pytest.mark.nightly
def test_a_link_to_an_unknown_family_says_so_and_opens_no_other_world(browser, tmp_path):
    shutil.copy(CORPORA / "thesis/config-05.grid", tmp_path)
    with studio_of(tmp_path, file="config-05.grid") as gate, opened(browser, gate) as page:
        base = page.url.partition("#")[0]
        page.goto("about:blank")
        page.goto(f"{base}#draw?family=nothing&world_seed=1")
        page.locator("#gone", has_text="nothing").wait_for()
        page.wait_for_load_state("networkidle")
        expect(page.locator("#gone")).to_be_visible()
        expect(page.locator("#name")).to_have_text("not saved yet")


@pytest.mark.nightly
def test_a_link_to_the_generated_world_that_is_shown_generates_nothing(browser, tmp_path):
    with studio_of(tmp_path) as gate, opened(browser, gate) as page:
        base = page.url.partition("#")[0]
        page.goto(f"{base}#draw?family=trap")
        page.locator("#said", has_text="Opened trap 1").wait_for(state="attached")
        page.wait_for_function("() => location.hash.includes('world_seed=1')")
        page.evaluate("document.getElementById('said').textContent = ''")
        page.goto(f"{base}#draw?world_seed=1&family=trap")
        page.wait_for_timeout(1500)
        expect(page.locator("#said")).to_have_text("")
        page.goto(f"{base}#draw?family=trap&world_seed=2")
        page.locator("#said", has_text="Opened trap 2").wait_for(state="attached")


@pytest.mark.gate
def test_on_a_phone_the_menu_and_every_place_of_the_tour_can_be_seen(browser, tmp_path):
    phone = {"viewport": {"width": 390, "height": 844}, "has_touch": True}
    with studio_of(tmp_path) as gate, opened(browser, gate, **phone) as page:
        page.locator("#start-menu summary").click()
        box = page.locator("#start-menu .menu").bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= 390
        page.locator("#take-tour").click()
        for number in range(1, 9):
            page.locator(".tour", has_text=f"{number} of 8").wait_for()
            if number == 5:
                page.locator(".result").wait_for()
            eventually(
                page,
                lambda: (middle_of_toured(page), page.locator(".tour").bounding_box()),
                is_seen,
            )
            page.locator("#tour-next").click()
        assert page.complaints == []


def middle_of_toured(page):
    """Return the height of the middle of the part that the tour shows, as far as it is in sight."""
    return page.locator(".toured").evaluate(
        """(shown) => {
          const { top, bottom } = shown.getBoundingClientRect();
          return (Math.max(top, 0) + Math.min(bottom, innerHeight)) / 2;
        }"""
    )


def is_seen(places):
    """Return whether a part is in the window of a phone, and not under the tour's card."""
    middle, card = places
    return 0 < middle < 844 and not card["y"] < middle < card["y"] + card["height"]


@pytest.mark.nightly
def test_a_fleet_runs_without_any_choice_under_a_model_that_takes_it(browser, tmp_path):
    write_world(generate("crossing", 3), tmp_path / "fleet.grid")
    with studio_of(tmp_path, file="fleet.grid") as gate, opened(browser, gate) as page:
        page.locator(".status", has_text="4 robots; the tools move robot 1").wait_for()
        page.keyboard.press("2")
        page.locator(".result", has_text="naive").first.wait_for()
        expect(page.locator(".result")).to_have_count(1)
        expect(page.locator(".result")).to_contain_text("reached")
        assert page.complaints == []


@pytest.mark.nightly
def test_a_fleet_that_cannot_arrive_together_is_called_blocked_in_draw_and_play(browser, tmp_path):
    write_world(passage(), tmp_path / "swap.grid")
    with studio_of(tmp_path, file="swap.grid") as gate, opened(browser, gate) as page:
        expect(page.locator("#proof")).to_have_text(re.compile("^✗ blocked: robots 1 and 2"))
        page.keyboard.press("2")
        expect(page.locator(".result .note")).to_have_text(
            "The robots cannot all arrive in this world, whatever the controllers do "
            "(proved by a swap)."
        )
        assert page.complaints == []
