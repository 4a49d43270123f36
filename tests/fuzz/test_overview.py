"""The overview of a campaign groups, sorts and compares causes."""

import json
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import click
import pytest
from msgspec import structs

from fuzz.campaign.configure import configure
from fuzz.campaign.executors import InlineExecutor, ProcessExecutor
from fuzz.campaign.run import Campaign
from fuzz.campaign.state import CampaignState
from fuzz.campaign.store import Find, resume
from fuzz.cause import Severity
from fuzz.corpus import Baseline, read_corpus
from fuzz.corpus.baseline import _key
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.overview import Cause, CauseResult, building, causes_of, read_overview
from fuzz.overview.building import Conclusion, build_overview, files_of, with_worlds
from fuzz.overview.causes import in_order, with_natural
from fuzz.overview.clearest import clearest
from fuzz.overview.comparison import compare, with_states
from fuzz.overview.counterfactual import Change
from fuzz.overview.natural import describe_fall, natural_families, natural_runs
from fuzz.overview.result import CampaignResult, NaturalTally, write_overview
from fuzz.simplicity import Case
from fuzz.triage.diagnosis import cause_of
from fuzz.unit.answer import AnswerNumbers
from fuzz.unit.constraint import Constraint
from fuzz.unit.options import CampaignOptions
from fuzz.unit.result import SearchState
from sim.clock.stopping import is_out_of_time, stopping_when
from sim.scenario import Scenario
from tests.helpers.campaign_results import natural_worlds, numbers, terminal
from tests.helpers.command_line import worldgen
from tests.helpers.faulty_robots import HERE, certified_hall, found_by, hall
from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.files.json_file import plain
from worldgen.support.plain_text import Styled

FAILING = AnswerNumbers(failures=1)


def test_causes_come_by_severity_and_frequency_in_natural_worlds():
    rare = CauseResult.of(Cause.CIRCLES_AN_OBSTACLE, ("a",), {"loop": 900})
    often = CauseResult.of(Cause.PUSHES_A_WALL, ("b",), {"loop": 1})
    worst = CauseResult.of(Cause.GOES_THROUGH_A_WALL, ("c",), {"tunnel": 1})
    assert in_order([often, rare, worst]) == [worst, rare, often]
    ordered = with_natural([often, rare, worst], {Cause.PUSHES_A_WALL: 5, Cause.WANDERS: 1})
    assert [one.cause for one in ordered] == [
        Cause.GOES_THROUGH_A_WALL,
        Cause.PUSHES_A_WALL,
        Cause.WANDERS,
        Cause.CIRCLES_AN_OBSTACLE,
    ]


def test_a_cause_that_no_natural_world_shows_comes_late():
    burned = CauseResult.of(Cause.DRIVES_INTO_A_HAZARD, ("a",), {"burned": 4})
    tunnel = CauseResult.of(Cause.GOES_THROUGH_A_WALL, ("b",), {"tunnel": 1})
    pushes = CauseResult.of(Cause.PUSHES_A_WALL, ("c",), {"loop": 145})
    assert in_order([pushes, burned, tunnel]) == [tunnel, burned, pushes]
    # An error that breaks the rules of the simulation is one wherever it happens.
    found = with_natural([pushes, burned, tunnel], {Cause.PUSHES_A_WALL: 45})
    assert [one.cause for one in found] == [tunnel.cause, pushes.cause, burned.cause]
    caught = with_natural([pushes, burned], dict.fromkeys((burned.cause, pushes.cause), 1))
    assert caught[0].cause == burned.cause


def test_failures_are_grouped_with_how_often_they_were_met():
    failures = [found_by("Pushes"), found_by("Pushes"), found_by("Still")]
    met = {("pushes-a-wall", "loop"): 7, ("stands-still", "loop"): 1, ("crash-a", "crash"): 3}
    causes = causes_of(failures, met)
    assert [(one.cause, one.groups, one.met) for one in causes] == [
        (Cause.PUSHES_A_WALL, ["pushes-a-wall"], 7),
        (Cause.STANDS_STILL, ["stands-still"], 1),
    ]


def test_natural_worlds_give_a_rate_that_depends_on_the_seed_alone():
    runs = [natural_runs(Scenario("bug2"), ["trap", "maze"], 6, seed=3) for _ in range(2)]
    (result, _), (again, _) = runs
    assert result == again and result.worlds == 6 and result.complete
    low, high = result.interval
    assert 0.0 <= low <= result.arrived / 6 <= high <= 1.0
    assert result.families.keys() == {"trap", "maze"}


def test_natural_worlds_end_with_the_time_and_say_so():
    runs, _ = natural_runs(Scenario("bug2"), ["trap"], 5, seed=3, is_over=lambda _: True)
    assert runs.worlds == 0 and not runs.complete


@pytest.mark.gate
def test_natural_worlds_are_the_same_whoever_runs_them():
    with ProcessExecutor(2) as executor:
        shared = natural_runs(Scenario("bug2"), ["trap", "maze"], 30, seed=3, executor=executor)
    assert shared == natural_runs(Scenario("bug2"), ["trap", "maze"], 30, seed=3)


@pytest.mark.gate
def test_a_campaign_concludes_the_same_with_workers():
    options = CampaignOptions(controller="turn-right", motion="endpoint", examples=8)
    config = configure(options, seed=1)
    campaign = Campaign(config, units=2)
    for _ in campaign.run():
        pass
    alone = build_overview(config, campaign.state, Conclusion())
    with ProcessExecutor(2) as executor:
        shared = build_overview(config, campaign.state, Conclusion(), executor=executor)
    assert plain(shared.result) == plain(alone.result)
    assert shared.result.causes and shared.files.keys() == alone.files.keys()


class LosesTheThird(InlineExecutor):
    """Returns the third world unfinished."""

    def submit(self, work, /, *args, **kwargs):
        future = super().submit(work, *args, **kwargs)
        future.result()[0].pop(2, None)
        return future


def test_worlds_after_one_that_was_not_finished_do_not_count():
    with LosesTheThird() as executor:
        runs, _ = natural_runs(Scenario("bug2"), ["trap"], 6, seed=3, executor=executor)
    assert runs.worlds == 2 and not runs.complete


def test_hazards_that_nobody_can_sense_are_left_out_of_the_rate():
    runs, examples = natural_runs(Scenario("bug2"), ["fire"], 4, seed=1)
    assert runs.unsensed + runs.worlds == 4 and runs.unsensed > 0
    assert Cause.HARMED_UNSENSED not in {*runs.causes, *examples}


def test_only_families_have_natural_worlds():
    assert natural_families(["native", "trap", "./mine.py:hall"]) == ["trap", "./mine.py:hall"]
    assert {"trap", "maze", "fire"} <= set(natural_families([]))


def test_a_robot_that_covers_its_target_is_not_the_clearest_picture():
    near = found_by("Still", hall(6, 5, start=(0.32, 0.25)))
    far = found_by("Still")
    assert near.size < far.size and clearest([near, far]) is far


def test_a_shrunk_world_is_clearer_than_one_as_found_even_if_it_is_narrow():
    narrow = found_by("Still", certified(hall(9, 3, start=(0.75, 0.15))))
    record = replace(narrow.record, details={**narrow.record.details, "shrinking": "done"})
    shrunk = replace(narrow, record=record)
    assert shrunk.shrinking == "done"
    found = found_by("Still")
    assert found.shrinking == "none" and clearest([found, shrunk]) is shrunk


def test_a_world_as_found_is_clearer_than_a_shrunk_one_whose_period_fills_the_picture(monkeypatch):
    found = found_by("Still")
    record = replace(found.record, details={**found.record.details, "shrinking": "done"})
    shrunk = replace(found, world=certified(hall(9, 5, start=(0.75, 0.25))), record=record)
    assert clearest([found, shrunk]) is shrunk

    def behaviour_of(world, episode):
        length = 31.0 * 9 if world.width == 9 else 1.0
        return SimpleNamespace(extent=1.0, length=length, nearest=9.0)

    monkeypatch.setattr("fuzz.overview.clearest.behaviour_of", behaviour_of)
    assert found.world.width != 9
    assert clearest([found, shrunk]) is found


@pytest.mark.parametrize(
    ("greedy", "seconds_of_each"),
    # The choice of the first cause's world gets 40 % of a third of 300 s, and so on.
    [("clearest", [40, 52, 84]), ("explained", [100, 100, 100])],
)
def test_one_cause_does_not_take_the_time_of_the_others(monkeypatch, greedy, seconds_of_each):
    still = found_by("Still")
    names = (Cause.STANDS_STILL, Cause.CIRCLES_AN_OBSTACLE, Cause.DRIVES_IN_CIRCLES)
    failures = {cause: still.noting(cause=cause.value) for cause in names}
    causes = causes_of(failures.values(), {})
    seconds = [0]
    spent = []

    def wait(*_):
        began = seconds[0]
        while not is_out_of_time():
            seconds[0] += 1
        spent.append(seconds[0] - began)

    def explained(failure, is_over, most_steps):
        with stopping_when(is_over):
            wait()

    monkeypatch.setattr(building, "explained", lambda *_: None)
    monkeypatch.setattr(building, greedy, {"clearest": wait, "explained": explained}[greedy])
    with_worlds(causes, lambda cause: [failures[cause]], end=300, clock=lambda: seconds[0])
    assert spent == seconds_of_each


def overview_of(best, found, known=None, executor=None, seconds=None):
    """Return the overview of a campaign with failures of a single class.

    Its file has ``best``, if any; the search met ``found``.
    """
    config = configure(CampaignOptions(controller=f"{HERE}:Still"), seed=1)
    find = Find(
        unit=0, strategy="drawn", cause=found.group, solid_cells=1, worlds=1, steps=1, seconds=1.0
    )
    state = CampaignState(best={} if best is None else {best.key: best}, finds=[(find, found)])
    state.memory = SearchState(failures={found.key: found})
    state.met[found.group, found.verdict] += 1
    conclusion = Conclusion(known or Baseline(), seconds=seconds)
    return build_overview(config, state, conclusion, natural=False, executor=executor)


@pytest.mark.parametrize(
    ("evidence", "fault"),
    [
        (
            {
                "error": "exit code 101",
                "reason": "panic",
                "message": "index out of bounds",
                "frames": [{"file": "mine.rs", "line": 18}],
            },
            "mine.rs:18: exit code 101: panic: index out of bounds",
        ),
        (
            {"error": "ValueError: too far", "message": "too far", "at": "mine.py:9"},
            "mine.py:9: ValueError: too far",
        ),
        ({"error": "killed by SIGSEGV", "signal": "SIGSEGV"}, "killed by SIGSEGV"),
    ],
)
def test_a_fault_has_its_place_and_what_the_program_reports(evidence, fault):
    found = found_by("Still").without("cause")
    crash = replace(found, record=replace(found.record, verdict="crash", evidence=evidence))
    ((row,), _) = with_worlds(causes_of([crash], {}), lambda _: [crash], most=0)
    assert row.fault == fault


class Stuck(InlineExecutor):
    """Workers of which none ends what it began."""

    room = 2

    def submit(self, work, /, *args, **kwargs):
        return Future()


def test_a_cause_that_no_worker_had_time_for_still_names_its_file():
    found = [found_by("Still"), found_by("Still", certified(hall(40))).noting(**{"class": "b"})]
    with Stuck() as executor:
        overview = overview_of(*found, executor=executor, seconds=0.0)
    (cause,) = overview.result.causes
    assert cause.file == "stands-still.grid" and overview.files["stands-still"] == found[0]
    assert cause.sentence.startswith("It stops")


def test_the_clearest_world_of_a_cause_comes_first_and_the_smallest_after_it():
    wide = found_by("Still", certified(hall(40))).noting(**{"class": "a"})
    usual = found_by("Still").noting(**{"class": "b"})
    overview = overview_of(wide, usual)
    (cause,) = overview.result.causes
    assert cause.file == "stands-still.grid" and overview.examples == {cause.cause: usual}
    assert cause.files == ["stands-still.grid", "stands-still-2.grid"]
    assert overview.files == {"stands-still": usual, "stands-still-2": wide}
    # A world that looks the same as a clearer one is not shown.
    same = overview_of(wide.noting(**{"class": "b"}), usual)
    assert same.files == {"stands-still": usual}
    assert same.result.causes[0].smallest == "stands-still.grid"


def test_a_known_failure_does_not_hide_a_new_one_of_its_cause(tmp_path):
    known = found_by("Still").noting(**{"class": "crash-a"}, cause="crashes")
    # The new one is in a larger world, so it comes later in order.
    new = found_by("Still", certified(hall(40))).noting(**{"class": "crash-b"}, cause="crashes")
    baseline = Baseline({_key(known): (tmp_path / "a.grid", known)})
    assert known.order < new.order and baseline.has(known) and not baseline.has(new)
    overview = overview_of(new, known, baseline)
    (cause,) = overview.result.causes
    assert (cause.file, cause.files) == ("crash-b.grid", ["crash-b.grid"])
    assert overview.examples == {cause.cause: new}
    assert cause.state == "new"


def test_a_world_whose_cause_changes_while_it_is_shrunk_is_shown_as_found(monkeypatch):
    scenario = Scenario(f"{HERE}:Still")
    case = Case(certified_hall(), scenario)
    other = found_by("Still", certified(hall(20))).noting(cause="pushed-too-hard")

    def files(smaller):
        return building._in_natural_world(
            Cause.STANDS_STILL, case, Baseline(), smaller, Constraint()
        )

    (as_found,) = files(lambda _: other)
    assert as_found.world.walls.shape == case.world.walls.shape
    small, again = files(lambda _: other.noting(cause="stands-still"))
    assert small.world is other.world and again == as_found


def test_at_most_three_failures_of_a_cause_have_files():
    failures = [found_by("Still").noting(**{"class": name}) for name in "abcde"]
    crashes = [found_by("Still").noting(**{"class": f"crash-{n}"}, cause="crashes") for n in (1, 2)]
    files = files_of([*failures, *crashes], [failures[4]])
    assert [*files] == ["stands-still", "stands-still-2", "stands-still-3", "crash-1", "crash-2"]
    assert files["stands-still"] is failures[4]


def test_the_reason_of_an_error_may_end_in_a_number():
    crash = found_by("Still").noting(cause="crashes")
    still = [crash.noting(**{"class": name}, cause="stands-still") for name in "ab"]
    files = files_of([*still, crash.noting(**{"class": "stands-still-2"})])
    assert {*files} == {"stands-still", "stands-still-2-more", "stands-still-2"}


def test_a_cause_that_nothing_met_is_never_in_the_numbered_list(tmp_path):
    hazard = CauseResult.of(Cause.HARMED_UNSENSED, ("e",), {"burned": 24}, 0)
    shrunk_only = CauseResult.of(Cause.STANDS_STILL, ("d",), {}, 0)
    lines = terminal(tmp_path, [hazard, shrunk_only], natural_worlds(8, 8), worlds=9)
    numbered = [line for line in lines if line[:2] in ("1.", "2.")]
    assert [line.partition(":")[0] for line in numbered] == ["1. harmed-by-what-it-cannot-sense"]
    assert "not counted: stands-still (only in worlds that shrinking made)" in lines


def test_natural_worlds_that_all_had_a_hazard_are_not_passed_over(tmp_path):
    lines = terminal(tmp_path, [], natural_worlds(unsensed=9), worlds=9)
    assert (
        "  hazards that it cannot sense harmed it in 9 natural worlds, and no other was finished"
        in lines
    )


def test_a_cause_that_nothing_met_has_no_verdicts():
    (cause,) = causes_of([found_by("Still")], {})
    assert (cause.met, cause.verdicts) == (0, {})


def test_the_terminal_names_no_hidden_file_for_a_known_failure(tmp_path):
    found = found_by("Still")
    found.write(tmp_path / "known.grid")
    known = Baseline.of(read_corpus([tmp_path]).entries, Scenario(f"{HERE}:Still"), print)
    overview = overview_of(None, found, known)
    causes = overview.result.causes
    assert causes[0].file.startswith(".campaign/failures/")
    lines = terminal(tmp_path, causes, known={"stands-still": 1})
    assert not any(".campaign" in line for line in lines)


FAR = """
import math

from sim import Command


class Far:
    senses = ("target_distance", "target_heading")

    def reset(self):
        return ()

    def act(self, observation, memory):
        # In the scenes of a search, the target is nearer.
        if observation.target_distance > 2.5:
            return Command(0.0, 0.0), memory
        turn = math.remainder(observation.target_heading - observation.heading, math.tau)
        return Command(observation.top_speed, turn / observation.time_step), memory
"""


@pytest.mark.nightly
def test_a_cause_that_only_natural_worlds_show_has_a_file_that_replays(tmp_path):
    (tmp_path / "far.py").write_text(FAR)
    out = tmp_path / "out"
    options = ("fuzz", "--controller", f"{tmp_path}/far.py:Far", "--no-shrink", "--units", 1,
               "--examples", 1, "--workers", 1, "--seed", 2, "--json", "--out")  # fmt: skip
    result = worldgen(*options, out)
    answer = json.loads(result.out)
    (cause,) = (one for one in answer["causes"] if one["natural"] and not one["met"])
    assert result.code == 1 and str(out / cause["file"]) in {
        failure["file"] for failure in answer["failures"]
    }
    failure = Failure.read(out / cause["file"])
    assert cause_of(failure) == cause["cause"] and failure.record.details["found_by"] == "natural"
    assert worldgen("replay", out / cause["file"]).code == 0

    files = {path.name: path.read_bytes() for path in out.glob("*.grid")}
    assert worldgen("fuzz", "--resume", out).code == 1
    assert {path.name: path.read_bytes() for path in out.glob("*.grid")} == files

    # If it is already known, it has no file.
    again = json.loads(worldgen(*options, tmp_path / "again", "--baseline", out).out)
    assert cause["cause"] in {one["cause"] for one in again["causes"]}
    named = {one[key] for one in again["causes"] for key in ("file", "smallest")}
    assert all((tmp_path / "again" / name).is_file() for name in named if name)


@pytest.mark.gate
def test_a_replay_of_stored_units_that_is_interrupted_leaves_the_folder_as_it_is(
    tmp_path, monkeypatch
):
    options = ("--controller", "turn-right", "--units", 2, "--examples", 5, "--workers", 1,
               "--seed", 1, "--out", tmp_path)  # fmt: skip
    assert worldgen("fuzz", *options).code == 1
    shown = [*tmp_path.glob("*.grid"), tmp_path / ".campaign" / "overview.json"]
    before = {path: path.read_bytes() for path in shown}
    merge = Campaign._merge

    def interrupted(campaign, unit, submitted):
        yield from merge(campaign, unit, submitted)
        raise KeyboardInterrupt

    monkeypatch.setattr(Campaign, "_merge", interrupted)
    result = worldgen("fuzz", "--resume", tmp_path)
    assert result.code == 130
    assert f"{len(shown) - 1} failures are kept" in result.err
    assert {path: path.read_bytes() for path in shown} == before


def test_the_file_of_a_cause_is_removed_once_another_world_is_clearer(tmp_path):
    out = tmp_path / "out"
    options = ("fuzz", "--controller", "turn-right", "--family", "trap", "--no-shrink", "--units", 1,
               "--examples", 2, "--workers", 1, "--seed", 1, "--out", out)  # fmt: skip
    assert worldgen(*options).code == 1
    store = resume(out).store
    store.write_failure("wanders.grid", next(out.glob("*.grid")).read_bytes())
    store.close()
    assert worldgen("fuzz", "--resume", out).code == 1
    assert not (out / "wanders.grid").exists()


def test_a_comparison_tells_new_from_fixed_and_still_there():
    found = compare("baseline", now={"a", "b"}, still={"b"}, fixed={"c", "b"})
    assert found.causes == {"new": ["a"], "still": ["b"], "fixed": ["c"]}
    assert found.sentence == (
        "against the baseline, new: 1 cause (a); fixed: 1 cause (c); still there: 1 cause (b)"
    )
    causes = [CauseResult.of(Cause.CRASHES, groups) for groups in (("a", "b"), ("b",), ("d",))]
    assert [one.state for one in with_states(causes, found)] == ["new", "still", ""]


def test_a_fall_of_the_natural_rate_beyond_its_interval_is_said():
    before = natural_worlds(100, 90)
    assert describe_fall(natural_worlds(100, 80), before) == ""
    fall = describe_fall(natural_worlds(100, 50), before)
    assert fall == "it arrives in 50 % of natural worlds, and arrived in 90 % before"
    found = compare("baseline", set(), set(), set(), fall)
    assert found.sentence.endswith(f"; {fall}")
    assert not describe_fall(natural_worlds(100, 95), before)
    assert not describe_fall(None, before) and not describe_fall(natural_worlds(9), None)


CRASHES = structs.replace(
    CauseResult.of(Cause.CRASHES, ["crash-a"], {"crash": 2}, 1), file="crash-a.grid"
)


def test_an_overview_that_is_read_is_the_one_that_was_written(tmp_path):
    (tmp_path / ".campaign").mkdir()
    natural, _ = natural_runs(Scenario("bug2"), ["trap"], 2, seed=1)
    changes = [Change("cell", [1, 2]), Change("radius", 0.2, 0.25, "m")]
    cause = structs.replace(CRASHES, changes=changes)
    comparison = compare("baseline", {"crash-a"}, set(), set())
    written = CampaignResult(causes=[cause], natural=natural, comparison=comparison)
    write_overview(structs.replace(written, summary=numbers()), tmp_path)
    assert read_overview(tmp_path) == written


def test_an_overview_of_an_earlier_version_is_read(tmp_path):
    (tmp_path / ".campaign").mkdir()
    written = CampaignResult(causes=[CRASHES])
    write_overview(written, tmp_path)
    file = tmp_path / ".campaign/overview.json"
    table = json.loads(file.read_text())
    del table["causes"][0]["fault"], table["causes"][0]["changes"], table["natural"]
    file.write_text(json.dumps(table))
    assert read_overview(tmp_path) == written


@pytest.mark.parametrize("file", ["../secret.grid", "a/b.grid", "/etc/passwd", ".campaign/x.grid"])
def test_an_overview_names_no_file_outside_its_folder(tmp_path, file):
    (tmp_path / ".campaign").mkdir()
    write_overview(CampaignResult(causes=[structs.replace(CRASHES, file=file)]), tmp_path)
    with raises(FormatError, "invalid-overview"):
        read_overview(tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "{}",
        '{"version": 2}',
        '{"version": 1, "causes": []}',
        '{"version": 2, "causes": [1]}',
        '{"version": 2, "causes": [], "natural": {"worlds": "many"}}',
        "{",
        "[" * 100_000,
    ],
)
def test_an_overview_of_another_form_is_refused(tmp_path, text):
    (tmp_path / ".campaign").mkdir()
    (tmp_path / ".campaign/overview.json").write_text(text)
    with raises(FormatError, "invalid-overview"):
        read_overview(tmp_path)


def test_every_cause_has_a_sentence_and_an_advice():
    for cause in Cause:
        assert cause.sentence.endswith(".") and cause.advice.endswith((".", "?"))
        assert cause.severity in Severity and cause.severity.phrase


def test_the_table_of_natural_worlds_names_what_was_never_tried():
    table = natural_worlds()
    assert table.share is None and table.clearances["less than 1.1"] == NaturalTally(0, 0)


@pytest.mark.gate
def test_the_terminal_says_it_in_fifteen_lines_and_json_says_it_all(tmp_path):
    options = ("fuzz", "--controller", "turn-right", "--motion", "endpoint", "--no-shrink", "--units", 1,
               "--examples", 4, "--workers", 1, "--seed", 1, "--out")  # fmt: skip
    text = worldgen(*options, tmp_path / "text")
    lines = text.out.splitlines()
    assert text.code == 1 and len(lines) <= 15
    assert lines[0].startswith("turn-right under endpoint: ")
    assert "natural world" in lines[1] and "(95 %: " in lines[1]
    assert any("worldgen replay" in line for line in lines)

    answer = json.loads(worldgen(*options, tmp_path / "json", "--json").out)
    assert answer["causes"][0]["cause"] in lines[2] and answer["failures"]
    assert {group for cause in answer["causes"] for group in cause["groups"]} >= set(answer["met"])
    assert all((tmp_path / "json" / cause["file"]).is_file() for cause in answer["causes"])
    assert plain(read_overview(tmp_path / "json").natural) == answer["natural"]


def test_a_campaign_without_an_answer_says_why_and_what_to_type(tmp_path):
    more = f"worldgen fuzz --resume {tmp_path} --budget 5m"
    lines = terminal(
        tmp_path, answer="none", answer_reason="1 of the 5 natural worlds was finished", remedy=more
    )
    assert lines[0].startswith("mine under swept: no answer: 1 of the 5 natural worlds")
    assert lines[-1] == f"give it more time: {more}"


def test_runs_that_do_not_arrive_are_reported_even_if_none_is_a_failure(tmp_path):
    line, *_ = terminal(tmp_path, answer_numbers=AnswerNumbers(searched_unjudged=13))
    assert "no failure of mine under swept found" in line and "did not arrive in 13" in line
    line, *_ = terminal(tmp_path)
    assert "did not arrive" not in line


def test_the_first_line_says_how_often_a_robot_arrives(tmp_path):
    cause = CauseResult.of(Cause.CIRCLES_AN_OBSTACLE, ("a",), {"loop": 9})

    def first_lines(arrived):
        natural = natural_worlds(400, arrived)
        return terminal(tmp_path, [cause], natural, answer_numbers=FAILING)[:2]

    assert "arrived in no natural world" in first_lines(0)[0]
    assert "rarely arrives" in first_lines(50)[0]
    assert "usually does not arrive" in first_lines(100)[0]
    assert "does not always arrive" in first_lines(200)[0]
    first, second = first_lines(399)
    assert "nearly always arrives" in first and "arrives in 99 % of 400" in second
    assert "arrives in all 400 natural worlds (95 %: at least 99 %)" in first_lines(400)[1]


def test_few_natural_worlds_are_not_said_to_be_all_there_are(tmp_path):
    cause = CauseResult.of(Cause.PUSHES_A_WALL, ("a",), {"loop": 9}, 1)

    def lines(worlds, arrived):
        return terminal(tmp_path, [cause], natural_worlds(worlds, arrived), answer_numbers=FAILING)

    first, second, third, *_ = lines(1, 0)
    assert "does not always arrive" in first
    assert "does not arrive in the only natural world that was finished" in second
    assert third.startswith("1. pushes-a-wall: in the only natural world")
    assert "arrives in the only natural world that was finished" in lines(1, 1)[1]
    assert "does not always arrive" in lines(4, 0)[0]
    assert "arrived in no natural world" in lines(5, 0)[0]
    assert "how often it arrives is not known: no natural world was finished" in lines(0, 0)[1]


def test_counts_never_contradict_each_other(tmp_path):
    own = CauseResult.of(Cause.PUSHES_A_WALL, ("a", "b"), {"loop": 1}, 0)
    natural_only = CauseResult.of(Cause.WANDERS, ("c",), {}, 2)
    shrunk_only = CauseResult.of(Cause.STANDS_STILL, ("d",), {"loop": 0}, 0)
    hazard = CauseResult.of(Cause.HARMED_UNSENSED, ("e",), {"burned": 24}, 0)
    causes = [own, shrunk_only, natural_only, hazard]
    natural = natural_worlds(8, 6)
    styled = terminal(tmp_path, causes, natural, in_colour=True, answer_numbers=FAILING)
    # Colours survive the way to the terminal only in a styled text.
    assert [line for line in styled if "\x1b" in line and not isinstance(line, Styled)] == []
    lines = list(map(click.unstyle, styled))
    assert "2 causes" in lines[0]
    assert "1. pushes-a-wall: none of 8 natural worlds; examined: 1 loop" in lines
    assert "2. wanders: 2 of 8 natural worlds; not met by the search" in lines
    assert (
        "not counted: stands-still (only in worlds that shrinking made), "
        "harmed-by-what-it-cannot-sense (24 burned)"
    ) in lines


@pytest.mark.parametrize(
    ("cause", "words"),
    [
        (Cause.CRASHES, "its controller crashes; 1 cause"),
        (Cause.INVALID_COMMAND, "its controller sends invalid commands; 1 cause"),
        (Cause.GOES_THROUGH_A_WALL, "goes through walls; 1 cause"),
        (Cause.WANDERS, "sometimes runs out of time; 1 cause"),
        (Cause.CIRCLES_AN_OBSTACLE, "does not always arrive; 1 cause"),
        (
            Cause.CAUGHT_BY_A_CHANGE,
            "does not always arrive, and runs into a hazard that it can sense; 1 cause",
        ),
    ],
)
def test_the_worst_cause_decides_the_first_line(tmp_path, cause, words):
    causes = [CauseResult.of(cause, ("a",), {"loop": 1})]
    line, *_ = terminal(tmp_path, causes, answer_numbers=FAILING)
    assert line.startswith(f"mine under swept: {words}")


def test_each_failure_has_its_page_only_if_asked_for(tmp_path):
    options = ("fuzz", "--controller", "turn-right", "--family", "trap", "--no-shrink", "--units", 1,
               "--examples", 4, "--workers", 1, "--seed", 1, "--out")  # fmt: skip
    brief = worldgen(*options, tmp_path / "brief").out
    verbose = worldgen(*options, tmp_path / "verbose", "--verbose").out
    assert "S start" not in brief and "S start" in verbose and "strategy" in verbose
    assert "returns-to-a-wall" in verbose


@pytest.mark.gate
def test_a_campaign_in_the_same_folder_is_compared_with_the_last_one(tmp_path):
    options = ("fuzz", "--controller", "turn-right", "--family", "trap", "--no-shrink", "--units", 1,
               "--examples", 4, "--workers", 1, "--seed", 1, "--out", tmp_path / "out", "--json")  # fmt: skip
    first = json.loads(worldgen(*options).out)
    second = json.loads(worldgen(*options, "--force").out)
    assert first["comparison"] is None and second["comparison"]["against"] == "last campaign"
    causes = sorted({group for cause in first["causes"] for group in cause["groups"]})
    assert second["comparison"]["causes"] == {"new": [], "still": causes, "fixed": []}
    assert {cause["state"] for cause in second["causes"]} == {"still"}
