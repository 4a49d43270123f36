"""Wrong commands as first-time users type them, each with the command that is suggested."""

import shlex

import click
import pytest

from tests.helpers.command_line import worldgen
from worldgen.cli.command_parts import first_fault
from worldgen.cli.main import cli
from worldgen.cli.names import MOTIONS

ROBOT = """\
from sim import Command


class {name}:
    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(), memory
"""

# The words of a command, and those that correct it. They are refused while they are parsed.
PARSED = {
    # A word that belongs to an option, or to none.
    "fuzz turn-right": "fuzz --controller turn-right --out failures/",
    "fuzz ./robot.py:Bouncer": "fuzz --controller ./robot.py:Bouncer --out failures/",
    "fuzz robot.py": "fuzz --controller robot.py:Bouncer --out failures/",
    "fuzz w.grid --controller turn-left": "fuzz --controller turn-left --world w.grid --out failures/",
    "fuzz --controller turn-left maze": "fuzz --controller turn-left --family maze --out failures/",
    "fuzz controller=turn-left": "fuzz --controller turn-left --out failures/",
    "maze 60": "maze --size 60",
    "maze size=60": "maze --size 60",
    "maze new.grid": "maze --out new.grid",
    "maze --size 60 60": "maze --size 60",
    "run w.grid turn-right": "run w.grid --controller turn-right",
    "run turn-right w.grid": "run w.grid --controller turn-right",
    "run turn-right": "run w.grid --controller turn-right",
    "run w.grid --controller turn right": "run w.grid --controller turn-right",
    "show w.grid out.png": "show w.grid",
    "boundary w.grid radius": "boundary w.grid --axis radius",
    "export w.grid ros": "export w.grid --to ros --out office.yaml",
    "export w.grid out.yaml": "export w.grid --out out.yaml",
    "import map.png new.grid": "import map.png --out new.grid",
    "report fails out.html": "report fails --out out.html",
    "corpus export fails out.csv": "corpus export fails --out out.csv",
    "compare w.grid turn-right bug2": "compare w.grid --controller turn-right --controller bug2",
    "new-controller mine c": "new-controller mine --kind c",
    "init . turn-right": "init . --controller turn-right",
    "demo turn-right": "demo --controller turn-right",
    "families maze": "families",
    # Options and arguments that are missing, or have no value.
    "fuzz": "fuzz --controller turn-right --out failures/",
    "fuzz --controller turn-left": "fuzz --controller turn-left --out failures/",
    "fuzz --controller robot.py": "fuzz --controller robot.py:Bouncer --out failures/",
    "run w.grid": "run w.grid --controller turn-right",
    "run w.grid --controller": "run w.grid --controller turn-right",
    "run w.grid --controller turn-left --picture":
        "run w.grid --controller turn-left --picture run.png",
    "run --controller turn-left": "run w.grid --controller turn-left",
    "fuzz --controller turn-left --out o --budget":
        "fuzz --controller turn-left --out o --budget 30s",
    "fuzz --resume": "fuzz --resume fails",
    "maze --out": "maze --out w-2.grid",
    "maze --count 3": "maze --count 3 --out worlds/",
    "replay": "replay fails",
    "verify": "verify w.grid",
    "verify --radius 0.2": "verify w.grid --radius 0.2",
    "show": "show w.grid",
    "audit w.grid": "audit w.grid track.csv",
    "report": "report fails --out report.html",
    "corpus list": "corpus list fails",
    "corpus merge fails": "corpus merge fails --out baseline/",
    "compare w.grid --controller": "compare w.grid --controller turn-left,turn-right",
    "boundary w.grid": "boundary w.grid --axis radius",
    "train w.grid": "train w.grid --out taught.json",
    "new-controller": "new-controller mine",
    "check-family": "check-family warehouse",
    # Options that do not exist here, or are spelt otherwise.
    "fuzz --controller turn-left -n 10": "fuzz --controller turn-left --units 10 --out failures/",
    "fuzz --controller turn-left -o out": "fuzz --controller turn-left --out out",
    "fuzz --controller turn-left --jobs 4 --out o": "fuzz --controller turn-left --workers 4 --out o",
    "fuzz --controller turn-left --timeout 60 --out o":
        "fuzz --controller turn-left --budget 60 --out o",
    "fuzz --controller turn-left --families maze --out o":
        "fuzz --controller turn-left --family maze --out o",
    "fuzz -controller turn-left -out o": "fuzz --controller turn-left --out o",
    "fuzz --controller: turn-left --out o": "fuzz --controller turn-left --out o",
    "maze -n 10": "maze --count 10 --out worlds/",
    "maze -o new.grid": "maze --out new.grid",
    "maze --output new.grid": "maze --out new.grid",
    "maze --width 60 --height 60": "maze --size 60",
    "maze --size60": "maze --size 60",
    "maze --robot_radius 0.1": "maze --radius 0.1",
    "run w.grid -c turn-left": "run w.grid --controller turn-left",
    "run w.grid --controllers turn-left": "run w.grid --controller turn-left",
    "run w.grid --controller turn-left --time_step 0.1":
        "run w.grid --controller turn-left --time-step 0.1",
    "run w.grid --controller turn-left --png a.png":
        "run w.grid --controller turn-left --picture a.png",
    "run w.grid --controller turn-left --out a.png":
        "run w.grid --controller turn-left --picture a.png",
    "run w.grid --controller turn-left --budget 10s": "run w.grid --controller turn-left",
    "run w.grid --controller turn-left --fast": "run w.grid --controller turn-left",
    "run w.grid --controller turn-left --json=yes": "run w.grid --controller turn-left --json",
    "run w.grid --controller turn-left --controller bug2":
        "compare w.grid --controller turn-left --controller bug2",
    "export w.grid --format ros --out x.yaml": "export w.grid --to ros --out x.yaml",
    "--seed 3 maze": "maze --seed 3",
    "--controller turn-left fuzz": "fuzz --controller turn-left --out failures/",
    "fuzz --controller turn-left --units 1 --budget 1s --out o":
        "fuzz --controller turn-left --units 1 --out o",
    # Values of another form.
    "fuzz --controller turn-left --family maze,trap --out o":
        "fuzz --controller turn-left --family maze --family trap --out o",
    "fuzz --controller turn-left --oracle turn,mirror --out o":
        "fuzz --controller turn-left --oracle turn --oracle mirror --out o",
    "fuzz --controller turn-left --budget 1min --out o":
        "fuzz --controller turn-left --budget 1m --out o",
    "fuzz --controller turn-left --budget '90 sec' --out o":
        "fuzz --controller turn-left --budget 90s --out o",
    "fuzz --controller turn-left --units ten --out o":
        "fuzz --controller turn-left --units 20 --out o",
    "maze --size 60x60": "maze --size 60",
    "maze --size 60,60": "maze --size 60",
    "maze --size big": "maze --size 30",
    "maze --size": "maze --size 30",
    "trap --shape X": "trap --shape U",
    "run w.grid --controller turn-left --time-step 0,1":
        "run w.grid --controller turn-left --time-step 0.1",
    "compare w.grid": "compare w.grid --controller turn-left,turn-right",
    "fuzz --controller turn-left --world wg.grid":
        "fuzz --controller turn-left --world w.grid --out failures/",
    "train w.grid new.json": "train w.grid --out new.json",
    "report fail": "report fails --out report.html",
    "import mpa.png": "import map.png --out w-2.grid",
    "maze --seed abc": "maze --seed 7",
    "maze --seed -1": "maze --seed 0",
    "maze --seed 0x10": "maze --seed 16",
    "maze --count 0 --out s": "maze --count 1 --out s",
    "maze --algorithm Wilson": "maze --algorithm wilson",
    "maze --algorithm hunt_and_kill": "maze --algorithm hunt-and-kill",
    "trap --shape u": "trap --shape U",
    "run w.grid --controller turn-left --steps 1e4":
        "run w.grid --controller turn-left --steps 10000",
    "run w.grid --controller turn-left --steps 10k":
        "run w.grid --controller turn-left --steps 10000",
    "verify w.grid --radius 10cm": "verify w.grid --radius 0.1",
    "studio --port 99999": "studio --port 65535",
    "boundary w.grid --axis radii": "boundary w.grid --axis radius",
    # Commands that do not exist.
    "run help": "run --help",
    "run -help": "run --help",
    "version": "--version",
    "-V": "--version",
    "-version": "--version",
    "--versions": "--version",
    "--hlep": "--help",
    "mazes": "maze",
    "MAZE --size 20": "maze --size 20",
    "generate maze --size 20": "maze --size 20",
    "make maze": "maze",
    "w.grid": "show w.grid",
    "robot.py": "run w.grid --controller robot.py:Bouncer",
    "check_family maze": "check-family maze",
    "newcontroller mine": "new-controller mine",
    "behaviors": "behaviours",
    "corpus ls fails": "corpus list fails",
    "corpus fails": "corpus list fails",
    # Fields of --only.
    "corpus prune fails --controller wall-right":
        "corpus prune fails --only controller=wall-right",
    "fuzz --controller turn-left --detour 3 --oracle turn":
        "fuzz --controller turn-left --oracle detour=3 --oracle turn --out failures/",
    "fuzz --controller turn-left --oracle detuor=3":
        "fuzz --controller turn-left --oracle detour=3 --out failures/",
    "corpus list fails --verdict stalled": "corpus list fails --only verdict=stalled",
    "corpus list fails --verdict=loop --cause 'circles-*'":
        "corpus list fails --only verdict=loop --only 'cause=circles-*'",
}  # fmt: skip

# These are refused by the command itself.
NAMED = {
    "run w.grid --controller turn-rigth": "run w.grid --controller turn-right",
    "run w.grid --controller=Turn_Right": "run w.grid --controller=turn-right",
    "run w.grid --controller robot:Bouncer": "run w.grid --controller ./robot.py:Bouncer",
    "run w.grid --controller robot.py": "run w.grid --controller robot.py:Bouncer",
    "run w.grid --controller ./robot.py:bouncer": "run w.grid --controller ./robot.py:Bouncer",
    "run w.grid --controller ./robot.py:Other": "run w.grid --controller ./robot.py:Bouncer",
    "run w.grid --controller ./rebot.py:Bouncer": "run w.grid --controller ./robot.py:Bouncer",
    "run w.grid --controller Bouncer": "run w.grid --controller ./robot.py:Bouncer",
    "compare w --controller turn-left,bouncer":
        "compare w.grid --controller turn-left,./robot.py:Bouncer",
    "run w --controller bouncer": "run w.grid --controller ./robot.py:Bouncer",
    "run w.grid --controller bouncer": "run w.grid --controller ./robot.py:Bouncer",
    "run w.grid --controller ./prog.sh": "run w.grid --controller cmd:./prog.sh",
    "run w.grid --controller prog.sh": "run w.grid --controller cmd:./prog.sh",
    "run w.grid --controller turn-left,bug2": "compare w.grid --controller turn-left,bug2",
    "run w.grid --controller behaviours:avoid,folow":
        "run w.grid --controller behaviours:avoid,follow",
    "run w.grid --controller turn-left+slp=0.1": "run w.grid --controller turn-left+slip=0.1",
    "run w.grid --controller turn-left --motion sweep":
        "run w.grid --controller turn-left --motion swept",
    "run w.grid --controller turn-left --motion SWEPT":
        "run w.grid --controller turn-left --motion swept",
    "run w.grid --controller turn-left --picture a.jpg":
        "run w.grid --controller turn-left --picture a.png",
    "run w.grid --controller turn-left --steps 0": "run w.grid --controller turn-left --steps 1",
    "run w --controller turn-left": "run w.grid --controller turn-left",
    "run w.gird --controller turn-left": "run w.grid --controller turn-left",
    "run maze --controller turn-left": "run w.grid --controller turn-left",
    "compare w.grid --controller turn-left bug2":
        "compare w.grid --controller turn-left --controller bug2",
    "verify *.gird": "verify w.grid",
    "audit fails fails/loop.grid": "audit fails/loop.grid fails/loop.grid",
    "maze --seed 1 --size 1": "maze --seed 1 --size 10",
    "maze --seed 1 --out w.grid": "maze --seed 1 --out w-2.grid",
    "export w.grid --to rso --out x.yaml": "export w.grid --to ros --out x.yaml",
    "formats rso": "formats ros",
    "controllers turn-rihgt": "controllers turn-right",
    "check-family maz": "check-family maze",
    "boundary w.grid --axis radius": "boundary w.grid --axis radius --controller turn-right",
    "fuzz --controller turn-left --family mazes --units 1 --seed 1 --out o":
        "fuzz --controller turn-left --family maze --units 1 --seed 1 --out o",
    "fuzz --controller turn-left --oracle detuor --units 1 --seed 1 --out o":
        "fuzz --controller turn-left --oracle detour --units 1 --seed 1 --out o",
}  # fmt: skip

# No command can be guessed for these, so the message alone says what to do.
UNCLEAR = [
    "run w.grid --controller ./a.out",
    "run w.grid --controller cmd:./a.out",
    "run w.grid --controller ./no_class.py",
    "fuzz --controller turn-left --strategy random --units 1 --seed 1 --out o",
    "run missing/else.grid --controller turn-left",
    "import robt.png",
    "import robt.png --out x.grid",
    "fuzz --controller ./a.out",
    "fuzz --controller turn-left,nope.py",
    "report nothing-like-it",
    "explain w.grid",
]


@pytest.fixture(autouse=True)
def beginner(tmp_path_factory, monkeypatch):
    """A folder as a first-time user has it: a world, two robots, a program, failures."""
    folder = tmp_path_factory.getbasetemp() / "beginner"
    if not folder.is_dir():
        folder.mkdir()
        made = worldgen("trap", "--size", 14, "--seed", 1, "--out", folder / "w.grid")
        assert made.code == 0
        (folder / "robot.py").write_text(ROBOT.format(name="Bouncer"), "utf-8")
        (folder / "no_class.py").write_text("def help():\n    pass\n", "utf-8")
        (folder / "prog.sh").write_text("#!/bin/sh\n", "utf-8")
        (folder / "track.csv").write_text("t,x,y,heading\n", "utf-8")
        (folder / "map.png").write_bytes(b"")
        (folder / "fails").mkdir()
        (folder / "fails" / "loop.grid").write_bytes((folder / "w.grid").read_bytes())
    monkeypatch.chdir(folder)


def check(command, expected):
    result = worldgen(*shlex.split(command))
    lines = result.err.splitlines()
    assert result.code == 2, result
    assert 1 <= len(lines) <= 3 and "Traceback" not in result.err
    assert lines[-1] == f"  worldgen {expected}"
    assert first_fault(cli, shlex.split(expected)) is None


@pytest.mark.parametrize("command", list(PARSED)[::4])
def test_a_wrong_command_is_answered_with_the_right_one(command):
    check(command, PARSED[command])


@pytest.mark.gate
@pytest.mark.parametrize("command", list(PARSED))
def test_every_wrong_command_is_answered_with_the_right_one(command):
    check(command, PARSED[command])


@pytest.mark.gate
@pytest.mark.parametrize("command", NAMED)
def test_a_value_that_names_nothing_is_answered_with_the_right_command(command):
    check(command, NAMED[command])


@pytest.mark.gate
@pytest.mark.parametrize("command", UNCLEAR)
def test_a_command_that_cannot_be_guessed_gets_one_sentence(command):
    result = worldgen(*shlex.split(command))
    assert result.code == 2 and len(result.err.splitlines()) <= 2
    assert not result.err.splitlines()[-1].startswith("  ")


def test_a_suggested_command_never_overwrites_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "failures").mkdir()
    assert worldgen("fuzz", "turn-right").err.endswith(
        "  worldgen fuzz --controller turn-right --out failures-2/\n"
    )


def _commands(group, path=()):
    context = click.Context(group, info_name="worldgen")
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from _commands(command, (*path, name))
        else:
            yield (*path, name), command


@pytest.mark.gate
def test_every_command_answers_a_word_and_an_option_too_many():
    for path, _ in _commands(cli):
        # `regenerate` needs a manifest that exists.
        if path[0] == "regenerate":
            continue
        for wrong in (["--nonsense-option"], ["--seeed", "1"]):
            result = worldgen(*path, *wrong)
            suggested = result.err.splitlines()[-1]
            assert result.code == 2 and suggested.startswith("  worldgen "), path
            words = shlex.split(suggested)[1:]
            assert words[: len(path)] == list(path)
            assert first_fault(cli, words) is None


def test_the_motion_models_that_are_offered_exist():
    from sim.motion import MOTIONS as MODELS

    assert sorted(MOTIONS) == MODELS.names()
