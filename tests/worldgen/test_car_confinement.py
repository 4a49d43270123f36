"""Cars that never reverse are confined, and a checker that refuses proofs that do not hold."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from sim import Command, simulate
from sim.episode.describe import describe_unreachable
from worldgen import CellState, Drive, Pose, Robot, Target, Timeline, World, generate
from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, decide
from worldgen.reach.car import decide as deciding
from worldgen.reach.car.confine import confine_car
from worldgen.reach.check.car_confinement import check_car_confinement
from worldgen.reach.verifying import verify_world


def dead_end(width, turning_radius=1.0, heading=0.0, **robot):
    """An aisle that is closed at both ends; the target is behind the car."""
    cells = round(width / 0.1)
    walls = np.ones((cells + 2, 32), bool)
    walls[1:-1, 1:-1] = False
    y = (1 + cells / 2) * 0.1
    drive = Drive(turning_radius, reverse=robot.pop("reverse", False))
    parts = {"radius": 0.2, "drive": drive, **robot}
    return World(walls, robots=[Robot(Pose(1.7, y, heading), Target(0.5, y, 0.1), **parts)])


def alley(turning_radius, ahead, end):
    """An aisle with the target straight ahead of the car, which is stopped by a wall at a distance."""
    walls = np.ones((8, 12 + round(end / 0.1)), bool)
    walls[1:-1, 1:-1] = False
    x = (walls.shape[1] - 1) * 0.1 - 0.2 - end
    target = Target(x + ahead, 0.4, 0.05)
    robot = Robot(Pose(x, 0.4), target, radius=0.2, drive=Drive(turning_radius))
    return World(walls, robots=[robot])


@pytest.fixture(scope="module")
def proof():
    return decide(dead_end(0.8)).confinement


@pytest.mark.parametrize(
    ("width", "result"),
    [
        pytest.param(0.5, BLOCKED, marks=pytest.mark.gate),
        (0.8, BLOCKED),
        pytest.param(1.1, BLOCKED, marks=pytest.mark.gate),
        (1.9, REACHABLE),
    ],
)
def test_a_car_turns_around_only_where_its_turning_circle_fits(width, result):
    # The axle needs twice the turning radius beside the disc's own width: 1.4 m.
    answer = verify_world(dead_end(width, 0.5))
    assert answer["result"] == result
    assert answer["certificate_valid"]
    assert answer["certificate"] == ("witness" if result == REACHABLE else "confinement")


@pytest.mark.gate
def test_a_footprint_is_confined_by_the_disc_in_it():
    box = ((0.25, 0.2), (-0.25, 0.2), (-0.25, -0.2), (0.25, -0.2))
    assert verify_world(dead_end(0.8, footprint=box))["result"] == BLOCKED


@pytest.mark.gate
def test_a_car_is_confined_from_a_waypoint():
    world = dead_end(0.8)
    behind = world.robots[0]
    ahead = replace(behind.target, x=2.5)
    assert decide(replace(world, robots=[replace(behind, target=ahead)])).result == REACHABLE
    both = replace(world, robots=[replace(behind, target=ahead, waypoints=[behind.target])])
    answer = verify_world(both)
    assert answer["result"] == BLOCKED and answer["certificate_valid"]
    # Not from one that can be passed before the car could turn around.
    there = replace(world, robots=[replace(behind, target=ahead, waypoints=[ahead])])
    assert verify_world(there)["result"] == REACHABLE


def test_a_car_that_may_reverse_is_not_confined():
    world = dead_end(0.8, reverse=True)
    assert decide(world).result == REACHABLE
    confinement = decide(dead_end(0.8)).confinement
    assert not check_car_confinement(world, confinement).valid


def test_a_car_that_faces_its_target_is_not_confined():
    assert decide(dead_end(0.8, heading=3.14159)).result == REACHABLE
    assert confine_car(dead_end(0.8, heading=3.14159)).proof is None


@pytest.mark.gate
@pytest.mark.parametrize(("ahead", "end"), [(1.6, 2.0), (2.0, 2.3), (1.3, 1.4)])
def test_a_car_is_not_confined_from_a_target_at_the_wall_ahead(ahead, end):
    # It is in the wall before it has driven a part of a step of a car of 10 m turning radius.
    world = alley(10.0, ahead, end)
    assert simulate(world, Straight(), steps=600, time_step=0.1).verdict == "reached"
    assert confine_car(world).proof is None
    # A cell that changes much later hides the path from the search.
    closed = Timeline([1000.0], [round((world.start.x + 0.7) / 0.1)], [4], [CellState.SOLID])
    assert verify_world(replace(world, timeline=closed))["result"] == UNDECIDED


@pytest.mark.gate
def test_a_large_world_with_a_large_body_takes_about_a_second():
    walls = np.zeros((1000, 1000), bool)
    walls[500] = True
    body = ((-5.0, -4.0), (5.0, -4.0), (5.0, 4.0), (-5.0, 4.0))
    robot = Robot(Pose(20.0, 20.0), Target(20.0, 80.0, 0.1), footprint=body, drive=Drive(1.03))
    begin = time.process_time()
    assert confine_car(World(walls, robots=[robot])).side is not None
    # 1.5 s where this was measured; rows of cells around each place would take 30 s.
    assert time.process_time() - begin < 8.0


def test_a_proof_that_the_checker_refuses_blocks_nothing(monkeypatch):
    world = dead_end(0.8)
    found = confine_car(world)
    without = replace(found.proof, boxes=found.proof.boxes[1:])
    monkeypatch.setattr(deciding, "confine_car", lambda _: found._replace(proof=without))
    assert decide(world).result == UNDECIDED


@pytest.mark.gate
def test_an_axle_outside_the_world_does_not_confine_a_car():
    # The body turns about its own middle, and the axle around it.
    box = ((-0.04, 0.36), (0.04, 0.36), (0.04, 0.44), (-0.04, 0.44))
    start = Pose(2.0, 0.03, 0.0)
    robot = Robot(start, Target(1.0, 0.03, 0.1), footprint=box, drive=Drive(0.4))
    world = World(np.zeros((5, 40), bool), robots=[robot])
    assert decide(world).result == REACHABLE
    assert confine_car(world).proof is None


@pytest.mark.gate
@pytest.mark.parametrize("seed", range(6))
def test_no_car_is_confined_that_has_a_path(seed):
    world = generate("maze", seed, size=14, drive="car", turning_radius=0.15)
    assert decide(world).result == REACHABLE
    assert confine_car(world).proof is None


@pytest.mark.parametrize("column", [0, 1, 2])
def test_a_confinement_that_lacks_boxes_is_refused(proof, column):
    world = dead_end(0.8)
    assert check_car_confinement(world, proof).valid
    # All runs of the most frequent heading, of the most frequent row, and those that begin in one column.
    values = proof.boxes[:, column]
    without = proof.boxes[values != np.bincount(values).argmax()]
    report = check_car_confinement(world, replace(proof, boxes=without))
    assert not report.valid and "does not hold" in report.reason


def test_a_confinement_that_lacks_any_single_box_is_refused(proof):
    world = dead_end(0.8)
    for run in np.random.default_rng(3).choice(len(proof.boxes), 12, replace=False):
        boxes = proof.boxes.copy()
        heading, row, left, right = boxes[run]
        middle = (left + right) // 2
        boxes[run] = heading, row, left, middle - 1
        boxes = np.vstack([boxes, [heading, row, middle + 1, right]])
        boxes = boxes[boxes[:, 2] <= boxes[:, 3]]
        assert not check_car_confinement(world, replace(proof, boxes=boxes)).valid


def test_a_confinement_holds_for_its_own_car_only(proof):
    others = {
        "a smaller turning circle": dead_end(0.8, 0.6),
        "a smaller disc": dead_end(0.8, radius=0.1),
        "another heading": dead_end(0.8, heading=3.14159),
    }
    for other in others.values():
        assert not check_car_confinement(other, proof).valid
    (ahead, left, radius), *_ = proof.discs
    wrong = (
        replace(proof, step=2.0),
        replace(proof, side=0.001),
        replace(proof, step=0.0),
        replace(proof, headings=proof.headings + 1),
        replace(proof, discs=()),
        replace(proof, discs=((ahead, left, 1.01 * radius),)),
        replace(proof, discs=((ahead + 0.1, left, radius),)),
        replace(proof, boxes=proof.boxes - 1),
        replace(proof, boxes=proof.boxes[:0]),
    )
    for changed in wrong:
        assert not check_car_confinement(dead_end(0.8), changed).valid


def test_without_a_wish_for_proofs_of_blocked_none_is_looked_for():
    assert decide(dead_end(0.8), cut=False).result == UNDECIDED


class Straight:
    """Drives ahead slowly."""

    senses = ("x",)

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(0.1, 0.0), memory


@pytest.mark.gate
def test_what_is_said_of_a_confined_car_leaves_out_what_else_moves_it():
    world = dead_end(1.2, 0.5)
    assert decide(world).result == BLOCKED
    pushes = (0.5, 0.0, 0.0, math.pi)
    assert (
        simulate(world, Straight(), steps=2000, time_step=0.1, pushes=pushes).verdict == "reached"
    )
    said = describe_unreachable(world, undecided=False, proof="confinement")
    assert "by a car that only its wheels move" in said
