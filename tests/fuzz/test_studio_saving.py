"""The server's answers for files saved from the player, and for a failure before shrinking."""

import base64
import io
import json
import re
import shutil
from dataclasses import replace
from importlib.resources import files
from urllib.parse import unquote

import pytest
from PIL import Image

from fuzz.player import replay_page
from tests.helpers.campaign_folder import LOOP, TUNNEL, campaign_folder
from tests.helpers.studio import CONFIG_5, message_of, page_of, studio_of, studio_of_config_5
from worldgen.files.grid import read_world, write_world

PLAYER = files("fuzz.player") / "page"


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    with studio_of_config_5(tmp_path_factory.mktemp("saving")) as gate:
        yield gate


def ask(page, **changes):
    message = {
        "world": message_of(read_world(CONFIG_5)),
        "motion": "stepped",
        "time_step": 0.015,
        "seed": 0,
    }
    message |= {
        "controllers": ["thesis-1", "thesis-2"],
        "steps": 900,
        "options": {},
        "title": "five",
        "looked": 0,
    }
    return page.ask("picture", **(message | changes))


@pytest.mark.nightly
def test_runs_are_saved_as_animation_drawing_and_page(gate):
    with page_of(gate) as page:
        gif, svg, html = (
            base64.b64decode(ask(page, kind=kind)["answer"]) for kind in ("gif", "svg", "html")
        )
        assert base64.b64decode(ask(page, kind="gif")["answer"]) == gif
    assert Image.open(io.BytesIO(gif)).n_frames == 120
    assert svg.startswith(b"<?xml") and b"five: thesis-1, stepped: " in svg
    assert b"<title>five</title>" in html and b"thesis-2" in html


@pytest.mark.gate
@pytest.mark.parametrize(
    "changes", [{"kind": "exe"}, {"kind": "svg", "looked": 2}, {"kind": "gif", "looked": -1}]
)
def test_a_picture_of_another_kind_or_of_nobody_is_refused(gate, changes):
    with page_of(gate) as page:
        assert ask(page, **changes)["error"]["code"] in ("unknown-name", "wrong-message")


@pytest.mark.gate
def test_a_picture_that_nobody_wants_is_ended(gate):
    with page_of(gate) as page:
        message = {
            "world": message_of(read_world(CONFIG_5)),
            "motion": "stepped",
            "time_step": 0.015,
            "seed": 0,
        }
        message |= {
            "controllers": ["thesis-3"] * 6,
            "steps": 1_000_000,
            "options": {},
            "title": "-",
            "looked": 0,
        }
        long = page.send("picture", **message, kind="gif")
        page.send("cancel", of=long)
        said = [page.hear() for _ in range(2)]
        assert {"id": long, "ended": True} in said
        assert "answer" in ask(page, kind="svg")


def test_a_replay_page_holds_no_markup_of_names():
    page = replay_page(
        "</title><script>alert(1)</script>", None, [{"name": "<img src=x>", "run": None}]
    ).decode()
    assert "<script>alert" not in page and "<img" not in page


def test_a_replay_page_holds_the_modules_that_it_imports_and_no_others():
    page = replay_page("a replay", None, []).decode()
    urls = json.loads(re.search(r'<script type="importmap"[^>]*>(.*?)</script>', page)[1])[
        "imports"
    ]
    scripts = {name: unquote(url.partition(",")[2]) for name, url in urls.items()}
    wanted = {name for text in scripts.values() for name in re.findall(r' from "(#.+?)";', text)}
    assert wanted | {"#replay/start.js"} == set(scripts)
    assert scripts["#player/dom.js"] == (PLAYER / "dom.js").read_text("utf-8")
    assert "#player/edit/board.js" not in scripts


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return campaign_folder(tmp_path_factory.mktemp("campaign") / "failures")


@pytest.mark.nightly
def test_a_failure_is_answered_with_what_it_was_before_shrinking(campaign):
    with studio_of(campaign) as gate, page_of(gate) as page:
        before = page.ask("before", name=LOOP)["answer"]
        assert before["words"].startswith("loop forever") and before["run"]["loop"] == [29, 104]
        assert page.ask("before", name=TUNNEL)["answer"] is None


@pytest.mark.nightly
def test_what_was_before_is_not_run_by_a_controller_that_nobody_has_named(campaign, tmp_path):
    shutil.copytree(campaign, tmp_path / "copy")
    (original,) = (tmp_path / "copy/.campaign/failures").glob("*.grid")
    world = read_world(original)
    write_world(
        replace(world, failure=replace(world.failure, controller="./evil.py:Robot")),
        original,
        force=True,
    )
    (tmp_path / "copy/evil.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    with studio_of(tmp_path / "copy") as gate, page_of(gate) as page:
        assert page.ask("before", name=LOOP)["answer"] is None
    assert not (tmp_path / "ran").exists()
