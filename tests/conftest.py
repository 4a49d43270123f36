"""Settings that every test shares.

Tiers, Hypothesis's profiles, and how workers share the tests.
"""

import itertools
import os
import signal
import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.database import DirectoryBasedExampleDatabase

from worldgen.cli.output import NO_DRAWN_SEEDS

# With CI set, Hypothesis would choose a profile for us, silently. This one tries the same examples
# each time, so that no change is rejected by bad luck. New examples are tried at night, and those
# that failed are kept: --hypothesis-profile.
settings.register_profile(
    "worldgen",
    max_examples=12,
    derandomize=True,
    deadline=None,
    database=None,
    print_blob=True,
    suppress_health_check=[
        HealthCheck.too_slow,
        HealthCheck.function_scoped_fixture,
        # Judged on the first few draws, which change with any constant in the sources.
        HealthCheck.filter_too_much,
    ],
)
EXAMPLES = (
    os.environ.get("WORLDGEN_EXAMPLES")
    or Path(__file__).parents[1] / "build" / "hypothesis-examples"
)
settings.register_profile(
    "nightly",
    settings.get_profile("worldgen"),
    max_examples=300,
    derandomize=False,
    database=DirectoryBasedExampleDatabase(EXAMPLES),
)
# For planted faults: it matters only whether a test fails, not how small its example is.
settings.register_profile(
    "unshrunk", settings.get_profile("worldgen"), phases=(Phase.explicit, Phase.generate)
)
settings.load_profile("worldgen")

# What a command prints must not depend on how fast the machine is.
os.environ["WORLDGEN_PROGRESS"] = "off"

# Nor may it depend on a seed that nobody chose, here or in a process that a test starts. A test of
# drawn seeds uses the fixture drawn_seeds.
os.environ[NO_DRAWN_SEEDS] = "1"
# What a test runs is not added to the user's list of code that was run before.
_STATE = tempfile.TemporaryDirectory(prefix="worldgen-tests-")
for variable in ("XDG_STATE_HOME", "LOCALAPPDATA"):
    os.environ[variable] = _STATE.name

MOST_WORKERS = 8


@pytest.fixture(autouse=True)
def _no_seed_from_the_system(monkeypatch):
    """Refuse a NumPy generator without a seed, as Gymnasium makes for ``reset()``."""

    def refuse(_bits):
        # trimesh makes a generator for its own names when it is imported, whenever that is.
        frame = sys._getframe()
        while frame is not None:
            if frame.f_globals.get("__name__", "").partition(".")[0] == "trimesh":
                return 1
            frame = frame.f_back
        pytest.fail("this test draws a seed from the system; give one")

    monkeypatch.setattr("numpy.random.bit_generator.randbits", refuse)


@pytest.fixture(autouse=True)
def _nothing_was_read_before(monkeypatch):
    """Forget which code the files of earlier tests have named."""
    monkeypatch.setattr("worldgen.plugins.trust._named_in", {})


@pytest.fixture
def drawn_seeds(monkeypatch):
    """Let commands draw seeds, which are 1001, 1002 and so on."""
    monkeypatch.delenv(NO_DRAWN_SEEDS)
    monkeypatch.setattr("worldgen.cli.output._fresh_seed", itertools.count(1001).__next__)


@pytest.fixture
def same_system_seed(monkeypatch):
    """Give generators without a seed the same one each time, for others' code that makes them."""
    monkeypatch.setattr("numpy.random.bit_generator.randbits", lambda _bits: 0x5EED)


# A shell's background job ignores Ctrl-C, and every process that a test starts would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config):
    """Keep the tests of a file together and in order with ``-n``.

    They may share expensive fixtures. Files are assigned in order of their names: the short ones
    come last, so no worker waits long for another.
    """
    if getattr(config.option, "numprocesses", None) and config.option.dist == "no":
        config.option.dist, config.option.loadscopereorder = "loadfile", False


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers():
    """Start a worker for each processor, but no more than there is work for, because each needs
    memory.
    """
    return min((yield), MOST_WORKERS)
