"""The shipped failures of the library: each replays, with the class in its name."""

import pathlib

import pytest

from fuzz.facts.signature import failure_class
from fuzz.failure import Failure
from fuzz.triage.judging import replay
from sim.controllers import CONTROLLERS
from worldgen.files.grid import read_world

ROOT = pathlib.Path(__file__).parents[2]
FAILURES = ROOT / "corpora" / "failures"
GROUPS = sorted({path.parent.relative_to(FAILURES).as_posix() for path in FAILURES.rglob("*.grid")})
README = (FAILURES / "README.md").read_text(encoding="utf-8")


def worlds_of(group):
    return {path.stem: read_world(path) for path in sorted((FAILURES / group).glob("*.grid"))}


@pytest.mark.nightly
@pytest.mark.parametrize("group", GROUPS)
def test_every_failure_replays_with_the_class_that_it_is_named_by(group):
    for name, world in worlds_of(group).items():
        again = replay(Failure.of(world))
        assert again.confirmed, f"{name}: {again.reason}"
        assert failure_class(world, again.episode) == name


@pytest.mark.parametrize("group", GROUPS)
def test_every_failure_is_of_the_controller_and_motion_model_of_its_folder(group):
    controller, motion = group.split("/")
    assert controller in CONTROLLERS.names()
    records = [world.failure for world in worlds_of(group).values()]
    assert {(record.controller, record.motion) for record in records} == {(controller, motion)}
    assert all(record.details["one_minimal"] for record in records)


@pytest.mark.parametrize("group", GROUPS)
def test_the_readme_counts_the_classes_of_a_controller(group):
    controller, motion = group.split("/")
    assert f"| `{controller}` | {motion} | {len(worlds_of(group))} |" in README
