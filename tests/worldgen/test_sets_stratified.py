"""Sets of worlds that are spread evenly over a range of difficulty."""

import json
import zipfile

import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.difficulty import measure
from worldgen.difficulty.search import Search, constraint_for, strata_constraints, strata_edges
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.grid import read_world, world_digest
from worldgen.sets import make_set, manifest_of, plan_wanted_set, strata_of

SPREAD = ("maze", "--size", 20, "--difficulty", "0.2..0.8", "--seed", 3, "--no-metrics")


def search(low, high, count, *, family="maze", tries=100, where=None, **given):
    constraint = constraint_for(where, (low, high))
    parts = strata_constraints(constraint.text, strata_edges(low, high, count))
    made_by = FAMILIES.get(family)
    return Search(made_by, constraint, 1, {"size": 16, **given}, parts).found(count, tries)


@pytest.fixture(scope="module")
def spread(tmp_path_factory):
    """A set of 20 mazes in a folder, and the command's output."""
    out = tmp_path_factory.mktemp("spread") / "mazes"
    result = worldgen(*SPREAD, "--count", 20, "--out", out)
    assert result.code == 0, result.err
    return out, result.err


@pytest.mark.gate
def test_every_stratum_has_its_share(spread):
    out, said = spread
    manifest = manifest_of(out)
    assert [stratum.worlds for stratum in strata_of(manifest)] == [2] * 10
    assert manifest.header.strata == (0.2, 0.26, 0.32, 0.38, 0.44, 0.5, 0.56, 0.62, 0.68, 0.74, 0.8)
    assert said.count("difficulty 0.") == 10 and "\n  difficulty 0.26 to 0.32: 2\n" in said


@pytest.mark.gate
def test_each_world_is_as_hard_as_the_manifest_says_and_lies_in_its_stratum(spread):
    out, _ = spread
    for entry in manifest_of(out).entries:
        low, high = entry.stratum
        difficulty = entry.metrics["difficulty"]
        assert (
            low <= difficulty <= high
            and measure(read_world(out / entry.file)).difficulty == difficulty
        )


def test_all_worlds_differ_and_the_parameter_given_stays(spread):
    entries = manifest_of(spread[0]).entries
    assert len({entry.digest for entry in entries}) == 20 and {
        entry.params["size"] for entry in entries
    } == {20}


@pytest.mark.gate
def test_equal_seeds_give_equal_sets_and_the_manifest_makes_them_again(spread, tmp_path):
    out, _ = spread
    assert worldgen(*SPREAD, "--count", 20, "--out", tmp_path / "a.zip").code == 0
    assert worldgen("regenerate", out, "--out", tmp_path / "b.zip").code == 0
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        assert archive.read("manifest.jsonl") == (out / "manifest.jsonl").read_bytes()


def test_json_names_the_stratum_of_every_world(tmp_path):
    done = worldgen(*SPREAD, "--count", 2, "--out", tmp_path / "two", "--json")
    assert sorted(file["stratum"] for file in json.loads(done.out)["files"]) == [
        [0.2, 0.5],
        [0.5, 0.8],
    ]


def test_a_search_that_was_interrupted_goes_on_to_the_same_set(spread, tmp_path):
    whole, _ = spread
    part = tmp_path / "part"
    plan = plan_wanted_set("maze", 3, 20, {"size": 20}, difficulty=(0.2, 0.8), metrics=False)

    def stop_after_five(done):
        if done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_set(plan, part, progress=stop_after_five)
    assert make_set(plan, part).resumed == 5
    assert (part / "manifest.jsonl").read_bytes() == (whole / "manifest.jsonl").read_bytes()


@pytest.mark.gate
def test_a_stratum_that_the_family_cannot_fill_leaves_its_worlds_to_its_neighbours(tmp_path):
    plan = plan_wanted_set(
        "maze", 1, 8, {"size": 12}, difficulty=(0.75, 1.0), tries=40, metrics=False
    )
    make_set(plan, tmp_path / "set")
    strata = strata_of(manifest_of(tmp_path / "set"))
    assert sum(stratum.worlds for stratum in strata) == 8
    assert strata[-1].worlds == 0 and any(stratum.worlds > stratum.share for stratum in strata)


def test_the_command_says_which_strata_are_short_of_worlds(tmp_path, monkeypatch):
    monkeypatch.setattr("worldgen.sets.searched.TRIES", 20)
    done = worldgen(
        "maze", "--size", 12, "--difficulty", "0.7..1", "--seed", 1, "--count", 3, "--no-metrics",
        "--out", tmp_path / "set",
    )  # fmt: skip
    assert done.code == 0 and "difficulty 0.9 to 1: 0  1 fewer than its share" in done.err


def test_a_range_that_no_world_lies_in_is_refused_after_the_tries():
    with raises(
        GenerationFailed, "no-world-found", before=0, tries=5, constraint="0.95 <= difficulty <= 1"
    ):
        list(search(0.95, 1.0, 4, tries=5))


def test_what_else_is_given_holds_for_every_world():
    found = list(search(0.3, 0.9, 4, where="solid < 0.45"))
    assert len({world_digest(one.world) for one in found}) == 4
    assert all(measure(one.world).solid < 0.45 for one in found)


@pytest.mark.parametrize(
    ("low", "high"), [(0.9, 0.1), (0.5, 0.5), (-0.1, 0.5), (0.5, 1.1), (float("nan"), 1.0)]
)
def test_what_is_no_range_of_difficulty_is_refused(low, high):
    with raises(InvalidParameter, "out-of-range"):
        strata_edges(low, high, 10)


def test_a_family_whose_worlds_change_has_no_difficulty_to_spread():
    with raises(InvalidParameter, "world-changes", name="fire"):
        search(0.1, 0.9, 4, family="fire")


def test_one_world_may_be_wanted_anywhere_in_a_range():
    done = worldgen("maze", "--size", 20, "--difficulty", "0.4..0.6", "--seed", 1, "--json")
    assert 0.4 <= json.loads(done.out)["metrics"]["difficulty"] <= 0.6


@pytest.mark.parametrize("text", ["hard", "0.1..", "0.1..0.2..0.3", "0.1-0.9"])
def test_a_difficulty_that_cannot_be_read_is_refused(text):
    done = worldgen("maze", "--difficulty", text, "--count", 2, "--out", "set")
    assert done.code == 2 and "is neither a difficulty, such as 0.8, nor a range of it" in done.err


@pytest.mark.parametrize("high", [0.5000001, 0.5009])
def test_a_range_that_is_too_narrow_for_strata_is_refused(high):
    with raises(InvalidParameter, "range-too-narrow", low=0.5, narrowest=0.001):
        strata_edges(0.5, high, 10)


def test_the_narrowest_range_has_strata_that_differ():
    assert len(set(strata_edges(0.3, 0.301, 10))) == 11


def test_a_set_that_is_not_found_is_an_error_even_if_quiet_and_one_object_of_json(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("worldgen.sets.searched.TRIES", 2)
    done = worldgen(
        "maze", "--size", 12, "--difficulty", "0.99..1", "--seed", 1, "--count", 2, "--no-metrics",
        "--out", tmp_path / "set", "-q", "--json",
    )  # fmt: skip
    assert done.code == 1 and "none of 2 worlds fits" in done.err
    assert json.loads(done.out)["constraint"] == "0.99 <= difficulty <= 1"
