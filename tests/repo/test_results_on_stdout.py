"""Whatever a user's code prints, stdout has a command's own results and nothing else."""

import json
import shutil
import subprocess
import sys

import click
import pytest

from build_tools.cores import compiler
from sim.controllers.shared.object_file import include_folder
from worldgen import generate, write_world
from worldgen.cli.main import cli
from worldgen.family import FAMILIES

NOISY = '''
import atexit, ctypes, itertools, os, subprocess, sys

import numpy as np

from worldgen.family import check_between, family
from worldgen.world import Pose, Target, World

libc = ctypes.CDLL(None)


def noise(where):
    print("NOISE print", where)
    sys.stdout.write(f"NOISE write {where}\\n")
    sys.__stdout__.write(f"NOISE __stdout__ {where}\\n")
    os.write(1, f"NOISE descriptor {where}\\n".encode())
    libc.printf(b"NOISE printf\\n")


noise("import")
subprocess.run(["echo", "NOISE child"])
atexit.register(noise, "exit")


class Noisy:
    def __init__(self):
        noise("init")

    def reset(self):
        noise("reset")
        return (0.0,)

    def act(self, observation, memory):
        if memory[0] == 0.0:
            noise("act")
        return (1.0, 1.5), (1.0,)


class Dog:
    def reset(self):
        noise("dog")

    def step(self, observation):
        return False


@family("noisy", version=1)
def noisy(rng, *, size: int = 12) -> World:
    """Build a hall with a pillar.

    Args:
        size: Cells per side.
    """
    noise("family")
    check_between("size", size, 12, 12)
    walls = np.zeros((12, 12), bool)
    walls[6, 1 + rng.below(10)] = True
    return World(walls, Pose(0.2, 0.2), Target(1.0, 1.0, 0.05))


def oracle(trial):
    """Object to nothing."""
    noise("oracle")

'''
LIBRARY = """
#include <stdio.h>
#include <unistd.h>
#include "worldgen_controller.h"
static void noisy(const WgObservation *observation, double *memory, WgCommand *command)
{
    if (memory[0] == 0.0) {
        memory[0] = 1.0;
        printf("NOISE printf\\n");
        if (write(1, "NOISE print\\n", 12) < 0) {
            command->error = "Full: stdout is full";
        }
    }
    command->speed = 1.0;
    command->turn_rate = 1.5;
}
WG_CONTROLLER(noisy, .memory_size = 1)
"""
PROGRAM = """
import json, sys
print("NOISE program", file=sys.stderr)
for line in sys.stdin:
    if "reset" not in json.loads(line):
        print(json.dumps({"speed": 1.0, "turn_rate": 1.5}), flush=True)
"""
MINE = ("--controller", "./noisy.py:Noisy")
SEARCH = (
    *MINE,
    "--family",
    "trap",
    "--units",
    "1",
    "--examples",
    "3",
    "--no-shrink",
    "--seed",
    "1",
    "--out",
)

# By leaf command: what makes it run code of a user's; None if nothing does.
COMMANDS = {
    "audit": None,
    "behaviours": None,
    "boundary": ("w.grid", *MINE, "--axis", "heading"),
    "check-family": ("./noisy.py:noisy",),
    "compare": ("w.grid", "--controller", "./noisy.py:Noisy,turn-left"),
    "controllers": ("./noisy.py:Noisy",),
    "corpus diff": None,
    "corpus export": ("found", "--out", "found.zip"),
    "corpus list": None,
    "corpus merge": None,
    "corpus prune": ("found",),
    "corpus show": ("found",),
    "demo": (*MINE, "--motion", "swept", "--out", "demo"),
    "explain": ("found",),
    "export": None,
    "families": None,
    "find": (
        "--outcome",
        "./noisy.py:Noisy=loop",
        "--budget",
        "2s",
        "--seed",
        "1",
        "--out",
        "x.grid",
    ),
    "formats": None,
    "fuzz": (*SEARCH, "again", "--workers", "2", "--oracle", "./noisy.py:oracle"),
    "import": None,
    "help": None,
    "init": (*MINE, "--units", "1"),
    "measure": None,
    "new-controller": None,
    "oracles": None,
    "regenerate": ("set", "--family", "./noisy.py:noisy", "--out", "other"),
    "replay": ("found",),
    "report": ("found", "--out", "r.html"),
    "run": ("w.grid", *MINE),
    "show": None,
    "shrink": ("found/*.grid", "--out", "s.grid"),
    "studio": None,
    "train": None,
    "verify": None,
    "watchdog": ("./noisy.py:Dog", "found", "--worlds", "1"),
}


def worldgen(folder, *words):
    command = [sys.executable, "-m", "worldgen", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a world, noisy code, its failures and a set of its family."""
    folder = tmp_path_factory.mktemp("noisy")
    (folder / "noisy.py").write_text(NOISY)
    (folder / "program.py").write_text(PROGRAM)
    for words in (
        ("trap", "--size", "20", "--seed", "4", "--out", "w.grid"),
        ("fuzz", *SEARCH, "found", "--workers", "1"),
        ("./noisy.py:noisy", "--count", "2", "--seed", "1", "--out", "set"),
    ):
        done = worldgen(folder, *words)
        assert done.returncode in (0, 1) and "NOISE" not in done.stdout, done
    return folder


@pytest.fixture
def folder(made, tmp_path):
    return shutil.copytree(made, tmp_path / "copy")


def leaves(command, path=()):
    """Yield the names of all commands below a group."""
    if not isinstance(command, click.Group):
        yield " ".join(path)
        return
    context = click.Context(command)
    for name in command.list_commands(context):
        yield from leaves(command.get_command(context, name), (*path, name))


def test_every_command_says_whether_it_runs_code_of_a_user():
    named = set(leaves(cli))
    assert named - set(FAMILIES.names()) == set(COMMANDS)


# Whole products, with shrinking.
LONG = ("demo", "init")


@pytest.mark.gate
@pytest.mark.parametrize(
    "command",
    [
        pytest.param(name, marks=pytest.mark.nightly if name in LONG else ())
        for name, words in COMMANDS.items()
        if words
    ],
)
@pytest.mark.parametrize("more", [[], ["--json"]], ids=["text", "json"])
def test_what_code_of_a_user_prints_goes_to_stderr(command, more, folder):
    # The folder is a copy, so its code has not run there before.
    words = [*command.split(), "--trust", *COMMANDS[command], *more]
    done = worldgen(folder, *(str(next(folder.glob(one))) if "*" in one else one for one in words))
    if "no option --json" in done.stderr:
        pytest.skip("it has no --json")
    assert done.returncode in (0, 1), done
    assert "NOISE" not in done.stdout
    # With --json, some commands need no code for what they print.
    if more:
        json.loads(done.stdout)
    else:
        assert "NOISE print" in done.stderr and "NOISE printf" in done.stderr


@pytest.fixture
def kinds(tmp_path):
    """A folder with a world, and a controller of each kind that prints."""
    (tmp_path / "noisy.py").write_text(NOISY)
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "noisy.c").write_text(LIBRARY)
    words = ["-std=c17", "-shared", "-fPIC", f"-I{include_folder()}", "noisy.c", "-o", "noisy.so"]
    subprocess.run([*compiler(), *words], cwd=tmp_path, check=True)
    write_world(generate("trap", 4, size=20), tmp_path / "w.grid")
    return tmp_path


@pytest.mark.gate
def test_the_json_of_a_run_is_readable_whatever_its_controllers_print(kinds):
    program = f"cmd:{sys.executable} program.py"
    names = ["./noisy.py:Noisy", "lib:./noisy.so:noisy", program]
    controllers = [word for name in names for word in ("--controller", name)]
    done = worldgen(kinds, "compare", "w.grid", *controllers, "--json")
    assert len(json.loads(done.stdout)["controllers"]) == 3
    assert "NOISE printf" in done.stderr and "NOISE child" in done.stderr


def test_a_result_that_is_written_to_dev_stdout_is_a_result(tmp_path):
    words = ("trap", "--size", "20", "--seed", "4", "--out")
    named = worldgen(tmp_path, *words, "/dev/stdout")
    worldgen(tmp_path, *words, "w.grid")
    assert named.stdout == (tmp_path / "w.grid").read_text()


def test_a_reader_that_has_enough_ends_the_command_without_a_fault(tmp_path):
    line = f"{sys.executable} -m worldgen maze --size 400 --seed 1 --no-metrics"
    words = ["bash", "-c", f"{line} | head -1; exit ${{PIPESTATUS[0]}}"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "%worldgen-grid 1\n")


@pytest.mark.gate
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_a_closed_stream_changes_no_exit_code(closed, tmp_path):
    line = f"{sys.executable} -m worldgen trap --size 20 --seed 4 {closed}"
    done = subprocess.run(["sh", "-c", line], cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0


def test_in_library_use_only_the_library_s_user_prints_to_stdout(tmp_path):
    (tmp_path / "chatty.py").write_text(
        "print('NOISE import')\n\n\nclass Robot:\n"
        "    def __init__(self):\n        print('NOISE init')\n\n"
        "    def reset(self):\n        print('NOISE reset')\n        return ()\n\n"
        "    def act(self, observation, memory):\n        print('NOISE act')\n"
        "        return (1.0, 0.0), ()\n"
    )
    code = (
        "from sim import simulate; from worldgen import generate; print('before');"
        "simulate(generate('trap', 1, size=20), './chatty.py:Robot', steps=2); print('after')"
    )
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == "before\nafter\n"
    for place in ("import", "init", "reset", "act"):
        assert f"NOISE {place}" in done.stderr
