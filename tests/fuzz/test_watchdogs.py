"""Watchdogs over proved runs: what they see, what counts as a miss, and bad ones."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from fuzz.watchdogs import Drive, drives_of, judge, watchdog_named
from fuzz.watchdogs.drives import _natural_drives
from sim.episode import simulate
from sim.options.robot import RobotOptions
from sim.options.run import RunOptions
from sim.scenario import Scenario
from tests.helpers.commands import worldgen
from tests.helpers.errors import raises
from tests.helpers.worlds import grid_world

U_TRAP = """
........
.#####..
.#...#..
.#.S.#..
.#...#T.
.....#..
........
"""


class Never:
    def reset(self):
        self.steps = []

    def step(self, observation):
        self.steps.append(observation)
        return False
