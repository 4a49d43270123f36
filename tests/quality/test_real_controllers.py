"""The controllers of ``benchmarks/real`` arrive, and each has a fault of one line."""

import math
from difflib import unified_diff

import pytest

from benchmarks.real.peers import FAMILIES, plain_loop
from benchmarks.real.planting import PURPOSES, ROBOTS, write
from sim import simulate
from worldgen import generate


@pytest.mark.parametrize("name", ROBOTS)
def test_a_fault_is_one_line(name):
    robot = ROBOTS[name]
    lines = unified_diff(
        robot.text(False).splitlines(), robot.text(True).splitlines(), n=0, lineterm=""
    )
    changes = [line for line in lines if line[0] in "+-" and line[:3] not in ("+++", "---")]
    assert [line[0] for line in changes] == ["-", "+"]


@pytest.mark.parametrize("name", ROBOTS)
def test_padding_and_counting_change_no_run(name, tmp_path):
    robot = ROBOTS[name]
    calls = tmp_path / "calls"
    plain = write(robot, tmp_path / "plain", faulty=False)
    padded = write(robot, tmp_path / "padded", faulty=False, pace=0.01, calls=calls)
    world = generate("rooms", 1, size=13)
    runs = [simulate(world, controller) for controller in (plain, padded)]
    assert runs[0] == runs[1]
    # The robot stands still in its first step, before it has sensed anything.
    assert len(calls.read_text()) == runs[1].steps - 1
    assert set(calls.read_text()) <= set(PURPOSES)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ROBOTS)
def test_a_correct_controller_arrives_in_small_worlds(name, tmp_path):
    peer = plain_loop(
        write(ROBOTS[name], tmp_path, faulty=False), math.inf, worlds=10 * len(FAMILIES)
    )
    assert peer.worlds - peer.failing >= ROBOTS[name].arrives * peer.worlds
