"""Whole runs have the same digest compiled and in plain Python, where numba is switched off."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

RUNS = """
import json, sys, warnings
warnings.simplefilter("ignore")  # plain NumPy warns where the digest wraps round
from tests.sim.test_batch import burning
from tests.sim.test_episode import cup
from tests.sim.test_vector_controllers import AlwaysTheSame, TurnsAway
import numpy as np
from fuzz.features import SCENE_BYTES
from fuzz.native import evaluate
from sim import simulate, simulate_many
from sim.scenario import Scenario
from worldgen.random_streams import RandomStream
runs = [(c, m) for c in ("turn-left", "turn-random") for m in ("swept", "endpoint", "stepped")]
layouts = RandomStream(3).bits(4 * 8).astype("<u8").view(np.uint8).reshape(4, 64)[:, :SCENE_BYTES]
looks = [evaluate(layouts, Scenario(c), np.arange(4, dtype=np.uint64), 0.1, 60) for c in ("turn-random", "vfh")]
fleets = [simulate_many([cup(), burning()], c, seeds=2, steps=150, digest=True) for c in (TurnsAway(), AlwaysTheSame())]
smoke = simulate(burning(), "turn-left", steps=150, smoke=0.3, signal="weakened").trace_digest
print(json.dumps([simulate(cup(), c, motion=m, steps=150).trace_digest for c, m in runs] + [smoke]))
print(json.dumps([fleet.to_numpy().tolist() for fleet in fleets] + [look.raw.tolist() for look in looks]))
"""


def digests(**environment):
    done = subprocess.run(
        [sys.executable, "-c", RUNS],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return tuple(map(json.loads, done.stdout.splitlines()))


@pytest.mark.gate
def test_runs_have_the_same_digests_compiled_and_interpreted():
    compiled, interpreted = digests(), digests(NUMBA_DISABLE_JIT="1")
    assert compiled == interpreted and len(set(compiled[0])) == len(compiled[0])
