"""IR-SIM and MuJoCo drive in an exported world again, fast and slow.

The audit finds the same as in the stored runs.
"""

from pathlib import Path

import pytest

from sim.audit import audit
from tests.clients.environments import client
from tests.helpers.command_line import worldgen
from worldgen import read_world
from worldgen.logs.reading import read_log

FOLDER = Path(__file__).parents[2] / "examples" / "audits"
ROUND = ("--via", "1.8,2.1", "2.3,2.1", "--speed", "1")

RECORDINGS = {
    "irsim-fast": ("irsim", "irsim", "wall.yaml", ("--speed", "6")),
    "irsim-slow": ("irsim", "irsim", "wall.yaml", ROUND),
    "mujoco-fast": ("mujoco", "mjcf", "wall.xml", ("--speed", "20")),
    "mujoco-unseen": ("mujoco", "mjcf", "wall.xml", ("--speed", "30", "--time-step", "0.01")),
    "mujoco-slow": ("mujoco", "mjcf", "wall.xml", (*ROUND, "--time-step", "0.01")),
}
HEARD = {"mujoco-fast"}
"""Places where the simulator noticed the wall but let the robot through anyway."""


@pytest.mark.parametrize("name", RECORDINGS)
def test_the_simulator_says_nothing_and_the_audit_says_what_it_said_before(name, tmp_path):
    simulator, kind, file, options = RECORDINGS[name]
    driver = client(simulator)
    assert (
        worldgen("export", FOLDER / "wall.grid", "--to", kind, "--out", tmp_path / file).code == 0
    )
    out = tmp_path / "out.csv"
    said = driver.ask(FOLDER / f"{simulator}_drive.py", tmp_path / file, *options, "--out", out)
    assert said["arrived"] and bool(said.get("collisions", said.get("contacts"))) == (name in HEARD)
    world = read_world(FOLDER / "wall.grid")
    anew, stored = (
        audit(world, read_log(path).trajectories[1])
        for path in (out, FOLDER / "recorded" / f"{name}.csv")
    )
    assert [(one.kind, one.cell) for one in anew.findings] == [
        (one.kind, one.cell) for one in stored.findings
    ]
