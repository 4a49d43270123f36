"""Families lay out their worlds for a body, prove them for it, and keep it in their parameters."""

import dataclasses
import math

import numpy as np
import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.body_room import layout_radius, rounded_up, with_fitting_heading, with_room
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.grid import read_world, world_digest
from worldgen.generation import generate
from worldgen.reach import check_certificate
from worldgen.robot import Drive
from worldgen.robot_overrides import RobotOverrides
from worldgen.sets import plan_set
from worldgen.world import Pose, Robot, Target, World

ALONE = [name for name in FAMILIES.names() if not FAMILIES.get(name).places_robots]
STILL = [name for name in ALONE if not FAMILIES.get(name).changes]
BODIES = {
    "rectangle": {"footprint": "0.62x0.9"},
    "long": {"footprint": "1.2x0.4@0.2"},
    "car": {"footprint": "0.62x0.9", "drive": "car", "turning_radius": 0.5, "reverse": True},
}


def robot(**options):
    return RobotOverrides(**options).applied_to_robot(Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 1.0)))


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("name", STILL)
def test_a_family_s_world_is_proved_for_the_body(name, body):
    world = generate(name, 3, **body)
    assert world.robots[0].footprint == robot(**body).footprint
    assert world.robots[0].drive == robot(**body).drive
    assert check_certificate(world).valid


@pytest.mark.gate
@pytest.mark.parametrize("name", [one for one in ALONE if one not in STILL])
def test_a_world_that_changes_is_proved_for_the_body(name):
    world = generate(name, 2, footprint="0.62x0.9")
    assert world.is_dynamic
    assert check_certificate(world).valid


def test_the_parameters_of_a_body_s_world_make_it_again_byte_for_byte():
    world = generate("corridor", 5, **BODIES["car"], target_heading="1.5708:0.2", arrival="stop")
    params = world.provenance.params
    assert {name: params[name] for name in BODIES["car"]} == BODIES["car"]
    assert params["arrival"] == "stop"
    assert world_digest(generate("corridor", 5, **params)) == world_digest(world)


def test_a_world_for_a_plain_robot_says_nothing_of_bodies():
    params = generate("maze", 5).provenance.params
    assert not params.keys() & {one.name for one in RobotOverrides.declared()}


def test_a_goal_alone_changes_nothing_of_the_layout():
    plain = generate("maze", 5)
    goal = generate("maze", 5, arrival="stop", target_heading="0")
    assert np.array_equal(plain.walls, goal.walls)
    assert goal.start == plain.start
    assert goal.target == dataclasses.replace(plain.target, arrival="stop", heading=0.0)


def test_given_sizes_are_kept():
    world = generate("maze", 5, footprint="0.62x0.9", cell_size=0.3, passage=5)
    assert world.cell_size == 0.3
    assert world.provenance.params["passage"] == 5


def test_a_round_car_keeps_its_radius():
    world = generate("maze", 5, drive="car", turning_radius=0.3)
    assert world.robot_radius == 0.07
    assert world.provenance.params["robot_radius"] == 0.07


@pytest.mark.parametrize("name", ["doorway", "warehouse"])
def test_families_of_fleets_have_no_bodies(name):
    with raises(InvalidParameter, "unknown-name", name="footprint"):
        generate(name, 1, footprint="0.62x0.9")


def test_a_body_is_refused_for_several_robots():
    with raises(InvalidParameter, "not-for-fleets", option="--footprint", robots=3):
        generate("maze", 1, footprint="0.62x0.9", robots=3)


def test_what_a_car_needs_is_refused_before_any_layout():
    with raises(InvalidParameter, "option-missing", needs=["--turning-radius"]):
        generate("maze", 1, drive="car")


def test_a_body_without_room_is_an_error_that_says_what_to_raise():
    with pytest.raises((InvalidParameter, GenerationFailed), match="larger size"):
        generate("maze", 1, footprint="3x0.3", cell_size=0.1, size=30)


def test_a_command_says_the_cells_that_it_chose(tmp_path):
    words = ["--footprint", "0.62x0.9", "--drive", "car", "--turning-radius", 0.5, "--reverse"]
    result = worldgen("maze", "--size", 30, *words, "--seed", 1, "--out", tmp_path / "w.grid")
    assert result.code == 0, result.err
    world = read_world(tmp_path / "w.grid")
    said = (
        f"cells of {world.cell_size:g} m for a car of 0.62 x 0.9 m with a turning radius of 0.5 m"
    )
    assert said in result.err
    # As from Python.
    assert world_digest(world) == world_digest(generate("maze", 1, **BODIES["car"]))


def test_a_set_keeps_the_body_in_its_header():
    header = plan_set("maze", 1, 2, {"footprint": "0.62x0.9"}).header
    assert header.params["footprint"] == "0.62x0.9"


@pytest.mark.parametrize(
    ("options", "width"),
    [
        ({}, 0.14),
        # Straight on, it is as wide as it is long.
        ({"footprint": "0.62x0.9"}, 0.9),
        # At a right angle it is tightest half way: (1.2 / 2 + 0.4) / sqrt(2).
        ({"footprint": "1.2x0.4"}, 1.0 / math.sqrt(2)),
        # The largest turning radius in a bend of 1.2 m with a disc of 0.07 m.
        (
            {
                "drive": "car",
                "turning_radius": (math.sqrt(2) * (1.2 - 0.07) - 0.07) / (math.sqrt(2) - 1),
                "reverse": True,
            },
            1.2,
        ),
    ],
)
def test_passages_are_as_wide_as_a_bend_needs(options, width):
    radius = layout_radius(robot(**options))
    assert 0.5 * width <= radius + 1e-12
    assert radius == pytest.approx(0.5 * width, rel=1e-3)


def test_a_number_is_rounded_up_and_not_further():
    assert [rounded_up(x, 2) for x in (0.1, 0.101, 0.11, 2.0, 1234.0)] == [0.1, 0.11, 0.11, 2, 1300]


def room(rows, heading=0.0, target=(2.5, 2.5), **options):
    text = rows.split()[::-1]
    walls = np.array([[letter == "#" for letter in row] for row in text])
    world = World(walls, Pose(2.5, 2.5, heading), Target(*target, 0.5), cell_size=1.0)
    return world, RobotOverrides(**options).applied_to_robot(world.robots[0])


TUNNEL = "#######\n#######\n#.....#\n#######\n#######"


def test_a_body_turns_to_a_heading_that_fits_its_start():
    world, body = room(TUNNEL, heading=math.pi / 2, footprint="2x0.8")
    placed = with_room(world, body)
    assert placed.start.heading in (0.0, math.pi, pytest.approx(math.pi), -math.pi)
    assert np.array_equal(placed.walls, world.walls)
    turned = with_fitting_heading(dataclasses.replace(world, robots=(body,)))
    assert turned.start == placed.start


def test_walls_make_way_where_a_body_fits_with_no_heading():
    world, body = room(TUNNEL, footprint="2x1.6")
    placed = with_room(world, body)
    assert placed.solid_cells < world.solid_cells
    assert placed.walls[[0, -1]].all()
    assert placed.walls[:, [0, -1]].all()


def test_the_border_leaves_no_room_for_a_body_that_is_too_large():
    world, body = room(TUNNEL, footprint="4x4")
    with raises(InvalidParameter, "no-room"):
        with_room(world, body)


def test_a_wanted_heading_at_the_target_fits_there():
    world, body = room(TUNNEL, target=(3.5, 2.5), footprint="2x0.8", target_heading="1.5708")
    placed = with_room(world, body)
    x = int(placed.target.x)
    assert not placed.walls[2:4, x].any()


def test_a_car_s_drive_is_part_of_the_world():
    drive = generate("trap", 1, **BODIES["car"]).robots[0].drive
    assert drive == Drive(0.5, reverse=True)


@pytest.mark.parametrize("drive", [{"reverse": True}, {}], ids=["reverses", "forward-only"])
def test_a_fire_spares_a_path_of_a_car(drive):
    world = generate("fire", 3, drive="car", turning_radius=0.2, **drive)
    assert check_certificate(world).valid
    assert (world.cells_at(10.0) != world.cells_at(0.0)).any()


def test_a_heading_that_any_other_is_near_is_refused_and_limits_of_a_stop_are_kept():
    with raises(InvalidParameter, "above-maximum"):
        RobotOverrides(target_heading="0:3.2")
    with pytest.raises(InvalidParameter) as refused:
        RobotOverrides(arrival="stop:0.1:0.2:0.3")
    assert "write stop:0.1:0.2;" in str(refused.value)
