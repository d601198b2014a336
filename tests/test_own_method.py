"""A method of one's own, from outside the package, by its name."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest

import pendpin as pp
from pendpin.integrators import FixedStep, Method, add_method
from pendpin.scene import METHODS
from scenes import scene_of

ONE = scene_of(
    pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.1),)),
    pp.effects.Gravity(),
    q=(0.7, 0.4),
    v=(1.3, -0.8),
    duration=1.0,
    samples=11,
)


class Ralston(FixedStep):
    """Two stages, order 2, with the least bound of the error (A. Ralston 1962)."""

    def stepping(self, derivative: Callable, y: np.ndarray) -> Callable[[float, float], None]:
        """A step of y (size,)."""
        first, last = np.empty_like(y), np.empty_like(y)

        def advance(t: float, h: float) -> None:
            derivative(first, t, y)
            derivative(last, t + 2 * h / 3, y + 2 * h / 3 * first)
            y[:] += h / 4 * (first + 3 * last)

        return advance


@pytest.fixture(autouse=True)
def ralston() -> Iterator[None]:
    """The method, known by its name for one test."""
    add_method(
        Method(name="ralston", integrator=Ralston, setting="step", family="explicit Runge-Kutta", order=2, stages=2)
    )
    yield
    METHODS.pop("ralston", None)


def test_it_has_its_order() -> None:
    """Its error falls as the square of the step, against the reference of dop853; by name from a scene's solver too."""
    reference = pp.simulate(ONE, method="dop853", tolerance=1e-13)
    runs = [pp.simulate(ONE.replace({"solver.method": "ralston", "solver.step": h})) for h in (1 / 200, 1 / 400)]
    errors = [float(np.abs(run.tips - reference.tips).max()) for run in runs]
    assert runs[0].stats.method == "ralston"
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_a_target_accuracy_is_met() -> None:
    """The step is found, and the distance from the reference is within what is promised."""
    run = pp.simulate(ONE, method="ralston", accuracy=1e-5)
    reference = pp.simulate(ONE, method="dop853", tolerance=1e-13)
    assert float(np.linalg.norm(run.tips - reference.tips, axis=-1).max()) < 1e-5


def test_costs_are_measured() -> None:
    """`cost` compares it by its name."""
    cost = pp.cost(ONE, methods=["ralston", "rk4"], budget=0.02)
    assert {curve.name for curve in cost.curves} == {"ralston", "rk4"}


def test_published_results_are_compared() -> None:
    """With the step of the method of ours that is nearest below in its order; left out where that is."""
    report = pp.validate(["conical", "iftomm-a01"], methods=["ralston", "gauss2"])
    compared = {row.method: row for row in report.comparisons if row.case == "conical"}
    assert compared.keys() == {"ralston", "gauss2"}
    assert not any(row.failure for row in compared.values())
    assert [words.partition(":")[0] for words in report.left_out] == ["iftomm-a01 by ralston", "iftomm-a01 by gauss2"]


def test_what_does_not_fit_is_refused() -> None:
    """A name that is taken, a tolerance, effects that need events; each in one line."""
    with pytest.raises(pp.InputError, match="add_method: rk4 is there already"):
        add_method(METHODS["rk4"])
    with pytest.raises(pp.InputError, match="ralston takes a step, not a tolerance"):
        pp.simulate(ONE, method="ralston", tolerance=1e-6)
    stop = pp.effects.Stop(lower=-0.5, upper=0.9)
    with pytest.raises(pp.InputError, match="ralston cannot handle stops and dry friction"):
        pp.simulate(ONE.replace(effects=[*ONE.effects, stop]), method="ralston", step=1e-3)
