"""Pictures and metrics of bodies and cars: outlines instead of discs, the goal's heading, the slack."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.command_line import worldgen
from worldgen import Pose, Robot, Target, Witness, World, render, write_world
from worldgen.difficulty import OF_DISCS, measure
from worldgen.render import terminal
from worldgen.render.body_parts import BodyPose, outline, tightest_pose
from worldgen.render.caption import facts
from worldgen.render.frame import Frame
from worldgen.render.primitives import DrawnCircle, DrawnLine, Text
from worldgen.render.scene import compose
from worldgen.robot import Drive

BAR = ((0.4, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.4, -0.1))
START = Pose(0.55, 1.05, 0.0)


def hall(footprint=BAR, drive=None, clearance=0.05, **goal):
    """A hall of 4 x 2 m, half of it narrowed to 0.3 m."""
    walls = np.zeros((20, 40), bool)
    walls[[0, -1]], walls[:, [0, -1]] = True, True
    walls[:9, 15:25], walls[12:, 15:25] = True, True
    target = Target(3.05, 1.05, 0.1, **goal)
    robot = Robot(START, target, 0.2, 1.0, footprint, drive or Drive())
    path = Witness([0.0, 2.5], [0.55, 3.05], [1.05, 1.05], clearance, [0.0, 0.0])
    plain = World(walls, cell_size=0.1, robots=[robot])
    return plain if robot.is_plain else replace(plain, certificate=path)


def parts(world, trail=None):
    made = compose(world, trail, signal=False, witness=True, title="", pixels=800)
    return made.primitives


def polygons(world, trail=None):
    """The closed lines with as many corners as the body, as their points, px."""
    count = len(world.robots[0].footprint)
    return [
        part.points
        for part in parts(world, trail)
        if isinstance(part, DrawnLine) and part.closed and len(part.points) == count
    ]


def has_outline(world, pose, trail=None):
    wanted = Frame.of(world, 800).points(outline(world.robots[0], BodyPose(*pose)))
    return any(np.allclose(found, wanted) for found in polygons(world, trail))


def words(world):
    return [part.text for part in parts(world) if isinstance(part, Text)]


def test_a_body_is_drawn_at_its_start_as_its_polygon():
    world = hall()
    assert has_outline(world, (START.x, START.y, START.heading))
    radius = world.robot_radius * Frame.of(world, 800).scale
    discs = [part for part in parts(world) if isinstance(part, DrawnCircle)]
    assert not any(abs(disc.radius - radius) < 1e-6 for disc in discs)


def test_a_few_outlines_lie_along_the_witness():
    assert 4 <= len(polygons(hall())) <= 20


def test_the_tightest_place_is_marked_with_what_is_to_spare():
    world = hall()
    x, y, heading = tightest_pose(world, world.certificate)
    assert (y, heading) == (1.05, 0.0) and x + 0.4 > 1.1 and x - 0.2 < 2.5
    assert has_outline(world, (x, y, heading))
    assert "0.05 m to spare at heading 0 degrees" in words(world)
    assert "touches a wall at heading 0 degrees" in words(hall(clearance=0.0))


def test_a_disc_has_no_tightest_place():
    world = hall(footprint=(), heading=1.0)
    assert tightest_pose(world, world.certificate) is None
    assert not any("to spare" in text for text in words(world))


def test_a_goal_with_a_heading_has_a_wedge_and_the_body_as_it_will_stand():
    plain, aimed = hall(), hall(heading=1.5)
    assert len(parts(aimed)) > len(parts(plain))
    assert has_outline(aimed, (3.05, 1.05, 1.5)) and not has_outline(plain, (3.05, 1.05, 1.5))


def test_a_car_has_wheels_at_its_axle():
    assert len(parts(hall(drive=Drive(0.5)))) == len(parts(hall())) + 2


def test_a_trail_ends_in_the_body_at_its_heading():
    trail = render.Trail([0.55, 1.0], [1.05, 1.05], headings=[0.0, 0.3])
    assert has_outline(hall(), (1.0, 1.05, 0.3), trail)
    # Without headings nobody knows how it stood.
    assert not has_outline(hall(), (1.0, 1.05, 0.3), render.Trail([0.55, 1.0], [1.05, 1.05]))


@pytest.mark.parametrize(
    ("world", "expected"),
    [
        (hall(), "body of 0.6 x 0.2 m"),
        (hall(drive=Drive(0.5)), "car of 0.6 x 0.2 m with a turning radius of 0.5 m"),
        (hall(footprint=()), "robot radius 0.2 m"),
    ],
    ids=["body", "car", "disc"],
)
def test_the_caption_names_the_body(world, expected):
    assert expected in facts(world)


@pytest.mark.parametrize("suffix", ["png", "svg", "html"])
def test_show_draws_a_body_in_every_form(suffix, tmp_path):
    write_world(hall(), tmp_path / "h.grid")
    result = worldgen("show", tmp_path / "h.grid", "--picture", tmp_path / f"h.{suffix}")
    assert result.code == 0, result.err


def test_the_terminal_shows_the_polygon_at_the_start():
    grid = terminal._Grid(cells=1, dots_per_cell=4, dot_size=0.025)
    rows, columns = np.nonzero(grid.dots(hall(), ()) == terminal.START_DOT)
    # A bar is longer than it is wide; a disc would be as high as it is long.
    assert np.ptp(columns) + 1 == pytest.approx(3 * (np.ptp(rows) + 1), abs=2)


@pytest.mark.parametrize("drive", [Drive(), Drive(0.5)], ids=["body", "car"])
def test_a_body_has_no_metrics_of_discs_but_a_slack(drive):
    metrics = measure(hall(drive=drive)).as_dict()
    assert not OF_DISCS & metrics.keys()
    assert metrics["slack"] == 0.05 and metrics["length"] == 2.5
    assert "bottleneck" in measure(hall(footprint=())).as_dict()


def test_measure_says_what_it_leaves_out(tmp_path):
    write_world(replace(hall(), certificate=None), tmp_path / "h.grid")
    result = worldgen("measure", tmp_path / "h.grid")
    assert "slack" in result.out and "bottleneck" not in result.out
    assert "about discs" in result.err
