"""A rclpy that keeps what is published and answers each scan with one command.

Just enough for a bridge.
"""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace
from typing import Any

MESSAGES = {
    "builtin_interfaces.msg": ["Time"],
    "geometry_msgs.msg": ["PoseStamped", "Quaternion", "TransformStamped", "Twist", "TwistStamped"],
    "nav_msgs.msg": ["OccupancyGrid", "Odometry"],
    "rosgraph_msgs.msg": ["Clock"],
    "sensor_msgs.msg": ["LaserScan"],
    "std_msgs.msg": ["Bool", "Float32"],
    "std_srvs.srv": ["Trigger"],
}


class Message:
    """Any ROS message; a field exists as soon as it is accessed."""

    def __init__(self, **fields: Any) -> None:
        self.__dict__.update(fields)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        self.__dict__[name] = Message()
        return self.__dict__[name]


class Node:
    """Keeps what is published as (topic, message), and who subscribed."""

    def __init__(self) -> None:
        self.published: list[tuple[str, Any]] = []
        self.qos: dict[str, Any] = {}
        self.hear: Any = None

    def create_publisher(self, _: type, topic: str, qos: Any) -> SimpleNamespace:
        self.qos[topic] = qos
        return SimpleNamespace(publish=lambda message: self.published.append((topic, message)))

    def create_subscription(self, _: type, topic: str, callback: Any, __: Any) -> None:
        assert topic == "/cmd_vel"
        self.hear = callback

    def on(self, topic: str) -> list[Any]:
        return [message for name, message in self.published if name == topic]


def modules(commands: list[Any]) -> dict[str, ModuleType]:
    """What ``sys.modules`` needs.

    A spin with a timeout receives the next command; one without a timeout receives none.
    """
    made = {
        name: ModuleType(name)
        for name in [*MESSAGES, "rclpy", "rclpy.node", "rclpy.qos", "tf2_ros"]
    }
    for name, types in MESSAGES.items():
        for kind in types:
            setattr(made[name], kind, type(kind, (Message,), {}))

    def spin_once(node: Node, timeout_sec: float) -> None:
        if timeout_sec > 0.0 and commands:
            node.hear(commands.pop(0))

    class Broadcaster:
        def __init__(self, node: Node) -> None:
            self._node = node

        def sendTransform(self, transform: Any) -> None:  # noqa: N802 - tf2_ros calls it so
            self._node.published.append(("/tf", transform))

    vars(made["rclpy"])["spin_once"] = spin_once
    vars(made["rclpy.node"])["Node"] = Node
    policies = SimpleNamespace(TRANSIENT_LOCAL="transient local", RELIABLE="reliable")
    vars(made["rclpy.qos"]).update(
        QoSProfile=SimpleNamespace, DurabilityPolicy=policies, ReliabilityPolicy=policies
    )
    vars(made["tf2_ros"])["TransformBroadcaster"] = Broadcaster
    parents = {name.partition(".")[0] for name in made}
    return {
        **{name: ModuleType(name) for name in parents - sys.modules.keys() - made.keys()},
        **made,
    }
