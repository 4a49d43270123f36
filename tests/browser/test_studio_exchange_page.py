"""Import and export in the studio, by mouse and keyboard."""

import re

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from worldgen import generate
from worldgen.files.grid import write_world

pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exchange")
    write_world(generate("corridor", 3), folder / "w.grid")
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder) as gate:
        yield gate


def scenario_in(folder):
    """A MovingAI map of 8 x 4 cells with three problems next to it."""
    (folder / "a.map").write_text("type octile\nheight 4\nwidth 8\nmap\n" + "........\n" * 4)
    rows = [f"0\ta.map\t8\t4\t{column}\t1\t6\t2\t5\n" for column in (1, 2, 3)]
    (folder / "a.map.scen").write_text("version 1\n" + "".join(rows))
    return folder / "a.map", folder / "a.map.scen"


def test_a_map_is_imported_again_with_other_options_and_another_row_and_its_like_begins_anew(
    page, folder, tmp_path
):
    (tmp_path / "x.bin").write_bytes(b"junk")
    pair = scenario_in(tmp_path)
    page.locator("#tab-files").click()
    page.get_by_text("Import and export").click()
    page.locator("#import").set_input_files(pair)
    page.get_by_text("Row 1 of the 3 of its scenario.").wait_for()
    page.get_by_text("Import options").click()
    more = page.locator("#import-more")
    more.get_by_label("Scenario row").fill("4")
    more.get_by_role("button", name="Import again").click()
    more.get_by_text("Enter a whole number from 1 to 3.").wait_for()
    more.get_by_label("Scenario row").fill("3")
    more.get_by_label("Cell size").fill("0.5")
    more.get_by_label("Cell size").press("Enter")
    page.get_by_text("Row 3 of the 3 of its scenario.").wait_for()
    page.locator("#place", has_text="8 x 4 cells, 0 solid · 4.00 x 2.00 m").wait_for()
    page.locator("#import").set_input_files(pair[:1])
    page.get_by_text(re.compile("^Imported a.map.$")).wait_for()
    expect(more.get_by_label("Cell size")).to_have_value("0.1")
    page.get_by_text("Import options").click()
    page.locator("#import").set_input_files(tmp_path / "x.bin")
    page.get_by_text("choose one of the formats listed in Import options").wait_for()
    more.get_by_label("Format").wait_for()  # it has opened
    assert page.complaints == []
