"""The first minute, and links to what a page shows."""

import shutil
from pathlib import Path

import pytest

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
        assert page.locator(".tour").is_hidden()

        page.goto(f"{base}#campaign?folder=found&failure=found/thesis-1-loop-104.grid")
        page.locator("#failure-cause b").wait_for()
        page.goto(
            f"{base}#play?world=config-05.grid&robots=thesis-1,thesis-2&motion=stepped&step=500"
        )
        page.locator(".result").nth(1).wait_for()
        page.locator("#readout", has_text="step 500 of").wait_for()
        assert page.url.endswith(
            "#play?world=config-05.grid&robots=thesis-1,thesis-2&motion=stepped"
        )

        # A failure sets its own robot, whichever one ran before.
        page.goto(f"{base}#campaign?folder=found&failure=found/thesis-1-loop-104.grid")
        page.locator("#open-play").click()
        page.locator("#name", has_text="thesis-1-loop-104.grid").wait_for()
        page.wait_for_function("() => document.querySelectorAll('.result').length === 1")
        assert page.locator("#play .robots input:checked").evaluate_all(
            "boxes => boxes.map(box => box.value)"
        ) == ["thesis-1"]

        page.locator("#start-menu summary").click()
        page.locator("[data-example=fire]").first.click()
        page.locator("#board-time").wait_for()
        assert page.complaints == []


@pytest.mark.gate
def test_a_fleet_runs_without_any_choice_under_a_model_that_takes_it(browser, tmp_path):
    write_world(generate("crossing", 3), tmp_path / "fleet.grid")
    with studio_of(tmp_path, file="fleet.grid") as gate, opened(browser, gate) as page:
        page.locator(".status", has_text="4 robots; the tools move robot 1").wait_for()
        page.keyboard.press("2")
        page.locator(".result", has_text="naive").first.wait_for()
        assert page.locator(".result").count() == 1
        assert "reached" in page.locator(".result").inner_text()
        assert page.complaints == []


@pytest.mark.gate
def test_a_fleet_that_cannot_arrive_together_is_called_blocked_in_draw_and_play(browser, tmp_path):
    write_world(passage(), tmp_path / "swap.grid")
    with studio_of(tmp_path, file="swap.grid") as gate, opened(browser, gate) as page:
        assert page.locator("#proof").inner_text().startswith("✗ blocked: robots 1 and 2")
        page.keyboard.press("2")
        note = page.locator(".result .note")
        note.wait_for(timeout=60_000)
        assert note.inner_text() == (
            "The robots cannot all arrive in this world, whatever the controllers do "
            "(proved by a swap)."
        )
        assert page.complaints == []
