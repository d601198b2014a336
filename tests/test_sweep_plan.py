"""The cases of a sweep: names by trial of every tail, places in a grid, spreads by their quantiles, what is refused."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, norm, uniform

import pendpin as pp
from laws import law
from pendpin.sweeps import plan

PARTS = st.lists(st.sampled_from(["a", "b", "a_b", "b_a"]), min_size=1, max_size=3)


@law(150)
@given(st.lists(PARTS.map(".".join), min_size=1, max_size=5, unique=True))
def test_short_names_are_the_shortest_that_tell_keys_apart(keys: list[str]) -> None:
    """The last parts of a key, as few as no other key ends with; one that has no such end is named by its place."""
    ends = [["_".join(key.split(".")[-n:]) for n in range(1, key.count(".") + 2)] for key in keys]
    names = plan.short_names(keys)
    assert len(set(names)) == len(keys)
    for i, (name, own) in enumerate(zip(names, ends, strict=True)):
        taken = {end for other in ends[:i] + ends[i + 1 :] for end in other} | {*names[:i]}
        free = [end for end in own if end not in taken]
        assert name == (free[0] if free else f"varied_{i + 1}")


@pytest.mark.parametrize("key", ["model.why", "model.case", "model.rods[0]"])
def test_names_that_a_result_has_already_are_not_taken(key: str) -> None:
    """Nor numbers alone: the next longer end of the key."""
    assert plan.short_names([key]) == ["_".join(key.replace("[0]", ".0").split(".")[-2:])]


def test_a_grid_has_its_cases_in_the_order_of_loops() -> None:
    """The last key changes first; pairs go side by side; every sweep has a digest of its own."""
    values = {"a": [1.0, 2.0, 3.0], "b": [5.0, 6.0], "c": [7.0, 8.0]}
    grid = plan.grid(values)
    assert (grid.count, grid.shape, grid.dims) == (12, (3, 2, 2), {"a": 3, "b": 2, "c": 2})
    assert grid.rows(np.arange(12)).tolist() == [list(row) for row in product(*values.values())]
    assert grid.rows(np.array([7, 0])).tolist() == [[2, 6, 8], [1, 5, 7]]
    pairs = plan.pairs({key: row[:2] for key, row in values.items()})
    assert (pairs.count, pairs.shape, pairs.dims) == (2, (2,), {"case": 2})
    assert pairs.rows(np.array([1, 0])).tolist() == [[2, 6, 8], [1, 5, 7]]
    others = [
        plan.grid(values | {"c": [7.0, 8.5]}),
        plan.grid(values | {"d": [1.0]}),
        plan.grid({"a": [1.0]}),
        plan.pairs({"a": [1.0]}),
    ]
    assert len({one.identity for one in (grid, pairs, *others)}) == 6
    assert plan.grid(values).identity == grid.identity


@pytest.mark.parametrize("method", plan.METHODS)
def test_spreads_have_their_distributions(method: str) -> None:
    """Uniform between its bounds, normal by mean and deviation, each number independent of the other."""
    spreads = {"a": ("uniform", -2.0, 4.0), "b": ("normal", 3.0, 0.5)}
    a, b = plan.samples(spreads, 512, method, seed=2).rows(np.arange(512)).T
    assert kstest(a, uniform(-2.0, 6.0).cdf).statistic < 0.06
    assert kstest(b, norm(3.0, 0.5).cdf).statistic < 0.06
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.12
    ends = {"latin": 512, "sobol": 512, "random": 2}[method]
    assert a.min() < -2 + 12 / ends
    assert a.max() > 4 - 12 / ends


def test_spreads_are_read_as_they_are_written() -> None:
    """LOW:HIGH, or normal(MEAN,DEVIATION)."""
    assert plan.read_spreads(["a=-1:3", "b = normal(2, 0.5)"]) == {
        "a": ("uniform", -1.0, 3.0),
        "b": ("normal", 2.0, 0.5),
    }


@pytest.mark.parametrize(
    ("texts", "says"),
    [
        (["a=1:2:0"], "FROM:TO:COUNT with a count from 1 to 100000000"),
        (["a=1:2:100000001"], "FROM:TO:COUNT"),
        (["a=1:2:-3"], "FROM:TO:COUNT"),
        (["a=1:2:3:4"], "FROM:TO:COUNT"),
        (["a=1,x"], "a: 'x' is not a number"),
        (["a=y:2:3"], "a: 'y' is not a number"),
        (["a=1:z:3"], "a: 'z' is not a number"),
        (["a"], "'a' is not KEY=FROM:TO:COUNT"),
        (["a=1", "a=2"], "a is given twice"),
    ],
)
def test_axes_that_cannot_be_are_refused(texts: list[str], says: str) -> None:
    """One line with the key."""
    with pytest.raises(pp.InputError, match=says):
        plan.read_axes(texts)
    assert len(plan.read_axes(["a=1:2:100000"])["a"]) == 100_000


@pytest.mark.parametrize(
    ("spread", "says"),
    [
        ("a=3:3", "a lower and a higher number"),
        ("a=4:3", "a lower and a higher number"),
        ("a=0:inf", "a lower and a higher number"),
        ("a=normal(1,0)", "a standard deviation above 0"),
        ("a=normal(1,-2)", "a standard deviation above 0"),
        ("a=normal(1,inf)", "a standard deviation above 0"),
        ("a=1:2:3", "LOW:HIGH or normal"),
        ("a=1", "LOW:HIGH or normal"),
    ],
)
def test_spreads_that_cannot_be_are_refused(spread: str, says: str) -> None:
    """One line with the key and what is wanted."""
    with pytest.raises(pp.InputError, match=says):
        plan.samples(plan.read_spreads([spread]), 4)


def test_values_that_cannot_be_are_refused_by_key() -> None:
    """Nothing, something else than numbers, a table, an infinite number, and more cases than a sweep can have."""
    for values, says in (
        ({}, "nothing is varied"),
        ({"a": []}, r"a: a list of one or more numbers is wanted, not shape \(0,\)"),
        ({"a": [[1.0, 2.0]]}, r"not shape \(1, 2\)"),
        ({"a": ["x"]}, "a: .* are not numbers"),
        ({"a": [True]}, "a: .* are not numbers"),
        ({"a": [1.0, 2.0, np.nan]}, "a: nan, the value at place 2, is not a finite number"),
        ({"a": np.ones(10**4), "b": np.ones(10**4 + 1)}, "100010000 cases are more than 100000000"),
    ):
        with pytest.raises(pp.InputError, match=says):
            plan.grid(values)
    assert plan.grid({"a": np.ones(10**4), "b": np.ones(10**4)}).count == plan.MOST_CASES
    for count in (0, plan.MOST_CASES + 1, 2.5, True, "3"):
        with pytest.raises(pp.InputError, match="is not a whole number from 1 to 100,000,000"):
            plan.samples({"a": ("uniform", 0.0, 1.0)}, count)


def test_a_cell_that_is_no_number_is_named_by_line_and_key(tmp_path: Path) -> None:
    """As a person counts lines."""
    file = tmp_path / "cases.csv"
    file.write_text("a,b\n1,2\n3,x\n")
    with pytest.raises(pp.InputError, match=r"cases.csv: line 3: b: 'x' is not a number"):
        plan.cases_of(file)
