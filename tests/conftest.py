"""Settings of Hypothesis: `pytest --hypothesis-profile=thorough` runs 100 times the examples of every property test."""

from hypothesis import HealthCheck, settings

# no deadlines, no looks at how fast examples come: nothing here depends on a clock
settings.register_profile("usual", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("thorough", settings.get_profile("usual"), max_examples=10_000, print_blob=True)
settings.load_profile("usual")
