"""The doctor's arithmetic: identities of every operation, sizes of terms, units, and what each special case sets."""

from fractions import Fraction

import pytest

import pendpin as pp
from pendpin.doctor.checking.conditions import conditions
from pendpin.doctor.checking.evaluation import LARGEST
from pendpin.doctor.checking.residuals import NONE, dimension, unit
from pendpin.doctor.reading.tree import Node
from pendpin.doctor.systems.base import System
from pendpin.doctor.systems.rod import SPECS
from test_doctor_exact import finding_of

IDENTITIES = [
    r"\sin^2\phi + \cos^2\phi = 1",
    r"\sin(\theta+\phi) = \sin\theta\cos\phi + \cos\theta\sin\phi",
    r"\cos(\theta-2\phi) = \cos\theta\cos(2\phi) + \sin\theta\sin(2\phi)",
    r"\cos(2\theta) = 1 - 2\sin^2\theta",
    r"\sin(3\theta) = 3\sin\theta - 4\sin^3\theta",
    r"\sin(\theta-\pi) = -\sin\theta",
    r"\tan\phi = \frac{\sin\phi}{\cos\phi}",
    r"\sec\phi\cos\phi = 1",
    r"\csc\phi\sin\phi = 1",
    r"\cot\phi\tan\phi = 1",
    r"m^{-2} = \frac{1}{m^2}",
    r"\frac{m l - m \dot\theta}{m} = l - \dot\theta",
    r"\vec\omega\times\vec r_G = -\vec r_G\times\vec\omega",
    r"\vec r_G\cdot(\vec\omega\times\vec r_G) = 0",
    r"|\vec r_G|^2 = \vec r_G\cdot\vec r_G",
    r"\vec r_G^{\,2} = \vec r_G\cdot\vec r_G",
    r"\vec r_G^T\vec\omega = \vec\omega\cdot\vec r_G",
    r"\mathbf{I}_G\vec\omega\, 2 = 2\mathbf{I}_G\vec\omega",
    r"\vec\omega\cdot\mathbf{I}_G\vec\omega\, m = m\,\vec\omega\cdot(\mathbf{I}_G\vec\omega)",
    r"\begin{bmatrix}1&2\\3&4\end{bmatrix}\begin{bmatrix}\theta\\ \phi\end{bmatrix}"
    r" = \begin{bmatrix}\theta+2\phi\\3\theta+4\phi\end{bmatrix}",
    r"\begin{bmatrix}1&2\\3&4\end{bmatrix}\begin{bmatrix}1&0\\ \phi&1\end{bmatrix}"
    r" = \begin{bmatrix}1+2\phi&2\\3+4\phi&4\end{bmatrix}",
    r"\begin{bmatrix}1&2\\3&4\end{bmatrix}^T = \begin{bmatrix}1&3\\2&4\end{bmatrix}",
    r"\begin{bmatrix}\vec b_1\\ \vec b_2\\ \vec b_3\end{bmatrix}\vec r_G = \begin{bmatrix}0\\0\\l/2\end{bmatrix}",
    r"\frac{d}{dt}(m l\dot\theta) = m l\ddot\theta",
    r"\frac{d}{dt}(\sin\theta\cos\phi) = \dot\theta\cos\theta\cos\phi - \dot\phi\sin\theta\sin\phi",
    r"\frac{\partial}{\partial\theta}(\theta^3\phi) = 3\theta^2\phi",
    r"\frac{\partial}{\partial\dot\phi}(\dot\theta\dot\phi^2) = 2\dot\theta\dot\phi",
    r"\dot E = 0",
]


@pytest.mark.parametrize("equation", IDENTITIES)
def test_identities_are_proved(equation: str) -> None:
    """Of circular functions, vectors, tensors, matrices and derivatives."""
    finding = finding_of(equation)
    assert (finding.verdict, finding.proved) == ("holds", True)
    assert finding.error < 1e-14


@pytest.mark.parametrize(
    "equation", [r"m^{3/2} = m\sqrt{m}", r"\sqrt{m^2 l^2} = m l", r"|\vec r_G| = \sqrt{\vec r_G\cdot\vec r_G}"]
)
def test_roots_hold_in_fifty_digits(equation: str) -> None:
    """As everything else: no algebra is asked."""
    finding = finding_of(equation)
    assert (finding.verdict, finding.proved) == ("holds", True)


def test_what_is_compared_with_a_scene_is_not_proved() -> None:
    """Its equations hold at random states."""
    rod = pp.Rod(length=1.0, mass=1.0, radius=0.05)
    scene = pp.Scene(model=pp.Chain(rods=[rod, rod]), effects=[pp.effects.Gravity()])
    (finding,) = pp.diagnose([r"\sin^2\phi_1 + \cos^2\phi_1 = 1"], scene=scene).findings
    assert (finding.verdict, finding.proved) == ("holds", False)


@pytest.mark.parametrize("term", ["m l^3", "m^2 l", r"\frac{l}{m}", r"\dot\theta^2 m"])
def test_a_power_counts_as_one_term(term: str) -> None:
    """Of an equation off by a thousandth the error is that over the value and both terms, whatever the power."""
    assert finding_of(f"{term} = 1.001 {term}").error == pytest.approx(0.001 / 3.001, rel=1e-6)


# --- units ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("powers", "written"),
    [
        ((1, 1, 0), "kg m"),
        ((0, 1, -1), "m s⁻¹"),
        ((0, 0, 2), "s²"),
        (("1/2", 0, -12), "kg^(1/2) s⁻¹²"),
        ((1, 2, 0), "kg m²"),
    ],
)
def test_units_are_powers_of_kg_m_and_s(powers: tuple, written: str) -> None:
    """A power of 1 is not written, one of 0 has no unit."""
    assert unit(tuple(map(Fraction, powers))) == written


def test_names_that_are_defined_by_others_have_their_dimension() -> None:
    """Through a row of definitions; of names that define each other there is none, and the search ends."""
    spec, symbol = SPECS["thin"], lambda name: Node("symbol", (0, 0), name)
    row = {f"n{i}": symbol(f"n{i + 1}") for i in range(15)} | {"n15": symbol("l")}
    assert dimension(symbol("n0"), row, spec, {}) == (0, 1, 0)
    assert dimension(symbol("a"), {"a": symbol("b"), "b": symbol("a")}, spec, {}) in (None, NONE)
    root = {"a": Node("power", (0, 0), Fraction(3, 2), (symbol("m"),))}
    assert dimension(symbol("a"), root, spec, {}) == (Fraction(3, 2), 0, 0)
    # each is two of the next: 2^60 ways lead to the last
    twice = {f"n{i}": Node("sum", (0, 0), (1, 1), (symbol(f"n{i + 1}"),) * 2) for i in range(60)} | {"n60": symbol("l")}
    assert dimension(symbol("n0"), twice, spec, {}) == (0, 1, 0)


# --- special cases --------------------------------------------------------------------------------------------------

AT_REST = {"dtheta": 0.0, "dphi": 0.0}
SETS = {
    "at rest": AT_REST,
    "at rest, hanging straight down": {"theta": 0.0, "phi": 0.0} | AT_REST,
    "theta = 0 throughout": {"theta": 0.0, "dtheta": 0.0},
    "phi = 0 throughout": {"phi": 0.0, "dphi": 0.0},
    "there is no gravity": {"g": 0.0},
}


@pytest.mark.parametrize("rod", SPECS)
def test_a_special_case_sets_what_it_says(rod: str) -> None:
    """Coordinates, rates or gravity; or it is that of another rod."""
    found = conditions(System(SPECS[rod]))
    assert {one.words: dict(one.instead) for one in found if one.spec is None} == SETS
    assert all(one.spec.kind in SPECS and not one.instead for one in found if one.spec is not None)


@pytest.mark.parametrize(
    ("equation", "verdict"),
    [
        (r"\ddot\theta = -\frac{3 g}{2 l}\theta", "holds if"),
        (r"\ddot\phi = -\frac{3 g}{2 l}\phi", "holds if"),
        (r"\ddot\phi = -\frac{3 g}{2 l}\phi - \dot\theta^2\phi", "holds if"),  # what is small of higher order may stand
        (r"\ddot\phi = -\frac{3.01 g}{2 l}\phi", "fails"),
        (r"\ddot\phi = -\frac{3 g}{2 l}\phi + 0.01\dot\theta", "fails"),
        (r"\ddot\phi = -\frac{3 g}{2 l}\sin\phi", "not checked"),  # no equation of small angles, and wrong beside theta
    ],
)
def test_equations_of_small_angles_hold_to_the_first_order(equation: str, verdict: str) -> None:
    """Those without circular functions, whose error falls a hundredfold where the angles do tenfold."""
    finding = finding_of(equation)
    assert finding.verdict == verdict
    assert ("small" in finding.condition) == (verdict == "holds if")


def test_columns_of_vectors_are_three() -> None:
    """Three make a matrix; two make none."""
    finding = finding_of(r"\begin{bmatrix}\vec b_1\\ \vec b_2\end{bmatrix}\vec r_G = 0")
    assert (finding.verdict, finding.remark) == ("not checked", "a matrix of vectors")


@pytest.mark.parametrize("count", [2, 3, LARGEST, LARGEST + 1])
def test_a_row_times_a_column_is_their_sum(count: int) -> None:
    """Of any number of entries that a matrix may have."""
    row, column = " & ".join(["m"] * count), r" \\ ".join(["l"] * count)
    finding = finding_of(
        rf"\begin{{bmatrix}}{row}\end{{bmatrix}}\begin{{bmatrix}}{column}\end{{bmatrix}} = {count} m l"
    )
    assert finding.verdict == ("holds" if count <= LARGEST else "not checked")


def test_a_symbol_that_nothing_explains_is_0() -> None:
    """Where the equation holds without it: it is the condition; of one that is wrong without it nothing is said."""
    for gravity, condition in (("3 g", "Q = 0"), ("3.1 g", "")):
        load = r"- \dot\theta^2\sin\phi\cos\phi + \frac{Q}{m l^2}"
        finding = finding_of(rf"\ddot\phi = -\frac{{{gravity}}}{{2 l}}\cos\theta\sin\phi {load}")
        assert (finding.verdict, finding.condition) == ("holds if" if condition else "not checked", condition)


def test_a_vector_has_a_square_and_no_cube() -> None:
    """It is not checked, with the reason."""
    assert finding_of(r"\vec r_G^{\,3} = \vec r_G").remark == "a power of a vector"


@pytest.mark.slow
def test_a_linear_model_alone_shows_its_system():
    """A and B of x' = A x + B u, of a pendulum on a cart whose equations stand elsewhere."""
    text = r"""An inverted pendulum on a cart: $$\dot x = A x + B u$$
$$A = \begin{bmatrix} 0 & 1 & 0 & 0 \\ 0 & 0 & -\frac{m g}{M} & 0
\\ 0 & 0 & 0 & 1 \\ 0 & 0 & \frac{(M + m) g}{M l} & 0 \end{bmatrix}$$
$$B = \begin{bmatrix} 0 \\ \frac1M \\ 0 \\ -\frac{1}{M l} \end{bmatrix}$$"""
    found = pp.diagnose(text)
    assert found.system.kind.startswith("cart-pole")
    assert [one.verdict for one in found.findings[1:]] == ["holds if", "holds if"]  # for small angles
    assert pp.diagnose(text.replace("(M + m) g", "(M - m) g")).findings[1].verdict == "not checked"
