"""The shipped failures of the library: each replays, and is filed by its cause."""

import pathlib

import pytest

from fuzz.cause import CAUSE
from fuzz.facts.signature import failure_class
from fuzz.failure import MOST_SHOWN, Failure
from fuzz.overview.building import files_of
from fuzz.overview.clearest import clearest
from fuzz.shrink import removable
from fuzz.shrink.predicate import StillFails
from fuzz.triage.diagnosis import cause_of, details_of, diagnosis_of
from fuzz.triage.replaying import replay
from sim.controllers import CONTROLLERS

ROOT = pathlib.Path(__file__).parents[2]
FAILURES = ROOT / "corpora" / "failures"
GROUPS = sorted({path.parent.relative_to(FAILURES).as_posix() for path in FAILURES.rglob("*.grid")})
README = (FAILURES / "README.md").read_text(encoding="utf-8")


def failures_of(group):
    return {path.stem: Failure.read(path) for path in sorted((FAILURES / group).glob("*.grid"))}


@pytest.mark.nightly
@pytest.mark.parametrize("group", GROUPS)
def test_every_failure_replays_with_the_cause_and_signature_of_its_record(group):
    for name, failure in failures_of(group).items():
        again = replay(failure)
        assert again.confirmed, f"{name}: {again.reason}"
        assert failure_class(failure.world, again.episode) == failure.signature
        recorded = failure.record.details
        diagnosed = details_of(diagnosis_of(failure.without(CAUSE)))
        assert diagnosed == {key: recorded[key] for key in diagnosed}, name


@pytest.mark.nightly
@pytest.mark.parametrize("group", GROUPS)
def test_nothing_can_be_removed_without_losing_verdict_or_cause(group):
    for name, failure in failures_of(group).items():
        still_fails = StillFails.of(failure, cause=cause_of(failure))
        assert removable(failure.world, still_fails) == [], name


@pytest.mark.gate
@pytest.mark.parametrize("group", GROUPS)
def test_a_folder_is_filed_as_a_campaign_files_its_failures(group):
    failures = failures_of(group)
    by_cause = {}
    for failure in failures.values():
        by_cause.setdefault(failure.group, []).append(failure)
    assert all(len(own) <= MOST_SHOWN for own in by_cause.values())
    filed = files_of(failures.values(), map(clearest, by_cause.values()))
    assert {name: one.id for name, one in filed.items()} == {
        name: one.id for name, one in failures.items()
    }


@pytest.mark.parametrize("group", GROUPS)
def test_every_failure_is_of_the_controller_and_motion_model_of_its_folder(group):
    controller, motion = group.split("/")
    assert controller in CONTROLLERS.names()
    records = [failure.record for failure in failures_of(group).values()]
    assert {(record.controller, record.motion) for record in records} == {(controller, motion)}
    assert all(record.details["one_minimal"] for record in records)


@pytest.mark.parametrize("group", GROUPS)
def test_the_readme_counts_the_failures_of_a_controller(group):
    controller, motion = group.split("/")
    assert f"| `{controller}` | {motion} | {len(failures_of(group))} |" in README
