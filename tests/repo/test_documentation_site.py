"""The documentation site builds, and its pages are where readers look for them."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import pytest

from tests.repo.documented_commands import DOCS, GENERATED, ROOT
from tests.repo.documented_commands import SITE as PAGES

MOST_PAGES = 49  # in nine groups: a reader who scans the contents still finds the right one
MOST_WORDS = 900  # of a page to read, outside its code: about three screens
BUDGETS = {
    # Pages to look things up in; what isn't here has MOST_WORDS.
    "explanation/reachability.md": 2050,
    "explanation/search.md": 1550,
    "explanation/thesis.md": 950,
    "reference/behaviours.md": 750,
    "reference/campaign-files.md": 950,
    "reference/controllers.md": 2950,
    "reference/environments.md": 1000,
    "reference/families.md": 1550,
    "reference/fleets.md": 1300,
    "reference/formats.md": 2405,
    "reference/grid-format.md": 3200,
    "reference/import-formats.md": 2360,
    "reference/library.md": 1600,
    "reference/simulator.md": 1900,
    "reference/tables.md": 1500,
    "reference/verdicts.md": 3700,
}
MOST_TO_READ = 14_000  # words of the front page, the tutorials and the how-tos: an afternoon
MOST_IN_ALL = 45_000  # words of all pages, without what comes from the code
MOST_GENERATED = 15_500  # words that come from the code, without docstrings
SECTIONS = ("tutorials", "howto", "reference", "explanation")
BUILD = (sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going")
_CODE = re.compile(r"^( *)```.*?^\1```\s*$|<!--.*?-->", re.DOTALL | re.MULTILINE)
_WORD = re.compile(r"\S*\w\S*")


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
@pytest.mark.parametrize(
    ("page", "named"),
    [
        ("campaign-files", ("off-centre", "drop-robots")),
        ("ci", ("fail-on", "corpus-path")),
        ("tables", ("bottleneck_radii", "tortuosity")),
        ("import-formats", ("--ignore-unread", "--scen")),
    ],
)
def test_a_page_includes_the_tables_that_come_from_the_code(site, page, named):
    text = (site / f"reference/{page}.html").read_text(encoding="utf-8")
    assert all(name in text for name in named)


@pytest.mark.gate
@pytest.mark.usefixtures("site")
def test_what_comes_from_the_code_is_short_enough():
    pages = [page.read_text(encoding="utf-8") for page in GENERATED.rglob("*.md")]
    assert 0 < sum(len(_WORD.findall(text)) for text in pages) <= MOST_GENERATED


@pytest.mark.gate
def test_the_site_asks_nothing_of_another_server(site):
    for file in site.rglob("*.html"):
        links = _Links(file.read_text(encoding="utf-8"))
        assert not [one for one in links.targets if one.endswith((".css", ".js")) and "//" in one]


def test_the_site_has_few_enough_pages_to_find_one():
    assert len(PAGES) <= MOST_PAGES, "add to a page that serves the same reader, or merge two"


def words(page):
    """Return the number of words of a page, outside its code and its comments."""
    return len(_WORD.findall(_CODE.sub("", page.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_a_page_is_short_enough_to_read(page):
    name = page.relative_to(DOCS).as_posix()
    most = BUDGETS.get(name, MOST_WORDS)
    assert words(page) <= most, f"{name}: at most {most} words; move facts to the reference"


def test_all_pages_together_are_short_enough():
    read = [page for page in PAGES if page.parent.name in ("docs", "tutorials", "howto")]
    assert sum(map(words, read)) <= MOST_TO_READ
    assert sum(map(words, PAGES)) <= MOST_IN_ALL


def test_every_page_is_in_one_of_the_four_sections():
    folders = {page.relative_to(DOCS).parts[0] for page in PAGES}
    assert folders == {*SECTIONS, "index.md"}
