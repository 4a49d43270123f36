"""The part that needs rclpy.

A node that publishes what the robot senses and listens to the driver's commands, written for ROS 2
Jazzy and later. It decides nothing: the contents of messages are in ``messages``, and their timing
in ``lockstep``.
"""

from __future__ import annotations

import time
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Quaternion, TransformStamped, TwistStamped
from geometry_msgs.msg import Twist as TwistMessage
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Float32
from std_srvs.srv import Trigger

try:
    from tf2_ros import TransformBroadcaster
except ModuleNotFoundError:  # ROS from Python packages has no tf2
    TransformBroadcaster = None

from worldgen_ros2_bridge.lockstep import Situation
from worldgen_ros2_bridge.messages import Grid, Pose, Scan, Twist, quaternion, stamp

MAP = "map"
ODOM = "odom"
BASE = "base_link"
LATCHED = QoSProfile(
    depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE
)
"""As map_server publishes a map: late subscribers get it too."""


class RosPorts:
    """ROS node that publishes the robot's sensors and listens to its commands.

    It publishes ``/clock /map /tf /odom /scan /goal_pose /signal /signal_heading /bump`` and
    subscribes to ``/cmd_vel``.

    Args:
        node: A node made by the caller, who has called ``rclpy.init``.
        stamped: Whether ``/cmd_vel`` is a TwistStamped, as with Nav2's ``enable_stamped_cmd_vel``;
            a command with a stamp older than the step is ignored, one without a stamp counts as
            new.
        reset_services: Services of type std_srvs/Trigger, called at the start of each episode.
        reset_timeout: Real time, s, that one of them may take.
    """

    def __init__(
        self,
        node: Node,
        *,
        stamped: bool = False,
        reset_services: tuple[str, ...] = (),
        reset_timeout: float = 10.0,
    ) -> None:
        self._node = node
        self._stamped = stamped
        self._reset_timeout = reset_timeout
        self._clock = node.create_publisher(Clock, "/clock", 10)
        self._map = node.create_publisher(OccupancyGrid, "/map", LATCHED)
        self._goal = node.create_publisher(PoseStamped, "/goal_pose", LATCHED)
        self._odom = node.create_publisher(Odometry, "/odom", 10)
        # Reliable, REP 2003: all subscribers match.
        self._scan = node.create_publisher(LaserScan, "/scan", 10)
        self._signal = node.create_publisher(Float32, "/signal", 10)
        self._signal_heading = node.create_publisher(Float32, "/signal_heading", 10)
        self._bump = node.create_publisher(Bool, "/bump", 10)
        self._transforms = None if TransformBroadcaster is None else TransformBroadcaster(node)
        if self._transforms is None:
            node.get_logger().warning("there is no tf2_ros, so nothing is published on /tf")
        node.create_subscription(
            TwistStamped if stamped else TwistMessage, "/cmd_vel", self._hear, 1
        )
        self._resets = [node.create_client(Trigger, name) for name in reset_services]
        self._heard: Twist | None = None
        self._now = 0.0
        self._goal_is_due = True

    def begin(self, grid: Grid | None) -> None:
        """Publish the map and make the driver reset.

        Raises:
            RuntimeError: If a reset service does not answer, or reports a failure.
        """
        self._goal_is_due = True
        if grid is not None:
            self._map.publish(_occupancy_grid(grid, self._now))
        for client in self._resets:
            if not client.wait_for_service(timeout_sec=self._reset_timeout):
                raise RuntimeError(f"there is no service {client.srv_name}")
            future = client.call_async(Trigger.Request())
            rclpy.spin_until_future_complete(self._node, future, timeout_sec=self._reset_timeout)
            if not future.done() or not future.result().success:
                raise RuntimeError(f"service {client.srv_name} did not reset")

    def publish(self, situation: Situation) -> None:
        """Publish a step: the clock first, the scan last, because drivers react to it."""
        # Commands for an earlier step must not move the robot in this one.
        self._drop_what_is_late()
        self._now = situation.time
        self._clock.publish(Clock(clock=_time(situation.time)))
        if self._transforms is not None:
            now = situation.time
            self._transforms.sendTransform(_transform(MAP, ODOM, situation.odom_in_map, now))
            self._transforms.sendTransform(_transform(ODOM, BASE, situation.odometry, now))
        # The goal is sent once per episode, as navigation stacks expect it.
        if self._goal_is_due:
            self._goal.publish(_pose_stamped(situation.target, situation.time))
            self._goal_is_due = False
        self._signal.publish(Float32(data=float(situation.signal)))
        self._signal_heading.publish(Float32(data=float(situation.signal_heading)))
        self._bump.publish(Bool(data=bool(situation.bump)))
        self._odom.publish(_odometry(situation))
        if situation.scan is not None:
            self._scan.publish(_laser_scan(situation.scan, situation.time))

    def wait(self, seconds: float) -> Twist | None:
        """Return the first command that comes; None if none does."""
        end = time.monotonic() + seconds
        while self._heard is None and (left := end - time.monotonic()) > 0.0:
            rclpy.spin_once(self._node, timeout_sec=left)
        return self._heard

    def _drop_what_is_late(self) -> None:
        rclpy.spin_once(self._node, timeout_sec=0.0)
        self._heard = None

    def _hear(self, message: Any) -> None:
        if self._stamped:
            sent = (message.header.stamp.sec, message.header.stamp.nanosec)
            if (0, 0) != sent < stamp(self._now):
                return
            message = message.twist
        if message.linear.y:
            self._node.get_logger().warning(
                "linear.y of /cmd_vel is left out: the robot cannot drive sideways", once=True
            )
        self._heard = Twist(float(message.linear.x), float(message.angular.z))


def _time(seconds: float) -> Time:
    sec, nanosec = stamp(seconds)
    return Time(sec=sec, nanosec=nanosec)


def _quaternion(heading: float) -> Quaternion:
    x, y, z, w = quaternion(heading)
    return Quaternion(x=x, y=y, z=z, w=w)


def _occupancy_grid(grid: Grid, now: float) -> OccupancyGrid:
    message = OccupancyGrid()
    message.header.frame_id = MAP
    message.header.stamp = _time(now)
    message.info.map_load_time = _time(now)
    message.info.resolution = grid.resolution
    message.info.width = grid.width
    message.info.height = grid.height
    message.info.origin.position.x = grid.origin.x
    message.info.origin.position.y = grid.origin.y
    message.info.origin.orientation = _quaternion(grid.origin.heading)
    message.data = grid.data
    return message


def _transform(parent: str, child: str, pose: Pose, now: float) -> TransformStamped:
    message = TransformStamped()
    message.header.frame_id = parent
    message.header.stamp = _time(now)
    message.child_frame_id = child
    message.transform.translation.x = pose.x
    message.transform.translation.y = pose.y
    message.transform.rotation = _quaternion(pose.heading)
    return message


def _pose_stamped(pose: Pose, now: float) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = MAP
    message.header.stamp = _time(now)
    message.pose.position.x = pose.x
    message.pose.position.y = pose.y
    message.pose.orientation = _quaternion(pose.heading)
    return message


def _odometry(situation: Situation) -> Odometry:
    message = Odometry()
    pose = situation.odometry
    message.header.frame_id = ODOM
    message.header.stamp = _time(situation.time)
    message.child_frame_id = BASE
    message.pose.pose.position.x = pose.x
    message.pose.pose.position.y = pose.y
    message.pose.pose.orientation = _quaternion(pose.heading)
    message.twist.twist.linear.x = situation.twist.speed
    message.twist.twist.angular.z = situation.twist.turn_rate
    return message


def _laser_scan(scan: Scan, now: float) -> LaserScan:
    message = LaserScan()
    message.header.frame_id = BASE
    message.header.stamp = _time(now)
    message.angle_min = scan.angle_min
    message.angle_max = scan.angle_max
    message.angle_increment = scan.angle_increment
    message.ranges = scan.ranges
    message.range_min = scan.range_min
    message.range_max = scan.range_max
    return message
