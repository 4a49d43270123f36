"""A learner that a world traps is taught in it, and is no longer trapped."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim import simulate
from sim.controllers import CONTROLLERS
from sim.controllers.learning import Learned, learned_text, read_learned
from sim.drawing.curve import curve_svg
from sim.runners.training import TrainingOptions, train
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter
from worldgen.families import trap
from worldgen.files.grid import read_world

TRAP = Path(__file__).parents[1] / "data" / "learner" / "trapped.grid"
COMPOSED = "behaviours+by=learning:avoid,follow,approach,escape"


@pytest.mark.gate
def test_a_learner_that_a_shrunk_world_traps_is_taught_and_no_longer_trapped(tmp_path):
    out = tmp_path / "taught.json"
    assert json.loads(worldgen("replay", TRAP, "--json").out)["confirmed"] == 1
    first = worldgen("train", TRAP, "--out", out, "--json")
    assert first.code == 0
    curve = json.loads(first.out)["curve"]
    assert curve[0]["reached"] == 0 and max(point["reached"] for point in curve) == 1
    run = worldgen("run", TRAP, "--controller", f"learned:{out}", "--json")
    assert (run.code, json.loads(run.out)["verdict"]) == (0, "reached")

    again = tmp_path / "again.json"
    worldgen("train", TRAP, "--out", again)
    assert again.read_bytes() == out.read_bytes()


@pytest.mark.nightly
def test_fuzz_finds_a_trap_of_the_learner_shrinks_it_and_the_learner_is_taught_in_it(tmp_path):
    found = tmp_path / "found"
    worldgen("fuzz", "--controller", "q-learner", "--units", "1", "--seed", "1", "--out", found)
    (path, *_) = sorted(found.glob("*.grid"))
    assert worldgen("run", path, "--controller", "q-learner").code == 1
    out = tmp_path / "taught.json"
    worldgen("train", path, "--episodes", "400", "--out", out)
    assert worldgen("run", path, "--controller", f"learned:{out}").code == 0


def test_what_it_learned_is_read_back_and_starts_the_next_run(tmp_path):
    learner = CONTROLLERS.get("q-learner")
    options = TrainingOptions(episodes=3, steps=50)
    learned = train([trap(3, size=24)], Scenario("q-learner"), learner, options)
    path = tmp_path / "taught.json"
    path.write_text(learned_text(learned))
    assert read_learned(path) == learned
    taught = CONTROLLERS.get(f"learned:{path}")
    assert taught.memory[learner.learning.places] == learned.numbers
    assert taught.memory[: learner.learning.first] == learner.memory[: learner.learning.first]


def test_a_file_that_changes_is_read_again(tmp_path):
    path = tmp_path / "taught.json"
    learner = CONTROLLERS.get("q-learner")
    numbers = learner.memory[learner.learning.places]
    for value in (1.0, 22.0):
        path.write_text(learned_text(Learned("q-learner", (value, *numbers[1:]), ())))
        assert CONTROLLERS.get(f"learned:{path}").memory[learner.learning.first] == value


def test_a_learner_changes_its_table_within_a_run_and_draws_nothing():
    world = trap(3, size=24)
    episode = simulate(world, "q-learner", steps=300, record=True)
    first = CONTROLLERS.get("q-learner").learning.first
    before, after = (episode.trace.memory(step)[first:] for step in (0, episode.steps))
    assert 10 < np.count_nonzero(before != after) < 300
    assert not CONTROLLERS.get("q-learner").randomised


def test_an_arbiter_keeps_what_it_learned_too(tmp_path):
    controller = CONTROLLERS.get(COMPOSED)
    world = trap(3, size=24)
    episode = simulate(world, COMPOSED, steps=200, record=True)
    numbers = tuple(episode.trace.memory(episode.steps)[controller.learning.places])
    assert any(numbers)
    path = tmp_path / "taught.json"
    path.write_text(learned_text(Learned(COMPOSED, numbers, ())))
    taught = simulate(world, f"learned:{path}", steps=200)
    assert taught.trace_digest != episode.trace_digest


def test_the_curve_is_drawn():
    learner = CONTROLLERS.get("q-learner")
    options = TrainingOptions(episodes=2, steps=20)
    learned = train([trap(3, size=24)], Scenario("q-learner"), learner, options)
    svg = curve_svg(learned.curve, "q<1>")
    assert svg.count("<circle") == 2 * len(learned.curve) and "q&lt;1&gt;" in svg


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "not-learned"),
        ("[]", "not-learned"),
        ('{"format":"worldgen-learned","version":2}', "not-learned"),
        ('{"format":"worldgen-learned","version":1,"controller":"learned:x"}', "not-learned"),
        (learned_text(Learned("q-learner", (1.0, 2.0), ())), "wrong-size"),
        (learned_text(Learned("bug2", (1.0,), ())), "does-not-learn"),
        (learned_text(Learned("q-learner", (-1.0,) * 1536, ())), "out-of-range"),
        (learned_text(Learned("q-learner", (0.5,) * 1536, ())), "out-of-range"),
        (learned_text(Learned("q-learner", (1.0,), ())).replace("[1]", "[1e999]"), "not-learned"),
    ],
)
def test_a_file_that_holds_something_else_is_an_error_with_a_code(tmp_path, text, code):
    path = tmp_path / "taught.json"
    path.write_text(text)
    with pytest.raises(InvalidParameter) as caught:
        CONTROLLERS.get(f"learned:{path}")
    assert caught.value.code == code


def test_what_cannot_be_trained_is_refused(tmp_path):
    bug2 = CONTROLLERS.get("bug2")
    with raises(InvalidParameter, "does-not-learn"):
        train([read_world(TRAP)], Scenario("bug2"), bug2, TrainingOptions())
    with raises(InvalidParameter, "no-such-file"):
        CONTROLLERS.get(f"learned:{tmp_path}/missing.json")
    with raises(InvalidParameter, "no-worlds"):
        train([], Scenario("q-learner"), CONTROLLERS.get("q-learner"), TrainingOptions())
    with raises(InvalidParameter, "out-of-range"):
        replace(TrainingOptions(), episodes=0)
