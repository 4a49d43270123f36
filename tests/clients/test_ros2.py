"""A node of the real rclpy drives through the bridge of examples/ros2."""

import json
import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest

from tests.clients.environments import client
from tests.helpers.command_line import worldgen
from worldgen import generate, write_world

BRIDGE = Path(__file__).parents[2] / "examples" / "ros2"
# The node answers every scan, so the time-out only ends a broken run.
OPTIONS = "start=120+deadline=120+memory=none+time_step=0.05+beams=36+beam_range=3.5"
ARGUMENTS = "--beam-range 3.5 --timeout 60 --reset /wander/reset"


@pytest.fixture
def controller(monkeypatch):
    """The name of the controller while its node runs in a ROS graph of its own."""
    python = client("ros2").python
    domain = 1 + os.getpid() % 100
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("PYTHONPATH", str(BRIDGE))
    node = subprocess.Popen([python, BRIDGE / "wander.py"])
    yield f"cmd+{OPTIONS}:{shlex.quote(str(python))} -m worldgen_ros2_bridge {ARGUMENTS}"
    assert node.poll() is None, "the node ended before the test"
    node.terminate()
    node.wait(60)


def test_a_run_of_a_node_repeats_bit_for_bit(controller, tmp_path):
    write_world(generate("trap", seed=1), tmp_path / "w.grid")
    command = ["run", tmp_path / "w.grid", "--controller", controller, "--steps", "300", "--json"]
    first, second = (json.loads(worldgen(*command).out) for _ in range(2))
    assert first["steps"] > 50 and first["trace_digest"] == second["trace_digest"]
    # It drove.
    assert first["path_length"] > 1.0


def test_a_campaign_with_a_node_finds_failures_that_replay(controller, tmp_path):
    out = tmp_path / "found"
    done = worldgen(
        "fuzz", "--family", "trap", "--controller", controller, "--units", "1", "--examples", "1",
        "--pace", "5", "--no-shrink", "--workers", "1", "--seed", "1", "--out", out,
    )  # fmt: skip
    assert done.code in (0, 1), done.err
    assert re.search(r"[1-9]\d* (whole )?unit", done.out + done.err)
    for failure in sorted(out.glob("*.grid"))[:1]:
        assert worldgen("replay", failure).code in (0, 1)
