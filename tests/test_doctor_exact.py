"""Parts of the equation doctor against exact values: errors over the terms, units, fractions, conditions in words."""

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

import pendpin as pp
from pendpin.doctor.checking.residuals import Disagreement, Equation, common, stack_residuals, unit
from pendpin.doctor.reading.grammar import parse
from pendpin.doctor.reading.names import Vocabulary, bound
from pendpin.doctor.report import Finding, residual
from pendpin.doctor.systems.base import System, dot, free_states
from pendpin.doctor.systems.rod import SPECS
from pendpin.doctor.systems.tables import FAMILIES

SYSTEM = System(SPECS["general"])
WORDS = Vocabulary(SYSTEM.spec)
FORCE = (Fraction(1), Fraction(1), Fraction(-2))


def finding_of(equation: str, rod: str | None = "thin") -> Finding:
    """What is said of one equation."""
    (finding,) = pp.diagnose([equation], rod=rod).findings
    return finding


@pytest.mark.parametrize("equation", ["m l = 1.001 m l", "m l = m l = 1.001 m l", "1.001 m l = m l"])
def test_an_error_is_the_difference_over_all_terms(equation: str) -> None:
    """Of the left side once as a value and of both sides as terms; of several pairs of sides the largest."""
    left = 1.001 if equation.startswith("1") else 1.0
    assert finding_of(equation).error == pytest.approx(0.001 / (left + 2.001), rel=1e-6)


@pytest.mark.parametrize(
    "equation",
    [
        r"\sin(\theta+\frac{\pi}{2}) = \cos\theta",
        r"\cos(\phi-\frac{3\pi}{2}) = -\sin\phi",
        r"\dot\theta l^{-1} l = \dot\theta",
        r"\vec r_G + 0 = \vec r_G",
        r"\vec r_G - \vec r_G = 0",
        r"\begin{bmatrix}1&0&0\\0&1&0\\0&0&1\end{bmatrix}\vec r_G = \vec r_G",
        r"\vec\omega = (-1.0\dot\theta\cos\phi,\ \dot\phi,\ -1.0\dot\theta\sin\phi)",
    ],
)
def test_right_equations_are_proved(equation: str) -> None:
    """Quarter turns, negative powers, zeros among vectors, printed decimals."""
    finding = finding_of(equation)
    assert (finding.verdict, finding.proved) == ("holds", True)


def test_a_digit_beyond_rounding_fails() -> None:
    """The eleventh, of one row among right ones: states do not tell in floats, but in 50 digits."""
    finding = finding_of(r"\vec\omega = (-1.0\dot\theta\cos\phi,\ \dot\phi,\ -1.00000000001\dot\theta\sin\phi)")
    assert finding.verdict == "fails"


@pytest.mark.parametrize(
    ("equation", "remark"),
    [
        (r"\vec r_G + 1 = \vec r_G", "a number is added to a vector"),
        (r"\vec r_G l = 1 l", "a vector is set equal to a number"),
        (r"\begin{bmatrix}\vec r_G & 0 & 0\\ 0&1&0\\0&0&1\end{bmatrix} = 0", "a matrix of vectors"),
    ],
)
def test_what_has_no_meaning_is_not_checked(equation: str, remark: str) -> None:
    """And says why."""
    finding = finding_of(equation)
    assert (finding.verdict, finding.remark) == ("not checked", remark)


@pytest.mark.parametrize(
    ("equation", "condition"),
    [
        (r"R_3 = m g \quad \text{hanging straight down}", "at rest, hanging straight down"),
        (r"\ddot\phi = -\dot\theta^2\sin\phi\cos\phi", "there is no gravity"),
    ],
)
def test_a_special_case_is_exact(equation: str, condition: str) -> None:
    """An equation that holds in a special case alone, which is named."""
    finding = finding_of(equation, None)
    assert (finding.verdict, finding.condition) == ("holds if", condition)


@pytest.mark.parametrize(
    ("equation", "when"),
    [
        (r"\ddot\theta\cos\phi = -\frac{3 g}{2 l}\sin\theta", "only when theta and phi both turn"),
        (r"\ddot\phi = -\frac{3 g}{2 l}\cos\theta\sin\phi", "as soon as theta turns"),
        (r"\ddot\phi = -\frac{g}{l}\cos\theta\sin\phi - \dot\theta^2\sin\phi\cos\phi", "already at rest"),
        (r"V = -m g \frac{l}{3}\cos\theta\cos\phi", "already at rest"),
        (r"2T = m l^2(\dot\theta^2+\dot\phi^2)/3", "as soon as theta turns"),
        (
            r"T = \frac{1}{3} m l^2(\dot\theta^2\cos^2\phi+\dot\phi^2)",
            "as soon as theta turns and as soon as phi turns",
        ),
    ],
)
def test_where_an_equation_fails(equation: str, when: str) -> None:
    """In which motions."""
    finding = finding_of(equation)
    assert (finding.verdict, finding.when) == ("fails", when)


def test_units_of_dimensions() -> None:
    """By their names, or as powers; what has none takes that of the others, and two that differ disagree."""
    named = {(1, 2, -2): "N m", (1, 1, -2): "N", (1, 2, 0): "kg m²", (0, 0, 0): "a pure number"}
    assert {powers: unit(tuple(map(Fraction, powers))) for powers in named} == named
    assert unit((Fraction(2), Fraction(2), Fraction(0))) == "kg² m²"
    assert common([None, FORCE, None, FORCE]) == FORCE
    assert common([None, None]) is None
    with pytest.raises(Disagreement, match="N and kg m²"):
        common([FORCE, (Fraction(1), Fraction(2), Fraction(0))])


@pytest.mark.parametrize(
    "equation",
    [
        r"\ddot\phi = -\dot\theta^2\sin\phi\cos\phi - \frac{3g}{2l}\cos\theta\sin\phi",
        r"\frac{d}{dt}\frac{\partial L}{\partial\dot\phi} = \frac{\partial L}{\partial\phi}",
        r"\frac{1}{2}m|\vec v_G|^2 = T",
        r"\vec R + m\vec g = m\vec a_G",
    ],
)
def test_a_residual_as_text_is_that_of_the_equation(equation: str) -> None:
    """Left minus right off the true motion, vectors along the axes of the rod."""
    one = Equation(tuple(bound(side, WORDS) for side in parse(equation)[0]))
    states = free_states(SYSTEM)
    numbers = stack_residuals(one, states, plain=True)
    numbers = [dot(numbers, states[axis]) for axis in ("b1", "b2", "b3")] if len(numbers) == 3 else numbers
    names = {name: sp.Symbol(name) for name in states.base}
    entries = sp.flatten([sp.sympify(residual(one, SYSTEM), locals=names)])
    values = [sp.lambdify([*names.values()], entry)(*states.base.values()) for entry in entries]
    np.testing.assert_allclose(values, numbers, atol=1e-12)


def test_second_rates_of_places_need_no_rates_of_accelerations():
    """They are those of the chain rule also off the true motion; third rates are not known there."""
    q = free_states(System(next(spec for spec in FAMILIES["double"] if spec.kind == "double point absolute down")))
    swing = q["l1"] * (np.cos(q["theta1"]) * q["ddtheta1"] - np.sin(q["theta1"]) * q["dtheta1"] ** 2)
    other = q["l2"] * (np.cos(q["theta2"]) * q["ddtheta2"] - np.sin(q["theta2"]) * q["dtheta2"] ** 2)
    np.testing.assert_allclose(q["ddx2"], swing + other, rtol=0, atol=1e-8)  # central differences of what is about 10
    with pytest.raises(KeyError, match="rate of an acceleration"):
        q["dddx2"]


def test_what_is_named_after_one_point_does_not_hold_of_another():
    """The acceleration of G is half of that of the tip."""
    right = r"a_{G} = \frac{l}{2}((\ddot\phi + \dot\theta^2\sin\phi\cos\phi)\hat b_1"
    right += r" + (\ddot\theta\cos\phi - 2\dot\theta\dot\phi\sin\phi)\hat b_2"
    right += r" - (\dot\phi^2 + \dot\theta^2\cos^2\phi)\hat b_3)"
    for name in ("a_{G}", r"{}^I\mathbf{a}_{G/O}"):
        equation = right.replace("a_{G}", name)
        assert pp.diagnose([equation], rod="thin").findings[0].verdict == "holds"
        assert pp.diagnose([equation.replace(r"\frac{l}{2}", "l")], rod="thin").findings[0].verdict != "holds"
