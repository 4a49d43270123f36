"""Known failures: counted, not kept.

Their cause and whether they still fail are determined again.
"""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from fuzz.campaign.run import Campaign
from fuzz.campaign.store import Budget, FolderStore
from fuzz.campaign.store.fingerprint import fingerprint_of
from fuzz.corpus import Baseline, read_corpus
from fuzz.failure import Failure
from fuzz.triage.judging import failure_of
from fuzz.unit.config import CampaignConfig
from sim.controllers import CONTROLLERS
from sim.options.run import RunOptions
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen import generate, read_world, write_world
from worldgen.world import Pose

FUZZ = (
    "fuzz",
    "--controller",
    "turn-right",
    "--strategy",
    "features",
    "--units",
    "2",
    "--examples",
    "30",
)
FUZZ = (*FUZZ, "--seed", "5", "--workers", "1")
TURN_RIGHT = Scenario("turn-right")


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A campaign's folder, and its classes."""
    out = tmp_path_factory.mktemp("found")
    result = worldgen(*FUZZ, "--no-shrink", "--out", out, "--json")
    assert result.code == 1
    return out, sorted(one["class"] for one in json.loads(result.out)["failures"])


def again(out, *baseline, more=()):
    given = [*more, *(word for path in baseline for word in ("--baseline", path))]
    result = worldgen(*FUZZ, "--out", out, "--json", *given)
    return result, json.loads(result.out)


def stored(folder, path, **changes):
    """A failure's file in a folder, with another record."""
    world = read_world(path)
    folder.mkdir(exist_ok=True)
    write_world(
        replace(world, failure=replace(world.failure, **changes)),
        folder / Path(path).name,
        force=True,
    )
    return folder


def baseline_of(path, notes, scenario=TURN_RIGHT):
    return Baseline.of(read_corpus([path]).entries, scenario, notes.append)


def a_loop(found):
    return next(
        file
        for file in sorted(found[0].glob("*.grid"))
        if read_world(file).failure.verdict == "loop"
    )


@pytest.mark.gate
def test_known_classes_are_counted_but_neither_written_nor_a_failure(found, tmp_path):
    result, summary = again(tmp_path / "out", found[0])
    assert (
        result.code == 0 and not summary["failures"] and not list((tmp_path / "out").glob("*.grid"))
    )
    groups = {Failure.read(path).group for path in found[0].glob("*.grid")}
    assert groups <= set(summary["known"]) and min(summary["known"].values()) > 0


@pytest.mark.gate
def test_a_class_that_the_baseline_has_not_is_found_still(found, tmp_path):
    groups = {path: Failure.read(path).group for path in sorted(found[0].glob("*.grid"))}
    missing = groups[a_loop(found)]
    kept = [path for path, group in groups.items() if group != missing]
    result, summary = again(tmp_path / "out", *kept, more=["--no-shrink"])
    assert result.code == 1 and {one["cause"] for one in summary["failures"]} == {missing}
    assert (tmp_path / "out" / f"{missing}.grid").is_file()


@pytest.mark.gate
def test_the_terminal_says_how_often_known_classes_were_met(found, tmp_path):
    text = worldgen(*FUZZ, "--out", tmp_path / "out", "--baseline", found[0], "--verbose").out
    assert (
        "known: " in text
        and f"{found[1][0]} " in text
        and "no new failure of turn-right under swept found" in text
    )


def test_a_name_of_another_time_hides_nothing_and_is_told(found, tmp_path):
    file, notes = a_loop(found), []
    failure = Failure.read(file)
    other = {**failure.record.details, "cause": "stands-still"}
    known = baseline_of(stored(tmp_path / "old", file, details=other), notes)
    assert {key[2] for key in known.failures} == {failure.group} and known.has(failure)
    assert len(notes) == 1
    assert f"stored as stands-still, its cause is now {failure.group}" in notes[0]


def test_a_file_from_before_causes_were_recorded_is_known_by_its_run(found, tmp_path):
    file, notes = a_loop(found), []
    failure = Failure.read(file)
    details = {name: value for name, value in failure.record.details.items() if name != "cause"} | {
        "class": "loop-of-old"
    }
    known = baseline_of(stored(tmp_path / "old", file, details=details), notes)
    assert known.has(failure) and not notes


def test_a_new_variant_of_a_known_cause_is_new_only_if_strict(found):
    failure = Failure.read(a_loop(found))
    entries = read_corpus([found[0]]).entries
    variant = failure.noting(**{"class": "loop-that-looks-different"})
    known = Baseline.of(entries, TURN_RIGHT, print)
    assert known.has(variant) and known.is_new_variant(variant)
    assert not known.is_new_variant(failure)
    strict = Baseline.of(entries, TURN_RIGHT, print, strict=True)
    assert strict.has(failure) and not strict.has(variant)


def test_a_failure_that_is_none_any_more_is_told_and_not_known(found, tmp_path):
    file, notes = a_loop(found), []
    world = read_world(file)
    there = replace(world, start=Pose(world.target.x, world.target.y, 0.0))
    write_world(replace(there, certificate=None), tmp_path / "w.grid")
    assert not baseline_of(tmp_path / "w.grid", notes).failures
    assert (
        "has no witness" in notes[0]
        and f"so its cause {Failure.read(file).group} is not known" in notes[0]
    )


def test_a_controller_that_is_mended_has_no_known_failures(found, tmp_path):
    notes = []
    mended = stored(tmp_path / "mended", a_loop(found), controller="bug2")
    assert (
        not baseline_of(mended, notes, Scenario("bug2")).failures and "no longer fails" in notes[0]
    )


def test_failures_of_other_controllers_and_motion_models_are_passed_over(found):
    notes = []
    for scenario in (Scenario("turn-left"), Scenario("turn-right", RunOptions("endpoint"))):
        assert not baseline_of(found[0], notes, scenario).failures
    assert "no failure of turn-left under swept, only of turn-right under swept" in notes[0]


@pytest.mark.parametrize(
    "stored_as",
    ["./mine.py:Mine", "mine.py:Mine", "below/../mine.py:Mine", "{folder}/mine.py:Mine"],
)
@pytest.mark.parametrize("given_as", ["./mine.py:Mine", "mine.py:Mine", "{folder}/mine.py:Mine"])
def test_a_file_is_the_same_controller_however_its_path_is_written(
    stored_as, given_as, crash, tmp_path, monkeypatch
):
    _, _, known = crash
    monkeypatch.chdir(tmp_path)
    (tmp_path / "below").mkdir()
    file = known / "crash.grid"
    stored(known, file, controller=stored_as.format(folder=tmp_path))
    scenario = Scenario.parse(given_as.format(folder=tmp_path))
    baseline = baseline_of(known, [], scenario)
    met = failure_of(generate("trap", 4, size=20), scenario)
    assert baseline.has(met)


@pytest.mark.gate
def test_a_resumed_campaign_counts_known_failures_as_often(tmp_path):
    """Few failures of a unit are stored, but all of them were met."""
    config = CampaignConfig(TURN_RIGHT, seed=5, families=("features",), examples=3)

    def known_after(units, store):
        campaign = Campaign(config, units=units, store=store, is_known=lambda _: True)
        list(campaign.run())
        return campaign.state.known

    whole = known_after(19, None)
    for units in (18, 19):
        store = FolderStore(tmp_path)
        store.begin(fingerprint_of(config), Budget(units=units))
        again = known_after(units, store)
        store.close()
    assert again == whole and whole.total() > 0


CLASS = """
class Mine:
    def reset(self):
        return (0.0,)

    def act(self, o, m):
        {first}
        if m[0] > 3.0:
            raise KeyError("late")
        return (1.0, 0.0), (m[0] + 1.0,)
"""


@pytest.fixture
def crash(tmp_path):
    """A controller's file, its scenario, and a folder with its only known crash."""
    file = tmp_path / "mine.py"
    file.write_text(CLASS.format(first="pass"))
    scenario = Scenario.parse(f"{file}:Mine")
    (tmp_path / "known").mkdir()
    failure_of(generate("trap", 4, size=20), scenario).write(tmp_path / "known" / "crash.grid")
    return file, scenario, tmp_path / "known"


def edited(file, first):
    file.write_text(CLASS.format(first=first))
    CONTROLLERS.forget(str(file))


@pytest.mark.gate
def test_a_known_crash_is_known_after_an_edit_of_other_lines(crash):
    file, scenario, known = crash
    edited(file, "x = 1")
    assert len(baseline_of(known, [], scenario).failures) == 1


def test_a_new_crash_in_a_known_world_is_not_known(crash):
    file, scenario, known = crash
    edited(file, "1 / 0")
    notes = []
    assert not baseline_of(known, notes, scenario).failures
    assert "which is not known" in notes[0]
