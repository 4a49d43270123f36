"""Decide reachability for a robot with a footprint."""
