"""Shells complete commands, options, names and classes of the user's files."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROBOT = "class Bouncer:\n    def reset(self): ...\n    def act(self, o, m): ...\n"
FILE = ROBOT + "class Gains: ...\nraise SystemExit('the file was run')\n"
PROGRAM = Path(sys.executable).with_name("worldgen")
CODE = "import sys; sys.argv[0] = 'worldgen'; from worldgen.cli.main import main; main()"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "robot.py").write_text(FILE, "utf-8")
    (tmp_path / "worlds.py").write_text(
        "from worldgen import family\n@family('mine', version=1)\ndef mine(rng): ...\n", "utf-8"
    )
    return tmp_path


def completions(folder, shell, words, current):
    environment = {
        **os.environ, "_WORLDGEN_COMPLETE": f"{shell}_complete",
        "COMP_WORDS": "\n".join(words), "COMP_CWORD": current,
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", CODE], env=environment, cwd=folder, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.stderr == ""
    return done.stdout.splitlines()


def in_bash(folder, *words):
    found = completions(folder, "bash", ["worldgen", *words], str(len(words)))
    return [line.partition(",")[2] for line in found]


@pytest.mark.gate
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["fu"], ["fuzz"]),
        (["corpus", "l"], ["list"]),
        (["run", "w.grid", "--contr"], ["--controller"]),
        (["run", "w.grid", "--controller", "turn-l"], ["turn-left"]),
        (["fuzz", "--family", "maz"], ["maze"]),
        (["run", "w.grid", "--motion", "s"], ["stepped", "swept"]),
        (["fuzz", "--oracle", "det"], ["detour"]),
        (["export", "w.grid", "--to", "mj"], ["mjcf"]),
        (["import", "a.map", "--from", "movi"], ["movingai"]),
        (["controllers", "bug"], ["bug1", "bug2"]),
        (["check-family", "maz"], ["maze"]),
        (["maze", "--algorithm", "wi"], ["wilson"]),
        # The classes of a file that can drive a robot; the file is not run.
        (["run", "w.grid", "--controller", "./rob"], ["./robot.py:Bouncer"]),
        (["run", "w.grid", "--controller", "./robot.py:B"], ["./robot.py:Bouncer"]),
        (["check-family", "./wor"], ["./worlds.py:mine"]),
        # bash gives these in one word if `=` or `:` does not break words there, else in three.
        (["run", "w.grid", "--controller=turn-l"], ["turn-left"]),
        (["run", "w.grid", "--controller", "=", "turn-l"], ["turn-left"]),
        (["fuzz", "--controller", "=", "turn-left", "--family", "=", "maz"], ["maze"]),
        (["run", "w.grid", "--controller", "./robot.py", ":", "B"], ["Bouncer"]),
        (["run", "w.grid", "--controller", "=", "./robot.py", ":"], ["Bouncer"]),
    ],
)
def test_bash_completes_a_word(folder, words, expected):
    assert in_bash(folder, *words) == expected


@pytest.mark.gate
def test_every_name_is_offered_for_an_empty_word(folder):
    names = in_bash(folder, "run", "w.grid", "--controller", "")
    assert {"turn-left", "bug2", "./robot.py:Bouncer"} <= set(names)
    assert "./robot.py:Gains" not in names


@pytest.mark.gate
@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_replace_the_whole_word(folder, shell):
    words = ["worldgen", "run", "w.grid", "--controller=turn-l"]
    current = "3" if shell == "zsh" else words[-1]
    assert "--controller=turn-left" in "\n".join(completions(folder, shell, words, current))


@pytest.mark.gate
def test_a_real_bash_fills_in_the_rest_of_the_line(folder):
    script = """
        eval "$(_WORLDGEN_COMPLETE=bash_source worldgen)"
        complete -p worldgen >/dev/null || exit 9
        fill() {
            COMP_WORDS=("$@")
            COMP_CWORD=$(($# - 1))
            COMPREPLY=()
            _worldgen_completion worldgen
            printf '%s\\n' "${COMPREPLY[*]}"
        }
        fill worldgen fu
        fill worldgen run w.grid --controller turn-l
        fill worldgen run w.grid --controller = turn-l
        fill worldgen fuzz --family = maz
        fill worldgen run w.grid --controller ./robot.py : B
    """
    path = f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "--norc", "-c", script], env={**os.environ, "PATH": path}, cwd=folder,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.split() == ["fuzz", "turn-left", "turn-left", "maze", "Bouncer"]
    assert done.stderr == ""


@pytest.mark.gate
@pytest.mark.parametrize(
    "words", [["ma"], ["run", "w.grid", "--controller", "t"], ["fuzz", "--family", "m"]]
)
def test_completing_a_name_imports_nothing_heavy(folder, words):
    code = f"import atexit\natexit.register(lambda: print('MODULES', *sys.modules))\n{CODE}"
    environment = {
        **os.environ, "_WORLDGEN_COMPLETE": "bash_complete",
        "COMP_WORDS": "\n".join(["worldgen", *words]), "COMP_CWORD": str(len(words)),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", code.replace("import atexit", "import atexit, sys")],
        env=environment, cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    loaded = set(done.stdout.rpartition("MODULES ")[2].split())
    assert loaded and not loaded & {"numpy", "scipy", "shapely", "hypothesis", "PIL", "sim.motion"}
