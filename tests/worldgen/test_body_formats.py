"""Footprints, cars and goals in other programs' files: stored, or kept next to them, or refused."""

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import yaml

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import FormatError, InvalidWorld, Pose, Robot, Target, World
from worldgen.files.grid import read_world, write_world
from worldgen.interop import FORMATS, ImportedRobot, export_world, import_world, write_export
from worldgen.interop.readers.nav2_params import nav2_params, read_nav2_params
from worldgen.robot import Drive
from worldgen.robot_overrides import RobotOverrides

BOX = ((0.41, 0.15), (-0.21, 0.15), (-0.21, -0.15), (0.41, -0.15))
WEDGE = ((0.3, 0.0), (-0.1, 0.15), (-0.1, -0.1))
BOTH_WAYS = [
    name
    for name in FORMATS
    # The other two have room for certain mazes only.
    if FORMATS.get(name).direction == "both" and name not in ("micromouse", "thesis")
]
GOAL = {"heading": 1.5, "heading_tolerance": 0.2, "arrival": "stop", "contact": "fail"}


def hall(robot):
    walls = np.zeros((20, 40), bool)
    walls[[0, -1]], walls[:, [0, -1]] = True, True
    return World(walls, cell_size=0.1, robots=[robot])


def robot(footprint=(), drive=None, **goal):
    target = Target(3.05, 1.05, 0.1, **goal)
    return Robot(Pose(0.55, 1.05, 0.0), target, 0.2, 1.0, footprint, drive or Drive())


def kind(one):
    return one.footprint, one.drive, replace(one.target, x=0.0, y=0.0, radius=1.0)


ROBOTS = {
    "box": robot(BOX),
    "wedge": robot(WEDGE),
    "car": robot(BOX, Drive(0.5, True, 2.0)),
    "goal": robot((), None, **GOAL),
}


@pytest.mark.parametrize("name", BOTH_WAYS)
@pytest.mark.parametrize("which", ROBOTS)
def test_a_robot_of_any_kind_comes_back_from_any_file(name, which, tmp_path):
    export = export_world(hall(ROBOTS[which]), name)
    back = import_world(write_export(export, tmp_path)[0], name=name).world
    assert kind(back.robots[0]) == kind(ROBOTS[which])


@pytest.mark.parametrize("name", BOTH_WAYS)
def test_a_file_that_holds_only_discs_says_so(name):
    known = FORMATS.get(name)
    export = export_world(hall(ROBOTS["box"]), name)
    says = any("footprint" in sentence and "0.62 x 0.3 m" in sentence for sentence in export.lost)
    assert says == ("footprint" not in known.holds)
    disc = export_world(hall(robot()), name)
    assert not any("footprint" in sentence for sentence in disc.lost)


def test_a_ros_map_has_the_footprint_as_nav2_writes_it(tmp_path):
    export = export_world(hall(ROBOTS["box"]), "ros", file="hall.yaml")
    ours = yaml.safe_load(export.data)["worldgen"]
    assert json.loads(ours["footprint"]) == [list(corner) for corner in BOX]


@pytest.mark.parametrize("which", ROBOTS)
def test_parameters_of_nav2_come_back(which, tmp_path):
    export = export_world(hall(ROBOTS[which]), "ros+nav2", file="hall.yaml")
    path = write_export(export, tmp_path)[0]
    params = yaml.safe_load((tmp_path / "hall-nav2.yaml").read_text())
    costmap = params["local_costmap"]["local_costmap"]["ros__parameters"]
    assert costmap == params["global_costmap"]["global_costmap"]["ros__parameters"]
    # Without our own table, the parameters are all that is known of the robot.
    path.write_text(re.sub(r"(?s)worldgen:.*", "", path.read_text()))
    asked = ImportedRobot((0.55, 1.05, 0.0), (3.05, 1.05))
    back = import_world(path, asked, options={"params": "hall-nav2.yaml"}).world.robots[0]
    assert back.footprint == ROBOTS[which].footprint
    assert back.radius == pytest.approx(ROBOTS[which].radius) and back.target.radius == 0.1
    assert back.target.arrival == ("stop" if which == "goal" else "step")


NAV2 = """
local_costmap:
  local_costmap:
    ros__parameters:
      footprint: "[ [0.31, 0.45], [0.31, -0.45], [-0.31, -0.45], [-0.31, 0.45] ]"
      plugins: ["voxel_layer"]
global_costmap:
  global_costmap:
    ros__parameters:
      robot_radius: 0.22
controller_server:
  ros__parameters:
    general_goal_checker:
      stateful: True
      plugin: "nav2_controller::SimpleGoalChecker"
      xy_goal_tolerance: 0.1
"""


def test_a_footprint_counts_before_a_radius():
    found = read_nav2_params(NAV2.encode())
    assert found.radius is None and len(found.footprint) == 4
    assert (found.goal.arrival, found.goal.radius) == ("step", 0.1)
    assert read_nav2_params(b"a:\n  footprint: '[]'\n  robot_radius: 0.3\n").radius == 0.3


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("a:\n  footprint: '[[0,0],[1,0]]'\n", "wrong-footprint", 2),
        ("a:\n  footprint: round\n", "wrong-form", 2),
        ("a:\n  b: 1\n", "missing-key", 1),
        ("a:\n  robot_radius: wide\n", "not-a-number", 2),
    ],
)
def test_parameters_that_do_not_fit_are_named_with_their_line(text, code, line):
    with raises(FormatError, code) as raised:
        read_nav2_params(text.encode())
    assert raised.value.line == line


def test_parameters_of_a_disc_have_its_radius():
    assert yaml.safe_load(nav2_params(robot()))["local_costmap"]["local_costmap"] == {
        "ros__parameters": {"robot_radius": 0.2}
    }


def test_irsim_gets_a_polygon_and_the_goals_heading():
    made = export_world(hall(robot(WEDGE, heading=1.5)), "irsim").data
    (one,) = yaml.safe_load(made)["robot"]
    assert one["shape"] == {"name": "polygon", "vertices": [list(corner) for corner in WEDGE]}
    assert one["goal"] == [3.05, 1.05, 1.5] and one["arrive_mode"] == "state"


def test_gazebo_gets_a_box_with_wheels_inside():
    root = ET.fromstring(export_world(hall(ROBOTS["box"]), "sdf+robot").data)
    chassis = root.find(".//model[@name='robot']/link[@name='chassis']")
    box = chassis.find("collision[@name='box']")
    length, width, _ = map(float, box.findtext("geometry/box/size").split())
    assert (length, width) == (0.62, 0.3)
    assert box.findtext("pose").split()[:2] == ["0.1", "0"]
    wheel = root.find(".//link[@name='left_wheel']/pose").text.split()
    assert float(wheel[1]) < 0.15


def test_gazebo_draws_a_polygon_as_a_disc_and_says_so():
    export = export_world(hall(ROBOTS["wedge"]), "sdf+robot")
    assert any("only rectangles become boxes" in note for note in export.notes)
    trailer = robot(tuple((x - 0.6, y) for x, y in BOX))
    with raises(InvalidWorld, "axle-outside"):
        export_world(hall(trailer), "sdf+robot")


def test_mujoco_gets_a_prism():
    root = ET.fromstring(export_world(hall(ROBOTS["wedge"]), "mjcf+robot").data)
    corners = root.find("asset/mesh[@name='robot_body']").get("vertex").split()
    found = [(float(x), float(y)) for x, y in zip(corners[::3], corners[1::3], strict=True)]
    assert found == [*WEDGE, *WEDGE]
    assert root.find(".//geom[@name='robot']").get("mesh") == "robot_body"


def test_import_takes_the_options_of_run(tmp_path):
    write_world(hall(robot()), tmp_path / "h.grid")
    options = ("--footprint", "0.62x0.3@0.1", "--arrival", "step", "--json")
    result = worldgen("import", tmp_path / "h.grid", "--out", tmp_path / "b.grid", *options)
    made = read_world(tmp_path / "b.grid")
    assert result.code == 0, result.err
    assert set(made.robots[0].footprint) == set(BOX) and made.target.arrival == "step"
    assert len(json.loads(result.out)["footprint"]) == 4
    # A radius asks for a disc again.
    disc = import_world(tmp_path / "b.grid", ImportedRobot(radius=0.2)).world
    assert disc.robots[0].is_disc and disc.target.arrival == "step"


def test_a_body_is_placed_where_it_can_turn(tmp_path):
    write_world(hall(robot()), tmp_path / "h.grid")
    asked = ImportedRobot(seed=1, overrides=RobotOverrides(footprint="0.62x0.3@0.1"))
    back = import_world(tmp_path / "h.grid", asked)
    assert back.decision.result == "reachable"
    assert back.world.robots[0].footprint and back.world.certificate is not None
