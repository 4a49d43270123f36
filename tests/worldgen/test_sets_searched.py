"""Sets of worlds found by a search: recreated, continued, kept."""

import json
import shutil

import pytest

from tests.helpers.command_line import worldgen as run
from tests.helpers.set_contents import contents
from worldgen.files.grid import read_world
from worldgen.sets import manifest_of

SEARCHED = ("trap", "--where", "detour > 2", "--size", 12, "--seed", 5)


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """A folder with a set found by a search; do not change it."""
    folder = tmp_path_factory.mktemp("searched") / "set"
    assert run(*SEARCHED, "--count", 4, "--out", folder).code == 0
    return folder


def test_a_set_that_was_searched_for_is_made_again_from_its_manifest(searched, tmp_path):
    assert manifest_of(searched).header.constraint == "detour > 2"
    assert run("regenerate", searched / "manifest.jsonl", "--out", tmp_path / "again").code == 0
    assert contents(tmp_path / "again") == contents(searched)


def test_lines_of_a_set_that_was_searched_for_have_what_the_search_varied(searched):
    first, *lines = [
        json.loads(line) for line in (searched / "manifest.jsonl").read_text().splitlines()
    ]
    assert first["params"] == {"size": 12} and all("size" not in line["params"] for line in lines)
    worlds = [read_world(searched / line["file"]) for line in lines]
    assert [{**first["params"], **line["params"]} for line in lines] == [
        dict(w.provenance.params) for w in worlds
    ]


def test_a_search_that_was_interrupted_goes_on_to_the_same_set(searched, tmp_path):
    part = shutil.copytree(searched, tmp_path / "set")
    lines = (part / "manifest.jsonl").read_bytes().splitlines(keepends=True)
    (part / "manifest.jsonl").write_bytes(b"".join(lines[:3]))
    (part / "trap-4.grid").unlink()
    assert "2 of 4 worlds already exist" in run(*SEARCHED, "--count", 4, "--out", part).err
    assert contents(part) == contents(searched)


def test_another_constraint_does_not_go_on_with_a_set(searched):
    err = run(
        "trap",
        "--where",
        "detour > 1.5",
        "--size",
        12,
        "--seed",
        5,
        "--count",
        4,
        "--out",
        searched,
    ).err
    assert "holds 4 of 4 worlds of another set: trap from seed 5 where detour > 2" in err


def test_what_a_search_found_stays_when_it_finds_no_more(tmp_path, monkeypatch):
    monkeypatch.setattr("worldgen.sets.searched.TRIES", 2)
    result = run(*SEARCHED, "--count", 40, "--out", tmp_path / "set")
    assert result.code == 1
    assert 0 < len(manifest_of(tmp_path / "set").entries) < 40
