"""OMPL's Dubins and Reeds-Shepp spaces agree with ours about the shortest paths of a car."""

import json
import math

import numpy as np
import pytest

from tests.clients.environments import client
from worldgen import Pose
from worldgen.reach.car.curves import curves

_PAIRS = 4000


def _pairs():
    """Pairs of poses from near to far, a fifth of them on a grid, where words change places."""
    rng = np.random.default_rng(40)
    for number in range(_PAIRS):
        poses = rng.uniform(-1, 1, (2, 3)) * [1, 1, math.pi] * 10.0 ** rng.integers(-1, 2)
        poses[:, 2] = rng.uniform(-math.pi, math.pi, 2)
        if number % 5 == 0:
            poses[1, :2] = poses[0, :2] + rng.integers(-3, 4, 2)
            poses[1, 2] = math.remainder(poses[0, 2] + rng.integers(4) * math.pi / 2, math.tau)
        yield {"radius": float(rng.choice([0.5, 1.0, 3.0])), "poses": poses.tolist()}


def test_the_shortest_paths_of_cars_are_as_long_as_ompl_says(tmp_path):
    pairs = list(_pairs())
    (tmp_path / "pairs.json").write_text(json.dumps(pairs))
    said = client("ompl").ask("ompl_distances.py", tmp_path / "pairs.json")
    for name, reverse in (("dubins", False), ("reeds_shepp", True)):
        ours = [
            curves(*(Pose(*pose) for pose in pair["poses"]), pair["radius"], reverse=reverse)[0]
            for pair in pairs
        ]
        assert [curve.length for curve in ours] == pytest.approx(said[name], abs=1e-6)
