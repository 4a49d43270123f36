"""A node to try the bridge with: it drives ahead, and turns left where something is near.

``python wander.py`` answers each ``/scan`` with one ``/cmd_vel``, and forgets the last episode when
``/wander/reset`` is called.
"""

from __future__ import annotations

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

# m, m/s and rad/s.
NEAR = 0.5
SPEED = 0.5
TURN_RATE = 1.0
# Steps for which it keeps turning, so that it does not turn straight back.
KEPT = 10


class Wander(Node):
    """Drives ahead until something is near in front."""

    def __init__(self) -> None:
        super().__init__("wander")
        self._commands = self.create_publisher(Twist, "/cmd_vel", 1)
        self.create_subscription(LaserScan, "/scan", self._answer, 1)
        self.create_service(Trigger, "/wander/reset", self._reset)
        self._turning = 0

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._turning = 0
        response.success = True
        return response

    def _answer(self, scan: LaserScan) -> None:
        count = len(scan.ranges)
        ahead = [scan.ranges[k % count] for k in range(-(count // 8), count // 8 + 1)]
        self._turning = KEPT if min(ahead) < NEAR else max(self._turning - 1, 0)
        command = Twist()
        if self._turning:
            command.angular.z = TURN_RATE
        else:
            command.linear.x = SPEED
        self._commands.publish(command)


def main() -> None:
    """Run the node until it is ended."""
    rclpy.init()
    try:
        rclpy.spin(Wander())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
