"""A failure says how far it was shrunk, and every output says only that."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from fuzz.campaign import run as campaign_run
from fuzz.failure import Failure, ShrinkState
from fuzz.shrink import shrink as shrink_failure
from fuzz.shrink.queue import Shrinking, shrunk_or_same
from tests.helpers.command_line import worldgen
from worldgen.files.grid import dumps, loads

CORPUS = Path(__file__).parents[2] / "corpora"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """A campaign that does not shrink: its folder, and what it printed."""
    out = tmp_path_factory.mktemp("found") / "f"
    few = ("--units", 1, "--seed", 1, "--workers", 1, "--family", "trap", "--no-shrink", "--json")
    return out, worldgen("fuzz", "--controller", "turn-right", *few, "--out", out)


@pytest.fixture(scope="module")
def found(campaign):
    """A failure as the search found it, in a world with walls that do not matter."""
    failures = [Failure.read(path) for path in sorted(campaign[0].glob("*.grid"))]
    loops = [failure for failure in failures if failure.verdict == "loop"]
    return max(loops, key=lambda one: one.world.solid_cells)


@pytest.mark.gate
def test_a_failure_that_nobody_shrunk_says_none_and_stores_nothing(found):
    assert found.shrinking == ShrinkState.NONE
    assert b"shrinking" not in found.dumps()


def test_shrinking_to_the_end_says_done_and_the_check_agrees(found):
    result = shrink_failure(found)
    again = Failure.of(loads(result.failure.dumps()))
    assert (again.shrinking, again.record.details["shrinking"]) == (ShrinkState.DONE, "done")
    assert again.world.solid_cells < found.world.solid_cells


def test_shrinking_without_time_says_cut_short(found):
    result = shrink_failure(found, seconds=0.0)
    assert result.failure.shrinking == ShrinkState.CUT_SHORT


def test_shrinking_continues_a_file_that_was_cut_short(found, tmp_path):
    short = tmp_path / "short.grid"
    shrink_failure(found, seconds=0.0).failure.write(short)
    result = worldgen("shrink", short, "--out", tmp_path / "small.grid", "--json")
    assert json.loads(result.out)["shrinking"] == "done"
    assert Failure.read(tmp_path / "small.grid").shrinking == ShrinkState.DONE


def test_ctrl_c_says_cut_short(found):
    def stop(world):
        raise KeyboardInterrupt

    result = shrink_failure(found, progress=stop, keep_on_interrupt=True)
    assert result.failure.shrinking == ShrinkState.CUT_SHORT


def test_a_failure_that_shrinking_cannot_prove_again_stays_as_found(found):
    fine = replace(found, record=replace(found.record, verdict="tunnel"))
    assert shrunk_or_same(fine).failure.shrinking == ShrinkState.NONE


@pytest.mark.parametrize(
    ("details", "state"),
    [
        ({"one_minimal": True, "shrunk_from": 9}, "done"),
        ({"one_minimal": False, "shrunk_from": 9}, "cut short"),
        ({"shrunk_from": 9}, "none"),
        ({"shrinking": "cut short", "one_minimal": True}, "cut short"),
        ({"shrinking": "of another version"}, "none"),
        ({"shrinking": 7}, "none"),
        ({"shrinking": ["done"]}, "none"),
    ],
)
def test_a_record_of_another_version_is_read_by_its_check(found, details, state):
    assert replace(found, record=replace(found.record, details=details)).shrinking == state


def test_every_failure_of_the_library_is_done_and_its_bytes_stay():
    for path in sorted((CORPUS / "failures").rglob("*.grid"))[::40]:
        failure = Failure.read(path)
        assert failure.shrinking == ShrinkState.DONE
        assert dumps(failure.stored) == path.read_bytes()


def test_every_output_says_the_same(found, tmp_path):
    short = shrink_failure(found, seconds=0.0).failure
    short.write(tmp_path / "short.grid")
    found.write(tmp_path / "found.grid")
    out = worldgen("corpus", "list", tmp_path, "--json").out
    rows = {Path(row["file"]).stem: row["shrinking"] for row in json.loads(out)["failures"]}
    assert rows == {"short": "cut short", "found": "none"}
    assert "cut short" in worldgen("corpus", "list", tmp_path / "short.grid").out
    reports = {name: tmp_path / f"r.{name}" for name in ("junit", "sarif", "summary")}
    options = [word for name, path in reports.items() for word in (f"--{name}", path)]
    shown = worldgen("replay", tmp_path / "short.grid", "--show", *options)
    assert "shrinking cut short" in shown.out
    for path in reports.values():
        assert "cut short" in path.read_text()
    assert "not shrunk" in worldgen("replay", tmp_path / "found.grid", "--show").out
    page = tmp_path / "page.html"
    worldgen("report", tmp_path / "short.grid", "--out", page)
    assert "cut short" in page.read_text()


def test_a_campaign_lists_the_state_of_each_failure(campaign):
    failures = json.loads(campaign[1].out)["failures"]
    assert {one["shrinking"] for one in failures} == {"none"}
    assert not any("shrunk" in one for one in failures)


@pytest.mark.gate
def test_a_failure_whose_shrinking_ran_out_of_time_says_cut_short(tmp_path, monkeypatch):
    monkeypatch.setattr(
        campaign_run, "shrunk_or_same", lambda failure, *_, **__: Shrinking(failure, complete=False)
    )
    few = ("--units", 1, "--seed", 1, "--workers", 1, "--family", "trap", "--json")
    out = tmp_path / "f"
    result = worldgen("fuzz", "--controller", "turn-right", *few, "--out", out)
    failures = json.loads(result.out)["failures"]
    # A clearer world of the cause, which was not to be shrunk, may come first.
    states = {one["file"]: one["shrinking"] for one in failures}
    assert "cut short" in states.values() and set(states.values()) <= {"cut short", "none"}
    assert {file: Failure.read(Path(file)).shrinking for file in states} == states
    # No second file shows the same world in another state.
    assert len({Failure.read(path).without("shrinking").id for path in out.glob("*.grid")}) == len(
        list(out.glob("*.grid"))
    )


@pytest.mark.parametrize("key", ["cause", "class", "shrinking"])
@pytest.mark.parametrize("value", [["x"], {"x": 1}])
def test_a_forged_detail_of_another_type_is_no_fault_of_ours(found, key, value, tmp_path):
    forged = found.noting(**{key: value})
    forged.write(tmp_path / "forged.grid")
    assert worldgen("replay", tmp_path / "forged.grid", "--show").code in (0, 1)
    assert worldgen("corpus", "list", tmp_path).code == 0
