"""Trajectories recorded in IR-SIM and MuJoCo.

The audit's result for them, without those simulators.
"""

from pathlib import Path

import pytest

from sim.audit import audit
from worldgen import read_world
from worldgen.logs.reading import read_log

FOLDER = Path(__file__).parents[2] / "examples" / "audits"
FAST = ["irsim-fast", "mujoco-fast", "mujoco-unseen"]


def report(name):
    return audit(
        read_world(FOLDER / "wall.grid"),
        read_log(FOLDER / "recorded" / f"{name}.csv").trajectories[1],
    )


@pytest.mark.parametrize("name", FAST)
def test_a_fast_recording_goes_through_the_wall(name):
    found = report(name)
    assert [finding.kind for finding in found.findings] == ["overlap", "tunnel"]
    tunnel = found.findings[1]
    assert (tunnel.cell, tunnel.depth) == ((20, 8), pytest.approx(0.05)) and 2.0 <= tunnel.x <= 2.1


@pytest.mark.parametrize("name", ["irsim-slow", "mujoco-slow"])
def test_a_slow_recording_round_the_wall_is_possible_and_arrives(name):
    found = report(name)
    assert not found.findings and found.reached is not None


@pytest.mark.parametrize("name", [*FAST, "irsim-slow", "mujoco-slow"])
def test_the_readme_says_of_each_recording_how_it_came_about(name):
    assert f"recorded/{name}.csv" in (FOLDER / "README.md").read_text()
