"""Settings that every test shares."""

import os

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
