"""Whole runs have the same digest compiled and in plain Python, where numba is switched off."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

RUNS = """
import json, sys, warnings
warnings.simplefilter("ignore")  # plain NumPy warns where the digest wraps round
from tests.sim.test_episode import cup
from sim import simulate
runs = [(c, m) for c in ("turn-left", "turn-random") for m in ("swept", "endpoint", "stepped")]
print(json.dumps([simulate(cup(), c, motion=m, steps=150).trace_digest for c, m in runs]))
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
    return json.loads(done.stdout)


def test_runs_have_the_same_digests_compiled_and_interpreted():
    compiled, interpreted = digests(), digests(NUMBA_DISABLE_JIT="1")
    assert compiled == interpreted and len(set(compiled)) == len(compiled)
