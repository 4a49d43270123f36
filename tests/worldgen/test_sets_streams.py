"""Streams of worlds, and large sets in folders."""

import pytest

import worldgen.files.locks
import worldgen.sets.stores
from tests.helpers.command_line import worldgen as run
from tests.helpers.raising import raises
from tests.worldgen.test_sets import SMALL, TRAPS
from worldgen.errors import InvalidParameter
from worldgen.generation import generate, stream
from worldgen.sets import plan_set


def test_large_sets_are_in_folders_of_a_thousand():
    plan = plan_set("maze", 0, 10_001, {})
    assert [plan.file(k) for k in (0, 999, 1000, 10_000)] == [
        "0000/maze-0.grid", "0000/maze-999.grid", "0001/maze-1000.grid", "0010/maze-10000.grid",
    ]  # fmt: skip
    assert plan_set("maze", 0, 10_000, {}).file(9_999) == "maze-9999.grid"


def test_a_set_in_subfolders_is_made_and_checked(tmp_path, monkeypatch):
    monkeypatch.setattr(worldgen.sets.plan, "_FLAT", 3)
    monkeypatch.setattr(worldgen.sets.plan, "_SHARD", 2)
    run(*TRAPS, "--out", tmp_path / "set")
    assert (tmp_path / "set/0002/trap-10.grid").is_file()
    assert run("regenerate", tmp_path / "set", "--check").code == 0
    run(*TRAPS, "--out", tmp_path / "set", "--force", "--shape", "V")
    assert run("regenerate", tmp_path / "set", "--check").code == 0


def test_a_stream_gives_the_worlds_of_a_set_and_makes_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    worlds = list(stream("trap", seed=5, count=3, **SMALL))
    assert worlds == [generate("trap", seed, **SMALL) for seed in (5, 6, 7)] and not list(
        tmp_path.iterdir()
    )


def test_a_stream_without_a_count_has_no_end_and_goes_on_at_0():
    worlds = stream("trap", seed=2**64 - 2, **SMALL)
    assert [next(worlds).provenance.seed for _ in range(4)] == [2**64 - 2, 2**64 - 1, 0, 1]


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"sise": 3}, {"code": "unknown-name", "name": "sise"}),
        ({"count": -1}, {"code": "below-minimum"}),
    ],
)
def test_a_stream_refuses_at_once_what_can_give_no_world(params, expected):
    with raises(InvalidParameter, **expected):
        stream("trap", **params)
