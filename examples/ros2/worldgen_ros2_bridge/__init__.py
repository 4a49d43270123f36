"""A bridge between worldgen's process protocol and a ROS 2 node that drives a robot.

Contents:
    messages: the contents of the messages, without ROS.
    lockstep: the protocol, and one exchange per step, without ROS.
    node: the part that needs rclpy.
"""
