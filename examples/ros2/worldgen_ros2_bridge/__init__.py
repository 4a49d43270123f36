"""A bridge between worldgen's process protocol and a ROS 2 node that drives a robot.

Contents:
    messages: The content of each message, without ROS.
    lockstep: The protocol, and one exchange per step, without ROS.
    node: The part that needs rclpy.
"""
