"""Corpora: the files are authoritative, the smallest of each cause are kept, equal failures have
equal bytes.
"""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.corpus import Selection, differences, export, judge_all, merge, read_corpus, smallest
from fuzz.failure import Failure
from tests.helpers.command_line import worldgen
from worldgen import read_world, write_world

FAULTS = Path(__file__).parents[2] / "corpora" / "thesis-faults"
LOOP = FAULTS / "thesis-1-loop-104.grid"


def failure(folder, name, *, solid=0, kind="loop-a", controller="thesis-1", digest=None, seen=None):
    """Write the shipped loop with another group, controller, number of solid cells or trace
    digest.
    """
    world = read_world(LOOP)
    walls = world.walls.copy()
    walls.flat[:solid] = True
    record = replace(
        world.failure,
        controller=controller,
        # What has no known cause is filed by what it looks like.
        details={**world.failure.details, "cause": "unknown", "class": kind},
    )
    record = replace(record, trace_digest=digest or record.trace_digest)
    path = folder / f"{name}.grid"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_world(replace(world, walls=walls, failure=record), path, force=True)
    if seen is not None:
        os.utime(path, (seen, seen))
    return path


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*.grid"))
    }


def read(*paths, only=()):
    return read_corpus(paths, Selection(only)).entries


def test_list_has_a_row_for_each_failure():
    result = worldgen("corpus", "list", FAULTS)
    assert result.code == 0 and "16 failures of 4 causes" in result.out
    assert all(path.name in result.out for path in FAULTS.glob("*.grid"))


def test_list_as_json_has_what_the_file_says():
    row = json.loads(worldgen("corpus", "list", LOOP, "--json").out)["failures"][0]
    assert (row["controller"], row["motion"]) == ("thesis-1", "stepped")
    assert row["cause"] == "returns-to-a-wall"
    assert (row["width"], row["height"], row["solid"], row["verdict"]) == (9, 3, 0, "loop")
    assert row["replay"] == f"worldgen replay {LOOP}" and row["first_seen"].endswith("Z")


@pytest.mark.parametrize(
    ("field", "pattern", "count"),
    [
        ("controller", "thesis-3", 4),
        ("cause", "goes-*", 13),
        ("verdict", "stalled", 2),
        ("cause", "no", 0),
    ],
)
def test_a_filter_leaves_what_fits(field, pattern, count):
    told = worldgen("corpus", "list", FAULTS, "--only", f"{field}={pattern}", "--json")
    assert len(json.loads(told.out)["failures"]) == count


def test_filters_of_different_kinds_must_all_fit_and_of_one_kind_one():
    robots = (("controller", "thesis-1"), ("controller", "thesis-2"))
    assert len(read(FAULTS, only=(*robots, ("verdict", "stalled"), ("verdict", "loop")))) == 3


def test_a_filter_of_no_field_is_refused():
    done = worldgen("corpus", "list", FAULTS, "--only", "loop")
    assert done.code == 2 and "write verdict=loop" in done.err


def test_a_filter_that_fits_no_verdict_is_refused():
    done = worldgen("corpus", "list", FAULTS, "--only", "verdict=lopo")
    assert done.code == 2 and "no verdict is 'lopo'; write verdict=loop" in done.err
    assert worldgen("corpus", "list", FAULTS, "--only", "verdict=st*").code == 0


def test_the_options_of_a_run_are_part_of_its_controller(tmp_path):
    world = read_world(LOOP)
    noisy = replace(world.failure, parameters={**world.failure.parameters, "noise": True})
    write_world(replace(world, failure=noisy), tmp_path / "noisy.grid")
    assert read(tmp_path)[0].facts.controller == "thesis-1+noise"


def test_worlds_without_a_failure_are_passed_over(tmp_path):
    write_world(replace(read_world(LOOP), failure=None), tmp_path / "w.grid")
    result = worldgen("corpus", "list", tmp_path)
    assert "0 failures" in result.out and "skipped 1 world " in result.err


def test_a_hidden_folder_is_no_part_of_a_corpus_unless_it_is_named(tmp_path):
    failure(tmp_path, "out/x")
    failure(tmp_path, "out/.campaign/failures/y", kind="loop-b")
    hidden = tmp_path / "out/.campaign"
    assert [len(read(folder)) for folder in (tmp_path / "out", hidden)] == [1, 1]


@pytest.mark.parametrize("text", ["", "no world\n", "%worldgen-grid 1\ncell_size = 1e999\n"])
def test_a_broken_file_is_one_line_that_names_it(text, tmp_path):
    (tmp_path / "broken.grid").write_text(text)
    result = worldgen("corpus", "list", tmp_path)
    assert result.code == 2 and "broken.grid" in result.err and "Traceback" not in result.err


def test_a_missing_corpus_is_one_line():
    result = worldgen("corpus", "diff", "absent", FAULTS)
    assert result.code == 2 and result.error_code == "no-such-file"


def test_a_record_with_unknown_options_is_one_line(tmp_path):
    world = read_world(LOOP)
    odd = replace(world.failure, parameters={**world.failure.parameters, "wings": 2})
    write_world(replace(world, failure=odd), tmp_path / "odd.grid")
    result = worldgen("corpus", "list", tmp_path)
    assert result.code == 2 and "odd.grid" in result.err and result.error_code == "invalid-record"


def test_a_file_that_changed_under_the_same_date_and_length_is_noticed(tmp_path):
    path = failure(tmp_path, "a", kind="loop-a", seen=1_700_000_000)
    read(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"loop-a", b"loop-b"))
    os.utime(path, (1_700_000_000, 1_700_000_000))
    assert [entry.facts.group for entry in read(tmp_path)] == ["loop-b"]


def test_merge_keeps_the_smallest_of_each_cause_of_each_controller(tmp_path):
    failure(tmp_path / "A", "x", solid=3)
    small = failure(tmp_path / "B", "y", solid=1)
    failure(tmp_path / "B", "z", solid=5, controller="turn-right")
    result = worldgen("corpus", "merge", tmp_path / "A", tmp_path / "B", "--out", tmp_path / "C")
    assert result.code == 0 and "3 failures, 2 kept" in result.out
    files = contents(tmp_path / "C")
    assert list(files) == ["thesis-1/stepped/loop-a.grid", "turn-right/stepped/loop-a.grid"]
    assert files["thesis-1/stepped/loop-a.grid"] == small.read_bytes()


def test_merge_does_not_depend_on_the_order_of_corpora(tmp_path):
    for name, side in (("A", 0), ("B", 1)):  # two worlds of one size
        path = failure(tmp_path / name, "x")
        world = read_world(path)
        walls = np.zeros_like(world.walls)
        walls[0, side] = True
        write_world(replace(world, walls=walls), path, force=True)
    merge(read(tmp_path / "A", tmp_path / "B"), tmp_path / "C")
    merge(read(tmp_path / "B", tmp_path / "A"), tmp_path / "D")
    assert contents(tmp_path / "C") == contents(tmp_path / "D")


def test_merge_twice_is_merge_once(tmp_path):
    merge(read(FAULTS), tmp_path / "C")
    before = contents(tmp_path / "C")
    merge(read(FAULTS), tmp_path / "C")
    merge(read(tmp_path / "C"), tmp_path / "D")
    assert before == contents(tmp_path / "C") == contents(tmp_path / "D")


def test_merge_refuses_a_folder_with_other_worlds_and_leaves_it_alone(tmp_path):
    failure(tmp_path / "A", "x", solid=1)
    failure(tmp_path / "C", "thesis-1/stepped/loop-a", solid=2)
    before = contents(tmp_path / "C")
    result = worldgen("corpus", "merge", tmp_path / "A", "--out", tmp_path / "C")
    assert (
        result.code == 2
        and result.error_code == "folder-holds-worlds"
        and contents(tmp_path / "C") == before
    )


def test_a_baseline_grows_by_merging_into_itself(tmp_path):
    merge(read(failure(tmp_path / "A", "x", solid=2)), tmp_path / "base")
    small, fresh = (
        failure(tmp_path / "B", "x", solid=1),
        failure(tmp_path / "B", "y", kind="loop-b"),
    )
    base = tmp_path / "base"
    assert worldgen("corpus", "merge", base, tmp_path / "B", "--out", base, "--force").code == 0
    assert sorted(contents(base).values()) == sorted([small.read_bytes(), fresh.read_bytes()])


def test_a_merged_failure_is_dated_by_the_first_of_its_cause(tmp_path):
    failure(tmp_path / "A", "large", solid=2, seen=1_600_000_000)
    failure(tmp_path / "A", "small", solid=1, seen=1_700_000_000)
    merge(read(tmp_path / "A"), tmp_path / "C")
    assert read(tmp_path / "C")[0].first_seen == "2020-09-13T12:26:40Z"


@pytest.mark.parametrize("word", ["../../out", "/etc/x", "..", "", "a/b", "x\x07y", "é" * 300])
def test_a_name_from_a_strangers_file_stays_in_the_folder(word, tmp_path):
    failure(tmp_path / "A", "x", kind=word, controller=word)
    written = list(merge(read(tmp_path / "A"), tmp_path / "C"))
    assert (
        written[0].resolve().is_relative_to(tmp_path / "C")
        and len(list((tmp_path / "C").rglob("*.grid"))) == 1
    )


def test_names_that_look_alike_once_they_are_plain_stay_apart(tmp_path):
    for k, word in enumerate(("./mine.py:Robot", "./mine.py/Robot", "mine.py-Robot")):
        failure(tmp_path / "A", str(k), controller=word)
    assert len(merge(read(tmp_path / "A"), tmp_path / "C")) == 3


@pytest.mark.parametrize(
    ("old", "new", "change"), [(2, 1, "smaller"), (1, 2, "larger"), (1, 1, "same")]
)
def test_diff_says_what_became_of_a_cause(old, new, change, tmp_path):
    before, now = (
        read(failure(tmp_path, str(k), solid=solid)) for k, solid in enumerate((old, new))
    )
    assert [difference.change for difference in differences(before, now)] == [change]


def test_merging_loses_no_failure_whose_reason_ends_in_a_number(tmp_path):
    failure(tmp_path / "in", "one", kind="crash-act")
    failure(tmp_path / "in", "two", kind="crash-act-2", solid=1)
    # A second failure of the first reason, with another signature, would be crash-act-2, too.
    first, _ = sorted(read(tmp_path / "in"), key=lambda entry: entry.facts.group)
    other = replace(first, facts=replace(first.facts, signature="other", digest="f" * 64))
    merged = merge([*read(tmp_path / "in"), other], tmp_path / "out")
    assert len(merged) == 3
    assert {path.stem for path in merged} == {"crash-act", "crash-act-2", "crash-act-2-more"}


def test_diff_ends_with_1_for_a_new_cause_and_with_0_for_one_that_is_gone(tmp_path):
    failure(tmp_path / "one", "x")
    failure(tmp_path / "two", "x")
    failure(tmp_path / "two", "y", kind="loop-b")
    more = worldgen("corpus", "diff", tmp_path / "one", tmp_path / "two")
    less = worldgen("corpus", "diff", tmp_path / "two", tmp_path / "one", "--json")
    assert more.code == 1 and "1 new, 0 gone" in more.out and "loop-b" in more.out
    assert less.code == 0 and json.loads(less.out)["gone"] == 1


def test_against_an_empty_folder_every_cause_is_new_and_an_empty_one_has_none(tmp_path):
    (tmp_path / "none").mkdir()
    assert worldgen("corpus", "diff", tmp_path / "none", FAULTS).code == 1
    assert worldgen("corpus", "diff", FAULTS, tmp_path / "none").code == 0


@pytest.fixture
def mixed(tmp_path):
    """A failure that replays, one that is larger, one that no longer replays, one that cannot be
    run here.
    """
    failure(tmp_path, "holds")
    failure(tmp_path, "larger", solid=9)
    failure(tmp_path, "changed", kind="loop-b", digest="0" * 16)
    failure(tmp_path, "absent", kind="loop-c", controller="./absent.py:Robot")
    return tmp_path


def test_prune_keeps_what_replays_and_what_it_cannot_judge(mixed):
    result = worldgen("corpus", "prune", mixed)
    assert result.code == 1 and sorted(contents(mixed)) == ["absent.grid", "holds.grid"]
    assert (
        "no longer replays: the trace digest is" in result.out
        and "cannot be replayed here" in result.out
    )
    assert (
        "holds.grid is a smaller world that looks the same" in result.out
        and "2 kept, 2 dropped" in result.out
    )


def test_a_dry_run_of_prune_says_the_same_and_deletes_nothing(mixed):
    before = contents(mixed)
    result = worldgen("corpus", "prune", mixed, "--dry-run", "--json")
    summary = json.loads(result.out)
    assert contents(mixed) == before and (summary["kept"], summary["dropped"]) == (2, 2)


def test_prune_of_a_corpus_in_order_changes_nothing_and_ends_with_0(tmp_path):
    merge(read(LOOP), tmp_path)
    result = worldgen("corpus", "prune", tmp_path)
    assert result.code == 0 and "1 kept, 0 dropped" in result.out


def test_where_the_smallest_no_longer_replays_the_next_one_stays(tmp_path):
    failure(tmp_path, "next")
    other = read_world(FAULTS / "thesis-1-confined.grid")  # it has fewer cells
    record = replace(other.failure, details={"class": "loop-a"}, trace_digest="0" * 16)
    write_world(replace(other, failure=record), tmp_path / "small.grid")
    judged = [
        (judgement.entry.path.name, judgement.keep) for judgement in judge_all(read(tmp_path))
    ]
    assert judged == [("small.grid", False), ("next.grid", True)]


def test_the_smaller_of_two_failures_is_the_one_that_shrinking_calls_simpler():
    few_cells = Failure.read(FAULTS / "thesis-1-confined.grid")
    few_solid = Failure.read(LOOP)
    assert few_cells.world.walls.size < few_solid.world.walls.size
    assert few_cells.world.solid_cells > few_solid.world.solid_cells
    assert few_cells.size < few_solid.size


@pytest.mark.parametrize(
    ("body", "verdict"),
    [("raise FileNotFoundError('map.yaml')", "crash"), ("return None", "invalid-command")],
)
def test_prune_keeps_failures_whose_controller_now_fails_for_itself(body, verdict, tmp_path):
    (tmp_path / "mine.py").write_text(
        f"class R:\n def reset(self): return ()\n def act(self, o, m): {body}\n"
    )
    world = read_world(LOOP)
    record = replace(world.failure, controller=f"{tmp_path}/mine.py:R", motion="swept")
    write_world(replace(world, failure=record), tmp_path / "f.grid")
    result = worldgen("corpus", "prune", "--trust", tmp_path)
    assert (
        result.code == 1
        and (tmp_path / "f.grid").exists()
        and f"its controller ends with {verdict} here" in result.out
    )


def test_prune_refuses_an_archive():
    result = worldgen("corpus", "prune", "failures.zip")
    assert result.code == 2 and result.error_code == "wrong-kind-of-file"


def test_equal_failures_are_an_equal_archive(tmp_path):
    one = [
        failure(tmp_path / "A", "x", seen=1_600_000_000),
        failure(tmp_path / "A", "y", kind="loop-b"),
    ]
    two = [failure(tmp_path / "B/deep", "q", kind="loop-b"), failure(tmp_path / "B", "r"), *one]
    export(read(*one), tmp_path / "one.zip")
    export(read(*two), tmp_path / "two.zip")
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "two.zip").read_bytes()


@pytest.mark.gate
def test_an_archive_is_a_corpus_like_the_folder_it_came_from(tmp_path):
    worldgen("corpus", "export", FAULTS, "--only", "cause=goes-*", "--out", tmp_path / "f.zip")
    listed = read(tmp_path / "f.zip")
    assert smallest(listed).keys() == smallest(read(FAULTS, only=(("cause", "goes-*"),))).keys()
    assert worldgen("replay", tmp_path / "f.zip").code == 0
    assert worldgen("corpus", "diff", FAULTS, tmp_path / "f.zip").code == 0


def test_an_archive_has_a_row_and_a_picture_for_each_failure(tmp_path):
    import csv
    import zipfile

    failure(tmp_path / "A", "x", solid=1)
    failure(tmp_path / "A", "y", solid=2)
    export(read(tmp_path / "A"), tmp_path / "f.zip")
    with zipfile.ZipFile(tmp_path / "f.zip") as archive:
        rows = list(csv.DictReader(archive.read("corpus.csv").decode().splitlines()))
        assert [row["file"] for row in rows] == [
            f"thesis-1/stepped/loop-a{n}.grid" for n in ("", "-2")
        ]
        assert all(archive.read(row["picture"]).startswith(b"\x89PNG") for row in rows)


def test_a_table_alone_is_comma_separated(tmp_path):
    result = worldgen("corpus", "export", FAULTS, "--out", tmp_path / "t.csv", "--json")
    lines = (tmp_path / "t.csv").read_text().splitlines()
    assert json.loads(result.out)["failures"] == 16 == len(lines) - 1
    assert (
        lines[0]
        == "file,controller,motion,cause,verdict,width,height,solid,events,digest,first_seen"
    )


def test_a_parquet_table_holds_texts_and_pictures(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra [parquet]")
    export(read(LOOP), tmp_path / "t.parquet")
    row = parquet.read_table(tmp_path / "t.parquet").to_pylist()[0]
    assert (
        row["grid"] == LOOP.read_bytes()
        and row["picture"].startswith(b"\x89PNG")
        and row["solid"] == 0
    )


def test_a_parquet_table_without_pyarrow_is_refused_with_the_way_out(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    result = worldgen("corpus", "export", LOOP, "--out", tmp_path / "t.parquet")
    assert result.code == 2 and result.error_code == "package-missing"


@pytest.mark.parametrize(
    ("name", "error_code"), [("f.xls", "unknown-format"), ("there.csv", "file-exists")]
)
def test_export_refuses_what_it_cannot_write(name, error_code, tmp_path):
    (tmp_path / "there.csv").write_text("mine")
    result = worldgen("corpus", "export", LOOP, "--out", tmp_path / name)
    assert (
        result.code == 2
        and result.error_code == error_code
        and (tmp_path / "there.csv").read_text() == "mine"
    )


def test_show_draws_a_failure_and_says_how_to_replay_it():
    result = worldgen("corpus", "show", FAULTS, "--only", "cause=returns-*")
    assert (
        result.code == 0
        and "S start  G target" in result.out
        and f"worldgen replay {LOOP}" in result.out
    )


def test_words_from_a_strangers_file_cannot_steer_the_terminal(tmp_path):
    failure(tmp_path, "x\x1b[2J", kind="loop\x1b[2J", controller="thesis-2+oops\x1b[2J")
    failure(tmp_path, "y", kind="loop\x1b[2J")
    commands = ("corpus", "list"), ("corpus", "show"), ("corpus", "prune"), ("replay",)
    assert all("\x1b" not in worldgen(*command, tmp_path).out for command in commands)


@pytest.mark.gate
def test_show_draws_a_corpus_on_one_sheet(tmp_path):
    result = worldgen("corpus", "show", FAULTS, "--picture", tmp_path / "sheet.png")
    assert result.code == 0 and (tmp_path / "sheet.png").read_bytes().startswith(b"\x89PNG")


def test_a_failure_whose_controller_is_not_here_is_shown_without_its_way(tmp_path):
    failure(tmp_path, "x", controller="./absent.py:Robot")
    result = worldgen("corpus", "show", tmp_path)
    assert result.code == 0 and "9x3, 0 solid" in result.out and "cannot be run here" in result.err
    assert worldgen("corpus", "show", tmp_path, "--picture", tmp_path / "sheet.png").code == 0


def test_a_sheet_of_nothing_is_refused(tmp_path):
    result = worldgen(
        "corpus", "show", FAULTS, "--only", "cause=none", "--picture", tmp_path / "sheet.png"
    )
    assert result.code == 2 and result.error_code == "nothing-given"
