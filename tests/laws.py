"""How many examples a property test runs, under each profile of conftest.py; and when a test gives up waiting."""

import time
from collections.abc import Callable

from hypothesis import settings

POLL = 0.05  # s between two looks at what is waited for
HANG = 900.0  # s until what waits is taken to wait for ever; nothing else is decided by it, on however busy a machine


def law(examples: int) -> settings:
    """So many examples in the usual profile, in proportion in others."""
    return settings(max_examples=max(1, examples * settings.default.max_examples // 100))


def sooner_or_later(holds: Callable[[], object]) -> bool:
    """Whether a condition comes to hold, looked at so often that HANG has passed at the least."""
    for _ in range(round(HANG / POLL)):
        if holds():
            return True
        time.sleep(POLL)
    return False
