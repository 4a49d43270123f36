"""The campaign page ends with the answer that the terminal gives, and shows a failure at once."""

import contextlib
import shutil
import subprocess
import sys

import msgspec
import pytest

from fuzz.campaign.store import MEMORY, read_summary
from fuzz.overview.answer import answer_of
from fuzz.overview.result import read_overview
from tests.helpers.browser import expect
from tests.helpers.command_line import worldgen
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened

pytestmark = pytest.mark.gate


_LOCKS = (
    "import os, sys; from worldgen.files.locks import lock, sign; "
    "at = os.open(sys.argv[1], os.O_RDWR | os.O_CREAT); lock(at); sign(at); "
    "print('locked', flush=True); sys.stdin.read()"
)


@contextlib.contextmanager
def running(folder):
    """A process that holds a campaign's folder, as the one that runs it does."""
    command = [sys.executable, "-c", _LOCKS, str(folder / MEMORY / "lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        yield
        process.stdin.close()


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """The folder of a campaign that has ended."""
    folder = tmp_path_factory.mktemp("opened") / "failures"
    worldgen(
        "fuzz",
        "--controller",
        "turn-right",
        "--units",
        1,
        "--examples",
        40,
        "--seed",
        1,
        "--out",
        folder,
    )
    return folder


def test_an_ended_campaign_ends_with_the_answer_of_the_terminal(browser, campaign):
    result = read_overview(campaign)
    with studio_of(campaign.parent) as gate, opened(browser, gate, until=None) as page:
        page.locator("#tabs").get_by_role("link", name="Campaign").click()
        told = page.locator("#conclusion")
        told.locator("li").first.wait_for()
        answer = answer_of(msgspec.structs.replace(result, summary=read_summary(campaign)))
        for words in (answer.headline.words, answer.rate, *(one.sentence for one in answer.causes)):
            expect(told).to_contain_text(words)
        # A cause opens its example.
        told.get_by_role("button").first.click()
        page.locator("#failure-panel .actions").wait_for()
        assert page.complaints == []


def test_a_failure_is_drawn_as_soon_as_its_file_is_there(browser, campaign, tmp_path):
    """The page needs no reload: the watched folder's change brings the picture."""
    folder = tmp_path / "failures"
    shutil.copytree(campaign, folder)
    first, *others = sorted(folder.glob("*.grid"))
    kept = first.read_bytes()
    for path in (first, *others):
        path.unlink()
    with studio_of(tmp_path) as gate, running(folder), opened(browser, gate, until=None) as page:
        page.locator("#tabs").get_by_role("link", name="Campaign").click()
        page.locator("#campaign-state").wait_for()
        expect(page.locator(".card")).to_have_count(0)
        first.write_bytes(kept)
        page.locator(".card canvas").first.wait_for()
