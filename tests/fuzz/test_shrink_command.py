"""The command shrink: passes, what it preserves, Ctrl-C, and test modules that run."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.shrink import ORDER, PASSES, snippet, trying
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim.options.run import RunOptions
from sim.scenario import Scenario
from tests.fuzz.test_shrink import cup_world
from tests.helpers.command_line import worldgen
from worldgen import Pose, Target, World, read_world, world_digest, write_world


@pytest.fixture(scope="module")
def big(tmp_path_factory):
    path = tmp_path_factory.mktemp("shrink") / "big.grid"
    failure_of(certified(cup_world()), Scenario("turn-right"), fewest_steps=20_000).write(path)
    return path


def test_passes_lists_every_pass_and_every_measure():
    result = worldgen("shrink", "--passes")
    assert result.code == 0
    assert all(
        f"  {one.name} " in result.out and one.says in result.out for one in (*PASSES, *ORDER)
    )


def test_shrinking_keeps_the_cause_that_the_run_shows(big, tmp_path):
    record = read_world(big).failure
    # A cause that somebody has written into the file does not matter.
    other = {**record.details, "cause": "drives-in-circles"}
    write_world(
        replace(read_world(big), failure=replace(record, details=other)), tmp_path / "other.grid"
    )
    for file in (big, tmp_path / "other.grid"):
        result = worldgen("shrink", file, "--out", tmp_path / "small.grid", "--force")
        details = read_world(tmp_path / "small.grid").failure.details
        assert result.code == 0 and details["kept"] == "cause"
        assert details["cause"] == record.details["cause"]


def test_ctrl_c_keeps_the_best_so_far(big, tmp_path, monkeypatch):
    first, calls = trying.Trying.first, []

    def stop_at_the_fourth(*args):
        calls.append(args)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return first(*args)

    monkeypatch.setattr(trying.Trying, "first", stop_at_the_fourth)
    result = worldgen("shrink", big, "--out", tmp_path / "small.grid")
    small = read_world(tmp_path / "small.grid")
    assert result.code == 130 and "the smallest world so far is kept" in result.err
    assert small.walls.size < read_world(big).walls.size and replay(Failure.of(small)).confirmed


def test_snippet_and_json_do_not_go_together(big):
    result = worldgen("shrink", big, "--snippet", "--json")
    assert result.code == 2 and "use one of them" in result.err


@pytest.mark.parametrize(
    ("out", "error_code"), [("no/such.grid", "no-such-folder"), ("there.grid", "file-exists")]
)
def test_what_could_not_be_written_is_refused_before_the_work(
    big, tmp_path, monkeypatch, out, error_code
):
    (tmp_path / "there.grid").touch()
    monkeypatch.setattr("fuzz.shrink.shrink", lambda *args, **options: pytest.fail("it has begun"))
    result = worldgen("shrink", big, "--out", tmp_path / out)
    assert result.code == 2 and result.error_code == error_code


def run_pytest(folder):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "ignore", "."]
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=300, check=False
    ).stdout


@pytest.mark.gate
def test_the_printed_module_runs_and_fails_as_the_failure_does(big, tmp_path):
    files = {*big.parent.iterdir()}
    code = worldgen("shrink", big, "--snippet").out
    assert {*big.parent.iterdir()} == files
    (tmp_path / "test_small.py").write_text(code)
    told = run_pytest(tmp_path)
    assert "1 failed" in told and "loop forever" in told


def test_a_module_and_a_file_can_both_be_asked_for(big, tmp_path):
    code = worldgen("shrink", big, "--out", tmp_path / "small.grid", "--snippet").out
    small = Failure.read(tmp_path / "small.grid")
    assert code == snippet(small)


ROBOT = """
from sim import Command

class Mine:
    def reset(self):
        return ()

    def act(self, seen, memory):
        {}
"""


@pytest.mark.nightly
def test_the_module_passes_once_the_controller_is_repaired(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    corridor = certified(
        World(np.zeros((3, 9), bool), Pose(0.15, 0.15, 0.0), Target(0.75, 0.15, 0.05))
    )
    (tmp_path / "mine.py").write_text(ROBOT.format('raise OSError("no motor")'))
    made = failure_of(corridor, Scenario("./mine.py:Mine"))
    (tmp_path / "test_mine.py").write_text(snippet(made))
    assert "1 failed" in run_pytest(tmp_path)
    (tmp_path / "mine.py").write_text(ROBOT.format("return Command(speed=1.0), memory"))
    assert "1 passed" in run_pytest(tmp_path)


@pytest.mark.parametrize("motion", ["swept", "endpoint", "stepped"])
def test_a_module_is_valid_python_that_carries_the_same_world(motion):
    made = failure_of(
        certified(cup_world()),
        Scenario("turn-right", RunOptions(motion, time_step=0.03)),
        fewest_steps=20_000,
    )
    names = {}
    exec(compile(snippet(made), "test_it.py", "exec"), names)
    assert world_digest(names["FAILURE"]) == world_digest(made.stored)


NAMES = [
    "turn-right",
    "./deep/down/below/mine.py:MyRobotThatHasALongNameOfItsOwn",
    "cmd:./it's mine",
    'cmd:./mine "it"',
]


@pytest.mark.gate
@pytest.mark.parametrize("controller", NAMES)
@pytest.mark.parametrize(
    "parameters", [{}, {"slip": 0.125, "beams": 36, "sensor_range": 0.25, "friction": 0.5}]
)
def test_a_module_is_as_a_formatter_leaves_it_whatever_its_lines_are_allowed(
    controller, parameters, tmp_path
):
    pytest.importorskip("ruff", reason="no formatter here")
    made = failure_of(certified(cup_world()), Scenario("turn-right"), fewest_steps=20_000)
    record = replace(
        made.record, controller=controller, parameters={**made.record.parameters, **parameters}
    )
    (tmp_path / "test_it.py").write_text(snippet(replace(made, record=record)))
    for width in ("88", "120"):
        command = [
            sys.executable,
            "-m",
            "ruff",
            "format",
            "--isolated",
            "--check",
            "--line-length",
            width,
            "test_it.py",
        ]
        subprocess.run(command, cwd=tmp_path, check=True, timeout=60)


@pytest.mark.parametrize(
    ("controller", "says"),
    [
        ("./mine.py:Mine", True),
        ("mine.py:Mine", True),
        ("/a/./mine.py:Mine", False),
        ("cmd:./mine", True),
        ("cmd:python3 ./mine.py", True),
        ("cmd:/a/./mine", False),
        ("turn-right", False),
    ],
)
def test_a_module_says_from_where_a_controller_s_file_is_looked_for(controller, says):
    made = failure_of(certified(cup_world()), Scenario("turn-right"), fewest_steps=20_000)
    text = snippet(replace(made, record=replace(made.record, controller=controller)))
    assert (f"# {controller} is relative to the folder in which pytest is started." in text) == says
