"""Different states with equal fingerprints invent no loop: what is claimed is proved, or the budget decides."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# With numba switched off the fingerprint is a plain function, which can be replaced.
RUNS = """
import json, sys, warnings
warnings.simplefilter("ignore")  # plain NumPy warns where a fingerprint wraps round
import numpy as np
from sim import Command, CompiledController, simulate, simulate_many
from sim.controllers import Commands
from sim.kernels import recurrence
from tests.sim.test_episode import cup

MASK = np.uint64(int(sys.argv[1]))
STEPS = 90


def count_to(period):
    def act(observation, memory, command):
        memory[0] = (memory[0] + 1.0) % period
    return CompiledController("counts", act, (0.0,))


class Counts:
    def __init__(self, period):
        self.period = period

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(0.0, 0.0), ((memory[0] + 1.0) % self.period,)


class CountsMany(Counts):
    act = None

    def act_many(self, observation, memory):
        return Commands(0.0, 0.0), (memory + 1.0) % self.period


def runs():
    for period in (1, 7, 40, 1_000):  # the last one does not come back within the budget
        for make in (count_to, Counts):
            run = simulate(cup(), make(period), steps=STEPS)
            yield run.verdict, run.steps
        for make in (count_to, CountsMany):
            run = simulate_many([cup()], make(period), seeds=1, steps=STEPS)
            yield str(run.verdicts[0]), int(run.steps[0])
    for motion in ("swept", "stepped"):
        run = simulate(cup(), "turn-left", motion=motion, steps=STEPS)
        yield run.verdict, run.steps


whole = list(runs())
of_few, of_all = recurrence._fingerprint_of_few, recurrence._fingerprint
recurrence._fingerprint_of_few = lambda state: of_few(state) & MASK
recurrence._fingerprint = lambda search, state: of_all(search, state) & MASK
print(json.dumps([whole, list(runs())]))
"""


def outcomes(mask):
    """Verdict and steps of each run, where a loop ends with its first period: with the whole
    fingerprint and with these bits of it."""
    done = subprocess.run(
        [sys.executable, "-c", RUNS, str(mask)],
        cwd=ROOT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.gate
@pytest.mark.parametrize("mask", [0, 0xF << 60], ids=["all equal", "four bits"])
def test_equal_fingerprints_of_different_states_invent_no_loop(mask):
    whole, masked = outcomes(mask)
    assert sum(verdict == "loop" for verdict, _ in whole) == 12
    for honest, found in zip(whole, masked, strict=True):
        assert found == honest or (found[0] != "loop" and found[1] >= honest[1])
    assert 0 < sum(verdict == "loop" for verdict, _ in masked) < 12
