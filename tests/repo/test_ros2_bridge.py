"""The bridge to ROS 2: angles, frames, lockstep; rclpy is a fake here."""

import importlib
import json
import math
import shlex
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim import Command, ProcessController, simulate
from tests.helpers import fake_ros
from tests.helpers.command_line import worldgen
from worldgen import Pose, Target, World, generate
from worldgen.files.grid import dumps, write_world
from worldgen.world import Provenance

FOLDER = Path(__file__).parents[2] / "examples" / "ros2"


@pytest.fixture
def bridge(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    names = ("messages", "lockstep")
    return SimpleNamespace(
        **{name: importlib.import_module(f"worldgen_ros2_bridge.{name}") for name in names}
    )


def room(**changes) -> World:
    """3 x 2 m, the robot at (1, 0.5) m."""
    return World(
        np.zeros((20, 30), bool),
        cell_size=0.1,
        robot_radius=0.1,
        start=Pose(1.0, 0.5, 0.0),
        target=Target(2.5, 1.5, 0.1),
        **changes,
    )


class Recorder:
    """Sends the same command forever and keeps its observations."""

    def __init__(self, speed, turn_rate):
        self.command, self.seen = Command(speed, turn_rate), []

    def reset(self):
        return ()

    def act(self, observation, memory):
        self.seen.append(observation)
        return self.command, memory


class Ports:
    """A driver that sends a list of commands; None if it sends nothing in time."""

    def __init__(self, *commands):
        self.commands, self.situations, self.grids = list(commands), [], []

    def begin(self, grid):
        self.grids.append(grid)

    def publish(self, situation):
        self.situations.append(situation)

    def wait(self, seconds):
        return self.commands.pop(0) if self.commands else None


def lines(world, speed=0.4, turn_rate=0.3, steps=3, **options):
    """A reset line and observations, as a program gets them."""
    recorder = Recorder(speed, turn_rate)
    simulate(world, recorder, steps=steps, time_step=0.1, **options)
    observations = [
        json.dumps({**seen._asdict(), "time": 0.1 * k})
        for k, seen in enumerate(recorder.seen, start=1)
    ]
    return ['{"worldgen":1,"reset":{"time_step":0.1,"top_speed":2.0,"radius":0.1}}', *observations]


def test_an_occupancy_grid_has_the_worlds_cells_row_by_row_from_below(bridge):
    world = generate("rooms", 3, size=24)
    grid = bridge.messages.grid_of(dumps(world).decode())
    assert (grid.width, grid.height, grid.resolution) == (
        world.width,
        world.height,
        world.cell_size,
    )
    assert (np.reshape(grid.data, (grid.height, grid.width)) == np.where(world.walls, 100, 0)).all()


def test_the_origin_of_an_imported_map_is_kept(bridge):
    made = Provenance("import", 1, 0, {"format": "ros", "origin": [-12.5, 8.0]})
    grid = bridge.messages.grid_of(dumps(room(provenance=made)).decode())
    assert (grid.origin.x, grid.origin.y) == (-12.5, 8.0)
    assert bridge.messages.pose_in_map(bridge.messages.Pose(1.0, 2.0, 0.3), grid).x == -11.5


def test_a_text_that_is_no_grid_file_is_refused(bridge):
    with pytest.raises(ValueError, match="this is no"):
        bridge.messages.grid_of("type octile\n")


@pytest.mark.parametrize("field", [0.0, math.pi])
@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_a_scan_says_where_the_walls_are(bridge, field, heading):
    world = room()
    recorder = Recorder(0.0, heading / 0.1)
    simulate(world, recorder, steps=3, time_step=0.1, beams=9, beam_range=10.0, beam_field=field)
    seen = recorder.seen[0 if heading == 0.0 else 1]
    scan = bridge.messages.scan_of(seen.beams, 10.0, field)
    for k, distance in enumerate(scan.ranges):
        angle = seen.heading + scan.angle_min + k * scan.angle_increment
        x, y = seen.x + distance * math.cos(angle), seen.y + distance * math.sin(angle)
        assert min(abs(x), abs(3.0 - x), abs(y), abs(2.0 - y)) < 0.002
    assert scan.angle_max == pytest.approx(scan.angle_min + 8 * scan.angle_increment)


def test_a_beam_that_meets_nothing_is_infinite(bridge):
    assert bridge.messages.scan_of([5.0, 4.9], 5.0).ranges == [math.inf, 4.9]


def test_a_heading_as_quaternion_turns_the_x_axis_there(bridge):
    x, y, z, w = bridge.messages.quaternion(2.0)
    assert (x, y, math.atan2(2.0 * w * z, 1.0 - 2.0 * z * z)) == (0.0, 0.0, pytest.approx(2.0))


def test_a_time_has_whole_nanoseconds(bridge):
    assert bridge.messages.stamp(1.9999999999) == (2, 0)
    assert bridge.messages.stamp(0.015) == (0, 15_000_000)


def test_odometry_placed_where_odom_lies_in_the_map_is_the_true_pose(bridge):
    ports = Ports()
    served = bridge.lockstep.Bridge(ports)
    for line in lines(room(), speed=1.0, turn_rate=2.0, odometry_noise=0.5):
        served.answer(line)
    last = ports.situations[-1]
    found = bridge.messages.composed(last.odom_in_map, last.odometry)
    assert (found.x, found.y) == (pytest.approx(last.base.x), pytest.approx(last.base.y))
    assert found.heading == pytest.approx(last.base.heading)
    assert last.odometry != last.base


def test_the_measured_twist_is_what_was_commanded(bridge):
    ports = Ports()
    served = bridge.lockstep.Bridge(ports)
    for line in lines(room(), speed=-0.4, turn_rate=0.3, steps=4):
        served.answer(line)
    twist = ports.situations[-1].twist
    assert (twist.speed, twist.turn_rate) == (
        pytest.approx(-0.4, abs=0.003),
        pytest.approx(0.3, abs=0.003),
    )


def test_a_command_holds_for_a_while_then_the_robot_stops(bridge):
    served = bridge.lockstep.Bridge(
        Ports(None, bridge.messages.Twist(0.7, -0.2)), None, bridge.lockstep.Settings(keep=0.25)
    )
    answers = [served.answer(line) for line in lines(room(), steps=7)]
    speeds = [json.loads(answer)["speed"] for answer in answers if answer]
    assert speeds[:6] == [0.0, 0.7, 0.7, 0.7, 0.0, 0.0]


def test_time_never_goes_back_and_each_episode_begins_with_the_map(bridge):
    ports, grid = Ports(), bridge.messages.grid_of(dumps(room()).decode())
    served = bridge.lockstep.Bridge(ports, grid)
    for line in lines(room()) * 3:
        served.answer(line)
    times = [situation.time for situation in ports.situations]
    assert times == sorted(set(times))
    assert ports.grids == [grid] * 3


def test_another_version_of_the_protocol_is_refused(bridge):
    with pytest.raises(ValueError, match="speaks version 1"):
        bridge.lockstep.Bridge(Ports()).answer('{"worldgen":2,"reset":{}}')


DRIVER = """
import sys
from worldgen_ros2_bridge.lockstep import Bridge, serve
from worldgen_ros2_bridge.messages import Twist

class Ports:
    def begin(self, grid):
        pass
    def publish(self, situation):
        self.scan = situation.scan
    def wait(self, seconds):
        return Twist(0.6, 1.5 if self.scan.ranges[0] < 0.5 else 0.1)

serve(Bridge(Ports()), sys.stdin, sys.stdout)
"""


class Rule:
    """The same rule as a class."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(0.6, 1.5 if observation.beams[0] < 0.5 else 0.1), memory


def test_a_driver_behind_the_bridge_drives_as_the_same_rule_in_a_class(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(FOLDER))
    (tmp_path / "driver.py").write_text(DRIVER)
    world = generate("rooms", 5, size=20)
    with ProcessController([sys.executable, str(tmp_path / "driver.py")]) as program:
        bridged = simulate(world, program, steps=150, beams=12, record=True)
    direct = simulate(world, Rule(), steps=150, beams=12, record=True)
    assert (bridged.steps, bridged.trace_digest) == (direct.steps, direct.trace_digest)


@pytest.fixture
def node_module(bridge, monkeypatch):
    commands = []
    for name, module in fake_ros.modules(commands).items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.delitem(sys.modules, "worldgen_ros2_bridge.node", raising=False)
    yield importlib.import_module("worldgen_ros2_bridge.node"), commands
    sys.modules.pop("worldgen_ros2_bridge.node", None)


def twist(x, z, sec=None):
    said = fake_ros.Message(linear=fake_ros.Message(x=x, y=0.0), angular=fake_ros.Message(z=z))
    return (
        said
        if sec is None
        else fake_ros.Message(
            header=fake_ros.Message(stamp=fake_ros.Message(sec=sec, nanosec=0)), twist=said
        )
    )


def test_one_exchange_publishes_the_robot_and_hears_its_driver(bridge, node_module):
    module, commands = node_module
    node, grid = fake_ros.Node(), bridge.messages.grid_of(dumps(room()).decode())
    served = bridge.lockstep.Bridge(module.RosPorts(node), grid)
    commands.append(twist(0.5, -1.0))
    answers = [served.answer(line) for line in lines(room(), steps=2, beams=4)[:2]]
    assert json.loads(answers[1]) == {"speed": 0.5, "turn_rate": -1.0}
    topics = [topic for topic, _ in node.published]
    assert topics == [
        "/map",
        "/clock",
        "/tf",
        "/tf",
        "/goal_pose",
        "/signal",
        "/signal_heading",
        "/bump",
        "/odom",
        "/scan",
    ]
    assert node.qos["/map"].durability == "transient local"
    assert (
        node.qos["/scan"] == 10
    )  # a depth alone means reliable, which matches both kinds of subscribers
    assert len(node.on("/scan")[0].ranges) == 4
    assert node.on("/odom")[0].header.stamp.sec == node.on("/clock")[0].clock.sec
    assert node.on("/goal_pose")[0].pose.position.x == pytest.approx(2.5, abs=0.001)


def test_a_stamped_command_of_an_earlier_step_is_not_heard(bridge, node_module):
    module, commands = node_module
    served = bridge.lockstep.Bridge(module.RosPorts(fake_ros.Node(), stamped=True))
    commands += [twist(0.9, 0.0, sec=1), twist(0.5, 0.0, sec=2)]
    answers = [served.answer(line) for line in lines(room(), steps=2)[:2]]
    assert json.loads(answers[1])["speed"] == 0.5


def test_a_stamped_command_without_a_stamp_counts_as_of_now(bridge, node_module):
    module, commands = node_module
    served = bridge.lockstep.Bridge(module.RosPorts(fake_ros.Node(), stamped=True))
    commands += [twist(0.9, 0.0, sec=0)]
    answers = [served.answer(line) for line in lines(room(), steps=2)[:2]]
    assert json.loads(answers[1])["speed"] == 0.9


@pytest.mark.gate
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "No such file"),
        ("%worldgen-grid 1\n%cells\n..\n", "cell_size is missing"),
        ("type octile", "this is no"),
    ],
    ids=["gone", "no cell size", "foreign"],
)
def test_a_map_that_is_none_ends_the_bridge_with_a_sentence(text, message, tmp_path):
    path = tmp_path / "map.grid"
    if text is not None:
        path.write_text(text)
    code = [sys.executable, "-m", "worldgen_ros2_bridge", "--map", str(path)]
    done = subprocess.run(code, cwd=FOLDER, capture_output=True, text=True, check=False)
    assert (
        done.returncode == 1
        and done.stderr.startswith(f"--map {path}: ")
        and message in done.stderr
    )
    assert done.stderr.count("\n") == 1


PARAMS = """
controller_server:
  ros__parameters:
    controller_frequency: 10.0
    general_goal_checker:
      plugin: "nav2_controller::StoppedGoalChecker"
      xy_goal_tolerance: 0.2
      yaw_goal_tolerance: 0.3
      trans_stopped_velocity: 0.1
local_costmap:
  local_costmap:
    ros__parameters:
      footprint: "[]"
      robot_radius: 0.11
global_costmap:
  global_costmap:
    ros__parameters:
      footprint: "[[0.1, 0.06], [0.1, -0.06], [-0.1, -0.06], [-0.1, 0.06]]"
"""


@pytest.mark.parametrize(
    ("text", "options", "remark"),
    [
        (
            PARAMS,
            ["--time-step=0.1", "--footprint=0.1,0.06 0.1,-0.06 -0.1,-0.06 -0.1,0.06",
             "--arrival=stop:0.1:0.25", "--target-radius=0.2", "--target-heading=0:0.3"],
            "",
        ),
        ("local_costmap: {robot_radius: 0.22}", ["--time-step=0.05"], "for worldgen import: --radius 0.22\n"),
        (
            "plugin: nav2_controller/SimpleGoalChecker",
            ["--time-step=0.05", "--arrival=step", "--target-radius=0.25", "--target-heading=0:0.25"],
            "",
        ),
    ],
)  # fmt: skip
def test_parameters_of_nav2_become_options_that_a_run_takes(text, options, remark, tmp_path):
    params = tmp_path / "nav2_params.yaml"
    params.write_text(text)
    command = [sys.executable, FOLDER / "nav2_options.py", params, "0"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert shlex.split(done.stdout) == options
    assert done.stderr == remark
    write_world(room(), tmp_path / "w.grid")
    ended = worldgen("run", tmp_path / "w.grid", "--controller", "bug2", *options)
    assert ended.code in (0, 1), ended.err
