"""What the equations of a text say of each other: which are accused, which follow, and which confirm nothing."""

import re

import pytest

import pendpin as pp


def findings(text):
    return pp.diagnose(text).findings


POINTS = r"""
A double pendulum of two point masses, its angles from the downward vertical.
$$x_1 = l_1\sin\theta_1$$ $$y_1 = -l_1\cos\theta_1$$
$$x_2 = x_1 + l_2\sin\theta_2$$ $$y_2 = y_1 - l_2\cos\theta_2$$
"""
FIRST = r"""$$(m_1 + m_2) l_1 \ddot\theta_1 + m_2 l_2 \ddot\theta_2 \cos(\theta_1 - \theta_2)
 + m_2 l_2 \dot\theta_2^2 \sin(\theta_1 - \theta_2) + (m_1 + m_2) g \sin\theta_1 = 0$$
"""
SECOND = r"""$$l_2 \ddot\theta_2 + l_1 \ddot\theta_1 \cos(\theta_1 - \theta_2) - l_1 \dot\theta_1^2 \sin(\theta_1 - \theta_2)
 + g \sin\theta_2 = 0$$
"""
# both solved for the first acceleration, without a common factor
SOLVED = r"""$$\ddot\theta_1 = \frac{-m_2 l_2 \dot\theta_2^2\sin(\theta_1 - \theta_2) - (m_1 + m_2) g\sin\theta_1
 - m_2\cos(\theta_1 - \theta_2)(l_1\dot\theta_1^2\sin(\theta_1 - \theta_2) - g\sin\theta_2)}
 {l_1(m_1 + m_2 - m_2\cos^2(\theta_1 - \theta_2))}$$
"""


def test_what_is_solved_with_a_wrong_law_follows_from_it():
    """It is right where both laws are; where the second has a wrong sign, it holds in the motion that this allows."""
    assert {one.verdict for one in findings(POINTS + FIRST + SECOND + SOLVED)} == {"holds"}
    wrong, solved = SECOND.replace("+ g", "- g"), SOLVED.replace(r"- g\sin\theta_2)", r"+ g\sin\theta_2)")
    *_, second, third = findings(POINTS + FIRST + wrong + solved)
    assert (second.verdict, third.verdict, third.follows) == ("fails", "fails", second.number)


DIVIDED = """import numpy as np
x1 = l1*sin(theta1)
y1 = -l1*cos(theta1)
x2 = x1 + l2*sin(theta2)
y2 = y1 - l2*cos(theta2)
d = theta1 - theta2
den = m1 + m2 - m2*cos(d)**2
s, c = sin(d), cos(d)
ddtheta1 = (-m2*l2*dtheta2**2*s - (m1 + m2)*g*sin(theta1) - m2*c*(l1*dtheta1**2*s - g*sin(theta2)))/(l1*den)
ddtheta2 = ((m1 + m2)*(l1*dtheta1**2*s - g*sin(theta2) + g*sin(theta1)*c) + m2*l2*dtheta2**2*s*c)/(l2*den)
"""


@pytest.mark.parametrize(
    "wrong", ["m1 + m2 - m2*cos(d)", pytest.param("m1 + m2 + m2*cos(d)**2", marks=pytest.mark.slow)]
)
def test_a_definition_that_others_are_divided_by_is_accused(wrong):
    """One change of it mends both accelerations that use it: these are not accused."""
    right = "m1 + m2 - m2*cos(d)**2"
    assert {one.verdict for one in findings(DIVIDED)} == {"holds"}
    said = {one.latex.partition(" =")[0]: one for one in findings(DIVIDED.replace(right, wrong))}
    assert said["den"].verdict == "fails"
    assert said["den"].mends[0].latex.replace("cos(d)**2", "C") == f"den = {right}".replace("cos(d)**2", "C")
    assert [said[name].verdict for name in ("ddtheta1", "ddtheta2")] == ["not checked"] * 2


CART = r"""
A cart with an inverted pendulum.
$$x_b = x + L\sin\theta$$ $$y_b = L\cos\theta$$
$$T = \frac12 M\dot x^2 + \frac12 m(\dot x_b^2 + \dot y_b^2)$$
$$T = \frac12(M + m)\dot x^2 + m L\dot x\dot\theta\cos\theta + \frac12 m L^2\dot\theta^2$$
$$V = m g L\cos\theta$$ $$\mathcal{L} = T - V$$
"""


def test_a_dot_may_be_missing():
    """Over a name of the text's own; its L is the length, though the page has a Lagrangian too."""
    assert {one.verdict for one in findings(CART)} == {"holds"}
    third = findings(CART.replace(r"\dot y_b^2", "y_b^2"))[2]
    assert third.verdict == "fails"
    assert third.mends[0].latex.count("dot") == 3


def test_a_load_in_one_of_two_accelerations_confirms_neither():
    """A friction at the pole moves the cart too."""
    cart = r"$$\ddot x = \frac{F + m\sin\theta(L\dot\theta^2 + g\cos\theta)}{M + m\sin^2\theta}$$" + "\n"
    rod = r"""$$\ddot\theta = \frac{-F\cos\theta - m L\dot\theta^2\sin\theta\cos\theta - (M + m) g\sin\theta - b\dot\theta}
 {L(M + m\sin^2\theta)}$$"""
    said = findings("A cart with a pendulum.\n" + cart + rod)
    assert [one.verdict for one in said] == ["holds", "not checked"]
    assert "b" in said[1].remark


def test_an_inertia_that_the_section_gives_otherwise_confirms_nothing():
    """An energy of rods about their centres holds with m l^2/12, not with what the line below it says."""
    rods = r"""
A double pendulum of two uniform rods.
$$x_1 = \frac{l_1}{2}\sin\theta_1$$ $$y_1 = -\frac{l_1}{2}\cos\theta_1$$
$$x_2 = l_1\sin\theta_1 + \frac{l_2}{2}\sin\theta_2$$ $$y_2 = -l_1\cos\theta_1 - \frac{l_2}{2}\cos\theta_2$$
$$T = \frac12 m_1(\dot x_1^2 + \dot y_1^2) + \frac12 I_1\dot\theta_1^2
 + \frac12 m_2(\dot x_2^2 + \dot y_2^2) + \frac12 I_2\dot\theta_2^2$$
$$I_1 = \frac{1}{12} m_1 l_1^2$$ $$I_2 = \frac{1}{12} m_2 l_2^2$$
"""
    assert findings(rods)[4].verdict == "holds"
    assert findings(rods.replace("{12}", "{3}"))[4].verdict == "not checked"


def test_a_long_law_that_one_change_mends_is_accused_without_others():
    """A short one may be about anything."""
    (lone,) = findings("A double pendulum of two point masses.\n" + FIRST.replace("+ m_2 l_2 \\dot", "- m_2 l_2 \\dot"))
    assert lone.verdict == "fails"
    (short,) = findings("A double pendulum of two point masses.\n$$x_2 = l_1\\sin\\theta_1 - l_2\\sin\\theta_2$$")
    assert short.verdict == "not checked"


def test_a_wrong_equation_names_the_one_that_it_follows_from():
    """T lacks a square; the Lagrangian and an equation of motion that follow from it say so, another fault does not."""
    turn = r"\frac12 (m_1+m_2) l_1^2\dot\theta_1^2 + \frac12 m_2 l_2\dot\theta_2^2"
    both = r"m_2 l_1 l_2\dot\theta_1\dot\theta_2\cos(\theta_1-\theta_2)"
    swing = r"m_2 l_1 l_2\ddot\theta_1\cos(\theta_1-\theta_2) - m_2 l_1 l_2\dot\theta_1^2\sin(\theta_1-\theta_2)"
    text = rf"""The double pendulum.
$$V = -(m_1+m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2$$
$$M_{{12}} = m_2 l_1 l_2 \cos(\theta_1-\theta_2)$$
$$p_2 = m_2 l_2^2\dot\theta_2 + m_2 l_1 l_2\dot\theta_1\cos(\theta_1-\theta_2)$$
$$T = {turn} + {both}$$
$$E = {turn} + {both} + V$$
$$m_2 l_2\ddot\theta_2 + {swing} + m_2 g l_2\sin\theta_2 = 0$$
$$p_1 = (m_1+m_2) l_1^2\dot\theta_1 - m_2 l_1 l_2\dot\theta_2\cos(\theta_1-\theta_2)$$
"""
    found = pp.diagnose(text)
    assert [finding.verdict for finding in found.findings] == ["holds"] * 3 + ["fails"] * 4
    assert [finding.follows for finding in found.findings] == [0, 0, 0, 0, 4, 4, 0]
    assert str(found).splitlines()[0].startswith("Equation 4, line 5, is the first wrong one")
    assert "follow from it" in str(found)


def test_what_no_other_equation_bears_out_is_not_accused():
    """Equations of motion none of which holds may be read wrongly: none of them is called wrong."""
    wrong = r"$$m_1 l_1\ddot\theta_1 + 3 m_2 l_2\ddot\theta_2 = F_1$$ $$m_2\ddot\theta_2 + 5 l_1\dot\theta_1 = 0$$"
    found = pp.diagnose(f"A double pendulum.\n\n{wrong}\n\n$$\\dot\\theta_1 = \\dot\\theta_2$$\n")
    assert not found.wrong
    assert not found.ok


def test_a_speed_along_the_other_axis_is_a_slip():
    """Copied from the line above: x for y."""
    speeds = r"""$$V = m_1 g y_1 + m_2 g y_2$$
$$\dot x_2 = \dot x_1 + l_2\dot\theta_2\cos\theta_2$$
$$\dot y_2 = \dot x_1 + l_2\dot\theta_2\sin\theta_2$$"""
    *_, along, up = findings(POINTS + FIRST + speeds)
    assert (along.verdict, up.verdict) == ("holds", "fails")
    assert up.mends[0].words == r"\dot x_1 should be \dot y_1"  # not \doty_1, as it would be after \dot\theta


ON_A_CART = r"""
A cart of mass M moves along x. On it hangs a pendulum, a point mass m on a rod of length l.
$$T = \frac12 M\dot x^2 + \frac12 m(\dot x^2 + 2 l\dot x\dot\theta\cos\theta + l^2\dot\theta^2)$$
"""


def test_a_cart_may_be_at_capital_x():
    """Not a reaction, as X is elsewhere: it has a rate."""
    (kinetic,) = findings(ON_A_CART.replace("x", "X").replace(r"\teXt", r"\text"))
    assert kinetic.verdict == "holds"


def test_a_cosine_for_a_sine_is_a_slip():
    right = r"$$\ddot x = \frac{m l\dot\theta^2\sin\theta + m g\sin\theta\cos\theta}{M + m\sin^2\theta}$$"
    assert findings(ON_A_CART + right)[-1].verdict == "holds"
    assert findings(ON_A_CART + right.replace(r"m\sin^2", r"m\cos^2"))[-1].verdict == "fails"


def test_entries_of_a_matrix_that_is_not_unique_are_not_accused():
    """The velocity terms C q' may be divided among the entries of C in many ways; the mass matrix is one."""
    masses = r"""A double pendulum of point masses; the second angle is relative to the first rod.
$M_{11} = (m_1 + m_2) l_1^2 + 2 m_2 l_1 l_2\cos\theta_2 + m_2 l_2^2$, $M_{12} = m_2 l_1 l_2\cos\theta_2 + m_2 l_2^2$,
$M_{22} = m_2 l_2^2$, """
    entry = r"$C_{12} = -m_2 l_1 l_2 (2\dot\theta_1 + \dot\theta_2)\sin\theta_2$"
    assert [one.verdict for one in findings(masses + entry)] == ["holds", "holds", "holds", "not checked"]


def test_a_section_that_nothing_explains_is_read_as_the_page():
    """Of small angles in a cart-pole: not as of a rod on a universal joint, which a section alone might be about."""
    page = "# Laws\n" + ON_A_CART + "# Small angles\n" + r"$$(M + m)\ddot x + m l\ddot\theta = F$$"
    assert findings(page)[-1].verdict == "holds if"


EFFECTIVE = """A spherical pendulum.
E = m*l^2*(dtheta^2 + dphi^2*sin(theta)^2)/2 + m*g*l*(1 - cos(theta))
PE = Lz^2 / (2*m*l^2*sin(theta)^2) + m*g*l*(1 - cos(theta))
"""


def test_what_no_change_gives_sound_units_is_not_accused():
    """Lz is none of its letters; a sign is accused as before."""
    assert [one.verdict for one in findings(EFFECTIVE)] == ["holds", "not checked"]
    assert "units" in findings(EFFECTIVE)[1].remark
    assert findings(EFFECTIVE.replace("+ dphi", "- dphi"))[0].verdict == "fails"


BOB = r"A bob hangs on a string: $T = \frac12 m l^2\dot\theta^2$, $\ddot\theta = -\frac{g}{l}\sin\theta$. "
SPRING = r"""A mass on a spring, which is stretched by x:
$$m\ddot x = m(l_0+x)\dot\theta^2 + m g\cos\theta - k x$$
$$(l_0+x)\ddot\theta = -g\sin\theta - 2\dot x\dot\theta$$
$$T = \frac12 m(\dot x^2 + (l_0 + x)^2\dot\theta^2)$$
"""

HOOP = r"""$$\ddot\theta = -\frac gl\sin\theta + \nu^2\sin\theta\cos\theta$$
$$\nu^2\cos\theta\,l\ddot\theta = g\sin\theta$$"""
PUSHED = r"$$m\cos\theta\ddot x + m l\ddot\theta + m g\sin\theta = 0$$ $$L = T + m g l\cos\theta$$"


@pytest.mark.parametrize(
    ("text", "equation"),
    [
        (BOB, r"$$y = 100 - l\cos\theta$$"),  # from another origin
        (r"A pendulum on a cart: $T = \frac12 M\dot x^2$. ", r"$$\det(m l) = 3 m$$"),
        (SPRING, r"$$V_g = -m g l\cos\theta = -m g (l_0 + x)\cos\theta$$"),
        (SPRING, r"$$l = l_0$$"),
        (BOB, "$$\\theta = \\theta + \\pi$$"),
        (SPRING, r"$$u(\theta) = \cos\theta + 2\sin^2\theta$$ $$\frac{du}{d\theta} = 0$$"),
        (BOB, r"$$\frac{d}{dt}(m\dot y) - (-m g) = 0$$"),
        (ON_A_CART + PUSHED, r"$$(M + m)\ddot w + m l\ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F$$"),
        (BOB, HOOP),
        (BOB, "Lg = T - V\n"),
        (ON_A_CART + PUSHED, r"$$(\frac Mm + 1)\ddot x + l\cos\theta\ddot\theta - l\sin\theta\dot\theta^2 = F$$"),
    ],
    ids=[
        "a term of another origin",
        "det of a number",
        "a chain whose ends agree",
        "one length and another",
        "a new value",
        "the condition of a rest",
        "a body that falls",
        "a cart at w",
        "what moves as no load does",
        "a letter of a name",
        "a load over a mass",
    ],
)
def test_what_may_be_meant_otherwise_is_not_accused(text, equation):
    """A term too many may be an origin or a load, and a letter within a chain the text's own."""
    assert "fails" not in [finding.verdict for finding in pp.diagnose(f"{text}\n\n{equation}\n").findings]


def test_what_is_there_already_is_not_missing_once_more():
    """A mend of a bracket that holds one term adds none that is a multiple of it."""
    wrong = pp.diagnose(BOB + r"$$V = 7 m g l (\cos\theta)$$", rod="plane").findings[-1]
    assert wrong.mends
    assert not [mend.words for mend in wrong.mends if "is missing" in mend.words]


def test_second_derivatives_are_d2_before_a_name():
    """As d2theta in code, where names may end in _ before a sign."""
    text = "d2theta = -g/l*sin(theta)\nd = theta_-phi_\n"
    assert pp.diagnose(text, rod="plane").findings[0].verdict == "holds"


LONG = r"""A double pendulum of two bobs.
$$x_1 = l_1\sin\theta_1$$ $$y_1 = -l_1\cos\theta_1$$ $$x_2 = x_1 + l_2\sin\theta_2$$ $$y_2 = y_1 - l_2\cos\theta_2$$
$$V = m_1 g y_1 + m_2 g y_2$$ $$T_1 = \frac12 m_1 l_1^2\dot\theta_1^2$$
"""
SPEEDS = (
    r"$$\dot x_1 = l_1\dot\theta_1\cos\theta_1$$",
    r"$$\dot y_1 = l_1\dot\theta_1\sin\theta_1$$",
    r"$$\dot x_2 = \dot x_1 + l_2\dot\theta_2\cos\theta_2$$",
    r"$$\dot y_2 = \dot y_1 + l_2\dot\theta_2\sin\theta_2$$",
)


@pytest.mark.parametrize(("wrong", "accused"), [(1, 1), (2, 2), (4, 0)])
def test_a_long_text_of_which_little_holds_is_read_wrongly_rather_than_wrong(wrong, accused):
    """Where four of ten equations lack a rate and six hold, none is accused; where one or two do, these are."""
    speeds = [re.sub(r"l_(.)\\dot\\theta_.", r"l_\1", one) if i < wrong else one for i, one in enumerate(SPEEDS)]
    found = findings(LONG + "\n".join(speeds))
    assert len(found) == 10
    assert sum(finding.verdict == "fails" for finding in found) == accused


STRANGE = r"$$\xi = \zeta_1 + 3$$ $$\chi = \xi\zeta_2$$ $$\eta = \chi + \xi^2$$"


@pytest.mark.parametrize(
    ("right", "wrong", "accused"),
    [
        (r"\dot x_1 = l_1", r"\dot x_1 = -l_1", True),  # the rate of x_1, which holds
        (r"l_2\dot\theta_2\cos\theta_2", r"l_2\dot\theta_2\cos\theta_1", True),  # another index
        (r"l_2\dot\theta_2\cos\theta_2", r"l_2\theta_2\cos\theta_2", True),  # no speed
        (r"+ m_2 l_2 \dot\theta_2^2 \sin", r"- m_2 l_2 \dot\theta_2^2 \sin", True),  # long
    ],
)
def test_a_short_equation_may_be_meant_otherwise(right, wrong, accused):
    """In a long text, unless nearly all else holds, units disagree, an index is wrong, or it is the rate of what holds."""
    text = LONG + "\n".join(SPEEDS) + FIRST + SECOND
    assert right in text
    said = {one.latex: one.verdict for one in findings(text.replace(right, wrong, 1))}
    assert "fails" in said.values()
    said = findings(STRANGE + text.replace(right, wrong, 1))
    assert ("fails" in [one.verdict for one in said]) == accused


def test_a_letter_that_nothing_confirms_accuses_no_short_equation():
    """Nor does a text of which hardly anything holds, but of one that is so long that one change shows what it means."""
    text, own = LONG + "\n".join(SPEEDS) + FIRST, r"$$m_1 \ddot x_1 = -S_1\sin\theta_1 - S_2\sin\theta_2$$"
    assert "fails" not in [one.verdict for one in findings(STRANGE + text + own)]
    wrong = FIRST.replace(r"+ m_2 l_2 \dot", r"- m_2 l_2 \dot")
    assert "fails" in [one.verdict for one in findings(STRANGE + LONG + wrong)]
    assert "fails" in [one.verdict for one in findings(LONG + wrong + 9 * STRANGE)]
    shorter = r"$$V = -(m_1 + m_2) g l_1\cos\theta_1 + m_2 g l_2\cos\theta_2$$"
    assert "fails" in [one.verdict for one in findings(STRANGE + LONG + shorter)]
    assert "fails" not in [one.verdict for one in findings(LONG + shorter + 9 * STRANGE)]


def test_a_mend_whose_sides_are_0_is_none():
    """Lagrange's equation of a wrong Lagrangian is not mended by another letter for L: it would say 0 = 0."""
    text = r"""The Lagrangian of a double pendulum with the coordinates $\phi_1$ and $\phi_2$ is
$$\mathcal{L} = \frac12(m_1 + m_2) L_1^2\dot\phi_1 + m_2 L_1 L_2\dot\phi_1\dot\phi_2\cos(\phi_1 - \phi_2)
 + \frac12 m_2 L_2^2\dot\phi_2^2 - (m_1 + m_2) g L_1(1 - \cos\phi_1) - m_2 g L_2(1 - \cos\phi_2)$$
$$\frac{d}{dt}\frac{\partial\mathcal{L}}{\partial\dot\phi_1} = \frac{\partial\mathcal L}{\partial\phi_1}$$
$$\frac{d}{dt}\frac{\partial\mathcal{L}}{\partial\dot\phi_2} = \frac{\partial\mathcal L}{\partial\phi_2}$$
$$\begin{bmatrix} (m_1 + m_2) L_1^2 & m_2 L_1 L_2\cos(\phi_1 - \phi_2) \\
m_2 L_1 L_2\cos(\phi_1 - \phi_2) & m_2 L_2^2\end{bmatrix}
\begin{bmatrix}\ddot\phi_1 \\ \ddot\phi_2\end{bmatrix}
= \begin{bmatrix} -m_2 L_1 L_2\dot\phi_2^2\sin(\phi_1 - \phi_2) - (m_1 + m_2) g L_1\sin\phi_1 \\
m_2 L_1 L_2\dot\phi_1^2\sin(\phi_1 - \phi_2) - m_2 g L_2\sin\phi_2\end{bmatrix}$$
"""
    lagrangian, law, *_ = findings(text)
    assert lagrangian.verdict == "not checked"  # though the other one of Lagrange's equations holds with it
    assert "equation 2, which says that it obeys Lagrange" in lagrangian.remark
    assert law.verdict != "fails"
    assert not law.mends
    assert findings(text.replace(r"L_1^2\dot\phi_1 ", r"L_1^2\dot\phi_1^2 "))[0].verdict == "holds"


def test_a_speed_may_be_counted_the_other_way():
    """As v = -s' of a pendulum whose s grows backwards."""
    text = r"A simple pendulum: $$s = l\theta$$ $$v = -\dot s$$ $$m l\ddot\theta = -m g\sin\theta$$ $$V = -m g l\cos\theta$$"
    assert [one.verdict for one in findings(text)] == ["holds", "not checked", "holds", "holds"]
    assert "a direction may be chosen so" in findings(text)[1].remark


def test_a_mend_has_units_that_agree():
    """Where T may be a tension, whose derivative is 0, no mend empties the other side."""
    text = r"""A pendulum on a cart: $T = \frac12 M\dot x^2$.
$$\frac{\partial T}{\partial\dot x} = \frac{\partial}{\partial\dot x}(\frac12 m(\dot x^2 + 2 l\dot x\dot\theta))$$"""
    assert not any(" is too many" in mend.words for finding in findings(text) for mend in finding.mends)


STRETCHED = r"""The spring of rest length $\ell$ is $l(t) = \ell + z$ long; the angle is measured from the positive x-axis.
$$x = (\ell + z)\cos\theta$$ $$y = (\ell + z)\sin\theta$$
$$T = \frac{m}{2}\left(\dot z^2 + (\ell + z)^2\dot\theta^2\right)$$ $$V = \frac{k z^2}{2} + m g (\ell + z)\sin\theta$$
"""


def test_an_angle_may_be_measured_from_the_horizontal():
    """Of a bob on a spring too; a letter that is set equal to itself and more, as l(t) = l + z, says nothing of itself."""
    for letter in (r"\ell", "l"):
        _, *rest = findings(STRETCHED.replace(r"\ell", letter))
        assert {one.verdict for one in rest} == {"holds"}
    *_, last = findings(STRETCHED.replace(r"m g (\ell + z)", "m g z"))
    assert last.verdict != "holds"


def test_the_energy_of_one_body_alone_is_not_accused():
    """The second pendulum's, where the whole is given below; a term of a body that is there is missed."""
    one = r"$$T = \frac12 m_2 l_1^2\dot\theta_1^2 + m_2 l_1 l_2\dot\theta_1\dot\theta_2\cos(\theta_1 - \theta_2)"
    other, first = r" + \frac12 m_2 l_2^2\dot\theta_2^2", r" + \frac12 m_1 l_1^2\dot\theta_1^2"
    said = findings(POINTS + one + other + "$$\n" + FIRST + SECOND)
    assert said[4].verdict == "not checked"
    assert "one body alone" in said[4].remark
    said = findings(POINTS + one + first + "$$\n" + FIRST + SECOND)
    assert said[4].verdict == "fails"


def test_an_energy_may_be_printed_with_the_place_that_it_depends_on():
    """U(y) is no product."""
    text = r"A simple pendulum. $$y = -l\cos\theta$$ $$U(y) = m g y$$ $$T = \frac12 m l^2\dot\theta^2$$"
    assert {one.verdict for one in findings(text)} == {"holds"}


def test_what_no_equation_that_holds_has_is_not_left_out_by_mistake():
    """A pendulum on a cart whose own mass the text does not have: none of its momenta lacks M."""
    text = r"""A pendulum on a cart.
$$\frac{\partial T}{\partial\dot x} = m\dot x + m l\dot\theta\cos\theta$$
$$\frac{\partial T}{\partial\dot\theta} = m l\dot x\cos\theta + m l^2\dot\theta$$
$$\ddot\theta = -\frac{g}{l}\sin\theta - \frac1l\ddot x\cos\theta$$ $$V = -m g l\cos\theta$$"""
    assert [one.verdict for one in findings(text)] == ["not checked", "holds", "holds", "holds"]
    own = text.replace(
        r"$$V", r"$$T = \frac12(M + m)\dot x^2 + m l\dot x\dot\theta\cos\theta + \frac12 m l^2\dot\theta^2$$ $$V"
    )
    first, *others = findings(own)
    assert {one.verdict for one in others} == {"holds"}
    assert first.verdict == "fails"


def test_a_name_that_is_computed_twice_confirms_what_it_says_each_time():
    """As delta and the divisor of a double pendulum, at the start of two functions."""
    names = "delta = theta1 - theta2\nden = 2*m1 + m2 - m2*cos(2*delta)\n"
    first = "alpha_1 = (-g*(2*m1 + m2)*sin(theta1) - m2*g*sin(theta1 - 2*theta2) - 2*sin(delta)*m2*(w2**2*l2"
    first += " + w1**2*l1*cos(delta)))/(l1*den)\n"
    second = "alpha_2 = 2*sin(delta)*(w1**2*l1*(m1 + m2) + g*(m1 + m2)*cos(theta1) + w2**2*l2*m2*cos(delta))/(l2*den)\n"
    text = names + first + second
    assert {one.verdict for one in findings(text)} == {"holds"}
    *_, said, last, _ = findings(text.replace("w1**2*l1*cos", "w1*l1*cos") + "delta = theta1 - theta2\n")
    assert (said.verdict, last.verdict) == ("fails", "holds")
    assert said.mends[0].words == "w1*l1*cos(delta) should be w1**2*l1*cos(delta)"


@pytest.mark.parametrize("angle", ["theta", "t"])
def test_an_angular_acceleration_has_its_usual_name_beside_any_letter_of_the_angles(angle):
    """alpha_1 and alpha_2, also where t1 and t2 are the angles: alpha is then no angle."""
    text = """delta = theta1 - theta2
alpha_1 = (-g*(2*m1 + m2)*sin(theta1) - m2*g*sin(theta1 - 2*theta2)
           - 2*sin(delta)*m2*(w2**2*l2 + w1**2*l1*cos(delta)))/(l1*(2*m1 + m2 - m2*cos(2*delta)))
alpha_2 = 2*sin(delta)*(w1**2*l1*(m1 + m2) + g*(m1 + m2)*cos(theta1) + w2**2*l2*m2*cos(delta))/(
    l2*(2*m1 + m2 - m2*cos(2*delta)))
""".replace("theta", angle)
    assert {one.verdict for one in findings(text)} == {"holds"}
    _, right, wrong = findings(text.replace(f"*cos({angle}1)", f"*cos({angle}2)"))
    assert (right.verdict, wrong.verdict) == ("holds", "fails")
    assert wrong.mends[0].words == f"cos({angle}2) should be cos({angle}1)"


@pytest.mark.parametrize(
    ("line", "right", "wrong"), [(1, "l*sin(theta)", "l*cos(theta)"), (3, "k = m*l**2", "k = m*l**3")]
)
def test_of_a_name_that_is_computed_twice_the_value_that_is_wrong_is_accused(line, right, wrong):
    """As a torque and then an inertia: what uses the other value holds."""
    text = "k = g*m*l*sin(theta)\nm*l**2*theta_ddot = -k\nk = m*l**2\nT = k*theta_dot**2/2\nV = -m*g*l*cos(theta)\n"
    assert {one.verdict for one in findings(text)} == {"holds"}
    said = findings(text.replace(right, wrong))
    assert [one.number for one in said if one.verdict == "fails"] == [line]
    assert said[line - 1].mends[0].words.endswith(f" should be {right.partition('k = ')[2] or 'g*m*' + right}")
    assert [one.number for one in said if one.verdict != "holds"] == [line, line + 1]


@pytest.mark.parametrize(
    ("line", "verdict"),
    [
        (r"s = l\theta", "holds"),  # an arc, and no distance from the pivot
        (r"d = l\sin\theta", "not checked"),
        (r"y = l(1 - \cos\theta)", "holds if"),  # from the lowest point
        (r"y = l(1 - \sin\theta)", "not checked"),
        (r"V = -m g l\cos\theta", "holds"),
    ],
)
def test_a_text_may_have_letters_and_origins_of_its_own(line, verdict):
    """Of a simple pendulum whose law and potential energy hold."""
    law, energy = r"$$\ddot\theta = -\frac gl\sin\theta$$", r"$$V = m g l(1 - \cos\theta)$$"
    first, *others = findings(f"A simple pendulum: $${line}$$ {law} {energy}")
    assert first.verdict == verdict
    assert {one.verdict for one in others} == {"holds"}


def test_a_height_from_another_point_gives_the_same_potential_energy():
    """Also where L is the length in one line, and may be the Lagrangian in another."""
    text = r"A simple pendulum: $$y = L(1 - \cos\theta)$$ $$V = m g y$$ $$\ddot\theta = -\frac gL\sin\theta$$"
    assert [one.verdict for one in findings(text)] == ["holds if", "holds", "holds"]
    assert findings(text)[0].condition == "y is measured from another point"


def test_a_quantity_that_another_letter_gives_it_by_chance_is_none():
    """Half the length is h: where l is the length elsewhere, m l theta'^2 is no tension of a uniform rod."""
    text = r"""A uniform rod hangs from one end. $$\frac13 m\ell^2\ddot\theta = -m g\frac\ell2\sin\theta$$
$$V = -\frac12 m g\ell\cos\theta$$ $$N_r = m g\cos\theta + \frac12 m\ell\dot\theta^2$$"""
    assert {one.verdict for one in findings(text)} == {"holds"}
    assert findings(text.replace(r"+ \frac12 m\ell", r"+ m\ell"))[2].verdict == "not checked"


def test_a_law_in_the_units_of_the_pendulum_is_no_mistake():
    """theta'' + sin theta = 0 holds where g/l is 1; a law that has some of its parameters lacks the others."""
    text = r"""A simple pendulum: $$H = \frac{p^2}{2 m l^2} - m g l\cos\theta$$ $$p = m l^2\dot\theta$$
$$V = -m g l\cos\theta$$ $$\ddot\theta + \sin\theta = 0$$"""
    *right, scaled = findings(text)
    assert {one.verdict for one in right} == {"holds"}
    assert (scaled.verdict, scaled.remark) == ("not checked", "it does not hold, but where g = l = 1")
    assert findings(text.replace(r"+ \sin", r"+ g\sin"))[-1].verdict == "fails"


@pytest.mark.slow
def test_the_first_terms_of_a_series_and_unit_vectors_of_the_pendulum_are_no_mistakes():
    """The period at larger amplitudes; r = l times its unit vector, of which the rate is no product."""
    text = r"A simple pendulum: $$\ddot\theta = -\frac gl\sin\theta$$ $$T = 2\pi\sqrt{\frac lg}(1 + \frac{\theta_0^2}{16})$$"
    assert [one.verdict for one in findings(text)] == ["holds", "not checked"]
    text = r"$$\vec r = l\hat r$$ $$\dot{\vec r} = l\dot\theta\hat\theta$$ $$m l\ddot\theta = -m g\sin\theta$$"
    assert {one.verdict for one in findings(text)} == {"holds"}
