"""What the studio's page receives when something cannot be done:

data, and remedies that its user can apply.
"""

import json
import re
import string

import pytest

from fuzz.studio.requests.folder import Folder
from fuzz.studio.requests.refusals import IMPORT_OPTIONS, REMEDIES, describe_note, refusal
from tests.helpers.command_line import worldgen
from tests.helpers.raised_messages import raised_messages
from tests.helpers.studio import page_of, sent, studio_of
from tests.helpers.studio_campaign import begin, watch
from worldgen import generate
from worldgen.errors import FormatError, InvalidParameter, Message, Note
from worldgen.files.grid import write_world


def facts_at_terminal():
    """Return the names of the facts of each error whose remedy needs a terminal, by code and place."""
    return {
        (str(call.args[0].value), place): {str(keyword.arg) for keyword in call.keywords}
        for place, call in raised_messages()
        if any(keyword.arg == "at_terminal" for keyword in call.keywords)
        and hasattr(call.args[0], "value")
    }


def test_each_way_out_of_the_page_fills_from_the_facts_of_the_errors_that_it_is_for():
    for (code, place), facts in facts_at_terminal().items():
        wanted = {
            field for _, field, _, _ in string.Formatter().parse(REMEDIES.get(code, "")) if field
        }
        assert wanted <= facts, place


def test_each_way_out_of_the_page_is_for_an_error_that_there_is():
    computed = {"ambiguous-layer", "layer-missing"}  # one or the other, at the same place
    assert REMEDIES.keys() - {code for code, _ in facts_at_terminal()} <= computed
    assert REMEDIES.keys() >= IMPORT_OPTIONS


def test_no_way_out_of_the_page_names_an_option_of_the_command_line():
    assert not [words for words in REMEDIES.values() if re.search(r"(?<![\w-])--[a-z]", words)]


def test_an_error_keeps_its_code_facts_and_place():
    told = refusal(
        FormatError(
            "below-minimum", "size={size} is below 3", "give more", size=2, line=7, source="w.grid"
        )
    )
    assert sent(told) == {
        "code": "below-minimum",
        "problem": "size=2 is below 3",
        "remedy": "give more",
        "terminal": False,
        "frames": [],
        "opens": "",
        "facts": {"size": 2},
        "line": 7,
        "source": "w.grid",
    }


def test_a_way_out_that_the_page_has_takes_the_place_of_one_by_options():
    error = InvalidParameter(
        "file-exists", "{path} is there", "give --force", at_terminal=True, path="w.grid"
    )
    assert (refusal(error).remedy, refusal(error).terminal) == (REMEDIES["file-exists"], False)


def test_a_way_out_that_only_a_terminal_has_is_marked():
    error = InvalidParameter("too-many-things", "too many", "give --fewer", at_terminal=True)
    assert (refusal(error).remedy, refusal(error).terminal) == ("give --fewer", True)


def test_a_note_of_an_import_names_the_page_s_field():
    note = Note("no-scale", "the map has no scale", "--cell-size says another", at_terminal=True)
    assert note == "the map has no scale; --cell-size says another"
    assert describe_note(note) == "the map has no scale; set another Cell size, under World"


@pytest.mark.parametrize(
    ("fact", "shown"),
    [
        ("{}/w.grid", "w.grid"),
        ("{}", "the opened folder"),
        ("{}.old/w.grid", "{}.old/w.grid"),
        ("{}-2", "{}-2"),
    ],
)
def test_a_path_in_the_opened_folder_goes_by_its_name(fact, shown, tmp_path):
    folder = Folder(tmp_path)
    fact, shown = (text.replace("{}", str(folder.root)) for text in (fact, shown))
    told = folder.refusal(FormatError("x", "{path}: no", path=fact, source=fact))
    assert (told.facts["path"], told.problem, told.source) == (shown, f"{shown}: no", shown)


@pytest.mark.parametrize(
    "value", [float("nan"), float("inf"), object(), "x" * 50_000, ["a", float("nan")], {1: {2}}]
)
def test_whatever_a_fact_is_a_browser_can_read_it(value):
    told = json.dumps(sent(refusal(Message("odd", "{value!r:.20}", value=value))), allow_nan=False)
    assert len(told) < 5_000


@pytest.mark.gate
def test_a_file_of_no_known_format_is_opened_by_naming_its_format(tmp_path):
    (tmp_path / "map.odd").write_text("import this\n")
    with studio_of(tmp_path) as gate, page_of(gate) as page:
        error = page.ask("bring", name="map.odd")["error"]
    assert (error["code"], error["opens"], error["source"]) == (
        "unknown-format",
        "import",
        "map.odd",
    )


@pytest.mark.nightly
def test_a_folder_with_another_campaign_and_one_with_worlds_are_refused_by_what_the_page_has(
    tmp_path,
):
    (tmp_path / "mine").mkdir()
    write_world(generate("corridor", 1), tmp_path / "mine/w.grid")
    with studio_of(tmp_path) as gate, page_of(gate) as page:
        holds_worlds = begin(page, "mine", units=1)["error"]
        begin(page, "begun", units=1)
        watch(page, "begun")
        another = begin(page, "begun", units=1, seed="2")["error"]
    assert (holds_worlds["code"], holds_worlds["terminal"]) == ("folder-holds-worlds", False)
    assert (another["code"], another["facts"]["out"], another["terminal"]) == (
        "another-campaign",
        "begun",
        False,
    )


def test_a_program_in_place_of_a_world_is_told_how_its_robot_runs(tmp_path):
    (tmp_path / "mine.py").touch()
    said = worldgen("studio", tmp_path / "mine.py", "--no-browser")
    assert said.code == 2 and f"worldgen studio --controller {tmp_path}/mine.py:NAME" in said.err
