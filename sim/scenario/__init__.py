"""Scenarios: everything about a run except the world.

Contents:
    Scenario: A controller and the options of its runs.
    read_settings: Reads both from a text such as ``bug2+beams=36``.
"""

from sim.scenario.scenario import Scenario, read_settings

__all__ = ["Scenario", "read_settings"]
