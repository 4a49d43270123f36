"""What is saved from the player, and what a failure was before shrinking: by the server, and in a browser."""

import base64
import io
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from fuzz.player import replay_page
from tests.helpers.browser import missing_browser
from tests.helpers.campaign_folder import LOOP, TUNNEL, campaign_folder
from tests.helpers.studio import page_of, studio_of
from worldgen.grid_file import read_world, write_world

pytest.importorskip("playwright", reason="no playwright here: the studio is not tested in a browser")
in_a_browser = pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "-")

from fuzz.studio.messages import message_of  # noqa: E402
from tests.helpers.studio_page import opened  # noqa: E402

CONFIG_5 = Path(__file__).parents[2] / "corpora/thesis/config-05.grid"


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("saving")
    shutil.copy(CONFIG_5, folder / "config-05.grid")
    with studio_of(folder, file="config-05.grid") as gate:
        yield gate


def ask(page, **changes):
    message = {"world": message_of(read_world(CONFIG_5)), "motion": "stepped", "time_step": 0.015, "seed": 0}
    message |= {"controllers": ["thesis-1", "thesis-2"], "steps": 900, "options": {}, "title": "five", "looked": 0}
    return page.ask("picture", **(message | changes))


def test_runs_are_saved_as_animation_drawing_and_page(gate):
    with page_of(gate) as page:
        gif, svg, html = (base64.b64decode(ask(page, kind=kind)["answer"]["data"]) for kind in ("gif", "svg", "html"))
        assert base64.b64decode(ask(page, kind="gif")["answer"]["data"]) == gif
    assert Image.open(io.BytesIO(gif)).n_frames == 120
    assert svg.startswith(b"<?xml") and b"five: thesis-1, stepped: " in svg
    assert b"<title>five</title>" in html and b"thesis-2" in html


@pytest.mark.parametrize("changes", [{"kind": "exe"}, {"kind": "svg", "looked": 2}, {"kind": "gif", "looked": -1}])
def test_a_picture_of_another_kind_or_of_nobody_is_refused(gate, changes):
    with page_of(gate) as page:
        assert "choose one that drove, as gif, svg, html" in ask(page, **changes)["error"]


def test_a_picture_that_nobody_wants_is_ended(gate):
    with page_of(gate) as page:
        message = {"world": message_of(read_world(CONFIG_5)), "motion": "stepped", "time_step": 0.015, "seed": 0}
        message |= {"controllers": ["thesis-3"] * 6, "steps": 1_000_000, "options": {}, "title": "-", "looked": 0}
        long = page.send("picture", **message, kind="gif")
        page.send("cancel", of=long)
        said = [page.hear() for _ in range(2)]
        assert {"id": long, "ended": True} in said
        assert "data" in ask(page, kind="svg")["answer"]


def test_a_replay_page_holds_no_markup_of_names():
    page = replay_page("</title><script>alert(1)</script>", None, [{"name": "<img src=x>", "run": None}]).decode()
    assert "<script>alert" not in page and "<img" not in page


@in_a_browser
def test_picture_film_and_page_are_saved_with_the_mouse_and_the_page_replays_by_itself(browser, gate, tmp_path):
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
            if kind == "webm":  # so slow that it cannot end by itself before it is ended
                page.locator(".controls label", has_text="Speed").locator("select").select_option("0.05")
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


def test_a_failure_is_answered_with_what_it_was_before_shrinking(campaign):
    with studio_of(campaign) as gate, page_of(gate) as page:
        before = page.ask("before", name=LOOP)["answer"]["before"]
        assert before["words"].startswith("loop for ever") and before["run"]["loop"] == [29, 104]
        assert page.ask("before", name=TUNNEL)["answer"]["before"] is None


def test_what_was_before_is_not_run_by_a_controller_that_nobody_has_named(campaign, tmp_path):
    shutil.copytree(campaign, tmp_path / "copy")
    (original,) = (tmp_path / "copy/.campaign/failures").glob("*.grid")
    world = read_world(original)
    write_world(replace(world, failure=replace(world.failure, controller="./evil.py:Robot")), original, force=True)
    (tmp_path / "copy/evil.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    with studio_of(tmp_path / "copy") as gate, page_of(gate) as page:
        assert page.ask("before", name=LOOP)["answer"]["before"] is None
    assert not (tmp_path / "ran").exists()


@in_a_browser
def test_a_failure_is_played_beside_what_it_was(browser, campaign):
    with studio_of(campaign, file=LOOP) as gate, opened(browser, gate) as page:
        page.keyboard.press("2")
        page.locator("#beside").click()
        page.keyboard.press("Home")
        assert page.locator("section#play .stage canvas").count() == 2
        assert page.locator(".stage .tag").all_inner_texts() == ["As found", "Shrunk"]
        page.locator("#beside").click()
        assert page.locator("section#play .stage canvas").count() == 1
        assert page.complaints == []


def _pixels(page):
    """What each of the two canvases shows."""
    read = "nodes => nodes.map(node => node.toDataURL())"
    return page.locator("section#play .stage canvas").evaluate_all(read)


def _saved(page, words):
    """A file of the menu *Save*; a film is ended by hand, if it has not ended by itself."""
    page.locator(".save summary").click()
    with page.expect_download() as download:
        page.locator(".save button", has_text=words).click()
        if words == "Film":
            page.locator(".save summary").click()
    return Path(download.value.path()).read_bytes()


@in_a_browser
def test_both_of_two_runs_are_zoomed_moved_and_saved(browser, campaign):
    with studio_of(campaign, file=LOOP) as gate, opened(browser, gate) as page:
        page.keyboard.press("2")
        page.locator("#beside").click()
        page.keyboard.press("Home")
        whole = _pixels(page)
        boxes = [page.locator(f"section#play .stage canvas >> nth={k}").bounding_box() for k in (0, 1)]
        middles = [(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for box in boxes]
        page.mouse.move(*middles[0])
        page.mouse.wheel(0, -300)
        zoomed = _pixels(page)
        page.mouse.down()
        page.mouse.move(middles[0][0] + 60, middles[0][1] + 30, steps=4)
        page.mouse.up()
        moved = _pixels(page)
        for k in (0, 1):
            assert len({whole[k], zoomed[k], moved[k]}) == 3
        picture = Image.open(io.BytesIO(_saved(page, "Picture")))
        widths = page.locator("section#play .stage canvas").evaluate_all("nodes => nodes.map(node => node.width)")
        assert picture.width == sum(widths) + 2
        assert _saved(page, "Film").startswith(b"\x1aE")
        assert page.complaints == []


# Holds the question for a picture back until it is to be ended, so that no machine is too fast for the button.
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


@in_a_browser
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
        assert page.locator("#run-said.quiet").inner_text() == "Not saved." and saved == []
        assert page.complaints == []
