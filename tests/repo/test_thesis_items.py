"""The counts in the thesis page's table of items are right, and every command in it runs."""

import json
import re
import shlex
import shutil
from collections import Counter
from pathlib import Path

import pytest

from tests.helpers.command_line import worldgen
from worldgen import generate, write_world

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/notes/thesis.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (\d+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", PAGE, re.M)
STATES = ("working", "in part", "missing")
# The studio waits for a browser.
COMMANDS = sorted(
    {
        command
        for _, _, shown, _ in ROWS
        for command in re.findall(r"`worldgen ([^`]+)`", shown)
        if command != "studio"
    }
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("items")
    write_world(generate("trap", 3, size=24), made / "w.grid")
    write_world(generate("fire", 1, size=20), made / "f.grid")
    for name in ("thesis", "thesis-faults"):
        shutil.copytree(ROOT / "corpora" / name, made / "corpora" / name)
    text = (ROOT / "docs/reference/simulator.md").read_text(encoding="utf-8")
    (made / "sweep.py").write_text(re.search(r"```python\n(# sweep\.py\n.*?)```", text, re.S)[1])
    worldgen("new-controller", "mine", "--out", made)
    (made / "a.grid").write_bytes((made / "w.grid").read_bytes())
    return made


def test_there_are_98_items_and_the_sentence_above_them_counts_right():
    assert [int(number) for number, *_ in ROWS] == list(range(1, 99))
    counts = Counter(state for *_, state in ROWS)
    assert set(counts) <= set(STATES)
    works, in_part, missing = (counts[state] for state in STATES)
    said = f"98 items, of which {works} work, {in_part} work in part and {missing}"
    assert said in " ".join(PAGE.split())


def test_what_works_is_shown_by_a_command_or_a_page():
    assert all("`" in shown or "](" in shown for *_, shown, state in ROWS if state == "working")


def variants(command):
    """Return the command without each of its options that are to show something."""
    words = shlex.split(command)
    found = {}
    if "--controller" in words:
        at = words.index("--controller") + 1
        name, *options = words[at].split("+")
        # A composition is its options.
        for option in [] if name.startswith("behaviours") else options:
            label = "+".join([name, *(one for one in options if one != option)])
            found[option] = [*words[:at], label, *words[at + 1 :]]
    for option in ("--time-step", "--task", "--speedup", "--over", "--steps", "--size"):
        if option in words:
            at = words.index(option)
            found[option] = words[:at] + words[at + 2 :]
    return found


def outcome(words):
    """Return what a run's trace or a generated file is."""
    if words[0] == "run":
        return json.loads(worldgen(*words, "--json").out)["trace_digest"]
    result = worldgen(*words)
    assert result.code == 0, result.err
    return Path(words[words.index("--out") + 1]).read_bytes()


SHOWN = [
    pytest.param(shlex.split(command), words, id=f"{command} without {option}")
    for command in COMMANDS
    if command.split()[0] in ("run", "maze", "trap", "fire", "shift")
    for option, words in variants(command).items()
]


def test_an_option_that_is_to_show_something_is_found_in_its_command():
    assert {str(one.id).rpartition(" ")[2] for one in SHOWN} >= {
        "pushes=0.3:0.3:0:0", "noise", "sensor_field=1.57", "--time-step", "--speedup", "--over",
    }  # fmt: skip


@pytest.mark.gate
@pytest.mark.parametrize(("words", "without"), SHOWN)
def test_what_a_command_shows_makes_a_difference(words, without, folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert outcome(words) != outcome(without)


@pytest.mark.nightly
@pytest.mark.parametrize("command", COMMANDS)
def test_the_command_of_an_item_runs(command, folder, monkeypatch):
    monkeypatch.chdir(folder)
    for name in ("a", "b"):
        shutil.rmtree(folder / name, ignore_errors=True)
    result = worldgen(*shlex.split(command))
    assert result.code in (0, 1), result.err
    assert "has no effect" not in result.err
