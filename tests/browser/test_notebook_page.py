"""An episode's player as a notebook shows it, in a frame."""

import pytest

from sim import simulate
from tests.browser.test_player_page import room
from tests.helpers.browser import expect, page_in


@pytest.mark.gate
def test_an_episode_plays_in_the_frame_that_a_notebook_shows(browser, tmp_path):
    shown = simulate(room(2.0), "bug2", record=True).show()._repr_html_()
    (tmp_path / "cell.html").write_text(f"<!DOCTYPE html><title>Notebook</title>{shown}", "utf-8")
    with page_in(browser) as page:
        page.goto((tmp_path / "cell.html").as_uri())
        frame = page.frame_locator("iframe")
        frame.locator("#play-pause").wait_for()
        frame.locator("#scrub").press("End")
        frame.locator("#readout", has_text="step").wait_for()
        expect(frame.locator(".robots")).to_contain_text("bug2")
        assert page.complaints == []
