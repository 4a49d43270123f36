"""The documentation site builds, and its pages are where readers look for them."""

import subprocess
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import pytest

from tests.repo.documented_commands import DOCS, ROOT
from tests.repo.documented_commands import SITE as PAGES

MOST_PAGES = 31  # a reader who scans the contents still finds the right one
SECTIONS = ("tutorials", "howto", "reference", "explanation")
BUILD = (sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going")


class _Links(HTMLParser):
    """The targets and the anchors of a page."""

    def __init__(self, text):
        super().__init__()
        self.targets = []
        self.anchors = set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.targets.append(value)
            elif name == "id":
                self.anchors.add(value)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [*BUILD, "-d", folder / "trees", DOCS, folder / "html"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


@pytest.mark.gate
def test_every_link_of_the_site_leads_to_a_page_and_a_place_on_it(site):
    pages = {file: _Links(file.read_text(encoding="utf-8")) for file in site.rglob("*.html")}
    broken = []
    for file, links in pages.items():
        for target in links.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            to = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            known = to not in pages or not parts.fragment
            if not to.exists() or not (known or unquote(parts.fragment) in pages[to].anchors):
                broken.append(f"{file.relative_to(site)}: {target}")
    assert broken == []


@pytest.mark.gate
def test_the_site_documents_every_command_and_every_public_function(site):
    commands = (site / "reference/generated/command-line.html").read_text(encoding="utf-8")
    assert "worldgen corpus prune" in commands and "--budget" in commands
    python = (site / "reference/generated/python-api.html").read_text(encoding="utf-8")
    assert 'id="sim.simulate"' in python and 'id="worldgen.families.maze"' in python


@pytest.mark.gate
def test_the_site_asks_nothing_of_another_server(site):
    for file in site.rglob("*.html"):
        links = _Links(file.read_text(encoding="utf-8"))
        assert not [one for one in links.targets if one.endswith((".css", ".js")) and "//" in one]


def test_the_site_has_few_enough_pages_to_find_one():
    assert len(PAGES) <= MOST_PAGES, "add to a page that serves the same reader, or merge two"


def test_every_page_is_in_one_of_the_four_sections():
    folders = {page.relative_to(DOCS).parts[0] for page in PAGES}
    assert folders == {*SECTIONS, "index.md"}
