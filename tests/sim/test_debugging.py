"""What a user sees when debugging a controller:

the line that raised, the contract, transcripts, hints.
"""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from sim.controllers import CONTROLLERS
from sim.controllers.programs.program import WantsMemory
from sim.episode import simulate
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate, write_world

SERVE = """
import json, os, sys
step = 0
for line in sys.stdin:
    if "reset" in json.loads(line):
        step = 0
        continue
    step += 1
    if step == {step}:
        {do}
    print(json.dumps({{"speed": 1.0, "turn_rate": 0.0}}), flush=True)
"""


@pytest.fixture
def world_file(tmp_path):
    path = tmp_path / "w.grid"
    write_world(generate("trap", 4, size=20), path)
    return path


def python_class(folder, body):
    lines = "\n".join(f"        {line}" for line in body.splitlines())
    path = folder / "mine.py"
    path.write_text(
        f"from sim import Command\n\n\nclass Mine:\n    def reset(self):\n        return (0.0,)\n\n"
        f"    def act(self, o, m):\n{lines}\n"
    )
    return f"{path}:Mine"


def program(folder, do, step=3):
    path = folder / "mine.py"
    path.write_text(SERVE.format(do=do, step=step))
    return f"cmd:{sys.executable} {path}"


def test_run_prints_the_line_that_raised(world_file, tmp_path):
    name = python_class(tmp_path, "return 1 / m[0]")
    result = worldgen("run", world_file, "--controller", name)
    assert (result.code, result.out.splitlines()[1:]) == (
        1,
        ["  mine.py:9 in act: return 1 / m[0]"],
    )


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("return Command(1.0, 0.0)", "act returned a command without a memory"),
        ("pass", "act returned nothing"),
        ("return Command(1.0, 0.0), [0.0]", "the memory is not a tuple of numbers"),
        ("return Command(1.0, 0.0), (0.0, 1.0)", "the memory had 1 numbers and now has 2"),
        ("return 1.0, (0.0,)", "act did not return a command"),
    ],
)
def test_a_controller_that_breaks_the_contract_at_once_is_an_error_of_usage(
    body, words, world_file, tmp_path
):
    result = worldgen("run", world_file, "--controller", python_class(tmp_path, body))
    assert result.code == 2 and words in result.err and result.out == ""


def test_fuzz_refuses_a_controller_that_breaks_the_contract_at_once(tmp_path):
    name = python_class(tmp_path, "return Command(1.0, 0.0)")
    result = worldgen(
        "fuzz", "--controller", name, "--units", 1, "--seed", 1, "--out", tmp_path / "out"
    )
    assert result.code == 2 and "return Command(speed, turn_rate), memory" in result.err


def test_a_branch_that_forgets_the_memory_is_a_failure_where_it_is_taken(world_file, tmp_path):
    body = "if m[0] > 5:\n    return Command(1.0, 0.0)\nreturn Command(1.0, 0.0), (m[0] + 1,)"
    result = worldgen("run", world_file, "--controller", python_class(tmp_path, body), "--json")
    found = json.loads(result.out)
    assert (result.code, found["verdict"], found["steps"]) == (1, "invalid-command", 7)
    assert found["evidence"]["error"] == "act returned a command without a memory"


def test_a_transcript_repeats_the_crash_outside_the_simulator(world_file, tmp_path):
    name = program(tmp_path, "sys.exit('no plan')")
    result = worldgen("run", world_file, "--controller", name, "--transcript", tmp_path / "t.jsonl")
    lines = (tmp_path / "t.jsonl").read_bytes()
    command = [sys.executable, tmp_path / "mine.py"]
    again = subprocess.run(command, input=lines, capture_output=True, check=False)
    assert result.code == 1 and b"no plan" in again.stderr and again.stdout.count(b"\n") == 2
    assert lines.count(b"\n") == 4  # a reset and three observations


def test_a_transcript_holds_the_last_episode_only(tmp_path):
    world = generate("trap", 4, size=20)
    controller = CONTROLLERS.get(program(tmp_path, "pass"))
    with (tmp_path / "t.jsonl").open("wb") as out, controller.transcript(out):
        for _ in range(2):
            simulate(world, controller, steps=5)
    controller.close()
    lines = (tmp_path / "t.jsonl").read_text().splitlines()
    assert len(lines) == 6 and "reset" in json.loads(lines[0])


def test_a_transcript_of_a_class_is_refused(world_file, tmp_path):
    name = python_class(tmp_path, "return Command(), m")
    result = worldgen("run", world_file, "--controller", name, "--transcript", tmp_path / "t.jsonl")
    assert result.code == 2 and "sim.host" in result.err


def test_a_program_that_cannot_reserve_its_memory_at_the_start_gets_the_option_that_it_needs(
    tmp_path,
):
    said = (
        "==7==ERROR: AddressSanitizer failed to allocate; ReserveShadowMemoryRange failed while "
        "trying"
    )
    name = program(tmp_path, f"sys.exit({said!r})", step=1)
    with (
        CONTROLLERS.get(name) as controller,
        pytest.raises(WantsMemory, match=r"cmd\+memory=none:"),
    ):
        simulate(generate("trap", 4, size=20), controller, steps=5)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("./robot", "write 'cmd:./robot'"),
        ("robot", "write 'cmd:./robot'"),
        ("./robot --fast", "write 'cmd:./robot --fast'"),
        ("sh robot", "write 'cmd:sh robot'"),
        ("mine.py", "it has Mine; name a class, such as mine.py:Mine"),
        ("./robot:main", "./robot is not a Python file"),
        ("cmd:robot", "write ./robot"),
    ],
)
def test_a_program_without_cmd_gets_the_hint_that_it_needs(name, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot").write_text("#!/bin/sh\n")
    (tmp_path / "robot").chmod(0o755)
    python_class(tmp_path, "return Command(), m")
    with pytest.raises(InvalidParameter) as refused:
        CONTROLLERS.get(name)
    assert words in str(refused.value)


def test_an_option_of_programs_behind_another_controller_gets_the_hint_that_it_needs():
    with raises(InvalidParameter, "option-misplaced", name="memory", controller="./robot"):
        Scenario.parse("./robot+memory=4G")


@pytest.mark.parametrize(
    "command",
    [("run",), ("fuzz", "--units", 1, "--seed", 1, "--workers", 1)],
    ids=lambda command: command[0],
)
def test_leaving_the_debugger_ends_the_command_as_ctrl_c_does(world_file, tmp_path, command):
    name = python_class(tmp_path, "import bdb\nraise bdb.BdbQuit")
    where = ("--world", world_file, "--out", tmp_path / "f") if command[0] == "fuzz" else ()
    words = (*command, *(where or (world_file,)), "--controller", name)
    result = worldgen(*words)
    assert result.code == 130, result
    assert "BdbQuit" not in result.out + result.err


def test_leaving_the_debugger_at_a_breakpoint_is_no_verdict(world_file, tmp_path):
    name = python_class(tmp_path, "breakpoint()\nreturn Command(0.0, 0.0), m")
    words = [sys.executable, "-m", "worldgen", "run", world_file, "--controller", name]
    done = subprocess.run(words, input="q\n", capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.endswith("interrupted\n")
