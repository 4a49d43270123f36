"""Saving from the player, and two runs side by side, in a browser."""

import io
import re
from pathlib import Path

import pytest
from PIL import Image

from tests.helpers.browser import eventually, expect
from tests.helpers.campaign_folder import LOOP, campaign_folder
from tests.helpers.studio import studio_of, studio_of_config_5
from tests.helpers.studio_page import opened


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    with studio_of_config_5(tmp_path_factory.mktemp("saving")) as gate:
        yield gate


@pytest.mark.nightly
def test_picture_film_and_page_are_saved_with_the_mouse_and_the_page_replays_by_itself(
    browser, gate, tmp_path
):
    with opened(browser, gate) as page:
        page.keyboard.press("2")
        page.get_by_label("Steps", exact=True).fill("300")
        page.keyboard.press("Control+Enter")
        page.locator(".result", has_text="300 steps").wait_for()
        for words, kind, begins in (
            ("Picture", "png", b"\x89PNG"),
            ("Film", "webm", b"\x1aE"),
            ("HTML", "html", b"<!"),
        ):
            if kind == "webm":  # so slow that it cannot finish before the test stops it
                page.locator(".controls label", has_text="Speed").locator("select").select_option(
                    "0.05"
                )
            page.locator(".save summary").click()
            with page.expect_download() as download:
                page.locator(".save button", has_text=words).click()
                if kind == "webm":
                    page.locator("#readout", has_text=re.compile(r"step [1-9]")).wait_for()
                    page.get_by_role("button", name="Pause").click()
            assert download.value.suggested_filename == f"config-05.{kind}"
            download.value.save_as(tmp_path / f"run.{kind}")
            assert (tmp_path / f"run.{kind}").read_bytes().startswith(begins)
        assert page.complaints == []
        page.goto((tmp_path / "run.html").as_uri())
        page.keyboard.press("Home")
        page.locator("#readout", has_text="step 0 of 300").wait_for()
        assert page.complaints == []


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return campaign_folder(tmp_path_factory.mktemp("campaign") / "failures")


@pytest.mark.nightly
def test_a_failure_is_played_beside_what_it_was(browser, campaign):
    with studio_of(campaign, file=LOOP) as gate, opened(browser, gate) as page:
        page.keyboard.press("2")
        page.locator("#beside").click()
        page.keyboard.press("Home")
        expect(page.locator("section#play .stage canvas")).to_have_count(2)
        expect(page.locator(".stage .tag")).to_have_text(["As found", "Shrunk"])
        page.locator("#beside").click()
        expect(page.locator("section#play .stage canvas")).to_have_count(1)
        assert page.complaints == []


def _pixels(page):
    """Return the picture of each of the two canvases."""
    read = "nodes => nodes.map(node => node.toDataURL())"
    return page.locator("section#play .stage canvas").evaluate_all(read)


def _changed(page, before):
    """Return the pictures of the two canvases once both are others than before."""
    return eventually(
        page,
        lambda: _pixels(page),
        lambda seen: all(one != other for one, other in zip(before, seen, strict=True)),
    )


def _saved(page, words):
    """Save a file from the menu *Save*; stop a film by hand if it has not ended yet."""
    page.locator(".save summary").click()
    with page.expect_download() as download:
        page.locator(".save button", has_text=words).click()
        if words == "Film":
            page.locator(".save summary").click()
    return Path(download.value.path()).read_bytes()


@pytest.mark.nightly
def test_both_of_two_runs_are_zoomed_moved_and_saved(browser, campaign):
    with studio_of(campaign, file=LOOP) as gate, opened(browser, gate) as page:
        page.keyboard.press("2")
        page.locator("#beside").click()
        page.keyboard.press("Home")
        whole = _pixels(page)
        boxes = [
            page.locator(f"section#play .stage canvas >> nth={k}").bounding_box() for k in (0, 1)
        ]
        middles = [(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for box in boxes]
        page.mouse.move(*middles[0])
        page.mouse.wheel(0, -300)
        zoomed = _changed(page, whole)
        page.mouse.down()
        page.mouse.move(middles[0][0] + 60, middles[0][1] + 30, steps=4)
        page.mouse.up()
        moved = _changed(page, zoomed)
        assert all(one != other for one, other in zip(whole, moved, strict=True))
        picture = Image.open(io.BytesIO(_saved(page, "Picture")))
        # Each half has walls, trails and words of its own.
        middle = picture.width // 2
        for box in ((0, 0, middle, picture.height), (middle, 0, picture.width, picture.height)):
            assert len(picture.crop(box).convert("RGB").getcolors(1 << 20)) > 100
        assert _saved(page, "Film").startswith(b"\x1aE")
        assert page.complaints == []


# Holds back the request for a picture until the test stops it, so that no machine is too fast for
# the button.
_HOLD = """
() => {
  const send = WebSocket.prototype.send;
  let held = null;
  WebSocket.prototype.send = function (text) {
    if (text.includes('"do":"picture"')) { held = text; return; }
    if (text.includes('"do":"cancel"')) send.call(this, held);
    send.call(this, text);
  };
}
"""


@pytest.mark.nightly
def test_the_button_ends_a_picture_that_is_being_saved(browser, gate):
    with opened(browser, gate) as page:
        saved = []
        page.on("download", lambda file: saved.append(file.suggested_filename))
        page.keyboard.press("2")
        page.get_by_label("Steps", exact=True).fill("300")
        page.keyboard.press("Control+Enter")
        page.locator(".result", has_text="300 steps").wait_for()
        page.evaluate(_HOLD)
        save = page.locator(".save summary")
        save.click()
        page.locator(".save button", has_text="Animation").click()
        page.locator(".save summary", has_text="Stop saving").click()
        page.locator(".save summary", has_text=re.compile("^Save$")).wait_for()
        expect(page.locator("#run-said.quiet")).to_have_text("Not saved.")
        assert saved == []
        assert page.complaints == []
