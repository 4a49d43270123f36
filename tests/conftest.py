"""Settings that every test shares."""

import os
import signal

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

# In the background of a shell Ctrl-C is ignored, and so it would be by every process that a test starts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
