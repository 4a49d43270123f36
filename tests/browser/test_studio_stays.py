"""The state of the studio's page that does not change, whatever arrives in the meantime."""

import re

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_held import hold, let_go
from worldgen import generate
from worldgen.files.grid import write_world

pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stays")
    write_world(generate("trap", 1), folder / "trap.grid")
    write_world(generate("corridor", 3), folder / "corridor.grid")
    with studio_of(folder, file="trap.grid") as gate:
        yield gate


def held(page, *kinds):
    """Reload the page, and hold back its requests of these kinds."""
    hold(page, *kinds)
    page.reload()


def has_asked(page):
    page.wait_for_function("() => window.held.length > 0")


def test_where_every_way_closes_is_known_after_saving_as_before(page):
    known = page.locator("#widest", has_text="Robots with a radius of up to")
    known.wait_for()
    words = known.inner_text()
    page.keyboard.press("Control+s")
    page.locator("#name:not(:has-text('changed'))").wait_for()
    page.locator("[role=status]", has_text="Saved trap.grid.").first.wait_for(state="attached")
    expect(known).to_have_text(words, use_inner_text=True)


def test_a_wrong_number_goes_with_the_world_for_which_it_was_typed(page):
    radius = page.get_by_role("spinbutton", name="Radius").first
    was = radius.input_value()
    radius.fill("-3")
    radius.press("Tab")
    expect(radius).to_have_attribute("aria-invalid", "true")
    page.locator("#tab-files").click()
    page.locator(".file", has_text="corridor.grid").click()
    page.locator("#name", has_text="corridor.grid").wait_for()
    page.locator("#tab-world").click()
    page.wait_for_function("() => !document.querySelector('#panel-world [aria-invalid]')")
    expect(radius).to_have_value(was)


def test_walls_that_were_to_change_places_and_no_more_are_to_stay_where_they_are(page):
    held(page, "shift")
    page.locator("#proof.good").wait_for()
    page.keyboard.press("2")
    page.locator(".result").first.wait_for()
    page.locator("#changes").check()
    has_asked(page)
    page.locator("#changes").uncheck()
    let_go(page)
    expect(page.locator("#changes")).not_to_be_checked()
    expect(page.locator("#name")).not_to_contain_text("changed")


def test_what_is_imported_while_the_page_begins_is_not_replaced_by_the_file_to_open_first(page):
    held(page, "hello")
    has_asked(page)
    page.locator("#tab-files").click()
    page.get_by_text("Import and export").click()
    page.locator("#import").set_input_files(
        {"name": "open.map", "mimeType": "text/plain", "buffer": MAP}
    )
    page.locator("[role=status]", has_text="Imported").first.wait_for(state="attached")
    let_go(page)
    page.keyboard.press("2")
    page.locator(
        ".result"
    ).first.wait_for()  # the choices have been loaded, and the file would be listed
    expect(page.locator("#name")).to_have_text(re.compile("^not saved yet"))
    assert page.complaints == []


MAP = b"type octile\nheight 6\nwidth 9\nmap\n" + b".........\n" * 6
