"""Worlds at the ends of their domain are run within seconds, and no call of the core is deaf."""

import numpy as np
import pytest

from sim import RunOptions, simulate
from sim._core import lib
from sim.controllers import CONTROLLERS
from sim.controllers.library.dynamic_window import DynamicWindow, dynamic_window_robot
from sim.fleet.core_calls import CoreFleet
from sim.fleet.run import FleetRun
from sim.runners.lattice import LatticeRun
from tests.helpers.raising import raises
from worldgen import InvalidParameter, Pose, Target, World, generate

# Far more than a call has time for: minutes, even of the fastest steps.
ENDLESS = 10**10


def world_of(cell_size, radius):
    """A wall between start and target, in cells of any size."""
    walls = np.zeros((12, 12), bool)
    walls[6, 3:9] = True
    return World(
        walls=walls,
        cell_size=cell_size,
        robot_radius=radius * cell_size,
        robot_speed=5.0 * cell_size,
        start=Pose(5.5 * cell_size, 2.5 * cell_size, 0.0),
        target=Target(5.5 * cell_size, 9.5 * cell_size, 0.4 * cell_size),
    )


# A window of a map that is shifted line by line by a step of a whole cell takes hours here, as the
# map's own cells are a millionth of a cell.
@pytest.mark.parametrize("cell_size", [1e-6, 1e6])
@pytest.mark.parametrize("radius", [1e-6, 0.3], ids=["smallest disc", "usual disc"])
@pytest.mark.parametrize("name", ["mapper", "gestalt"])
def test_a_map_that_moves_far_in_a_step_is_shifted_at_once(name, radius, cell_size):
    world = world_of(cell_size, radius)
    assert simulate(world, name, steps=300, time_step=0.1).steps > 0


@pytest.mark.gate
@pytest.mark.parametrize("cell_size", [1e-6, 1e6])
@pytest.mark.parametrize("radius", [1e-6, 0.3], ids=["smallest disc", "usual disc"])
def test_every_controller_answers_at_the_ends_of_the_domain(radius, cell_size):
    world = world_of(cell_size, radius)
    for name in CONTROLLERS.names():
        assert simulate(world, name, steps=200, time_step=0.1).steps > 0


@pytest.mark.parametrize("digest", [False, True], ids=["plain loop", "general loop"])
def test_a_call_of_the_core_returns_before_a_long_run_ends(digest):
    controller = CONTROLLERS.get("turn-random")
    run = LatticeRun(generate("maze", 3, size=20), controller, RunOptions())
    run.settings.steps = ENDLESS
    run.settings.target.radius_sq = -1  # so that it never arrives
    run.settings.digest = int(digest)
    episode = run.episode()
    assert episode.run(ENDLESS) and 0 < episode.report.steps < ENDLESS


def test_a_call_of_the_core_returns_before_a_long_run_of_a_fleet_ends():
    world = generate("rooms", 3, robots=3)
    controllers = [CONTROLLERS.get("turn-random")] * 3
    fleet_run = FleetRun(world, controllers, [RunOptions()] * 3)
    for run in fleet_run.runs:
        run.settings.target.radius_sq = -1
    drivers = [run.driver() for run in fleet_run.runs]
    fleet = CoreFleet(fleet_run.runs, drivers, ENDLESS, lib.WG_NO_LOOP)
    assert fleet.run(ENDLESS) == lib.WG_GOES_ON and 0 < fleet.report.steps < ENDLESS


# The first count that no addition of 1 reaches is 2^53.
@pytest.mark.parametrize("count", [1, 10**9, 2**53, float("nan")])
@pytest.mark.parametrize("option", ["speeds", "turns"])
def test_a_window_tries_a_bounded_number_of_arcs(option, count):
    with raises(InvalidParameter, "out-of-range", name=option):
        dynamic_window_robot(DynamicWindow(**{option: count}))


def test_a_window_with_the_most_arcs_answers():
    robot = dynamic_window_robot(DynamicWindow(speeds=100, turns=100))
    assert simulate(world_of(0.1, 0.3), robot, steps=20).steps == 20
