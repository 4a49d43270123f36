"""What the studio's page says when something cannot be done: ways out that its user has."""

import ast
import re
from pathlib import Path

import pytest

from fuzz.studio.sentences import on_the_page
from tests.helpers.command_line import worldgen
from tests.helpers.studio import page_of, studio_of
from tests.helpers.studio_campaign import begin, watch
from worldgen import generate
from worldgen.grid_file import write_world

ROOT = Path(__file__).parents[2]
REACHED = (  # what the page asks of the library, as far as its sentences name options
    "worldgen/files.py", "worldgen/interop/*.py", "sim/episode.py", "sim/run_options.py", "sim/scenario.py",
    "fuzz/asked/*.py", "fuzz/lanes/*.py", "fuzz/ledger/*.py", "fuzz/session.py", "fuzz/variation.py",
)  # fmt: skip
NOT_ASKED = ("scenario_check.py",)
OPTION = re.compile(r"(?<![\w-])--[a-z]")


def texts_of(path):
    """A module's texts, what is put into them as X; without docstrings."""
    tree = ast.parse(path.read_text())
    parts = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
    said = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield "".join(part.value if isinstance(part, ast.Constant) else "X" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and not {id(node)} & (parts | said):
            yield node.value


SENTENCES = sorted(
    {
        text
        for pattern in REACHED
        for path in ROOT.glob(pattern)
        if path.name not in NOT_ASKED
        for text in texts_of(path)
        if OPTION.search(text)
    }
)


@pytest.mark.parametrize("sentence", SENTENCES)
def test_no_way_out_that_the_library_names_is_an_option_on_the_page(sentence):
    assert not OPTION.search(on_the_page(f"it cannot be done; {sentence}"))


def test_the_library_s_sentences_are_found():
    assert len(SENTENCES) > 15


def test_a_way_out_that_nobody_has_thought_of_says_where_it_is():
    assert on_the_page("too many; give --fewer") == "too many; give --fewer (at a terminal)"
    assert on_the_page("my --old/w.grid:2: too many; give fewer") == "my --old/w.grid:2: too many; give fewer"
    assert len(on_the_page("worldgen fuzz --resume x " * 20_000)) < 10_000
    assert on_the_page("two - one -- and three") == "two - one -- and three"


@pytest.mark.gate
def test_a_file_of_no_known_format_is_opened_by_naming_its_format(tmp_path):
    (tmp_path / "map.odd").write_text("import this\n")
    with studio_of(tmp_path) as gate, page_of(gate) as page:
        said = page.ask("bring", name="map.odd")["error"]
    assert "say which in Options of the import" in said and "--" not in said


@pytest.mark.nightly
def test_a_folder_with_another_campaign_and_one_with_worlds_are_refused_by_what_the_page_has(tmp_path):
    (tmp_path / "mine").mkdir()
    write_world(generate("corridor", 1), tmp_path / "mine/w.grid")
    with studio_of(tmp_path) as gate, page_of(gate) as page:
        holds_worlds = begin(page, "mine", units=1)["error"]
        begin(page, "begun", units=1)
        watch(page, "begun")
        another = begin(page, "begun", units=1, seed="2")["error"]
    assert "name another folder" in holds_worlds and "choose it above and go on" in another
    assert "--" not in holds_worlds + another


def test_a_program_in_place_of_a_world_is_told_how_its_robot_runs(tmp_path):
    (tmp_path / "mine.py").touch()
    said = worldgen("studio", tmp_path / "mine.py", "--no-browser")
    assert said.code == 2 and f"worldgen studio --controller {tmp_path}/mine.py:NAME" in said.err
