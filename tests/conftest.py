"""A browser for tests of pages, and settings of Hypothesis.

`pytest --hypothesis-profile=thorough` runs 100 times the examples of every property test, `few` a sixth.
"""

import functools
import gc
from collections.abc import Iterator
from unittest.mock import patch

import pytest
from hypothesis import HealthCheck, settings

from browser import Browser, chromium

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


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """One browser for all tests of pages: to start it takes longer than most of them."""
    with chromium() as running:
        yield running


@pytest.fixture(autouse=True, scope="session")
def commands_built_once() -> Iterator[None]:
    """Typer builds all commands at each call of `main`, of which there are a thousand: 0.02 s of processor each."""
    import typer.main

    with patch.object(typer.main, "get_command", functools.cache(typer.main.get_command)):
        yield


@pytest.fixture(autouse=True)
def nothing_known(request: pytest.FixtureRequest) -> Iterator[None]:
    """What was bound with a library or function that a test replaces is not met by other tests, nor theirs by it."""
    from pendpin.runs.preparation import (
        known_dynamics,
        known_runs,
    )  # here: the process that only hands out tests needs none

    replaces = "monkeypatch" in request.fixturenames
    for cache in (known_dynamics, known_runs) if replaces else ():
        cache.known.clear()
    yield
    for cache in (known_dynamics, known_runs) if replaces else ():
        cache.known.clear()
