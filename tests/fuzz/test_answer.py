"""What a campaign answers: failures, clean, or none, in every output and in the exit code."""

import json
from pathlib import Path

import pytest

from fuzz.campaign.state import CampaignState
from fuzz.campaign.store import read_summary
from fuzz.ci import Report
from fuzz.ci.junit import junit
from fuzz.ci.markdown import markdown
from fuzz.ci.sarif import sarif
from fuzz.overview import CampaignResult, Cause, CauseResult
from fuzz.overview.building import answer_numbers
from fuzz.triage.triage import Triage
from fuzz.unit.answer import FEWEST, AnswerNumbers, answer_of
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import UnitResult
from sim.scenario import Scenario
from tests.helpers.campaign_results import natural_worlds
from tests.helpers.ci_reports import read_junit, read_markdown, read_sarif
from tests.helpers.command_line import worldgen
from worldgen import generate

CAMPAIGN = ("--units", "1", "--examples", "10", "--seed", "1", "--workers", "1")
FLAKY = """\
import sys

from sim import Command

# Out of reach of anything that renews the controller between two runs.
sys.runs_of_flaky = getattr(sys, "runs_of_flaky", 0)


class Flaky:
    def reset(self):
        sys.runs_of_flaky += 1
        return (8.0 + sys.runs_of_flaky % 5,)

    def act(self, observation, memory):
        if memory[0] == 0.0:
            raise KeyError("sometimes")
        return Command(observation.top_speed, 0.0), (memory[0] - 1.0,)
"""


@pytest.mark.parametrize(
    ("numbers", "answer"),
    [
        ({"natural": FEWEST}, "clean"),
        ({"natural": FEWEST - 1}, "none"),
        ({"natural": FEWEST - 1, "searched": 100_000}, "none"),
        ({"natural": 0, "failures": 1}, "failures"),
        ({"natural": 0, "known": 1}, "failures"),
        ({"natural": 100, "natural_unjudged": 5}, "clean"),
        ({"natural": 100, "natural_unjudged": 6}, "none"),
        ({"natural": 100, "natural_unjudged": 6, "failures": 1}, "failures"),
        ({"natural": 100, "searched": 26, "searched_unjudged": 23}, "none"),
        # A thousand small worlds of a search do not outweigh the natural ones.
        ({"natural": 9, "natural_unjudged": 4, "searched": 100_000}, "none"),
        ({"natural": None, "searched": FEWEST}, "clean"),
        ({"natural": None, "searched": FEWEST - 1}, "none"),
    ],
    ids=str,
)
def test_the_numbers_decide_the_answer(numbers, answer):
    found, reason = answer_of(AnswerNumbers(**numbers))
    assert found == answer
    assert reason and not reason.endswith(".")


@pytest.mark.parametrize(
    ("config", "natural"),
    [
        ({}, 0),
        ({"families": ("maze",)}, 0),
        ({"families": ("native", "maze")}, 0),
        ({"families": ("native",)}, None),
        ({"robots": 2}, None),
        ({"fixed_map": generate("trap", 1)}, None),
    ],
    ids=["usual", "family", "both", "strategy", "fleet", "map"],
)
def test_the_search_counts_where_natural_worlds_are_not_defined(config, natural):
    numbers = answer_numbers(
        CampaignConfig(Scenario("bug2"), **config),
        CampaignState(worlds=7),
        CampaignResult(causes=[]),
        (),
    )
    assert (numbers.natural, numbers.searched) == (natural, 7)


def test_hazards_that_a_robot_cannot_sense_are_neither_failures_nor_unjudged():
    hazard = CauseResult.of(Cause.HARMED_UNSENSED, ("a",), {"burned": 4}, natural=3)
    unproved = CauseResult.of(Cause.CRASHES, natural=2)
    result = CampaignResult(causes=[hazard, unproved], natural=natural_worlds(9, 7))
    numbers = answer_numbers(CampaignConfig(Scenario("bug2")), CampaignState(), result, ())
    assert (numbers.failures, numbers.known, numbers.natural_unjudged) == (0, 0, 2)


def test_an_all_clear_says_how_many_worlds_a_hazard_ended():
    result = CampaignResult(causes=[], natural=natural_worlds(1, 1, unsensed=8))
    numbers = answer_numbers(CampaignConfig(Scenario("bug2")), CampaignState(), result, ())
    answer, reason = answer_of(numbers)
    assert answer == "clean" and reason.endswith("cannot sense ended 8 of them")


def test_a_few_examined_runs_stand_for_all_of_their_kind():
    triage = Triage(CampaignConfig(Scenario("bug2")), UnitResult("trap"))
    world = generate("trap", 1)
    # Screening gave up too early: the robot arrives.
    for _ in range(40):
        triage.enter(world, Scenario("bug2"), "undecided")
    assert triage.result.judged == 40 and not triage.result.failures
    # Nothing is known about a kind of which no run was examined.
    triage.count_alike("loop", "key 7", 10)
    assert triage.result.judged == 40


def test_a_correct_controller_in_a_short_campaign_is_clean(tmp_path):
    ran = worldgen("fuzz", "--controller", "bug2", *CAMPAIGN, "--out", tmp_path / "out", "--json")
    table = json.loads(ran.out)
    assert (ran.code, table["answer"]) == (0, "clean")
    assert table["answer_numbers"]["natural"] >= FEWEST and table["answer_reason"]
    assert read_summary(tmp_path / "out").answer == "clean"


@pytest.fixture(scope="module")
def flaky(tmp_path_factory):
    """A campaign whose controller crashes in a way that no second run shows."""
    folder = tmp_path_factory.mktemp("flaky")
    (folder / "flaky.py").write_text(FLAKY)
    words = ("--controller", f"{folder / 'flaky.py'}:Flaky", *CAMPAIGN, "--json")
    reports = (
        "--junit",
        folder / "x.xml",
        "--sarif",
        folder / "x.sarif",
        "--summary",
        folder / "x.md",
    )
    return folder, words, worldgen("fuzz", *words, "--out", folder / "out", *reports)


def test_failures_that_no_second_run_shows_leave_no_answer(flaky):
    folder, _, ran = flaky
    table = json.loads(ran.out)
    assert (ran.code, table["answer"], table["failures"]) == (4, "none", [])
    assert read_summary(folder / "out").answer_reason == table["answer_reason"]


def test_every_report_says_that_there_is_no_answer_and_what_to_type(flaky):
    folder, _, _ = flaky
    more = f"worldgen fuzz --resume {folder / 'out'} --units 4"
    suite = read_junit((folder / "x.xml").read_bytes())
    (case,) = suite.findall("testcase")
    assert case.find("failure") is None and more in case.find("error").text
    assert suite.attrib["errors"] == "1" and suite.attrib["failures"] == "0"
    (run,) = json.loads((folder / "x.sarif").read_text())["runs"]
    (note,) = run["invocations"][0]["toolExecutionNotifications"]
    assert run["results"] == [] and note["level"] == "error" and more in note["message"]["text"]
    text = (folder / "x.md").read_text()
    assert "✅" not in text and "no answer" in text and more in text


def test_no_answer_can_be_accepted(flaky):
    folder, words, _ = flaky
    ran = worldgen(
        "fuzz",
        *words,
        "--out",
        folder / "accepted",
        "--accept-no-answer",
        "--junit",
        folder / "y.xml",
    )
    assert (ran.code, json.loads(ran.out)["answer"]) == (0, "none")
    (case,) = read_junit((folder / "y.xml").read_bytes()).findall("testcase")
    assert case.find("skipped") is not None and case.find("error") is None


def test_reports_without_an_answer_are_valid():
    report = Report("fuzz", (), {"seed": "1"}, no_answer="because", remedy="worldgen fuzz <&>")
    read_junit(junit(report))
    read_markdown(markdown(report))
    read_sarif(sarif(report, Path.cwd()))


@pytest.mark.gate
def test_a_campaign_too_slow_for_one_world_has_no_answer(tmp_path):
    (tmp_path / "slow.py").write_text(
        "import time\n\nfrom sim import Command\n\n\nclass Slow:\n    def reset(self):\n"
        "        return (0.0,)\n\n    def act(self, observation, memory):\n"
        "        time.sleep(0.2)\n        return Command(1.0, 1.0), memory\n"
    )
    words = ("--controller", f"{tmp_path / 'slow.py'}:Slow", "--budget", "2s", "--workers", "1")
    ran = worldgen("fuzz", *words, "--seed", "1", "--out", tmp_path / "out", "--json")
    table = json.loads(ran.out)
    assert (ran.code, table["answer"]) == (4, "none")
    assert table["answer_numbers"]["natural"] == 0


def test_a_reason_says_what_is_pending_and_how_long_it_takes():
    waiting = {"searched": 26, "searched_unjudged": 6, "proof_seconds": 7.0}
    _, few = answer_of(AnswerNumbers(natural=0, **waiting))
    assert few.endswith("; 6 runs did not arrive, and proving them needs about 42 s")
    _, many = answer_of(AnswerNumbers(natural=FEWEST, **waiting))
    assert many.endswith("failure, and proving them needs about 42 s")
    # Milliseconds of proofs are not what kept them from being done.
    _, quick = answer_of(AnswerNumbers(natural=FEWEST, **(waiting | {"proof_seconds": 0.01})))
    assert "needs" not in quick
