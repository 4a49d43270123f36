"""Settings that every test shares."""

from hypothesis import HealthCheck, settings

# With CI set, Hypothesis silently derandomises and drops its database; so the profile is ours, everywhere.
settings.register_profile(
    "worldgen",
    deadline=None,
    derandomize=False,
    database=None,
    max_examples=60,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("worldgen")
