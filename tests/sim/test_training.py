"""A learner that is trapped in a world trains in it, and is no longer trapped."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim import Command, simulate
from sim.controllers import CONTROLLERS
from sim.controllers.learning import Learned, Learning, learned_text, read_learned
from sim.drawing.curve import curve_svg
from sim.runners.training import TrainingOptions, train
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter, write_world
from worldgen.families import rooms, trap
from worldgen.files.grid import read_world
from worldgen.plugins.trust import CodeNotTrusted, admit, command_rule

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


_HEAD = '{"format":"worldgen-learned","version":1,"controller":"q","curve":[],"numbers":'


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[" * 100_000, "it is not JSON"),
        (_HEAD + "[1" + "0" * 5000 + "]}", "it is not JSON"),
        ("[]", "it is not a JSON object"),
        ("{}", "its format is not 'worldgen-learned'"),
        ('{"format":"worldgen-learned","version":2}', "its version is not 1"),
        (_HEAD + "[NaN]}", "its numbers are not a list of finite numbers below 2**53"),
        (_HEAD + '["x"]}', "its numbers are not a list of finite numbers below 2**53"),
        (
            _HEAD.replace("[]", "[[1, 2]]") + "[]}",
            "its curve is not a list of points of four whole numbers",
        ),
    ],
)
def test_a_file_that_holds_something_else_is_told_why_in_plain_words(tmp_path, text, reason):
    path = tmp_path / "taught.json"
    path.write_text(text)
    with raises(InvalidParameter, "not-learned", reason=reason):
        read_learned(path)


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


@pytest.fixture
def escaper(tmp_path, monkeypatch):
    """The class from the page, in a file in the working directory, and a world."""
    page = Path(__file__).parents[2] / "docs/reference/behaviours.md"
    source = re.search(r"```python\n(# learner\.py\n.*?)```", page.read_text("utf-8"), re.DOTALL)
    (tmp_path / "learner.py").write_text(source[1])
    write_world(trap(5, size=20), tmp_path / "w.grid")
    monkeypatch.chdir(tmp_path)
    return "./learner.py:Escaper"


def test_a_class_of_one_s_own_is_taught_and_starts_with_what_it_learned(escaper):
    options = ("--episodes", 12, "--out", "taught.json")
    assert worldgen("train", "w.grid", "--controller", escaper, *options).code == 0
    taught = f"{escaper}+learned=taught.json"
    learned = read_learned(Path("taught.json"))
    assert learned.controller == escaper and any(learned.numbers)
    assert CONTROLLERS.get(taught).reset()[4:] == learned.numbers
    before, after = (
        json.loads(worldgen("run", "w.grid", "--controller", name, "--json").out)["steps"]
        for name in (escaper, taught)
    )
    best = min(point.steps for point in learned.curve)
    assert after == best < before == learned.curve[0].steps

    again = worldgen(
        "train", "w.grid", "--controller", taught, "--episodes", 1, "--out", "more.json"
    )
    assert again.code == 0 and read_learned(Path("more.json")).controller == escaper


def test_its_failures_replay_and_its_loops_are_proved(escaper):
    numbers = ",".join(["0"] * 12)
    Path("taught.json").write_text(
        '{"format":"worldgen-learned","version":1,"controller":"learner.py:Escaper","curve":[],'
        f'"numbers":[{numbers}]}}'
    )
    name = f"{escaper}+learned=taught.json"
    plain, taught = (simulate(rooms(101), one, steps=5000) for one in (escaper, name))
    assert plain.verdict == taught.verdict == "loop"
    assert plain.evidence == taught.evidence
    scenario = Scenario.parse(f"{name}+slip=0.1")
    assert scenario.controller == name and scenario.run.robot.slip == 0.1


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (learned_text(Learned("other.py:Escaper", (0.0,) * 12, ())), "other-controller"),
        (learned_text(Learned("other.py:Robot", (0.0,) * 12, ())), "other-controller"),
        (learned_text(Learned("learner.py:Escaper", (0.0,) * 3, ())), "wrong-size"),
        ("{}", "not-learned"),
    ],
)
def test_a_file_that_is_not_what_the_class_learned_is_refused(escaper, text, code):
    Path("taught.json").write_text(text)
    with raises(InvalidParameter, code):
        CONTROLLERS.get(f"{escaper}+learned=taught.json")


def test_a_file_alone_still_runs_no_code(escaper):
    Path("taught.json").write_text(learned_text(Learned(escaper, (0.0,) * 12, ())))
    with raises(InvalidParameter, "learned-names-code"):
        CONTROLLERS.get("learned:taught.json")
    with raises(InvalidParameter, "no-value"):
        CONTROLLERS.get(f"{escaper}+learned=")


def test_code_that_was_named_with_what_it_learned_may_run(escaper):
    Path("taught.json").write_text(learned_text(Learned(escaper, (0.0,) * 12, ())))
    name = f"{escaper}+learned=taught.json"
    with command_rule(None):
        with raises(CodeNotTrusted, "code-not-allowed"):
            CONTROLLERS.get(name)
        admit(name)
        assert CONTROLLERS.get(name).reset()


class _Odd:
    learning = Learning(0, 5)
    senses = ("bump",)

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(), memory


class _Failing(_Odd):
    learning = Learning(0, 1)

    def act(self, observation, memory):
        raise ValueError("no idea")


class _Planner(_Odd):
    def reset(self, world):
        return (0.0,)


class _Endless(_Failing):
    def act(self, observation, memory):
        return Command(), (float("inf"),)


@pytest.mark.parametrize(
    ("kind", "code"),
    [
        (_Odd, "wrong-declaration"),
        (_Failing, "code-failed"),
        (_Planner, "does-not-learn"),
        (_Endless, "not-finite"),
    ],
)
def test_learners_that_cannot_be_trained_are_refused_with_a_code(kind, code):
    options = TrainingOptions(episodes=1, steps=5)
    with raises(InvalidParameter, code):
        train([trap(3, size=24)], Scenario("mine"), kind(), options)
