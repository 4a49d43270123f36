"""The studio reads files only in its folder, and replaces only worlds."""

import shutil
from pathlib import Path

import pytest

from tests.helpers.raising import raises
from tests.helpers.studio import Answers
from worldgen import generate
from worldgen.errors import InvalidParameter, OutputError, WorldgenError
from worldgen.files.grid import read_world, write_world

SETTINGS = {"motion": "swept", "time_step": 0.015, "seed": 0, "steps": 50, "options": {}}
LEARNED = (
    '{"format":"worldgen-learned","version":1,"controller":"q-learner","curve":[],"numbers":[]}'
)
CODE = "print('mine')\n"


@pytest.fixture
def folder(tmp_path):
    """A studio's folder with a world, and files next to it that are none of its business."""
    folder = tmp_path / "open"
    (folder / "known").mkdir(parents=True)
    write_world(generate("trap", 1, size=14), folder / "w.grid")
    for name in ("evil.py", "notes.txt", "photo.png", "broken.grid", "settings.yaml"):
        (folder / name).write_text(CODE, "utf-8")
    for place in (folder, tmp_path):
        (place / "taught.json").write_text(LEARNED, "utf-8")
    (tmp_path / "notes.toml").write_text("secret = 1", "utf-8")
    (folder / "link.json").symlink_to(tmp_path / "taught.json")
    (folder / "away").symlink_to(tmp_path)
    return folder


@pytest.fixture
def answers(folder):
    return Answers(folder)


@pytest.fixture
def world(answers):
    return answers.ask("open", **({"name": "w.grid"}))["world"]


def save(answers, world, name, **more):
    return answers.ask("save", **({"name": name, "world": world, "overwrite": True, **more}))


def export(answers, world, name, kind, **more):
    message = {"name": name, "world": world, "format": kind, "keep": True, "overwrite": True}
    return answers.ask("export", **(message | more))


@pytest.mark.parametrize("name", ["evil.py", "new.py", "notes.txt", "photo.png"])
def test_a_world_is_saved_only_under_the_name_of_a_world(answers, world, folder, name):
    with raises(InvalidParameter, "wrong-suffix"):
        save(answers, world, name)
    assert not (folder / "new.py").exists()
    assert (folder / "evil.py").read_text("utf-8") == CODE


def test_a_world_replaces_a_world_and_nothing_else(answers, world, folder):
    save(answers, world, "w.grid")
    with raises(OutputError, "not-a-world"):
        save(answers, world, "broken.grid")
    assert (folder / "broken.grid").read_text("utf-8") == CODE
    assert read_world(folder / "w.grid").walls.shape == (14, 14)


@pytest.mark.parametrize(
    ("name", "kind", "code"),
    [("evil.py", "text", "wrong-suffix"), ("evil.py", "png", "wrong-suffix"),
     ("notes.txt", "text", "not-a-world"), ("photo.png", "png", "not-a-world"),
     ("settings.yaml", "ros", "not-a-world")],
)  # fmt: skip
def test_an_export_does_not_replace_what_the_studio_has_not_written(
    answers, world, folder, name, kind, code
):
    with raises(WorldgenError, code):
        export(answers, world, name, kind)
    assert (folder / name).read_text("utf-8") == CODE


def test_an_export_replaces_the_same_export(answers, world, folder):
    for _ in range(2):
        assert export(answers, world, "map.yaml", "ros")["written"]
    (folder / "map.pgm").write_text(CODE, "utf-8")
    with raises(OutputError, "not-a-world"):
        export(answers, world, "map.yaml", "ros")


OUTSIDE = ["../taught.json", "away/taught.json", "link.json", "/etc/passwd",
           "sub/../../taught.json"]  # fmt: skip


@pytest.mark.parametrize("place", OUTSIDE)
def test_what_was_learned_is_read_only_in_the_folder(answers, world, place):
    label = f"q-learner+learned={place}"
    with raises(InvalidParameter, "outside-of-folder"):
        answers.ask("check", **({"controller": label, **SETTINGS}))
    answers.ask("run", **({"world": world, "controllers": [label], **SETTINGS}))
    assert answers.parts[-1]["error"]["code"] == "outside-of-folder"
    campaign = {"folder": "new", "controller": label, "motion": "swept", "units": 1,
                "strategies": ["trap"]}  # fmt: skip
    with raises(InvalidParameter, "outside-of-folder"):
        answers.ask("command", **(campaign))
    with raises(InvalidParameter, "outside-of-folder"):
        answers.ask("begin", **(campaign))
    compared = {"controllers": [label], "worlds": [{"file": "w.grid"}], "seeds": 1}
    with raises(InvalidParameter, "outside-of-folder"):
        answers.ask("compare", **({**SETTINGS, **compared}))


@pytest.mark.parametrize("place", ["taught.json", "./taught.json"])
def test_what_was_learned_is_found_in_the_folder_from_any_other(
    answers, folder, tmp_path, monkeypatch, place
):
    monkeypatch.chdir(tmp_path / "open" / "known")
    # The file holds no numbers, which is known only after it was read.
    with raises(InvalidParameter, "wrong-size"):
        answers.ask("check", **({"controller": f"q-learner+learned={place}", **SETTINGS}))


def test_the_user_s_own_controller_may_read_any_file(folder, tmp_path):
    label = f"q-learner+learned={tmp_path / 'taught.json'}"
    with raises(InvalidParameter, "wrong-size"):
        Answers(folder, (label,)).ask("check", **({"controller": label, **SETTINGS}))


@pytest.mark.parametrize("place", ["../notes.toml", "away/notes.toml", "/etc/passwd"])
def test_a_family_reads_no_file_outside_the_folder(answers, place):
    with raises(InvalidParameter, "outside-of-folder"):
        answers.ask("generate", **({"family": "fire", "seed": "1", "parameters": {"over": place}}))


def test_a_family_s_name_is_no_file_even_if_a_folder_has_it(answers, folder):
    (folder / "maze").mkdir()
    made = answers.ask(
        "generate", **({"family": "fire", "seed": "1", "parameters": {"over": "maze"}})
    )
    assert "maze" in made["world"]["source"] and str(folder) not in made["world"]["source"]


def test_a_known_failure_does_not_replace_another_file(answers, folder):
    corpora = Path(__file__).parents[2] / "corpora"
    shutil.copy(corpora / "thesis-faults/thesis-1-loop-104.grid", folder / "one.grid")
    answers.ask("know", **({"name": "one.grid", "known": True}))
    (copy,) = (folder / "known").rglob("*.grid")
    copy.write_text(CODE, "utf-8")
    with raises(OutputError, "not-a-world"):
        answers.ask("know", **({"name": "one.grid", "known": True}))
