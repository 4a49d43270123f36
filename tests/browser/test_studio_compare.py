"""The table of several controllers over several worlds: verdicts, a click that plays, a link."""

import re
import shutil
from pathlib import Path

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened

CORPORA = Path(__file__).parents[2] / "corpora"


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    (folder / "maps").mkdir()
    for number in (1, 5):
        shutil.copy(CORPORA / f"thesis/config-0{number}.grid", folder / "maps")
    with studio_of(folder) as gate:
        yield gate


@pytest.mark.gate
def test_a_table_fills_and_a_click_plays_its_run_and_a_link_makes_it_again(browser, gate):
    with opened(browser, gate) as page:
        page.keyboard.press("4")
        page.get_by_label("maps (2 worlds)").check()
        page.locator("#compare").get_by_label("vfh").uncheck()
        page.locator("#run-compare").click()
        page.locator(".comparison tfoot td").nth(1).wait_for()
        # A colour and a word in each cell.
        expect(page.locator(".cell b")).to_have_count(10)
        words = page.locator(".cell b").all_inner_texts()
        verdicts = page.locator("td:has(.cell)").evaluate_all(
            "all => all.map(one => one.dataset.verdict)"
        )
        assert words == verdicts and {"loop", "reached"} <= set(words)
        link = "#compare?robots=turn-right,bug2&motion=swept&worlds=examples,folder:maps"
        expect(page).to_have_url(re.compile(re.escape(link) + "$"))

        # A click plays the run of the cell: the same world, robot, verdict and steps.
        cell = page.locator("tr", has_text="config-05").locator(".cell").nth(1)
        facts = cell.inner_text()
        cell.click()
        page.locator(".result[data-controller=bug2]").wait_for()
        page.locator("#name", has_text="maps/config-05.grid").wait_for()
        assert "reached" in facts
        expect(page.locator(".result")).to_contain_text("reached")
        expect(page.locator(".result")).to_contain_text(facts.split(", ")[-1])
        assert page.complaints == []
    # The link makes the same table in a fresh browser.
    with opened(browser, gate) as page:
        page.goto(page.url.partition("#")[0] + link)
        page.locator(".comparison tfoot td").nth(1).wait_for()
        expect(page.locator(".cell b")).to_have_text(words)


@pytest.mark.nightly
def test_nothing_chosen_is_said_and_a_comparison_can_be_stopped(browser, gate):
    with opened(browser, gate) as page:
        page.keyboard.press("4")
        page.get_by_label("The examples").uncheck()
        page.locator("#run-compare").click()
        page.locator("#compare-said.bad", has_text="No world is chosen").wait_for()
        page.get_by_label("The examples").check()
        expect(page.locator("#compare-said")).to_have_text(re.compile("^Choose robots and worlds"))
        page.locator("#compare").get_by_label("turn-random").check()
        page.get_by_label("Runs per random robot").fill("1000")
        page.locator("#run-compare").click()
        page.locator("#stop-compare").click()
        page.locator("#compare-said", has_text="Stopped.").wait_for()
        expect(page.locator("#stop-compare")).to_be_hidden()
        assert page.complaints == []


@pytest.mark.gate
def test_on_a_phone_table_and_form_have_the_whole_width(browser, gate):
    with opened(browser, gate, viewport={"width": 390, "height": 844}) as page:
        page.locator("#tabs").get_by_role("link", name="Compare").click()
        for part in ("#compare .side", ".comparison-scroll"):
            page.locator(part).wait_for()
            assert page.locator(part).bounding_box()["width"] > 350
