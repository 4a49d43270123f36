"""Run third-party controllers, named by the arguments, where nothing is in the way."""

import contextlib
import json
import sys

import numpy as np

from sim import simulate
from worldgen import Pose, Target, World

OPEN = World(
    np.zeros((30, 30), bool),
    cell_size=0.1,
    robot_radius=0.07,
    start=Pose(0.45, 1.55, 2.5),
    target=Target(2.5, 1.6, 0.07),
)

with contextlib.redirect_stdout(sys.stderr):
    verdicts = {
        name: simulate(OPEN, name, time_step=0.1, steps=600).verdict for name in sys.argv[1:]
    }
print(json.dumps(verdicts))
