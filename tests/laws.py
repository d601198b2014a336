"""How many examples a property test runs, under each profile of conftest.py; and when a test gives up waiting."""

from hypothesis import settings

HANG = 900.0  # s until what waits is taken to wait for ever; nothing else is decided by it, on however busy a machine


def law(examples: int) -> settings:
    """So many examples in the usual profile, in proportion in others."""
    return settings(max_examples=max(1, examples * settings.default.max_examples // 100))
