"""Contents of the studio's campaign page that are not separate files:

failures in archives, worlds of behaviours.
"""

import shutil

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio_packed import FAILURES, fill, studio_with_kinds
from tests.helpers.studio_page import opened

pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("packed")
    fill(folder)
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_with_kinds(folder) as gate:
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
        page.locator("#campaign-folder option", has_text="later").wait_for(
            state="attached"
        )  # listed again
        expect(page.locator("#campaign-folder")).to_have_value("below/old.tar.gz")
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
