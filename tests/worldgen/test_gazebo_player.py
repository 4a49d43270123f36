"""The script exported with SDF worlds that change, run with a stand-in for Gazebo's command."""

import json
import os
import re
import subprocess
import sys

import pytest

from tests.helpers.drawn_worlds import drawn
from worldgen.interop import export_world
from worldgen.timeline import CellState, Timeline

# Answers like the command, keeps the simulated time in a file, and records when models are moved.
STAND_IN = """#!{python}
import json, pathlib, re, sys
state = pathlib.Path(r"{state}")
now, moves = json.loads(state.read_text())
words = sys.argv[1:]
if words[0] == "topic":
    print("sim_time {{{{ sec: %d nsec: %d }}}} paused: true" % divmod(round(now * 10**9), 10**9))
else:
    said = dict(zip(words[1::2], words[2::2]))
    if said["-s"].endswith("/control") and "run_to" in said["--req"]:
        sec, nsec = map(int, re.findall(r"sec: (\\d+)", said["--req"]))
        now = sec + nsec / 10**9
    elif said["-s"].endswith("/set_pose_vector"):
        moves += [[now, name, float(z)] for name, z in re.findall(r'name: "(\\w+)".*?z: (\\S+) ', said["--req"])]
    state.write_text(json.dumps([now, moves]))
    print("data: true" if said["-s"].startswith("/world/tiny/") else "")
"""
ROOM = """
    #####
    #S.G#
    #####"""


def tiny():
    events = [
        (0.25, 2, 1, CellState.SOLID),
        (0.25, 1, 1, CellState.BURNING),
        (1.0, 2, 1, CellState.FREE),
    ]
    return drawn(ROOM, timeline=Timeline.of(events))


def played(tmp_path, name, command="ign"):
    """Return what the script does to a world with this name.

    The state of the stand-in, which runs a world called tiny.
    """
    files = export_world(tiny(), "sdf", file=f"{name}.sdf").files
    for file, data in files.items():
        (tmp_path / file).write_bytes(data)
    state = tmp_path / "state.json"
    state.write_text("[0.0, []]")
    stand_in = tmp_path / command
    stand_in.write_text(
        STAND_IN.format(python=sys.executable, state=state).replace("{{", "{").replace("}}", "}")
    )
    stand_in.chmod(0o755)
    done = subprocess.run(
        [sys.executable, tmp_path / f"{name}_player.py"],
        env={**os.environ, "PATH": str(tmp_path)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return (
        done,
        json.loads(state.read_text())[1],
        json.loads(files[f"{name}_events.json"])["events"],
    )


@pytest.mark.gate
@pytest.mark.skipif(
    os.name != "posix",
    reason="the stand-in is a script with a first line that names its interpreter",
)
@pytest.mark.parametrize("command", ["ign", "gz"])
def test_models_are_moved_at_the_simulated_times_of_the_changes(tmp_path, command):
    done, moves, events = played(tmp_path, "tiny", command)
    assert done.returncode == 0, done.stderr
    assert moves == events and [when for when, _, _ in events] == [0.0, 0.0, 0.25, 0.25, 1.0]


@pytest.mark.skipif(
    os.name != "posix",
    reason="the stand-in is a script with a first line that names its interpreter",
)
def test_a_gazebo_that_runs_another_world_is_said(tmp_path):
    done, _, _ = played(tmp_path, "other")
    assert done.returncode == 1 and re.match(
        r"/world/other/set_pose_vector refused: .*running this world", done.stderr
    )
