"""examples/published_equations.py finds both faults of the printed equations, and the mends that go with each."""

import runpy
from pathlib import Path

import pytest
from rich.console import Console

EXAMPLE = Path(__file__).parents[1] / "examples" / "published_equations.py"


@pytest.fixture(scope="module")
def example():
    """The example's names, without running its main."""
    return runpy.run_path(str(EXAMPLE))


@pytest.fixture(scope="module")
def rows(example):
    """Its comparison with Pinocchio, by quantity and version."""
    return example["many_states"](Console(quiet=True))


FAULTS = {
    "as printed": {"theta_dd", "phi_dd", "R1", "R2", "R3"},
    "m l²/12": {"R3"},
    "sign": {"theta_dd", "phi_dd", "R1", "R2"},
    "both": set(),
}


@pytest.mark.parametrize("version", FAULTS)
def test_which_equations_fail(rows, version):
    assert {name for (name, second), row in rows.items() if second == version and not row.ok} == FAULTS[version]
    # of the size of the vector that a component belongs to: far above rounding, 1e-16
    assert all(row.relative > 5e-3 for (name, second), row in rows.items() if second == version and not row.ok)


def test_pendpins_own_routes_stay_within_the_bound(rows):
    assert all(row.ok for (_, second), row in rows.items() if second not in FAULTS)


def test_it_says_what_mends_each_equation(example, rows):
    verdict = list(example["verdict"](rows))
    assert len(verdict) == 5
    assert [line for line in verdict if "m l²/12" in line] == verdict[:4]
    assert verdict[4].startswith("R3 fails as printed; the sign")
