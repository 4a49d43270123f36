"""One bad file in a folder or an archive keeps no command from the others."""

import json
import shutil
import zipfile
from pathlib import Path

import pytest

from tests.helpers.command_line import worldgen

CORPUS = Path(__file__).parents[2] / "corpora"
LOOP = CORPUS / "failures/turn-right/swept/returns-to-a-wall-2.grid"
OTHER = CORPUS / "failures/turn-right/swept/returns-to-a-wall.grid"
MAP = next(CORPUS.glob("thesis/*.grid"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Bad files sort before, between and after the good ones."""
    folder = tmp_path_factory.mktemp("mixed")
    shutil.copy(LOOP, folder / "b.grid")
    shutil.copy(OTHER, folder / "d.grid")
    shutil.copy(MAP, folder / "world.grid")
    (folder / "a.grid").write_bytes(b"not a world\n")
    (folder / "c.grid").write_bytes(LOOP.read_bytes()[:200])
    (folder / "z.grid.gz").write_bytes(b"not gzip either")
    return folder


@pytest.fixture(scope="module")
def archive(folder):
    path = folder.parent / "mixed.zip"
    with zipfile.ZipFile(path, "w") as packed:
        for file in sorted(folder.iterdir()):
            packed.write(file, file.name)
    return path


# Each command with its arguments, and what it prints only after the last good file.
COMMANDS = {
    "verify": ([], "d.grid: reachable"),
    "measure": ([], "d.grid"),
    "replay": ([], "2 of 2 confirmed"),
    "explain": ([], "d.grid: turn-right"),
    "report": (["--out", "{out}.html"], "2 failures"),
    "compare": (["--controller", "turn-right", "--steps", 50], "0 of 3"),
    "train": (["--episodes", 1, "--steps", 5, "--out", "{out}.q"], "of 3"),
    "corpus list": ([], "2 failures of"),
    "corpus show": ([], "d.grid"),
    "corpus merge": (["--out", "{out}"], "2 failures"),
    "corpus export": (["--out", "{out}.csv"], "2 failures"),
}


def run(words, place, tmp_path, *more):
    rest = [str(one).format(out=tmp_path / "out") for one in COMMANDS[words][0]]
    return worldgen(*words.split(" "), place, *rest, *more)


@pytest.mark.parametrize("words", COMMANDS)
@pytest.mark.parametrize("kind", ["folder", "archive"])
def test_every_command_names_bad_files_and_continues(words, kind, request, tmp_path):
    place = request.getfixturevalue(kind)
    result = run(words, place, tmp_path)
    assert result.code == 2
    for name in ("a.grid", "c.grid", "z.grid.gz"):
        assert result.err.count(f"worldgen: {place / name}:") == 1
    assert "worldgen: 3 files could not be read" in result.err
    assert COMMANDS[words][1] in result.out + result.err


@pytest.mark.parametrize("words", ["verify", "replay", "explain", "corpus list"])
def test_json_covers_the_files_that_can_be_read(words, folder, tmp_path):
    result = run(words, folder, tmp_path, "--json")
    found = json.loads(result.out)
    rows = found.get("failures") or found["files"]
    names = {Path(row.get("file") or row["path"]).name for row in rows}
    assert {"b.grid", "d.grid"} <= names


def test_files_that_are_named_one_by_one_are_treated_as_in_a_folder(folder, tmp_path):
    files = [folder / name for name in ("a.grid", "b.grid", "c.grid", "d.grid")]
    result = worldgen("replay", *files)
    assert result.code == 2
    assert "2 of 2 confirmed" in result.out
    assert "has no failure" not in result.err


def test_a_single_bad_file_is_an_error(folder):
    result = worldgen("replay", folder / "a.grid", "--json")
    assert (result.code, result.error_code, result.out) == (2, "not-a-grid", "")


def test_a_failure_that_is_not_confirmed_does_not_hide_a_bad_file(folder, tmp_path):
    text = LOOP.read_text()
    place = tmp_path / "changed"
    place.mkdir()
    (place / "x.grid").write_text(text.replace('trace_digest = "', 'trace_digest = "f', 1))
    (place / "y.grid").write_bytes(b"not a world\n")
    result = worldgen("replay", place)
    assert "0 of 1 confirmed" in result.out
    assert result.code == 2


def test_worlds_without_a_failure_in_a_folder_are_counted(tmp_path):
    shutil.copy(LOOP, tmp_path / "b.grid")
    shutil.copy(MAP, tmp_path / "world.grid")
    result = worldgen("replay", tmp_path, "--json")
    assert result.code == 0
    assert json.loads(result.out)["others"] == 1
    assert "skipped 1 world without a failure" in result.err


@pytest.mark.parametrize("words", ["replay", "explain"])
def test_a_folder_or_a_world_without_any_failure_ends_with_2(words, tmp_path):
    shutil.copy(MAP, tmp_path / "world.grid")
    assert worldgen(words, tmp_path).code == 2
    assert worldgen(words, tmp_path / "world.grid").code == 2
    assert worldgen(words, tmp_path / "world.grid", LOOP).code == 2
