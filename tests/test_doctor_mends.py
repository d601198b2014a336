"""The equation doctor: wrong equations are mended."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import pendpin as pp
from pendpin.doctor.checking import evaluation
from pendpin.doctor.checking.residuals import changed
from pendpin.doctor.mending.numbers import Numbers, swapped
from test_doctor import first_mend, verdicts

ONE_CHANGE = 1.9  # what two changes cost more than

# --- wrong equations are mended -------------------------------------------------------------------------------------

WRONG = [
    ("x = l/2*cos(phi)", "x = l/2*sin(phi)"),
    ("omega_3 = dtheta*sin(phi)", "omega_3 = -dtheta*sin(phi)"),
    (r"\omega_3 = -\dot\theta c_\phi", r"\omega_3 = -\dot\theta s_\phi"),
    (r"\frac{\partial L}{\partial\dot\theta} = \frac{ml^2}{3}\dot\theta\cos^2\phi + ml^2", None),
    (r"\ddot\phi = -\dot\theta\sin\phi\cos\phi - \frac{3g}{2l}\cos\theta\sin\phi", None),
    (r"y = \frac{l}{2}\sin\theta", None),
    (r"R_3 = \frac{ml}{2}\dot\phi^2 + mg\cos\theta\cos\phi", None),
    ("M_3 = M_c", "M_3 = cos(phi)*M_c"),
    ("T = m*l**2/6*(dphi**2 + dtheta**2*cos(phi)**2) + m*g*l", None),
    ("ddphi = dtheta**2*sin(phi)*cos(phi) - 3*g*sin(theta)*sin(phi)/(2*l)", None),
    (
        r"\frac{d}{dt}\left(\frac13ml^2\dot\theta\cos\phi\right) = -\frac12mgl\sin\theta\cos\phi",
        r"\frac{d}{dt}\left(\frac13ml^2\dot\theta\cos^2 \phi\right) = -\frac12mgl\sin\theta\cos\phi",
    ),
    (
        r"\frac{d}{dt}\frac{\partial L}{\partial\dot\theta} = \frac{\partial L}{\partial\phi}",
        r"\frac{d}{dt}\frac{\partial L}{\partial\dot\theta} = \frac{\partial L}{\partial\theta}",
    ),
    (r"\frac13(\ddot\phi+\dot\theta^2\sin\phi\cos\phi) = -\frac{R_1}{2ml}", None),
    (r"T = \frac12m(\dot x^2+\dot y^2)+\frac{ml^2}{24}(\omega_1^2+\omega_2^2)", None),
    ("φ̈ = −θ̇ sin φ cos φ − (3g/2l) cos θ sin φ", "φ̈ = −θ̇**2 sin φ cos φ − (3g/2l) cos θ sin φ"),
    (r"v_y = \frac l2(\dot\theta\cos\phi\cos\theta+\dot\phi\sin\theta\cos\phi)", None),
    (r"\ddot\theta = \dot\theta\dot\phi\tan\phi-\frac{3g}{2l}\sin\theta", None),
    (r"\vec r_G = \frac l2\begin{bmatrix}\sin\phi\\\sin\theta\sin\phi\\\cos\theta\cos\phi\end{bmatrix}", None),
]


@pytest.mark.parametrize(("wrong", "right"), WRONG)
def test_the_mend_holds_and_is_the_simplest(wrong, right):
    mended = first_mend(wrong, rod="general" if "M_3" in wrong else "thin")
    assert mended is not None
    assert right is None or mended == right
    assert verdicts(pp.diagnose([mended], convention="standard", rod="thin")) == ["holds"]


def test_a_missing_term_is_none_that_makes_the_equation_say_nothing():
    """A balance put in for the acceleration that it is solved for would give ddphi = ddphi."""
    wrong = "ddphi = -dtheta**2*sin(phi)*cos(phi)"
    (finding,) = pp.diagnose([wrong]).findings
    assert (finding.verdict, finding.condition) == ("holds if", "there is no gravity")
    assert finding.mends[0].latex == f"{wrong} - 3*g*cos(theta)*sin(phi)/(2*l)"
    assert first_mend(wrong, rod="thin") == finding.mends[0].latex  # who names the system means the general motion


def test_in_which_motions_an_equation_fails():
    words = {"omega_3 = dtheta*sin(phi)": "as soon as theta turns", "V = m*g*z": "already at rest"}
    words["ddtheta = dtheta*dphi*tan(phi) - 3*g*sin(theta)/(2*l*cos(phi))"] = "only when theta and phi both turn"
    words["ddphi/dphi = dtheta"] = "as soon as phi turns"  # at rest it has no value
    assert [pp.diagnose([text]).findings[0].when for text in words] == list(words.values())


def test_a_chain_of_which_one_part_alone_has_a_zero_of_energy_is_mended():
    """Its first equation holds but for a constant in the energy, its second has none: both count at the same states."""
    page = r"""A simple pendulum of length $l$ and mass $m$ with the energy $E$. $$ m l^2 \ddot\theta = -m g l \sin\theta $$
    $$ E = \frac{1}{2} m l^2 \dot\theta^2 - m g l \cos\theta = \frac{1}{2} m l^2 \dot\theta^2 - 2 m g l \cos\theta $$"""
    right, wrong = pp.diagnose(page).findings
    assert (right.verdict, wrong.verdict) == ("holds", "fails")
    assert wrong.mends


LOADED = r"""A pendulum in a plane: a point mass $m$ on a rod of length $l$ with a damping.
$$ m l^2\ddot\theta + b\dot\theta + m g l\sin\theta = 0 $$
$$ \ddot\theta = -\frac{b}{m l^2}\dot\theta - \frac{g}{l}\sin\theta $$
"""


def test_a_fault_beside_a_load_is_found_where_another_equation_holds_without_it():
    """It is compared where the load is 0; alone, nothing would tell that the symbol is a load."""
    assert verdicts(pp.diagnose(LOADED)) == ["holds", "holds"]
    right, wrong = pp.diagnose(LOADED.replace(r"l}\sin", r"l}\cos")).findings
    assert (right.verdict, wrong.verdict) == ("holds", "fails")
    assert wrong.mends[0].latex == LOADED.strip().split("$$")[-2].strip()
    first, second = LOADED.replace(r"l}\sin", r"l}\cos").split("$$ m l^2")
    (alone,) = pp.diagnose(first + second.partition("$$")[2]).findings
    assert alone.verdict == "not checked"


SWINGING = r"""A rigid body of mass $m$ swings about an axis at the distance $s$ from its centre of mass.
$$ I_A \ddot\theta = -m g s \sin\theta $$
$$ \omega = \sqrt{\frac{m g s}{I_A}} $$
"""


def test_a_root_may_be_missing():
    assert verdicts(pp.diagnose(SWINGING)) == ["holds"] * 2
    right, wrong = pp.diagnose(SWINGING.replace(r"\sqrt{\frac{m g s}{I_A}}", r"\frac{m g s}{I_A}")).findings
    assert (right.verdict, wrong.verdict) == ("holds", "fails")
    assert wrong.mends[0].words == r"\omega should be \omega^2"


CART = """(M + m)*ẍ + m*l*θ̈*cos(θ) - m*l*θ̇**2*sin(θ) = F
l*θ̈ + ẍ*cos(θ) + g*sin(θ) = 0
T = (M + m)*ẋ**2/2 + m*l*ẋ*θ̇*cos(θ) + m*l**2*θ̇**2/2
V = -m*g*l*cos(θ)
"""


def test_a_mend_prints_the_names_of_the_page():
    """Also those that its own equation lacks, with the dots that others have."""
    (wrong,) = pp.diagnose(CART.replace("m*l*θ̈*cos", "m*l*cos")).wrong
    assert wrong.mends[0].latex == "(M + m)*ẍ + θ̈*m*l*cos(θ) - m*l*θ̇**2*sin(θ) = F"


def test_far_fetched_mends_are_not_named():
    wrong = ["ddphi = g*m*sin(theta)**3 + l*dtheta"]
    (finding,) = pp.diagnose(wrong, rod="thin").findings
    assert (finding.verdict, finding.mends) == ("not checked", ())
    assert "no small change makes it hold" in finding.remark
    assert not pp.diagnose(wrong, rod="thin").ok
    assert verdicts(pp.diagnose(wrong)) == ["not checked"]  # nothing says that it is about a rod at all


def test_sympy_expressions_are_read():
    t = sp.Symbol("t")
    theta, phi = (sp.Function(name)(t) for name in ("theta", "phi"))
    g, l = sp.symbols("g l")  # noqa: E741
    right = sp.Eq(
        phi.diff(t, 2),
        -(theta.diff(t) ** 2) * sp.sin(phi) * sp.cos(phi) - 3 * g * sp.cos(theta) * sp.sin(phi) / (2 * l),
    )
    wrong = right.subs(g, 2 * g)
    assert verdicts(pp.diagnose([right, wrong])) == ["holds", "fails"]


def test_own_symbols_and_names():
    table = {"T": "D*dtheta**2/2 + J_2*dphi**2/2", "b2": "J_2*ddphi + (J_1 - I_3)*dtheta**2*s*c + m*g*h*c*cos(theta)"}
    symbols = {"s": "sin(phi)", "c": "cos(phi)", "D": "J_1*c**2 + I_3*s**2"}
    found = pp.diagnose(table, symbols=symbols)
    assert verdicts(found) == ["holds", "fails"]
    assert found.findings[1].mends[0].latex.endswith("m*g*h*s*cos(theta)")


# --- in definitions ----------------------------------------------------------------------------

DEFINED = r"""With $D = J_1\cos^2\phi + I_3\sin^2\phi$ the energies of the rod are
$$ T = \frac12(D\dot\theta^2 + J_1\dot\phi^2) $$
$$ V = -m g h\cos\theta\cos\phi $$
$$ \frac{d}{dt}(D\dot\theta) = -m g h\sin\theta\cos\phi $$
"""


def test_a_wrong_definition_is_mended_where_it_stands():
    """It heals all that use it; the same fault in an equation beside the right definition is mended in that equation."""
    found = pp.diagnose(DEFINED.replace("+ I_3", "- I_3"))
    assert verdicts(found) == ["fails", "not checked", "holds", "not checked"]  # the guilty only
    assert found.wrong[0].mends[0].latex == r"D = J_1\cos^2\phi + I_3\sin^2\phi"
    assert {finding.remark for finding in found.findings[1::2]} == {"it uses a wrong definition, line 1"}
    assert verdicts(pp.diagnose(DEFINED)) == ["holds"] * 4
    (alone,) = pp.diagnose(DEFINED.replace(r"(D\dot\theta^2", r"(2 D\dot\theta^2")).wrong
    assert alone.mends[0].latex == r"T = \frac12(D\dot\theta^2 + J_1\dot\phi^2)"


DOUBLE = r"""
$$ \begin{pmatrix} (m_1+m_2) l_1^2 & m_2 l_1 l_2\cos(q_1-q_2) \\ m_2 l_1 l_2\cos(q_1-q_2) & m_2 l_2^2 \end{pmatrix}
\begin{pmatrix} \ddot q_1 \\ \ddot q_2 \end{pmatrix} +
\begin{pmatrix} 0 & m_2 l_1 l_2\sin(q_1-q_2)\dot q_2 \\ -m_2 l_1 l_2\sin(q_1-q_2)\dot q_1 & 0 \end{pmatrix}
\begin{pmatrix} \dot q_1 \\ \dot q_2 \end{pmatrix} +
\begin{pmatrix} (m_1-m_2) g l_1\sin q_1 \\ m_2 g l_2\sin q_2 \end{pmatrix} = 0 $$
"""


def test_a_change_is_tried_on_what_it_touches_alone(monkeypatch):
    """The residual is that of the whole changed equation, and less than a third of the parts is evaluated for it.

    To 1e-10 of it: where the residual is straight in a part, it is a multiple of its slope.
    """
    residual, value, counts = Numbers.residual, evaluation._value, [0]

    def counted(*arguments):
        counts[-1] += 1
        return value(*arguments)

    def compared(numbers, swaps):
        counts.append(0)
        quick = residual(numbers, swaps)
        counts.append(0)
        sides = tuple(swapped(side, swaps) for side in numbers.equation.sides)
        whole = changed(replace(numbers.equation, sides=sides), numbers.quantities, {})
        assert (quick is None) == (whole is None)
        assert quick is None or np.abs(quick - whole).max() <= 1e-10 * (np.abs(whole).max() + numbers.size)
        return quick

    monkeypatch.setattr(evaluation, "_value", counted)
    monkeypatch.setattr(Numbers, "residual", compared)
    (finding,) = pp.diagnose(DOUBLE, rod="double").wrong
    assert finding.mends[0].words == "the sign of m_2 is wrong"
    quick, whole = sum(counts[1::2]), sum(counts[2::2])
    assert 0 < 3 * quick < whole


BALANCES = {
    "m_1 x_1'' = -T_1 sin(theta_1) + T_2 sin(theta_2)": "-T_1 sin(theta_1) - T_2 sin(theta_2)",
    "m_1 y_1'' = T_1 cos(theta_1) - T_2 cos(theta_2) - m_1 g": "T_1 cos(theta_1) - T_1 cos(theta_2) - m_1 g",
    "m_2 x_2'' = -T_2 sin(theta_2)": "T_2 sin(theta_2)",
    "m_2 y_2'' = T_2 cos(theta_2) - m_2 g": "T_2 cos(theta_2) - m_1 g",
}


@pytest.mark.parametrize("faulty", BALANCES)
def test_newton_s_balances_of_two_bobs_are_mended(faulty):
    """They hold second rates of places: what has those also off the true motion, where a mend is told from another."""
    places = (
        "x_1 = l_1 sin(theta_1)\nx_2 = x_1 + l_2 sin(theta_2)\ny_1 = -l_1 cos(theta_1)\ny_2 = y_1 - l_2 cos(theta_2)\n"
    )
    left = faulty.partition(" = ")[0]
    laws = [law if law != faulty else f"{left} = {BALANCES[faulty]}" for law in BALANCES]
    found = [f for f in pp.diagnose(places + "\n".join(laws)).findings if f.verdict != "holds"]
    assert [f.verdict for f in found] == ["fails"]
    mended = found[0].mends[0].latex
    assert pp.diagnose(places + "\n".join(law if law != faulty else mended for law in BALANCES)).ok


def test_a_function_of_an_angle_may_be_missing():
    """A sine of the only angle, in an equation that has no angle."""
    laws = r"$$\ddot\theta = -\frac{g}{l}\sin\theta$$ $$V = -mgl\cos\theta$$"
    *_, finding = pp.diagnose(laws + r" $$m l\ddot\theta = -mg$$").findings
    assert finding.verdict == "fails"
    assert finding.mends[0].latex.replace(r"\sin(\theta)", r"\sin\theta") == r"m l\ddot\theta = -\sin\theta mg"


def test_a_missing_factor_is_one_change():
    """Of a number and of some symbols; the more are missing, the less likely it is."""
    missing = (
        (r"V = -\frac{mg}{2}\cos\theta\cos\phi", r"V = -l \frac{mg}{2}\cos\theta\cos\phi"),
        (r"V = -\frac{l}{2}\cos\theta\cos\phi", r"V = -m g \frac{l}{2}\cos\theta\cos\phi"),
        (r"R_1 = \cos\theta\sin\phi", r"R_1 = \frac{m g}{4} \cos\theta\sin\phi"),
    )
    mends = [pp.diagnose([wrong], rod="thin").findings[0].mends[0] for wrong, _ in missing]
    assert [mend.latex for mend in mends] == [right for _, right in missing]
    assert mends[0].cost < mends[1].cost < mends[2].cost < ONE_CHANGE


@pytest.mark.parametrize(
    ("wrong", "right", "words"),
    [
        (
            r"\ddot\theta = -\frac{l}{g}\sin\theta",
            r"\ddot\theta = -\frac{g}{l}\sin\theta",
            r"the quotient \frac{l}{g} is upside down",
        ),
        ("theta'' = -l/g*sin(theta)", "theta'' = -g/l*sin(theta)", "the quotient l/g is upside down"),
    ],
)
def test_a_quotient_may_be_upside_down(wrong, right, words):
    (finding,) = pp.diagnose([wrong], rod="plane").findings
    assert finding.mends[0].words == words
    assert finding.mends[0].latex == right


def test_a_mass_may_stand_where_it_moves_another_one_with_it():
    """The first of two bobs carries the second: m_1 + m_2."""
    law = r"{} l_1\ddot\theta_1 + m_2 l_2\ddot\theta_2\cos(\theta_1 - \theta_2)"
    law += r" = -m_2 l_2\dot\theta_2^2\sin(\theta_1 - \theta_2) - (m_1 + m_2) g\sin\theta_1"
    assert first_mend(law.format("m_1"), rod="double") == law.format("(m_1 + m_2)")
    assert verdicts(pp.diagnose([law.format("(m_1 + m_2)")], rod="double")) == ["holds"]
    code = "{}*self.l1*ddtheta1 + self.m2*self.l2*ddtheta2*cos(theta1 - theta2)"
    code += " = -self.m2*self.l2*dtheta2**2*sin(theta1 - theta2) - (self.m1 + self.m2)*self.g*sin(theta1)"
    assert first_mend(code.format("self.m1"), rod="double") == code.format("(self.m1 + self.m2)")


@pytest.mark.parametrize("argument", [r"\theta_1", r"\theta_1\theta_2", r"\theta_2"])
def test_a_function_may_be_of_another_argument(argument):
    """The mend takes one that stands in the same equation."""
    law = (
        r"l_2\ddot\theta_2 + l_1\ddot\theta_1\cos({}) - l_1\dot\theta_1^2\sin(\theta_1 - \theta_2) + g\sin\theta_2 = 0"
    )
    assert first_mend(law.format(argument), rod="double") == law.format(r"\theta_1 - \theta_2")
    code = "ddtheta2 = (-l1*ddtheta1*cos({}) + l1*dtheta1**2*sin(theta1 - theta2) - g*sin(theta2))/l2"
    assert first_mend(code.format("theta1"), rod="double") == code.format("theta1 - theta2")


@pytest.mark.parametrize(
    ("right", "wrong"), [(r"+ \ddot x", r"- \ddot x"), (r"g\theta", r"gl\theta"), ("(M + m)", "M"), ("= F", "= -F")]
)
def test_a_law_of_small_angles_is_mended_to_the_first_order(right, wrong):
    """But not where it would hold of an angle that is measured otherwise, as l theta'' - x'' does."""
    energies = [r"T = \frac{M + m}{2}\dot x^2 + m l\dot x\dot\theta\cos\theta + \frac{m l^2}{2}\dot\theta^2"]
    energies += [r"V = -m g l\cos\theta"]
    laws = [r"(M + m)\ddot x + m l\ddot\theta = F", r"l\ddot\theta + \ddot x + g\theta = 0"]
    faulty = [law.replace(right, wrong) for law in laws]
    wrong_ones = pp.diagnose([*energies, *faulty]).wrong
    assert [one.latex for one in wrong_ones] == [law for law in faulty if law not in laws and "- " not in law]
    assert all(one.mends[0].latex in {*laws} - {*faulty} for one in wrong_ones)
    assert all(one.remark == "read as a law of small angles" for one in wrong_ones)
    assert verdicts(pp.diagnose([*energies, *laws])) == ["holds", "holds", "holds if", "holds if"]


def test_a_law_about_upright_beside_those_about_hanging_is_not_accused():
    """As control tutorials have it: theta from hanging, then theta = pi + phi and small phi."""
    laws = [r"(I + m l^2)\ddot\theta + m g l\sin\theta = -m l\ddot x\cos\theta", r"\theta = \pi + \phi"]
    laws += [r"(M + m)\ddot x + m l\ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F"]
    laws += [r"(I + m l^2)\ddot\phi - m g l\phi = m l\ddot x"]
    assert not pp.diagnose(laws).wrong


def test_beside_laws_of_small_angles_an_energy_without_angles_is_one_too():
    """That two bobs swing little makes cos(theta_1 - theta_2) 1 in T; by itself T lacks it."""
    kinetic = r"T = \frac12(m_1+m_2) l_1^2\dot\theta_1^2 + \frac12 m_2 l_2^2\dot\theta_2^2"
    kinetic += r" + m_2 l_1l_2\dot\theta_1\dot\theta_2"
    laws = [r"(m_1+m_2) l_1\ddot\theta_1 + m_2 l_2\ddot\theta_2 + (m_1+m_2) g\theta_1 = 0"]
    laws += [r"l_1\ddot\theta_1 + l_2\ddot\theta_2 + g\theta_2 = 0"]
    text = "".join(f"$${law}$$\n" for law in (*laws, kinetic))
    assert verdicts(pp.diagnose(text)) == ["holds if"] * 3
    assert r"\cos(\theta_1-\theta_2)" in first_mend(kinetic, rod="double")


def test_an_angle_that_stands_in_sines_is_mended_where_it_is_defined():
    """No law is straight in the difference of two angles, and each would need two changes; the other sign mends both."""
    laws = """d = t1 - t2
den = m1 + m2 - m2*cos(d)**2
dw1 = (m2*l1*w1**2*sin(d)*cos(d) + m2*g*sin(t2)*cos(d) + m2*l2*w2**2*sin(d) - (m1 + m2)*g*sin(t1))/(l1*den) - b*w1
dw2 = (-m2*l2*w2**2*sin(d)*cos(d) + (m1 + m2)*(g*sin(t1)*cos(d) - l1*w1**2*sin(d) - g*sin(t2)))/(l2*den) - b*w2
"""
    found = pp.diagnose(laws).findings
    assert [one.latex for one in found if one.verdict == "fails"] == ["d = t1 - t2"]
    assert found[0].mends[0].latex == "d = -(t1 - t2)"
    assert verdicts(pp.diagnose(laws.replace("t1 - t2", "t2 - t1"))) == ["holds"] * 4


def test_a_sum_without_brackets_gets_them_with_its_other_sign():
    law = "ddphi = 3*g*cos(theta)*sin(phi)/(2*l) + dtheta**2*sin(phi)*cos(phi)"
    assert first_mend(law, rod="thin") == "ddphi = -(3*g*cos(theta)*sin(phi)/(2*l) + dtheta**2*sin(phi)*cos(phi))"
