"""Settings that every test shares."""

import os
import signal

import pytest
from hypothesis import HealthCheck, settings

# With CI set, Hypothesis would choose for us, silently. So the choice is ours, everywhere: the gate runs the
# same examples each time, for nobody should fail to land by luck; WORLDGEN_EXAMPLES=300 searches afresh.
fresh = os.environ.get("WORLDGEN_EXAMPLES")
settings.register_profile(
    "worldgen",
    max_examples=int(fresh) if fresh else 60,
    derandomize=not fresh,
    deadline=None,
    database=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("worldgen")

MOST_WORKERS = 8

# In the background of a shell Ctrl-C is ignored, and so it would be by every process that a test starts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config):
    """With ``-n`` the tests of a file stay together and in order, for they may share what was costly to make.

    Files go out in the order of their names: the short ones are the last, and no worker waits long for another.
    """
    if getattr(config.option, "numprocesses", None) and config.option.dist == "no":
        config.option.dist, config.option.loadscopereorder = "loadfile", False


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers():
    """A worker for each processor, but no more than have work: each compiles kernels and needs memory."""
    return min((yield), MOST_WORKERS)
