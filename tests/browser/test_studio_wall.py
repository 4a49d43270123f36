"""The wall of failures: the worst first, with the cells that the explanation of one names."""

import pytest

from tests.helpers.browser import eventually, expect
from tests.helpers.campaign_folder import (
    LOOP,
    STALLED,
    TUNNEL,
    campaign_folder,
    explain_the_loop,
    with_details,
)
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened
from tests.helpers.yellow_marks import check_in_place
from worldgen.files.grid import read_world, write_world

pytestmark = pytest.mark.gate


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wall")
    found = campaign_folder(folder / "found", controller="thesis-1")
    world = with_details(read_world(found / STALLED), cause="harmed-by-what-it-cannot-sense")
    del world.failure.details["one_minimal"]
    write_world(world, found / STALLED, force=True)
    explain_the_loop(found, [{"what": "cell", "value": [2, 1]}])
    return folder


@pytest.fixture
def page(browser, folder):
    with studio_of(folder) as gate, opened(browser, gate) as page:
        page.keyboard.press("3")
        page.locator(".card").nth(2).wait_for()
        yield page


def shown(page):
    return page.locator(".card").evaluate_all("cards => cards.map((one) => one.dataset.failure)")


def test_the_worst_failure_comes_first_and_what_cannot_be_sensed_last(page, folder):
    ordered = [f"found/{name}" for name in (TUNNEL, LOOP, STALLED)]
    eventually(page, lambda: shown(page), lambda names: names == ordered)
    page.locator("[data-filter=sort]").select_option("size")
    eventually(
        page,
        lambda: [read_world(folder / name).walls.size for name in shown(page)],
        lambda sizes: sizes == sorted(sizes),
    )


def test_what_is_not_shrunk_is_said_to_be_as_found(page):
    unshrunk = page.locator(".card", has_text="as found, not shrunk")
    expect(unshrunk).to_have_count(1)
    unshrunk.click()
    page.locator("#failure-panel", has_text="as found, not shrunk").wait_for()
    expect(unshrunk).to_have_attribute("data-failure", f"found/{STALLED}")


def test_the_explained_failure_has_its_cells_marked(page, folder):
    panel = page.locator("#failure-panel")
    page.locator(f".card[data-failure='found/{LOOP}']").click()
    page.locator("#failure-cause", has_text="It arrives if some cell is free.").wait_for()
    expect(panel.get_by_text("cell named in the text")).to_be_visible()
    check_in_place(
        panel.locator("canvas:not([data-mark])"), read_world(folder / "found" / LOOP), (2, 1)
    )
    # Nothing is known about the others.
    page.locator(f".card[data-failure='found/{TUNNEL}']").click()
    page.locator("#failure-cause", has_text="It slides").wait_for()
    expect(panel.get_by_text("cell named in the text")).to_have_count(0)
    assert page.complaints == []
