"""The command ``explain``, and what commands show of a user's code."""

import json

import pytest

from fuzz.ci import CiFinding, FindingState
from fuzz.commands.explain import _counted_in
from fuzz.failure import Failure
from fuzz.overview.describe import describe
from fuzz.overview.explanation import explain_failure
from fuzz.triage.judging import failure_of
from sim.scenario import Scenario
from tests.fuzz.test_counterfactual import CHANCE, FIRE, WALL
from tests.fuzz.test_report import data_of
from tests.helpers.command_line import worldgen
from worldgen import generate
from worldgen.files.grid import write_world
from worldgen.support.progress import Work

BREACH = WALL.parents[3] / "thesis-faults" / "thesis-1-breach.grid"

BREAKS = """
from sim import Command
class Breaks:
    def reset(self):
        return (0.0,)
    def act(self, observation, memory):
        (count,) = memory
        if count > 3:
            raise ValueError("too far")
        return Command(observation.top_speed, 0.0), (count + 1.0,)
"""


@pytest.fixture
def breaks(tmp_path):
    """The name of a controller that raises an error."""
    file = tmp_path / "breaks.py"
    file.write_text(BREAKS)
    return f"{file}:Breaks"


@pytest.fixture
def crashed(breaks, tmp_path):
    """A file with a failure of that controller."""
    failure = failure_of(generate("corridor", 1), Scenario(breaks))
    write_world(failure.stored, tmp_path / "crash.grid")
    return tmp_path / "crash.grid"


def campaign(breaks, out, *more):
    options = ("--units", 1, "--examples", 2, "--family", "corridor", "--seed", 1, "--workers", 1)
    return worldgen("fuzz", "--controller", breaks, *options, "--out", out, *more)


@pytest.mark.parametrize("path", [WALL, CHANCE])
def test_every_key_in_json_is_documented(path):
    text = (WALL.parents[4] / "docs/reference/verdicts.md").read_text(encoding="utf-8")
    documented = text.partition("`explain --json` has")[2].partition("JUnit and SARIF")[0]
    found = json.loads(worldgen("explain", path, "--json").out)
    assert all(f"`{key}`" in documented for key in [*found, *found["failures"][0]])


def test_a_failure_that_no_change_can_explain_still_has_its_facts_in_json():
    result = worldgen("explain", CHANCE, "--json")
    found = json.loads(result.out)
    assert result.code == 2 and found["explained"] == 0
    (row,) = found["failures"]
    assert row["cause"] == "wanders" and row["goes_wrong"].startswith("It still reaches new")
    assert row["changes"] == [] and "may fail by chance" in row["problem"]
    assert row["reactions"]


def test_progress_never_names_a_time_that_is_over(monkeypatch):
    clock = iter([0.0, 2.0, 55.0, 70.0])
    monkeypatch.setattr("time.monotonic", lambda: next(clock))
    work = Work("explaining", clock=lambda: 0.0)
    count = _counted_in(work, 60.0)
    said = []
    for done, of in ((2, 50), (55, 55), (56, 56)):
        count(done, of)
        said.append(work.message)
    assert said == [
        "explaining: 2 of about 50 runs, which take about 50 s",
        "explaining: 55 runs, for at most 60 s",
        "explaining: 56 runs, for at most 60 s",
    ]


def test_the_cause_comes_before_the_changes():
    lines = worldgen("explain", WALL).out.splitlines()
    assert lines[1].startswith("  returns-to-a-wall: It drives from wall to wall")
    assert lines[2].startswith("  It arrives if cell (")


@pytest.mark.gate
def test_a_crash_is_explained_by_its_error(crashed):
    lines = worldgen("explain", "--trust", crashed).out.splitlines()
    assert "crash (ValueError: too far, breaks.py:9)" in lines[0]
    assert lines[1] == "  crashes: Its code raises an error."


def test_the_headline_of_a_crash_is_its_error(crashed, tmp_path):
    failure = Failure.read(crashed)
    found = CiFinding.of(failure, crashed, FindingState.NEW)
    error = "crash (ValueError: too far, breaks.py:9)"
    assert found.headline.endswith(f"breaks.py:Breaks under swept: {error}")
    assert found.text.count(error) == 1 and not found.explanation
    assert describe(failure, crashed).splitlines()[0] == found.headline
    page = tmp_path / "page.html"
    assert worldgen("report", "--trust", crashed, "--out", page).code == 0
    (shown,) = data_of(page)["failures"]
    assert shown["words"] == error and not shown["sentence"]


def test_the_headline_of_an_unknown_cause_is_what_happened():
    found = CiFinding.of(Failure.read(WALL).noting(cause="unknown"), WALL, FindingState.NEW)
    assert ": loop " in found.headline and not found.explanation


def test_a_picture_of_several_failures_is_refused_before_any_is_explained(tmp_path):
    result = worldgen("explain", WALL, FIRE, "--picture", tmp_path / "two.png")
    assert result.code == 2 and result.out == ""
    assert "--picture" in result.err and "pass a single file" in result.err


def test_another_controller_is_explained_by_its_own_run(crashed):
    arrived = worldgen("explain", crashed, "--controller", "bug2")
    assert arrived.code == 2 and arrived.out == ""
    assert arrived.err.endswith("crash.grid: the robot arrives now\n")
    turned = worldgen("explain", WALL, "--controller", "potential-field")
    assert "potential-field under swept" in turned.out
    assert turned.out.splitlines()[1].startswith("  goes-back-and-forth: ")


def test_a_controller_that_cannot_be_run_has_neither_verdict_nor_cause():
    result = worldgen("explain", WALL, "--controller", "nosuch", "--json")
    (row,) = json.loads(result.out)["failures"]
    assert result.code == 2 and "nosuch" in row["problem"]
    assert (row["verdict"], row["cause"], row["goes_wrong"]) == ("", "", "")


def test_another_controller_has_not_the_recorded_cause_of_a_breach():
    failure = Failure.read(BREACH).noting(cause="crashes")
    assert explain_failure(failure).diagnosis.cause == "crashes"
    assert explain_failure(failure, "turn-left").diagnosis.cause != "crashes"


@pytest.mark.gate
def test_a_controller_that_was_edited_since_its_campaign_is_mentioned(breaks, tmp_path):
    out = tmp_path / "found"
    assert campaign(breaks, out).code == 1
    file = next(out.glob("*.grid"))
    before = worldgen("explain", file, "--json")
    assert "has changed" not in before.err
    assert "changed" not in json.loads(before.out)["failures"][0]
    (tmp_path / "breaks.py").write_text(BREAKS.replace("count > 3", "count > 2"))
    after = worldgen("explain", file, "--json")
    sentence = "breaks.py:Breaks has changed since the campaign"
    assert sentence in json.loads(after.out)["failures"][0]["changed"]
    assert sentence in after.err
    page = tmp_path / "page.html"
    assert worldgen("report", out, "--out", page).code == 0
    data = data_of(page)
    assert sentence in data["campaigns"][0]["changed"]
    assert all(sentence in failure["changed"] for failure in data["failures"])
    # Of another controller, the campaign knows nothing.
    # Of other controllers, the campaign knows nothing.
    write_world(Failure.read(file).driven_by("turn-left").stored, out / "other.grid")
    assert "has changed" not in worldgen("explain", out / "other.grid").err
    assert worldgen("report", out, "--out", page, "--force").code == 0
    notes = {one["controller"]: one["changed"] for one in data_of(page)["failures"]}
    assert notes["turn-left"] == "" and len(notes) == 2
    assert "has changed" not in worldgen("explain", file, "--controller", "vfh").err


@pytest.mark.gate
def test_a_campaign_and_its_report_can_leave_out_the_code(breaks, tmp_path):
    out = tmp_path / "found"
    page = tmp_path / "page.html"
    assert campaign(breaks, out, "--no-code", "--report", page).code == 1
    overview = json.loads((out / ".campaign/overview.json").read_text())
    assert overview["causes"] and all(one["inside"] is None for one in overview["causes"])
    assert "(count,) = memory" not in page.read_text()
    (file,) = out.glob("*.grid")
    assert "(count,) = memory" in worldgen("explain", file).out
    assert "(count,) = memory" not in worldgen("explain", file, "--no-code").out
