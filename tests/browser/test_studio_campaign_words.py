"""The texts of the studio's campaign page while data is still missing, and the consistency of its
numbers.
"""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from fuzz.failure import Failure
from tests.helpers.browser import eventually, expect
from tests.helpers.studio import page_of, studio_of
from tests.helpers.studio_campaign import begin, watch
from tests.helpers.studio_held import hold, let_go
from tests.helpers.studio_page import opened

pytestmark = pytest.mark.nightly

FAILURES = Path(__file__).parents[2] / "corpora/failures/turn-right/swept"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a finished campaign.

    One cause was met in natural worlds only, one is known, and the failures of one were deleted.
    """
    folder = tmp_path_factory.mktemp("words")
    shutil.copytree(FAILURES, folder / "collected")
    with studio_of(folder) as gate, page_of(gate) as page:
        assert "answer" in begin(page, "done", units=2)
        watch(page, "done")
    summary = folder / "done/.campaign/summary.json"
    said = json.loads(summary.read_text())
    groups = [Failure.read(path).group for path in (folder / "done").glob("*.grid")]
    natural = next(group for group in groups if group in said["met"])
    said["met"] = {"crash-deleted": said["met"].pop(natural), "crash-known": 4, **said["met"]}
    said["known"] = {"crash-known": 4}
    summary.write_text(json.dumps(said))
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder) as gate:
        yield gate


@pytest.fixture
def page(browser, gate):
    with opened(browser, gate, until=None) as page:
        yield page


def reopened(page, *held):
    """Reload the campaign page, and hold back its requests of these kinds."""
    hold(page, *held)
    page.keyboard.press("3")
    page.reload()


def test_the_line_the_table_and_the_wall_name_the_same_number_of_causes(page):
    reopened(page)
    of_the_wall = re.compile(r"^(\d+) failures of (\d+) causes?$")
    of_the_line = re.compile(r"(\d+) causes: (\d+) known, (\d+) not kept")
    expect(page.locator("#wall-count")).to_have_text(of_the_wall)
    expect(page.locator("#progress-line")).to_have_text(of_the_line)
    count = page.locator("#wall-count").inner_text()
    pictures, shown = map(int, of_the_wall.match(count).groups())
    line = page.locator("#progress-line").inner_text()
    causes, known, lost = map(int, of_the_line.search(line).groups())
    rows = page.locator(".tables tbody").first.locator("tr")
    expect(rows).to_have_count(causes)
    expect(page.locator(".card")).to_have_count(pictures)
    assert (known, lost) == (1, 1) and shown == causes - known - lost
    met = rows.locator("td:nth-child(2)").all_inner_texts()
    assert (
        "not by the search" in met
        and f"{sum(int(text) for text in met if text.isdigit())} failures met" in line
    )


def test_while_the_folder_is_being_read_no_cause_is_said_to_wait_for_anything(page):
    reopened(page, "failures")
    page.locator("#campaign-state", has_text="Done").wait_for()
    sizes = page.locator(".tables tbody").first.locator("td:nth-child(3)")
    eventually(page, lambda: set(sizes.all_inner_texts()), lambda words: words == {"…", "known"})
    expect(page.locator("#progress-line")).not_to_contain_text("cause")
    let_go(page)
    page.locator(".card").first.wait_for()
    eventually(page, sizes.all_inner_texts, lambda words: {"not kept", "known"} < set(words))


def test_another_folder_s_failures_are_in_no_number_of_a_campaign(page):
    reopened(page)
    page.locator("#campaign-folder").select_option("collected")
    page.locator("#name", has_text="collected").wait_for()
    page.locator("#wall-count", has_text=re.compile(r"^\d+ failures of \d+ causes?$")).wait_for()
    page.evaluate("window.heldKinds.push('failures')")
    page.locator("#campaign-folder").select_option("done")
    page.locator("#campaign-state", has_text="Done").wait_for()
    page.locator(".wall .empty", has_text="Looking through done …").wait_for()
    expect(page.locator(".tables", has_text="not by the search")).to_have_count(0)
    expect(page.locator(".card")).to_have_count(0)


def test_what_was_chosen_in_the_form_is_there_again_with_the_next_server(browser, folder):
    with studio_of(folder) as gate, opened(browser, gate, until=None) as page:
        page.keyboard.press("3")
        page.locator("#campaign-controller").select_option("bug1")
        page.get_by_label("From these strategies and families").check()
        page.locator("#campaign-strategies").get_by_label("maze", exact=True).check()
        page.get_by_label("Units of work").check()
        page.locator("#campaign-amount").fill("7")
        page.get_by_role("textbox", name="Seed").fill("12")
        page.get_by_text("More", exact=True).click()
        page.get_by_label("Worlds per unit").fill("9")
        page.keyboard.press("Tab")
        kept = page.evaluate("JSON.stringify(localStorage)")
    with studio_of(folder) as gate, opened(browser, gate, until=None) as page:
        page.evaluate("kept => Object.assign(localStorage, JSON.parse(kept))", kept)
        page.keyboard.press("3")
        page.goto(gate.address)
        page.keyboard.press("3")
        page.locator("#campaign-controller").wait_for()
        strategies = page.locator("#campaign-strategies")
        expect(page.locator("#campaign-controller")).to_have_value("bug1")
        expect(strategies.get_by_label("maze", exact=True)).to_be_checked()
        expect(page.get_by_label("Units", exact=True)).to_have_value("7")
        expect(page.get_by_role("textbox", name="Seed")).to_have_value("12")
        expect(page.get_by_label("Worlds per unit")).to_have_value("9")


def test_a_test_that_was_copied_runs_as_pasted_and_is_formatted(browser, gate, folder, tmp_path):
    with opened(
        browser, gate, until=None, permissions=["clipboard-read", "clipboard-write"]
    ) as page:
        page.keyboard.press("3")
        page.locator("#campaign-folder").select_option("collected")
        page.locator(".card[data-verdict=loop]").first.click()
        page.get_by_role("button", name="Copy test").click()
        page.get_by_role("button", name="Copied").wait_for()
        (tmp_path / "test_pasted.py").write_text(page.evaluate("navigator.clipboard.readText()"))
    pytest.importorskip("ruff", reason="no formatter here")
    python = [sys.executable, "-m"]
    subprocess.run(
        [*python, "ruff", "format", "--isolated", "--check", "."],
        cwd=tmp_path,
        check=True,
        timeout=60,
    )
    pytest_there = [*python, "pytest", "-q", "-p", "no:cacheprovider"]
    tried = subprocess.run(
        pytest_there, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
    assert "1 failed" in tried.stdout and "loop forever" in tried.stdout


def test_campaigns_failures_come_after_the_user_s_own_worlds(page, folder):
    (folder / "zoo").mkdir()
    shutil.copy(next(FAILURES.glob("*.grid")), folder / "zoo/mine.grid")
    page.locator("#tab-files").click()
    page.locator(".files").first.get_by_text("zoo/mine.grid").wait_for()
    page.get_by_text("Found by campaigns").wait_for()
    expect(page.locator(".files").first).not_to_contain_text("done/")
    page.get_by_text("Found by campaigns").click()
    page.get_by_role("list", name="Found by campaigns").get_by_role("button").first.click()
    page.locator("#name", has_text="done/").wait_for()
