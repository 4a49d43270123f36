"""The documentation's playground: one static file, opened from disk, in which worlds are judged."""

import re

import pytest

from docs import playground
from fuzz.player.live import live_core
from tests.helpers.accessibility import complaints
from tests.helpers.browser import expect, page_in
from worldgen.files.grid import read_world
from worldgen.reach import check_certificate

pytestmark = [
    pytest.mark.gate,
    pytest.mark.skipif(live_core() is None, reason="this installation has no core for pages"),
]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with the page, and a page of which it is a figure."""
    folder = tmp_path_factory.mktemp("site")
    (folder / playground.NAME).write_bytes(playground.page())
    (folder / "index.html").write_text(f"<!DOCTYPE html>{playground.frame('maze', 'maze', '')}")
    return folder


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_world_is_drawn_run_proved_and_saved_without_a_server(browser, site, tmp_path, scheme):
    with page_in(browser, accept_downloads=True, color_scheme=scheme) as page:
        page.goto((site / playground.NAME).as_uri())
        page.locator("#change-verdict b", has_text="loop").wait_for()
        expect(page.locator("#change-proof.good")).to_contain_text("reachable")
        assert complaints(page) == []
        page.locator("#controller").select_option("bug2")
        page.locator("#change-verdict b", has_text="reached").wait_for()
        page.get_by_label("Robot radius, m").fill("0.05")
        page.get_by_label("Robot radius, m").press("Enter")
        with page.expect_download() as download:
            page.get_by_role("button", name="Save as .grid").click()
        download.value.save_as(tmp_path / "w.grid")
        world = read_world(tmp_path / "w.grid")
        assert world.robot_radius == 0.05 and check_certificate(world).valid
        page.locator("#scene").select_option("walled")
        page.locator("#change-proof.bad", has_text="blocked").wait_for()
        assert page.complaints == []
        assert all(address.startswith(("file:", "data:", "blob:")) for address in page.requested)


def test_a_figure_has_the_slider_of_its_family_and_a_link_to_the_playground(browser, site):
    with page_in(browser) as page:
        page.goto((site / "index.html").as_uri())
        figure = page.frame_locator("iframe")
        figure.locator("#change-proof.good").wait_for()
        expect(figure.get_by_label("Controller")).to_be_hidden()
        figure.get_by_label("braid").fill("0")
        figure.locator("#shown").get_by_text("0", exact=True).wait_for()
        figure.locator("#change-proof.good").wait_for()
        expect(figure.get_by_role("link")).to_have_attribute("href", re.compile("#maze$"))
        assert page.complaints == []
