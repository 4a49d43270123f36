"""A bridge between worldgen's process protocol and a ROS 2 node that drives a robot.

Contents:
    messages: what stands in which message, without ROS.
    lockstep: the protocol, and one exchange for each step, without ROS.
    node: the part that needs rclpy.
"""
