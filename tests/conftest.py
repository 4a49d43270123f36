"""Settings that every test shares.

Tiers, Hypothesis's profiles, and how workers share the tests.
"""

import os
import signal
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.database import DirectoryBasedExampleDatabase

# With CI set, Hypothesis would choose a profile for us, silently. This one tries the same examples
# each time, so that no change is rejected by bad luck. New examples are tried at night, and those
# that failed are kept: --hypothesis-profile.
#
# Leave out the phase "explain": it traces a failing test, and CPython 3.11.7 then never returns
# from some calls, so the test hangs instead of failing.
settings.register_profile(
    "worldgen",
    phases=tuple(phase for phase in Phase if phase is not Phase.explain),
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

# What a test runs is not added to the user's list of code that was run before.
_STATE = tempfile.TemporaryDirectory(prefix="worldgen-tests-")
for variable in ("XDG_STATE_HOME", "LOCALAPPDATA"):
    os.environ[variable] = _STATE.name

MOST_WORKERS = 8

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
