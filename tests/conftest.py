"""A browser for tests of pages, and settings of Hypothesis.

`pytest --hypothesis-profile=thorough` runs 100 times the examples of every property test, `few` a sixth.
"""

import gc
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

from browser import Browser, chromium
from pendpin.runs.preparation import known_dynamics, known_runs

# no deadlines, no looks at how fast examples come: nothing here depends on a clock
settings.register_profile("usual", max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("thorough", settings.get_profile("usual"), max_examples=6_000, print_blob=True)
settings.register_profile("few", parent=settings.get_profile("usual"), max_examples=10)
settings.load_profile("usual")


def pytest_collectstart() -> None:
    """Reading the tests makes a million objects and no garbage: no search for any, a third of the time of reading."""
    gc.disable()


def pytest_collection_finish() -> None:
    """What stays until the end is not searched again and again: 0.7 s of processor each time."""
    gc.freeze()
    gc.set_threshold(100_000, 20, 20)
    gc.enable()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """A browser for the tests of a file."""
    with chromium() as running:
        yield running


@pytest.fixture(autouse=True)
def nothing_known(request: pytest.FixtureRequest) -> Iterator[None]:
    """What was bound with a library or function that a test replaces is not met by other tests, nor theirs by it."""
    replaces = "monkeypatch" in request.fixturenames
    for cache in (known_dynamics, known_runs) if replaces else ():
        cache.known.clear()
    yield
    for cache in (known_dynamics, known_runs) if replaces else ():
        cache.known.clear()
