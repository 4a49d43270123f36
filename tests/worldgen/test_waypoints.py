"""Waypoints: goals in order before the target, in worlds, files, options and proofs."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen import FormatError, InvalidParameter, InvalidWorld, Pose, Robot, Target, World
from worldgen.files.grid import dumps, loads
from worldgen.generation import generate
from worldgen.interop import FORMATS, ImportedRobot, export_world, import_world, write_export
from worldgen.reach import check_certificate, decide, decide_in_time
from worldgen.robot import MOST_WAYPOINTS, Drive
from worldgen.robot_overrides import RobotOverrides
from worldgen.timeline import CellState, Timeline
from worldgen.world import Cut, Witness

BOX = ((0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1))
KINDS = {
    "disc": Robot(Pose(0.5, 0.5), Target(2.5, 0.5, 0.1), 0.1),
    "body": Robot(Pose(0.5, 0.5), Target(2.5, 0.5, 0.1), footprint=BOX),
    "car": Robot(Pose(0.5, 0.5), Target(2.5, 0.5, 0.1), 0.1, drive=Drive(0.3, reverse=True)),
}
THERE = (Target(1.5, 1.5, 0.1), Target(0.5, 1.5, 0.1, heading=1.5), Target(2.5, 1.5, 0.2))


def hall(robot, *, closed=()):
    """Return a hall of 3 x 2 m, with solid cells around some places."""
    walls = np.zeros((20, 30), bool)
    walls[[0, -1]], walls[:, [0, -1]] = True, True
    for x, y in closed:
        walls[y - 3 : y + 3, x - 3 : x + 3] = True
        walls[y - 2 : y + 2, x - 2 : x + 2] = False
    return World(walls, cell_size=0.1, robots=[robot])


def through(robot, *waypoints):
    return replace(robot, waypoints=waypoints)


@pytest.mark.parametrize("kind", KINDS)
def test_a_witness_leads_through_all_waypoints_in_order(kind):
    world = hall(through(KINDS[kind], *THERE))
    decision = decide(world)
    assert isinstance(decision.certificate, Witness)
    report = check_certificate(world, decision.certificate)
    assert report.valid and "all 3 waypoints" in report.reason
    assert decide(world, certificate=False).result == decision.result


def test_two_waypoints_are_both():
    world = hall(through(KINDS["disc"], *THERE[:2]))
    report = check_certificate(world, decide(world).certificate)
    assert report.reason.endswith("leads through both waypoints")


@pytest.mark.parametrize("kind", KINDS)
def test_a_witness_in_another_order_is_refused(kind):
    path = decide(hall(through(KINDS[kind], *THERE))).certificate
    report = check_certificate(hall(through(KINDS[kind], *THERE[::-1])), path)
    assert not report.valid and "waypoint 2 of 3" in report.reason


def test_a_heading_is_asked_for_at_the_waypoint_itself():
    path = decide(hall(through(KINDS["body"], *THERE))).certificate
    turned = replace(THERE[1], heading=-1.5, heading_tolerance=0.01)
    report = check_certificate(hall(through(KINDS["body"], THERE[0], turned, THERE[2])), path)
    assert not report.valid and "waypoint 2 of 3" in report.reason


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_goal_that_is_cut_off_is_named(kind):
    world = hall(through(KINDS[kind], *THERE), closed=[(5, 15)])
    decision = decide(world)
    assert isinstance(decision.certificate, Cut) and decision.certificate.waypoint == 2
    assert "waypoint 2 of 3, at (0.5, 1.5)" in decision.reason
    assert check_certificate(world, decision.certificate).valid
    assert decide(world, certificate=False).result == "blocked"


@pytest.mark.parametrize("waypoint", [0, 1, 3])
def test_a_cut_of_one_goal_proves_nothing_about_another(waypoint):
    world = hall(through(KINDS["disc"], *THERE), closed=[(5, 15)])
    cut = replace(decide(world).certificate, waypoint=waypoint)
    assert not check_certificate(world, cut).valid


def test_a_cut_before_the_target_names_the_target():
    world = hall(through(KINDS["disc"], *THERE), closed=[(25, 5)])
    decision = decide(world)
    assert decision.certificate.waypoint == 0 and "the target, at (2.5, 0.5)" in decision.reason
    assert check_certificate(world, decision.certificate).valid


def test_a_passage_that_the_disc_just_fits_is_passed_both_ways():
    walls = np.ones((7, 9), bool)
    walls[2:5, 1:4] = walls[2:5, 5:8] = False
    walls[3, 4] = False
    robot = Robot(Pose(0.2, 0.35), Target(0.2, 0.35, 0.02), 0.05)
    world = World(walls, robots=[through(robot, Target(0.65, 0.35, 0.02))])
    decision = decide(world)
    assert check_certificate(world, decision.certificate).valid


def test_a_changing_world_has_a_timed_path_through_its_waypoints():
    # The door to the waypoint opens at 5 s and closes at 20 s.
    world = hall(through(KINDS["disc"], THERE[1], THERE[0]), closed=[(5, 15)])
    door = [(5.0, 7, y, CellState.FREE) for y in range(13, 17)]
    shut = [(20.0, 7, y, CellState.SOLID) for y in range(13, 17)]
    world = replace(world, timeline=Timeline.of([*door, *shut]))
    decision = decide(world)
    assert check_certificate(world, decision.certificate).valid
    assert decision.certificate.duration > 5.0
    assert decide_in_time(world, 4.0).result == "undecided"


def test_a_waypoint_that_is_shut_off_for_good_blocks_a_changing_world():
    world = hall(through(KINDS["disc"], THERE[0], THERE[1]), closed=[(5, 15)])
    world = replace(world, timeline=Timeline.of([(3.0, 20, 10, CellState.SOLID)]))
    decision = decide(world)
    assert decision.certificate.waypoint == 2
    assert check_certificate(world, decision.certificate).valid


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_holds_waypoints_and_their_proof(kind):
    goals = (*THERE, Target(1.0, 1.0, 0.1, arrival="stop", arrival_speed=0.2))
    for closed in ([], [(25, 15)]):
        world = hall(through(KINDS[kind], *goals), closed=closed)
        world = replace(world, certificate=decide(world).certificate)
        data = dumps(world)
        assert data.startswith(b"%worldgen-grid 2")
        assert loads(data) == world and dumps(loads(data)) == data


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("target = [1.5", "targt = [1.5", "unknown-name"),
        ("0.1] },", '0.1], contact = "stop" },', "wrong-place"),
        ("[2.5, 1.5", "[9.5, 1.5", "outside-grid"),
        ("waypoints = [", "waypoints = [3, ", "wrong-type"),
        ("{ target = [1.5, 1.5, 0.1] }", "{ }", "missing-key"),
        ("[1.5, 1.5, 0.1]", "[1.5, 1.5, -0.1]", "not-positive"),
        ("heading = 1.5", 'heading = "up"', "wrong-type"),
    ],
)
def test_a_wrong_waypoint_is_refused_at_its_line(old, new, code):
    text = dumps(hall(through(KINDS["disc"], *THERE))).decode()
    line = 1 + next(k for k, one in enumerate(text.split("\n")) if one.startswith("waypoints"))
    with raises(FormatError, code) as caught:
        loads(text.replace(old, new).encode())
    assert caught.value.line == line


@pytest.mark.parametrize("waypoint", [0, 4])
def test_a_cut_names_a_waypoint_that_the_robot_has(waypoint):
    world = hall(through(KINDS["disc"], *THERE), closed=[(5, 15)])
    text = dumps(replace(world, certificate=decide(world).certificate)).decode()
    with raises(FormatError, "out-of-range"):
        loads(text.replace("waypoint = 2", f"waypoint = {waypoint}").encode())


def test_a_world_refuses_too_many_waypoints_and_a_contact_of_one():
    with raises(InvalidWorld, "too-many-waypoints"):
        hall(through(KINDS["disc"], *[THERE[0]] * (MOST_WAYPOINTS + 1)))
    with raises(InvalidWorld, "contact-of-waypoint"):
        hall(through(KINDS["disc"], replace(THERE[0], contact="fail")))


def test_waypoints_of_an_option_take_the_targets_radius_and_arrival():
    given = RobotOverrides(waypoints="1,1.5 2,0.5,0.3", arrival="step", target_heading="1")
    robot = given.applied_to_robot(KINDS["disc"])
    assert robot.waypoints == (
        Target(1.0, 1.5, 0.1, arrival="step"),
        Target(2.0, 0.5, 0.3, arrival="step"),
    )


@pytest.mark.parametrize("text", ["", "0", "65", "1,2,3,4", "a,b", "1,2,0", "1,2 " * 65])
def test_wrong_waypoints_of_an_option_are_refused(text):
    with pytest.raises(InvalidParameter):
        RobotOverrides(waypoints=text)


def test_other_waypoints_drop_the_certificate():
    world = hall(KINDS["disc"])
    world = replace(world, certificate=decide(world).certificate)
    assert RobotOverrides(waypoints="1,1").applied_to(world).certificate is None


def test_a_family_makes_way_at_waypoints():
    world = generate("maze", 3, waypoints="1.0,1.0 0.4,1.3")
    assert len(world.robots[0].waypoints) == 2
    assert check_certificate(world).valid
    assert world.provenance.params["waypoints"] == "1.0,1.0 0.4,1.3"


def test_fleets_with_waypoints_are_undecided():
    robots = [through(KINDS["disc"], THERE[0]), Robot(Pose(1.0, 1.5), Target(2.0, 1.5, 0.1), 0.1)]
    decision = decide(replace(hall(KINDS["disc"]), robots=robots))
    assert decision.result == "undecided" and "waypoints" in decision.reason


@pytest.mark.parametrize(
    "name",
    [
        name
        for name in FORMATS
        if FORMATS.get(name).direction == "both" and name not in ("micromouse", "thesis")
    ],
)
def test_an_export_keeps_waypoints_next_to_the_file(name, tmp_path):
    world = hall(through(KINDS["disc"], *THERE))
    export = export_world(world, name)
    says = any("waypoints" in sentence for sentence in export.lost)
    assert says == ("waypoints" not in FORMATS.get(name).holds)
    back = import_world(write_export(export, tmp_path)[0], name=name).world
    assert back.robots[0].waypoints == THERE


def test_waypoints_of_an_import_are_in_the_files_frame(tmp_path):
    export = export_world(hall(KINDS["disc"]), "ros", origin=(-1.0, 2.0))
    given = ImportedRobot(in_file_frame=True, overrides=RobotOverrides(waypoints="0,3"))
    world = import_world(write_export(export, tmp_path)[0], given).world
    assert [(goal.x, goal.y) for goal in world.robots[0].waypoints] == [(1.0, 1.0)]
