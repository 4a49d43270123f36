"""Whatever a controller in a shared library does, its run has a verdict with a reason."""

import json
import os
import platform
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest

from build_tools.cores import compiler
from sim import CONTROLLERS, simulate
from sim.controllers.shared.guarded import renew
from sim.controllers.shared.object_file import include_folder
from tests.helpers.command_line import worldgen
from tests.helpers.faulty_library import SOURCE
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate, write_world

pytestmark = pytest.mark.skipif(
    platform.system() != "Linux", reason="elsewhere systems describe some faults in other words"
)

FAULTS = {
    "segfault": "killed by SIGSEGV",
    "aborts": "killed by SIGABRT",
    "exits": "exit code 0",
    "quits": "exit code 3",
    "terminates": "killed by SIGTERM",
    "sends_segv": "killed by SIGSEGV",
    "overflows_stack": "killed by SIGSEGV",
    "smashes_stack": "killed by SIGABRT",
    "writes_before": "it wrote 8 bytes before its memory",
    "writes_state": "it wrote 40 bytes before its memory",
    "writes_further_before": "it wrote 72 bytes before its memory",
    "writes_far_before": "it reached 24000 bytes before its memory",
    "writes_after": "it reached 8 bytes after its memory",
    "writes_far_after": "it reached 799984 bytes after its memory",
    "reads_after": "it reached 8 bytes after its memory",
    "writes_command_before": "it wrote before its command",
    "writes_command_after": "it wrote after its command",
    "complains_nowhere": "killed by SIGSEGV",
    "reset_segfault": "in reset: killed by SIGSEGV",
    "reset_aborts": "in reset: killed by SIGABRT",
    "reset_exits": "in reset: exit code 0",
    "reset_writes_before": "in reset: it wrote 8 bytes before its memory",
    "reset_writes_far_before": "in reset: it reached 24000 bytes before its memory",
    "reset_writes_after": "in reset: it reached 8 bytes after its memory",
    "reset_writes_far_after": "in reset: it reached 799984 bytes after its memory",
}
HANGS = ("never_returns", "sleeps", "stops", "closes_all_and_waits", "reset_never_returns")
HARMLESS = ("closes", "closes_all", "prints", "rounds_up", "traps", "writes_observation")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The library of hostile controllers, by its whole path."""
    made = tmp_path_factory.mktemp("library") / "hostile.so"
    words = [
        "-std=c17",
        "-O1",
        "-fstack-protector-all",
        "-shared",
        "-fPIC",
        f"-I{include_folder()}",
    ]
    source = SOURCE.with_name("hostile.c")
    subprocess.run([*compiler(), *words, str(source), "-o", str(made), "-lm"], check=True)
    return made


def maze():
    return generate("maze", 3, size=20)


@pytest.mark.parametrize(("name", "error"), FAULTS.items(), ids=FAULTS)
def test_a_fault_is_a_crash_with_its_reason_and_the_same_digest_twice(name, error, library):
    first, second = (simulate(maze(), f"lib:{library}:{name}") for _ in range(2))
    assert (first.verdict, first.evidence.error) == ("crash", error)
    assert (first.steps, first.trace_digest) == (second.steps, second.trace_digest)


def test_a_debugger_finds_the_fault_in_the_process_that_it_started(library, tmp_path):
    write_world(maze(), tmp_path / "w.grid")
    words = ["run", tmp_path / "w.grid", "--controller", f"lib:{library}:segfault"]
    done = subprocess.run(
        [sys.executable, "-m", "worldgen", *words],
        env={**os.environ, "WORLDGEN_DEBUG": "debugger"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == -signal.SIGSEGV


@pytest.mark.parametrize("name", ["says_nan", "says_inf"])
def test_a_number_that_is_not_finite_is_an_invalid_command(name, library):
    assert simulate(maze(), f"lib:{library}:{name}").verdict == "invalid-command"


@pytest.mark.parametrize("name", HARMLESS)
def test_what_does_no_harm_changes_no_bit(name, library, capfd):
    plain, changed = (simulate(maze(), f"lib:{library}:{one}") for one in ("behaves", name))
    assert (plain.verdict, plain.trace_digest) == (changed.verdict, changed.trace_digest)
    assert not capfd.readouterr().out


def test_an_exception_of_long_ago_is_not_raised_by_a_library_that_traps(library):
    """x87 arithmetic keeps its exceptions, and a new process inherits them."""
    renew()
    assert np.longdouble(1) / np.longdouble(3) > 0
    assert simulate(maze(), f"lib:{library}:traps").verdict == "loop"


@pytest.mark.parametrize("name", ["prints", "prints_part", "prints_and_faults", "reset_prints"])
def test_what_a_library_prints_goes_to_stderr(name, library, capfd):
    # A process from an earlier test has another standard error.
    renew()
    simulate(maze(), f"lib:{library}:{name}")
    printed = capfd.readouterr()
    assert (printed.out, "on stdout" in printed.err) == ("", True)


def test_what_this_process_has_not_written_yet_is_written_once(library):
    code = (
        "import ctypes; from sim import simulate; from worldgen import generate;"
        "ctypes.CDLL(None).printf(b'ours ');"
        f"simulate(generate('trap', 1, size=20), 'lib:{library}:behaves')"
    )
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("ours ", "")


@pytest.mark.parametrize("name", ["reset_prints", "reset_says_nan"])
def test_a_reset_that_does_no_harm_runs(name, library, capfd):
    assert simulate(maze(), f"lib:{library}:{name}").verdict == "loop"
    assert not capfd.readouterr().out


@pytest.mark.gate
@pytest.mark.parametrize("name", HANGS)
def test_an_endless_call_is_a_hang(name, library):
    episode = simulate(maze(), f"lib:{library}:{name}")
    assert episode.verdict == "hang"
    assert episode.evidence.error.removeprefix("in reset: ") == "no answer"


@pytest.mark.parametrize("name", ["bursts", pytest.param("ponders", marks=pytest.mark.gate)])
def test_a_library_that_fails_when_it_is_asked_is_refused(name, library):
    with raises(InvalidParameter, "cannot-load"):
        CONTROLLERS.get(f"lib:{library}:{name}")


def test_a_description_that_changes_does_not_change_the_memory(library):
    runs = {simulate(maze(), f"lib:{library}:grow", steps=500).trace_digest for _ in range(3)}
    assert len(runs) == 1


@pytest.mark.parametrize("name", ["behaves", "rounds_up", "writes_observation"])
def test_robots_of_a_fleet_drive_as_in_this_process(name, library, monkeypatch):
    world = generate("rooms", 3, robots=3)
    run = simulate(world, f"lib:{library}:{name}", steps=1000)
    monkeypatch.setattr("sim.controllers.shared.guarded.can_fork", False)
    alone = simulate(world, f"lib:{library}:behaves", steps=1000)
    assert [one.trace_digest for one in run.robots] == [one.trace_digest for one in alone.robots]


@pytest.mark.parametrize("name", ["segfault", "writes_before", "writes_after", "reset_segfault"])
def test_a_fault_of_a_robot_of_a_fleet_is_its_crash(name, library):
    world = generate("rooms", 3, robots=3)
    run = simulate(world, f"lib:{library}:{name}", steps=1000)
    errors = [one.evidence.error for one in run.robots if one.verdict == "crash"]
    assert run.verdict == "crash" and errors == [FAULTS[name]]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("writes_before", "crash"),
        ("reset_aborts", "crash"),
        pytest.param("segfault", "crash", marks=pytest.mark.nightly),
        pytest.param("exits", "crash", marks=pytest.mark.nightly),
        pytest.param("writes_far_after", "crash", marks=pytest.mark.nightly),
        pytest.param("reset_writes_before", "crash", marks=pytest.mark.nightly),
        pytest.param("says_nan", "invalid-command", marks=pytest.mark.nightly),
        pytest.param("never_returns", "hang", marks=pytest.mark.nightly),
    ],
)
def test_every_command_survives_it(name, verdict, library, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(library, "robot.so")
    controller = f"lib:./robot.so:{name}"
    write_world(maze(), tmp_path / "w.grid")
    run = worldgen("run", "w.grid", "--controller", controller, "--json")
    assert (run.code, json.loads(run.out)["verdict"]) == (1, verdict)
    # Each world that is tried for a hang takes the whole deadline of a step, and shrinking tries
    # hundreds of worlds.
    whole, budget = (("--no-shrink",), ("--budget", "5s")) if verdict == "hang" else ((), ())
    campaign = ("--units", 1, "--examples", 3, "--seed", 1, "--workers", 1, *whole)
    fuzz = worldgen("fuzz", "--controller", controller, *campaign, "--out", "found", "--json")
    files = [one["file"] for one in json.loads(fuzz.out)["failures"] if one["verdict"] == verdict]
    assert fuzz.code == 1 and files
    kinds = [
        worldgen("replay", files[0]),
        worldgen("shrink", files[0], "--out", "small.grid", *budget),
        worldgen("explain", files[0]),
        worldgen("compare", "w.grid", "--controller", controller, "--controller", "turn-right"),
    ]
    assert all(one.code in (0, 1) and "bug in" not in one.err for one in kinds)
