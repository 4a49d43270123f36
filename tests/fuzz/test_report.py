"""The contents of a report's page; tests/browser/test_report_page.py opens it in a browser."""

import base64
import json
import re
import shutil
import tomllib
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.campaign.store import read_summary
from fuzz.corpus import read_corpus
from fuzz.failure import Failure
from fuzz.overview import CampaignResult, read_overview
from fuzz.overview.result import write_overview
from fuzz.player.runs import MOST_STEPS, SHARE, drawn_run
from fuzz.player.streams import bits, numbers
from fuzz.player.worlds import drawn_world
from fuzz.report import write_report
from fuzz.report.answers import answers_for
from fuzz.report.gather import look_at
from sim.episode import Episode, simulate
from sim.evidence import LoopEvidence, WallEvidence
from sim.trace import Trace
from tests.helpers.campaign_folder import (
    CORPUS,
    LOOP,
    STALLED,
    SUMMARY,
    TUNNEL,
    campaign_folder,
    explain_the_loop,
    with_details,
)
from tests.helpers.campaign_results import natural_worlds
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter
from worldgen.files.grid import read_world, write_world
from worldgen.world import FailureRecord


def data_of(page):
    """The JSON in a page."""
    return json.loads(
        re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text())[1]
    )


def decoded(text):
    """The inverse of ``numbers``, as in decode.js."""
    values, value, rate, zigzag, scale = [], 0, 0, 0, 1
    for byte in base64.b64decode(text):
        zigzag, scale = zigzag + (byte & 127) * scale, scale * 128
        if byte < 128:
            rate += -(zigzag + 1) // 2 if zigzag % 2 else zigzag // 2
            value += rate
            values.append(value)
            zigzag, scale = 0, 1
    return values


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = campaign_folder(tmp_path_factory.mktemp("campaign") / "failures")
    out = folder.parent / "report.html"
    write_report([folder], out)
    return out


@given(st.lists(st.integers(-(2**50), 2**50)))
def test_numbers_come_back_as_they_were(values):
    assert decoded(numbers(np.array(values, np.int64))) == values


@given(st.lists(st.booleans()))
def test_bits_come_back_as_they_were(flags):
    data = base64.b64decode(bits(flags))
    assert [bool(data[k // 8] >> k % 8 & 1) for k in range(len(flags))] == flags


def test_a_page_has_the_failures_but_not_what_the_campaign_remembers(page):
    assert sorted(failure["now"]["name"] for failure in data_of(page)["failures"]) == sorted(
        [LOOP, STALLED, TUNNEL]
    )


def test_a_file_in_the_page_is_the_file_byte_for_byte(page):
    embedded = {
        failure["now"]["name"]: failure["now"]["file"] for failure in data_of(page)["failures"]
    }
    for name in (LOOP, TUNNEL, STALLED):
        assert base64.b64decode(embedded[name]) == (page.parent / "failures" / name).read_bytes()


def test_the_failure_as_found_stands_beside_the_shrunk_one(page):
    loop = next(failure for failure in data_of(page)["failures"] if failure["verdict"] == "loop")
    assert loop["before"]["world"]["width"] == 9
    assert all(
        failure["before"] is None
        for failure in data_of(page)["failures"]
        if failure["verdict"] != "loop"
    )


def test_the_page_sorts_by_the_place_in_the_order_of_failures(page):
    told = sorted(data_of(page)["failures"], key=lambda failure: failure["place"])
    folder = page.parent / "failures"
    ordered = sorted(folder.glob("*.grid"), key=lambda path: Failure.read(path).order)
    assert [failure["now"]["name"] for failure in told] == [path.name for path in ordered]


def test_every_failure_says_whether_it_replays(page):
    assert [failure["confirmed"] for failure in data_of(page)["failures"]] == [True, True, True]


def test_numbers_say_strategy_chance_and_how_often_the_cause_was_met(page):
    loop = next(failure for failure in data_of(page)["failures"] if failure["verdict"] == "loop")
    groups = {title: dict(rows) for title, rows, _ in loop["groups"]}
    raw = [title for title, _, is_raw in loop["groups"] if is_raw]
    assert raw == ["Options", "Evidence"]
    assert groups["Search"]["found by strategy"] == "native"
    assert groups["Search"]["cause met"] == "17 times"
    assert groups["Failure"]["chance"].startswith("39 of 40 seeds fail")
    assert groups["Run"]["period"] == "104 steps (1.56 s)"
    driven, witness = (
        float(text.split()[0])
        for text in (groups["Run"]["path length"], groups["World"]["witness"])
    )
    assert float(groups["Run"]["path / witness"]) == pytest.approx(driven / witness, rel=0.01)


def test_an_exact_answer_is_among_the_numbers(tmp_path):
    trap = read_world(CORPUS / "thesis-1-drifting.grid")
    trap = with_details(trap, chance="trap", states=512, newly_noted=[1, 2])
    write_world(trap, tmp_path / "a.grid")
    write_report([tmp_path], tmp_path / "r.html")
    groups = {
        title: dict(rows)
        for title, rows, _ in data_of(tmp_path / "r.html")["failures"][0]["groups"]
    }
    assert groups["Failure"]["exact answer"] == "trap, over 512 states"
    assert groups["Search"]["newly noted"] == "1, 2"


def test_equal_input_gives_equal_bytes(page):
    again = page.parent / "again.html"
    write_report([page.parent / "failures"], again)
    assert again.read_bytes() == page.read_bytes()


def test_a_page_names_no_address_and_lets_nothing_load(page):
    text = page.read_text()
    assert not re.search("https?:", text)
    assert "default-src 'none'" in text
    # The cores in the page may be compiled, which makes no text run as a script.
    assert "unsafe" not in text.replace("'wasm-unsafe-eval'; worker-src blob:", "")


def test_a_title_is_text_whatever_it_holds(page, tmp_path):
    out = tmp_path / "r.html"
    write_report([page.parent / "failures"], out, title="</title><script>alert(1)</script>")
    assert "<script>alert(1)" not in out.read_text()


def test_a_hostile_name_stays_inside_the_data(tmp_path):
    name = "</script><script>alert(1)</script>\u2028"
    write_world(
        with_details(read_world(CORPUS / LOOP), **{"class": name}, cause="unknown"),
        tmp_path / "a.grid",
    )
    write_report([tmp_path / "a.grid"], tmp_path / "r.html")
    assert data_of(tmp_path / "r.html")["failures"][0]["group"] == name


def test_failures_are_named_by_their_cause_and_their_signature_is_only_in_their_files(page):
    data = data_of(page)
    assert {failure["verdict"]: failure["group"] for failure in data["failures"]} == {
        "loop": "returns-to-a-wall",
        "tunnel": "goes-through-a-wall",
        "stalled": "wanders",
    }
    for failure in data["failures"]:
        del failure["test"]
    assert "loop-a" not in json.dumps(data)


def test_an_error_is_named_by_its_reason_and_a_file_without_a_cause_by_its_signature(tmp_path):
    crash = with_details(read_world(CORPUS / LOOP), **{"class": "crash-KeyError"}, cause="crashes")
    write_world(crash, tmp_path / "a.grid")
    Failure.read(CORPUS / STALLED).without("cause").write(tmp_path / "b.grid")
    write_report([tmp_path], tmp_path / "r.html")
    data = data_of(tmp_path / "r.html")
    names = {failure["group"]: failure["cause"] for failure in data["failures"]}
    assert names == {"crash-KeyError": "crashes", "stalled-confined-end-near": "returns-to-a-wall"}
    (answer,) = data["answers"]
    assert {cause["cause"]: cause["groups"] for cause in answer["causes"]} == {
        cause: [group] for group, cause in names.items()
    }


def test_a_failure_whose_controller_is_not_here_is_shown_without_its_way(tmp_path):
    loop = read_world(CORPUS / LOOP)
    write_world(
        replace(loop, failure=replace(loop.failure, controller="./gone.py:Robot")),
        tmp_path / "a.grid",
    )
    write_report([tmp_path], tmp_path / "r.html")
    (failure,) = data_of(tmp_path / "r.html")["failures"]
    assert failure["now"]["run"] is None
    assert not failure["confirmed"]
    assert "gone.py" in failure["reason"]


def test_a_single_file_is_shown_with_its_campaign(page):
    out = page.parent / "one.html"
    assert write_report([page.parent / "failures" / LOOP], out) == 1
    (failure,) = data_of(out)["failures"]
    assert failure["met"] == 17
    assert failure["before"]["name"].endswith(".grid")


def test_a_failure_belongs_to_the_innermost_campaign_around_it(tmp_path):
    campaign_folder(campaign_folder(tmp_path / "outer") / "inner", met={"returns-to-a-wall": 3})
    write_report([tmp_path], tmp_path / "r.html")
    loop = next(
        failure
        for failure in data_of(tmp_path / "r.html")["failures"]
        if failure["group"] == "returns-to-a-wall"
    )
    assert (loop["path"], loop["met"]) == (str(tmp_path / "outer" / "inner" / LOOP), 3)


def test_of_a_failure_that_does_not_replay_nothing_is_said_but_why(tmp_path):
    loop = read_world(CORPUS / LOOP)
    write_world(
        replace(loop, failure=replace(loop.failure, trace_digest="0" * 16)), tmp_path / "a.grid"
    )
    write_report([tmp_path], tmp_path / "r.html")
    (failure,) = data_of(tmp_path / "r.html")["failures"]
    assert (failure["words"], failure["confirmed"]) == ("loop", False)
    assert "digest" in failure["reason"]


@pytest.mark.parametrize(("controller", "motion"), [("bug1", "swept"), ("turn-right", "stepped")])
@pytest.mark.parametrize("signal", ["open", "blocked"])
def test_the_floor_is_tinted_by_a_signal_that_walls_do_not_stop(
    tmp_path, controller, motion, signal
):
    steps = {"steps": 10, "time_step": 0.015, "signal": signal}
    record = FailureRecord(controller, motion, 0, "timeout", "0" * 16, steps)
    write_world(replace(read_world(CORPUS / LOOP), failure=record), tmp_path / "a.grid")
    write_report([tmp_path], tmp_path / "r.html")
    assert data_of(tmp_path / "r.html")["failures"][0]["now"]["sensors"]["signal"] == (
        signal == "open"
    )


def test_an_archive_is_read_like_a_folder(tmp_path):
    archive = tmp_path / "corpus.zip"
    assert worldgen("corpus", "export", CORPUS / LOOP, CORPUS / TUNNEL, "--out", archive).code == 0
    assert write_report([archive], tmp_path / "r.html") == 2
    answers = data_of(tmp_path / "r.html")["answers"]
    assert [len(answer["causes"]) for answer in answers] == [1] * len(answers)


def test_equal_failures_are_shown_once(tmp_path):
    for name in ("a.grid", "b.grid"):
        shutil.copy(CORPUS / LOOP, tmp_path / name)
    assert write_report([tmp_path], tmp_path / "r.html") == 1


def long_loop(steps, entry, period):
    """A run of many steps on a line, with the evidence of a loop."""
    line, none = np.arange(steps + 1) / 1000.0, np.zeros(0)
    words = np.zeros(0, np.uint64)
    trace = Trace(
        0.015,
        line,
        line,
        line,
        line > 1.0,
        none,
        none,
        none.astype(np.int64),
        none,
        words,
        words,
        True,
    )
    loop = LoopEvidence(entry=entry, period=period, state_digest="0" * 16)
    return Episode("loop", steps, steps * 0.015, 1.0, 0, "0" * 16, loop, trace)


def test_a_long_run_is_thinned_but_for_the_period_of_its_loop():
    run = drawn_run(long_loop(40_000, 20_000, 104), 0.1)
    kept = {at // SHARE for at in decoded(run["at"])}
    assert set(range(20_000, 20_105)) <= kept
    assert {0, 40_000} <= kept
    assert len(kept) <= MOST_STEPS + 4
    assert run["thinned"] > 1


def test_a_long_run_is_thinned_but_for_what_leads_to_a_breach_and_follows():
    breach = replace(
        long_loop(40_000, 0, 1), verdict="tunnel", evidence=WallEvidence(step=20_000, cell=(1, 2))
    )
    kept = {at // SHARE for at in decoded(drawn_run(breach, 0.1)["at"])}
    assert set(range(19_800, 20_200)) <= kept
    assert len(kept) <= MOST_STEPS + 4


def test_a_world_that_is_too_large_is_not_drawn(monkeypatch):
    world = read_world(CORPUS / LOOP)
    assert drawn_world(world)["width"] == world.width
    monkeypatch.setattr("fuzz.player.worlds.MOST_CELLS", world.width * world.height - 1)
    assert drawn_world(world) is None


def test_no_step_of_a_short_run_is_left_out():
    run = drawn_run(long_loop(500, 396, 104), 0.1)
    assert [at // SHARE for at in decoded(run["at"])] == list(range(501))
    assert run["thinned"] == 1


def test_a_breach_is_marked_on_the_whole_way_to_the_target(tmp_path):
    write_report([CORPUS / "thesis-2-breach.grid"], tmp_path / "r.html")
    run = data_of(tmp_path / "r.html")["failures"][0]["now"]["run"]
    steps = {mark["name"]: mark["step"] for mark in run["marks"]}
    assert steps["Cause"] < steps["Breach"] < steps["Arrives"] == run["steps"]


def test_a_stall_is_marked_where_the_last_new_cell_is_entered(page):
    stall = next(
        failure for failure in data_of(page)["failures"] if failure["verdict"] == "stalled"
    )
    last = read_world(CORPUS / STALLED).failure.evidence["last_new_cell"]
    assert [(mark["name"], mark["step"]) for mark in stall["now"]["run"]["marks"]] == [
        ("First bump", first_bump(STALLED)),
        ("Nothing new after", last),
    ]


def first_bump(name):
    """Return the step of a failure's first bump, found in its recording."""
    (first, *_) = np.flatnonzero(Failure.read(CORPUS / name).run().trace.bump)
    return int(first)


def test_the_step_of_the_first_bump_is_kept_in_a_thinned_run():
    failure = Failure.read(CORPUS / STALLED)
    run = drawn_run(failure.run(), failure.world.cell_size, most=20)
    assert run["thinned"] > 1
    assert first_bump(STALLED) * SHARE in decoded(run["at"])


def test_only_the_example_of_a_cause_names_cells_and_only_those_in_its_world(tmp_path):
    folder = campaign_folder(tmp_path / "c", controller="thesis-1")
    changes = [
        {"what": "cell", "value": [2, 1]},
        {"what": "event", "value": [3, 2], "was": 1.0},
        {"what": "cell", "value": [10_000, 1]},
        {"what": "cell", "value": "gone"},
        {"what": "radius", "value": 0.05, "was": 0.1},
    ]
    explain_the_loop(folder, changes)
    write_report([folder], tmp_path / "r.html")
    named = {
        Path(one["path"]).name: one["now"]["named"]
        for one in data_of(tmp_path / "r.html")["failures"]
    }
    assert named[LOOP] == [[2, 1], [3, 2]]
    assert named[STALLED] == []


def test_corners_inside_steps_are_kept():
    world = read_world(CORPUS / LOOP)
    episode = simulate(world, "turn-right", motion="swept", time_step=0.1, steps=40, record=True)
    run = drawn_run(episode, world.cell_size)
    inside = np.count_nonzero(episode.trace.path_share < 1.0)
    assert inside > 0
    assert len(decoded(run["at"])) > episode.steps + 1


def test_a_campaign_without_failures_has_a_page(tmp_path):
    folder = campaign_folder(tmp_path / "c", met={}, found=[], archive=None)
    for name in (LOOP, TUNNEL, STALLED):
        (folder / name).unlink()
    write_report([folder], tmp_path / "r.html")
    assert data_of(tmp_path / "r.html")["campaigns"][0]["worlds"] == 900


def test_a_campaign_whose_natural_worlds_do_not_count_has_a_page(tmp_path):
    folder = campaign_folder(tmp_path / "c")
    write_overview(CampaignResult(causes=[], natural=natural_worlds(unsensed=3)), folder)
    write_report([folder], tmp_path / "r.html")
    answers = data_of(tmp_path / "r.html")["answers"]
    (answer,) = (one for one in answers if one["campaign"] == 0)
    assert (answer["natural"]["worlds"], answer["natural"]["percent"]) == (0, 0)
    assert answer["headline"]["words"] == "no answer yet"


def test_nothing_to_report_on_is_refused(tmp_path):
    with raises(InvalidParameter, "no-failure"):
        write_report([tmp_path], tmp_path / "r.html")


def test_a_page_that_is_there_is_not_overwritten(page):
    result = worldgen("report", page.parent / "failures", "--out", page)
    assert (result.code, result.error_code) == (2, "file-exists")


def test_the_command_says_what_it_wrote(tmp_path):
    result = worldgen("report", CORPUS / LOOP, "--out", tmp_path / "r.html")
    assert (result.code, result.out) == (0, "")
    assert result.err.endswith("r.html: 1 failure\n")


@pytest.mark.gate
def test_a_campaign_writes_its_own_page(tmp_path):
    run = (
        "--controller",
        "turn-right",
        "--motion",
        "stepped",
        "--units",
        1,
        "--examples",
        60,
        "--seed",
        1,
    )
    page = tmp_path / "r.html"
    assert (
        worldgen("fuzz", *run, "--workers", 1, "--out", tmp_path / "f", "--report", page).code == 1
    )
    data = data_of(page)
    assert data["campaigns"][0]["units"] == 1
    assert len(data["failures"]) == len(list((tmp_path / "f").glob("*.grid")))
    assert all(failure["strategy"] for failure in data["failures"])
    # The clearest failure of a cause may be one that was not shrunk.
    assert all(failure["before"] or failure["example"] for failure in data["failures"])
    # The example of a cause that only natural worlds show is shrunk too.
    natural = [failure for failure in data["failures"] if failure["strategy"] == "natural"]
    assert natural and all(failure["shrinking"] == "done" for failure in natural)
    assert {failure["cause"] for failure in natural} <= {
        cause["cause"] for cause in data["answers"][0]["causes"] if cause["natural"]
    }


ARCHIVE = SUMMARY["archive"]


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"version": 1}, "its version is 1, but this program reads version 3"),
        ({"version": 2}, "its version is 2, but this program reads version 3"),
        ({"version": "3"}, "$.version"),
        ({"worlds": -1}, "$.worlds"),
        ({"worlds": True}, "$.worlds"),
        ({"seed": 2**64}, "the seed is not below 2**64"),
        ({"status": "gone"}, "$.status"),
        ({"seconds": "fast"}, "$.seconds"),
        ({"seconds": 10**400}, "$.seconds"),
        ({"seconds": float("nan")}, "malformed"),
        ({"controller": None}, "$.controller"),
        ({"archive": {**ARCHIVE, "cells": [[0, 0, 1.0, ""]]}}, "$.archive.cells[0][3]"),
        ({"met": {"loop": 1.5}}, "$.met[...]"),
        ({"strategies": {}}, "$.strategies"),
        ({"found": [3]}, "$.found[0]"),
        ({"archive": {"axes": []}}, "$.archive.axes"),
        ({"archive": {**ARCHIVE, "cells": [[3, 0, 1.0, "loop"]]}}, "cell [3, 0] is outside"),
        ({"archive": {**ARCHIVE, "cells": [[0]]}}, "$.archive.cells[0]"),
    ],
)
def test_a_summary_of_another_form_is_refused_in_one_sentence(tmp_path, change, place):
    folder = campaign_folder(tmp_path / "c", **change)
    with raises(FormatError, "invalid-summary") as caught:
        read_summary(folder)
    sentence = str(caught.value)
    assert place in caught.value.facts["reason"] and "\n" not in sentence
    assert sentence.endswith("; resume the campaign to write it again, or delete it")


WHOLE = json.dumps(SUMMARY)


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("", id="empty"),
        pytest.param("[]", id="list"),
        pytest.param("nonsense", id="nonsense"),
        pytest.param("[" * 100_000, id="nested"),
        pytest.param(WHOLE[:-1] + ', "new": ' + "[" * 100_000, id="nested-below"),
        pytest.param(WHOLE[: len(WHOLE) // 2], id="truncated"),
        pytest.param(WHOLE + "}", id="more"),
        pytest.param(WHOLE.replace("turn-right", "\\ud800"), id="half-a-character"),
    ],
)
def test_a_file_that_is_no_summary_is_refused(tmp_path, text):
    (tmp_path / ".campaign").mkdir()
    (tmp_path / ".campaign" / "summary.json").write_text(text)
    with raises(FormatError, "invalid-summary"):
        read_summary(tmp_path)


@pytest.mark.parametrize(
    ("data", "code"),
    [
        pytest.param(b'{"version": 2, "controller": "\xff"}', "not-utf8", id="not-utf8"),
        pytest.param(b" " * (64 << 20) + b"{}", "too-large", id="too-large"),
    ],
)
@pytest.mark.parametrize(
    ("name", "read"), [("summary.json", read_summary), ("overview.json", read_overview)]
)
def test_a_file_that_no_campaign_writes_is_refused_before_it_is_parsed(
    tmp_path, name, read, data, code
):
    (tmp_path / ".campaign").mkdir()
    (tmp_path / ".campaign" / name).write_bytes(data)
    with raises(FormatError, code):
        read(tmp_path)


def test_a_summary_of_a_later_version_of_the_same_form_is_read(tmp_path):
    folder = campaign_folder(tmp_path / "c", weather="rain")
    assert read_summary(folder).seed == 2**64 - 1


@pytest.mark.parametrize(
    ("package", "part"), [("fuzz.report", "body.html"), ("fuzz.player", "player.css")]
)
def test_the_page_s_parts_are_shipped(package, part):
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    patterns = project["tool"]["setuptools"]["package-data"][package]
    folder = Path(str(files(package)))
    parts = {file for file in (folder / "page").rglob("*") if file.is_file()}
    assert folder / "page" / part in parts
    assert parts <= {found for pattern in patterns for found in folder.glob(pattern)}


def test_controllers_without_a_campaign_share_the_work_of_explaining_causes(monkeypatch, tmp_path):
    record = read_world(CORPUS / LOOP)
    for number in range(6):
        names = ("turn-left", "turn-right", "turn-random", "bug1", "bug2", "wall-left")
        failure = replace(record.failure, controller=names[number], parameters={})
        write_world(replace(record, failure=failure), tmp_path / f"{number}.grid")
    explained = []
    monkeypatch.setattr(
        "fuzz.overview.building.explained",
        lambda failure, is_over, most_steps: explained.append(most_steps),
    )
    entries = read_corpus([tmp_path]).entries
    answers_for(entries, [])
    assert len(explained) == 6 and sum(explained) <= 2_000_001
    explained.clear()
    answers_for(entries[:1], [])
    assert explained == [float("inf")]


def test_a_run_that_the_replay_confirmed_is_not_run_again_for_the_picture(monkeypatch):
    monkeypatch.setattr(Failure, "run", lambda self, **how: pytest.fail("run again"))
    seen = look_at(CORPUS / LOOP, [])
    assert seen.replay.confirmed and seen.shown.trace.steps == seen.shown.steps
