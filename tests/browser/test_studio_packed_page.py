"""What the studio's campaign page shows that is in no file of its own: failures in archives, worlds of behaviours."""

import shutil
import tarfile
from pathlib import Path

import pytest

from tests.helpers.studio import page_of, studio_of
from tests.helpers.studio_campaign import begin, watch
from tests.helpers.studio_page import opened

pytestmark = pytest.mark.nightly

FAILURES = sorted((Path(__file__).parents[2] / "corpora/failures/turn-right/swept").glob("*.grid"))[:4]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Make a folder with the same failures as files and in an archive."""
    folder = tmp_path_factory.mktemp("packed")
    (folder / "below").mkdir()
    (folder / "plain").mkdir()
    with tarfile.open(folder / "below/old.tar.gz", "w:gz") as archive:
        for file in FAILURES:
            shutil.copy(file, folder / "plain")
            archive.add(file, f"deep/{file.name}")
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder) as gate:
        with page_of(gate) as page:
            assert "answer" in begin(page, "kinds", lanes=["archive"], units=2)
            watch(page, "kinds")
        yield gate


def test_an_archive_s_failures_are_on_the_wall_and_one_is_edited(browser, gate, folder):
    with opened(browser, gate, until=None) as page:
        page.keyboard.press("3")
        page.locator("#campaign-folder").select_option("below/old.tar.gz")
        page.locator("#wall-count", has_text=f"{len(FAILURES)} failures").wait_for()
        page.locator(".card").first.click()
        page.locator("#open-draw").click()
        page.locator("#proof.good").wait_for()
        page.locator("#name", has_text="not saved yet").wait_for()
        shutil.copytree(folder / "plain", folder / "later")
        page.keyboard.press("3")
        page.locator("#campaign-folder option", has_text="later").wait_for(state="attached")  # listed anew
        assert page.locator("#campaign-folder").input_value() == "below/old.tar.gz"
        shutil.rmtree(folder / "later")
        assert page.complaints == []


def test_a_click_on_a_kind_of_behaviour_opens_its_world_on_the_board(browser, gate):
    with opened(browser, gate, until=None) as page:
        page.keyboard.press("3")
        page.locator("#campaign-folder").select_option("kinds")
        page.locator("#tab-archive").click()
        page.locator("#archive-panel rect.opens").first.click()
        page.locator("#board").wait_for()
        page.locator("#proof.good").wait_for()
        page.keyboard.press("Control+z")
        page.keyboard.press("3")
        page.locator("#archive-panel summary").click()
        page.locator("#archive-panel table button").first.press("Enter")
        page.locator("#proof.good").wait_for()
        assert page.complaints == []
