"""What an accusation of the doctor rests on: other bodies, instants, series, loads and solutions accuse nobody."""

import pytest

import pendpin as pp

LAW = r"$$\ddot\theta + \frac gl\sin\theta = 0$$ $$T = \frac12 m l^2\dot\theta^2$$ "
OF_SPRINGS = r"""Of a spring: $$L = \frac12 m (\dot r^2 + r^2\dot\theta^2) + m g r\cos\theta - \frac12 k (r - L_0)^2$$
$$r\ddot\theta + 2\dot r\dot\theta + g\sin\theta = 0$$ """
FALLING = r"$$\dot\theta^2 = \frac{3 g}{l}(\cos\theta_0 - \cos\theta)$$ $$l\ddot\theta = \frac32 g\sin\theta$$ "
DRIVEN = r"$$x = x_0 + l\sin\theta, \quad y = y_0 - l\cos\theta$$ "
OF_BOWLS = r"$$V = m g (R - r)(1 - \cos\theta)$$ $$(R - r)\dot\theta = r\omega$$ "


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (LAW, r"\omega = \sqrt{\frac{m g d^2}{4 I L}}"),  # two wires
        (LAW, r"I = \frac12 m R^2"),
        (OF_BOWLS, r"I = \frac25 m r^2"),
        (OF_BOWLS, r"\frac34 m (R - r)^2\dot\theta^2 = T"),
        (LAW, r"g(h) = g_0\left(\frac{R}{R + h}\right)^2"),
        (LAW, r"T_0 = 2\pi\sqrt{\frac{l}{g\sin\alpha}}"),
        (LAW, r"\frac{1}{2 m l^2}\left(\frac{dW}{d\theta}\right)^2 - m g l\cos\theta = E"),
        (LAW, r"\omega^2 = \frac gl - \Omega^2"),
        (LAW, r"\omega = \sqrt{\frac{g}{l\cos\theta}}"),
        (LAW, r"\frac12 m v_b^2 = \frac12 m v_t^2 + 2 m g l"),
        (LAW, r"\dot p = -\sin\theta"),
        (OF_SPRINGS, r"m\ddot y = m g - k (r - L_0)\frac yr"),  # y points down
        (OF_SPRINGS, r"V = \frac12 k (r - L_0)^2 - m g y"),
        (FALLING, r"\cos\theta = \frac23\cos\theta_0"),
        (DRIVEN, r"x_0 = A\cos\alpha\cos\Omega t, \quad y_0 = A\sin\alpha\cos\Omega t"),
        (LAW + r"$$m l^2\ddot\theta + m g l\sin\theta = u$$ ", r"\dot E = 0"),
    ],
)
def test_another_body_an_instant_or_units_of_its_own_accuse_nobody(text, line):
    """Two letters would be one length, a speed is of an instant, axes and units are the text's own, a load may be 0."""
    assert "fails" not in [one.verdict for one in pp.diagnose(f"{text}$${line}$$").findings]


@pytest.mark.parametrize(
    ("line", "right"),
    [
        (r"\ddot\theta + \frac gl(\theta - \frac{\theta^3}{6}) = 0", True),
        (r"\ddot\theta + \frac gl(\theta + \frac{\theta^3}{6}) = 0", False),
        (r"\ddot\theta + \frac gl(\theta - \frac{\theta^3}{6} + \frac{\theta^5}{120}) = 0", True),
        (r"\ddot\theta + \frac gl(\theta - \frac{\theta^3}{6} + \frac{\theta^5}{100}) = 0", False),
        (r"V = \frac12 m g l\theta^2", True),
        (r"V = m g l\theta^2", False),
        (r"V = m g l(\frac{\theta^2}{2} - \frac{\theta^4}{24})", True),
        (r"V = m g l(\frac{\theta^2}{2} + \frac{\theta^4}{24})", False),
        (r"m l^2\ddot\theta + c\dot\theta + m g l\theta = 0", True),
        (r"m l^2\ddot\theta + c\theta^2 + m g l\theta = 0", False),
    ],
)
def test_a_series_holds_to_its_own_last_term(line, right):
    """A wrong last term leaves an error of its own order, a right one an error of the next."""
    assert (pp.diagnose(f"{LAW}$${line}$$").findings[-1].verdict == "holds if") == right


def test_an_acceleration_at_an_instant_is_no_mistake():
    """A rod that begins to fall from the horizontal has no angle in it."""
    laws = (
        r"$$I = \frac13 m l^2$$ $$I\ddot\theta = \frac12 m g l\sin\theta$$ $$\ddot\theta = \frac{3 g}{2 l}\sin\theta$$ "
    )
    falls = pp.diagnose(laws + r"As it begins to fall, $$\alpha = \frac{3 g}{2 l}$$").findings
    assert falls[-1].verdict == "not checked"


def test_what_multiplies_a_letter_that_vanishes_is_not_checked():
    """At rest each factor of a rate would do."""
    text = LAW + r"From rest at its lowest point $$E = \frac13 m l^2\dot\theta^2 - m g l\cos\theta$$"
    assert not pp.diagnose(text).findings[-1].verdict.startswith("holds")


DAMPED = r"""$$\ddot\theta + 2\gamma\dot\theta + \omega_0^2\theta = 0,\quad \omega_0 = \sqrt{g/l}$$
$$\theta = A e^{-\gamma t}\cos(\Omega t)$$ $$m l^2\ddot\theta + c\dot\theta + m g l\sin\theta = 0$$
"""


@pytest.mark.parametrize(
    ("line", "right"),
    [
        (r"\gamma = \frac{c}{2 m l^2}", True),
        (r"\gamma = \frac{c}{m l^2}", False),  # c acts otherwise in the law with it
        (r"\gamma = \frac{c}{2 m l^2}, \quad \Omega = \sqrt{\omega_0^2 - \gamma^2}", True),
    ],
)
def test_a_solution_and_a_law_with_the_load_confirm_what_they_use(line, right):
    """A decay rate is right if the load acts with it as it does without; a frequency, if the solution holds with it."""
    assert (pp.diagnose(f"{DAMPED}$${line}$$").findings[-1].verdict == "holds") == right


def test_what_two_constants_are_off_by_makes_neither_follow_from_the_other():
    """Of parameters alone every residual is another one times what depends on parameters."""
    text = (
        LAW
        + r"$$T_0 = \frac{1}{2\pi}\sqrt{\frac lg}$$ $$\omega_0 = \sqrt{\frac gl}$$ $$\omega_0^2 = \frac{g^2}{l^2}\pi^2$$"
    )
    first, *_, last = pp.diagnose(text).findings[2:]
    assert (first.verdict, last.follows) == ("fails", 0)


def test_a_number_at_the_end_of_a_chain_is_a_value_beside():
    """What stands before it is checked."""
    chain = r"$$T_0 = 2\pi\sqrt{\frac lg} = 3.5$$"
    assert [pp.diagnose(LAW + text).findings[-1].verdict for text in (chain, chain.replace("2", "4"))] == [
        "holds",
        "fails",
    ]


def test_a_two_behind_a_prime_is_a_power_whose_mark_is_lost():
    """As of a page that was copied without its raised letters."""
    text = "x1 = L1 sin θ1\nx1'' = −θ1'2 L1 sin θ1 + θ1'' L1 cos θ1\nV = -(m1+m2) g L1 cos θ1 - m2 g L2 cos θ2\n"
    assert {one.verdict for one in pp.diagnose(text).findings} == {"holds"}


@pytest.mark.parametrize(
    ("line", "verdict"),
    [
        (r"\vec L = \vec r\times m\vec v", "holds"),
        (r"\vec L = m(\vec r\times\vec v)", "holds"),
        (r"\vec L = m(\vec v\times\vec r)", "fails"),
    ],
)
def test_a_cross_product_in_a_plane_is_about_its_axis(line, verdict):
    """A mass between its factors multiplies it."""
    laws = r"$$L_z = m l^2\dot\theta$$ $$\tau_z = -m g l\sin\theta$$ $$\frac{dL_z}{dt} = \tau_z$$ "
    assert pp.diagnose(f"{laws}$${line}$$").findings[-1].verdict == verdict


@pytest.mark.parametrize("line", ["T = 2*pi*sqrt(2*L/(3*g))", "omega = sqrt(g/(L*cos(theta)))", "T = pi*sqrt(L/g)"])
def test_what_is_true_of_every_point_shows_no_pendulum(line):
    """As m v^2/2: beside it a period may be that of anything."""
    assert "fails" not in [one.verdict for one in pp.diagnose(f"{line}\nKE = 0.5*m*v**2\n").findings]


CART = r"""$$(M + m)\ddot x + m l\ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F$$
$$l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$$ """
PERIODS = r"$$T = 2\pi\sqrt{\frac{2 L}{3 g}}$$ "


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (CART, r"\ddot\theta + \frac gl\sin\theta = 0"),  # a simple pendulum before a cart
        (
            r"$$l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$$",
            r"L = \frac12(\frac32 M + m)\dot x^2 + \frac12 m l^2\dot\theta^2 + m l\dot x\dot\theta\cos\theta"
            r"+ m g l\cos\theta",
        ),
        (
            r"$$l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$$",
            r"\left(\frac32 M + m\right)\ddot x + m l\ddot\theta = 0",
        ),
        (PERIODS, r"\ddot\theta = -\frac{12 g}{7 L}\sin\theta"),  # a rod about another point
        (PERIODS, r"\frac43 m L^2\ddot\theta = -m g\frac L2\sin\theta - m g L\sin\theta"),
        (LAW, r"V = -\left(m + \frac{\mu}{2}\right) g l\cos\theta"),  # a string with mass
        (LAW, r"K = \frac12 m\dot y^2"),  # a body that falls
        (
            r"$$\ddot\theta = \frac gl\sin\theta$$ $$T = \frac12 m l^2\dot\theta^2$$ ",
            r"F = m g\cos\theta - m l\dot\theta^2",
        ),
        (LAW, r"\ddot\theta = \ddot\theta(\dot\theta)"),
        (LAW, r"\theta'' + (\delta - \epsilon\cos\tau)\sin\theta = 0"),
        (CART, r"x_p = x + l\cos\theta, \quad y_p = l\sin\theta"),  # an angle from the horizontal
    ],
)
def test_what_no_law_of_the_text_contradicts_may_be_about_another_body(text, line):
    """Nor is a line accused that holds for another system of the page, or in which two letters would be one mass."""
    assert "fails" not in [one.verdict for one in pp.diagnose(f"{text}$${line}$$").findings]


ENERGIES = {
    "T": (r"T = m l^2\dot\theta^2", r"V = -m g l\cos\theta"),
    "V": (r"V = -2 m g l\cos\theta", r"T = \frac12 m l^2\dot\theta^2"),
    "L": (r"L = m l^2\dot\theta^2 + m g l\cos\theta", r"V = -m g l\cos\theta"),
}


@pytest.mark.parametrize("name", ENERGIES)
def test_a_wrong_energy_is_accused_where_a_law_contradicts_it(name):
    """Twice the kinetic energy is that of a ring: only the law of motion shows that the body is a bob."""
    energies = " ".join(f"$${one}$$" for one in ENERGIES[name])
    assert "fails" not in [one.verdict for one in pp.diagnose(energies).findings]
    first, *_ = pp.diagnose(energies + r"$$l\ddot\theta + g\sin\theta = 0$$").findings
    assert first.verdict == "fails"


def test_columns_of_an_alignment_are_no_factor():
    text = r"\begin{alignat*}{4} l\ddot\theta & = -g\sin\theta \\ T & = \tfrac12 m l^2\dot\theta^2 \end{alignat*}"
    assert {one.verdict for one in pp.diagnose(text).findings} == {"holds"}


def test_a_period_is_contradicted_by_what_holds_and_a_spring_pulls_back():
    """A number before the root is no other body; with the other sign a stiffness pushes away from the rest."""
    assert (
        pp.diagnose(r"$$\ddot\theta = -\frac gl\sin\theta$$ $$T = 3\pi\sqrt{\frac lg}$$").findings[-1].verdict
        == "fails"
    )
    for sign, right in (("-", True), ("+", False)):
        found = pp.diagnose(LAW + rf"$$m l^2\ddot\theta = -m g l\sin\theta {sign} k a^2\theta$$").findings[-1]
        assert found.verdict.startswith("holds") == right


OF_A_STRING = r"""$$L = \frac12 m (\dot r^2 + r^2 \dot\theta^2) + m g r \cos\theta$$
$$m \ddot r - m r \dot\theta^2 - m g \cos\theta = \lambda$$
$$m r^2 \ddot\theta + 2 m r \dot r \dot\theta + m g r \sin\theta = 0$$
Putting $r = l$, $\dot r = \ddot r = 0$: $$\lambda = -m l \dot\theta^2 - m g \cos\theta$$
The tension is $$T = m l \dot\theta^2 + m g \cos\theta$$ $$T = \frac{2 E}{l} + 3 m g \cos\theta$$"""


def test_a_term_that_a_definition_lacks_may_be_0_there():
    """The multiplier of a string whose length is given lacks the term of its length."""
    assert "fails" not in [one.verdict for one in pp.diagnose("With $f = r - l = 0$\n" + OF_A_STRING).findings]


GIVEN = r"$$T = \frac12 m l^2\dot\theta^2$$ $$V = -m g l\cos\theta$$ $$l\ddot\theta + g\sin\theta = 0$$ "


@pytest.mark.parametrize(("line", "wrong"), [("L = T + V", 1), ("L = T - V", 0), ("E = T - V", 1), ("E = T + V", 0)])
def test_a_sum_of_energies_that_the_text_gives_is_compared_with_them(line, wrong):
    """Without one of them its letter may have the other sign."""
    found = pp.diagnose(f"{GIVEN}$${line}$$").findings[-1]
    assert (found.verdict == "fails") == bool(wrong)
    less = pp.diagnose(f"{GIVEN}$${line}$$".replace(r"$$V = -m g l\cos\theta$$", "")).findings[-1]
    assert less.verdict != "fails"


@pytest.mark.parametrize(
    ("x", "y", "wrong"), [("sin", "cos", ""), ("cos", "cos", "x1"), ("sin", "sin", "y1"), ("cos", "sin", "")]
)
def test_a_coordinate_of_a_point_is_compared_with_the_other_one(x, y, wrong):
    """Where both are turned round, the angle is measured from elsewhere."""
    text = f"a double pendulum\nx1 = L1*{x}(theta1)\ny1 = -L1*{y}(theta1)\nx2 = x1 + L2*sin(theta2)\n"
    text += "y2 = y1 - L2*cos(theta2)\nvx2 = L1*theta1_dot*cos(theta1) + L2*theta2_dot*cos(theta2)\n"
    assert [one.latex[:2] for one in pp.diagnose(text).findings if one.verdict == "fails"] == ([wrong] if wrong else [])


def test_a_letter_that_an_equation_holds_with_is_read_rightly():
    """Another body of the page may have a letter r for l; a law of control says of u what nothing here can check."""
    fall = r"Free fall on a circle: $$r^2 = x^2 + y^2$$ $$F_c = m r\dot\theta^2$$ "
    text = fall + r"$$y = -L\cos\theta$$ $$\ddot\theta = -\frac gL\sin\theta$$ $$x = L\cos\theta$$"
    assert pp.diagnose(text).findings[-1].verdict == "fails"
    laws = """T = (M + m)*x_dot**2/2 + m*l*x_dot*theta_dot*cos(theta) + m*l**2*theta_dot**2/2
u = -(k1*x + k2*x_dot + k3*theta)
theta_ddot = -(u*cos(theta) + m*l*theta_dot**2*sin(theta)*cos(theta) + (M + m)*g*sin(theta))/(l*(M + m*sin(theta)**2))
x_ddot = (u + m*l*theta_dot**2*sin(theta) + m*g*sin(theta)*cos(theta))/(M + m*sin(theta)**2)
"""
    for new, wrong in (("u + m*l", 0), ("u - m*l", 1)):
        found = pp.diagnose(laws.replace("u + m*l", new)).findings
        assert [one.verdict for one in found].count("fails") == wrong


BELOW = r"""$$x_1 = l_1\cos\theta_1, \quad y_1 = l_1\sin\theta_1$$
$$T_2 = \frac12 m_2 (l_1^2\dot\theta_1^2 + l_2^2\dot\theta_2^2
+ 2 l_1 l_2\dot\theta_1\dot\theta_2\cos(\theta_1 - \theta_2))$$
$$V_1 = -m_1 g l_1\sin\theta_1, \quad V_2 = -m_2 g (l_1\sin\theta_1 + l_2\sin\theta_2)$$
$$(m_1 + m_2) l_1\ddot\theta_1 + m_2 l_2\ddot\theta_2\cos(\theta_1 - \theta_2)
+ m_2 l_2\dot\theta_2^2\sin(\theta_1 - \theta_2) - (m_1 + m_2) g\cos\theta_1 = 0$$
$$l_2\ddot\theta_2 + l_1\ddot\theta_1\cos(\theta_1 - \theta_2)
- l_1\dot\theta_1^2\sin(\theta_1 - \theta_2) - g\cos\theta_2 = 0$$"""


def test_angles_below_the_horizontal_turn_gravity_round():
    """All laws agree in that. One alone that has it is wrong."""
    assert {one.verdict for one in pp.diagnose(BELOW).findings} <= {"holds", "holds if"}
    above = BELOW.replace("= -m", "= m").replace("- g", "+ g")
    assert [one.verdict for one in pp.diagnose(above).findings].count("fails") == 1


def test_gravity_from_a_period_is_no_acceleration_of_an_instant():
    found = pp.diagnose(LAW + r"$$T_0 = 2\pi\sqrt{\frac lg}$$ $$g = \frac{4\pi}{T_0^2} l$$").findings[-1]
    assert found.verdict == "fails"


SPHERE = r"$$\ddot\theta = \sin\theta\cos\theta\dot\phi^2 - \frac gl\sin\theta$$ "
HUNG = r"$$l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$$ "


@pytest.mark.parametrize(
    ("law", "line", "verdict"),
    [
        (SPHERE, r"\ddot\phi = -\frac{3\dot\theta\dot\phi}{\tan\theta}", "fails"),
        (SPHERE, r"\ddot\phi = -\frac{\dot\theta\dot\phi}{\tan\theta}", "fails"),
        (HUNG, r"(M + m)\ddot x + m l\ddot\theta\cos\theta - 2 m l\dot\theta^2\sin\theta = F", "fails"),
        # the mass of the cart may be another, and both may be terms that rates do not change
        (HUNG, r"(2M + m)\ddot x + m l\ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F", "not checked"),
    ],
)
def test_the_laws_of_the_other_coordinates_fix_the_terms_of_two_rates(law, line, verdict):
    """Both come from one mass matrix."""
    assert [one.verdict for one in pp.diagnose(f"{law}$${line}$$").findings] == ["holds", verdict]


def test_the_last_law_is_believed_where_little_of_a_long_text_is_read():
    """The other one holds; without it two of eleven equations that hold show too little."""
    other = "phi_dd = -2*theta_d*phi_d/tan(theta)\n"
    line = "theta_dd = phi_d*cos(theta)*sin(theta) - g/l*sin(theta)\n"
    unread = "".join(f"q{i} = scale*offset{i}*n{i}\n" for i in range(9))
    verdicts = [[x.verdict for x in pp.diagnose(law + line + unread).findings] for law in (other, "")]
    assert [one.count("fails") for one in verdicts] == [1, 0]


CART = """# friction of the track c and of the joint b; theta is measured from the vertical
den = M + m*sin(theta)**2
x_ddot = (F + m*sin(theta)*(l*theta_dot**2 + g*cos(theta)) - c*x_dot{track}) / den
theta_ddot = (-F*cos(theta) - m*l*theta_dot**2*cos(theta)*sin(theta) - (M + m)*g*sin(theta){joint}) / (l*den)
"""


@pytest.mark.parametrize(
    ("track", "joint", "right"),
    [
        (" + b*theta_dot*cos(theta)/l", " + c*x_dot*cos(theta) - b*theta_dot*(M + m)/(m*l)", True),
        ("", " - b*theta_dot*(M + m)/(m*l)", False),
    ],
)
def test_a_load_moves_every_coordinate(track, joint, right):
    """What acts on one of two coordinates is in both accelerations, once these are solved for."""
    findings = pp.diagnose(CART.format(track=track, joint=joint)).findings
    accelerations = [finding for finding in findings if "_ddot = (" in finding.latex]
    assert [finding.verdict.startswith("holds") for finding in accelerations] == [right, right]


def test_a_length_that_changes_is_no_small_angle():
    """r^2 theta'^2 vanishes beside r'^2 near r = 0 alone; so its wrong sign is found."""
    text = r"""A swinging Atwood machine: the mass $m$ swings on a string of length $r$, $M$ moves up and down.
$$T = \frac12 M \dot r^2 + \frac12 m(\dot r^2 - r^2\dot\theta^2)$$
$$(M + m)\ddot r = m r\dot\theta^2 + m g\cos\theta - M g$$
$$r\ddot\theta + 2\dot r\dot\theta + g\sin\theta = 0$$"""
    first, *others = pp.diagnose(text).findings
    assert first.verdict == "fails"
    assert {finding.verdict for finding in others} == {"holds"}
    assert pp.diagnose(text.replace(r"\dot r^2 - r^2", r"\dot r^2 + r^2")).findings[0].verdict == "holds"


def test_functions_of_csharp_are_functions():
    """Math.Sin is a sine, with a blank before its bracket and a cast before it too."""
    line = "alpha = -(g / l) * (float)Math.Sin (theta);\nomega += alpha * dt;\ntheta += omega * dt;"
    assert pp.diagnose(line).findings[0].verdict == "holds"
    assert pp.diagnose(line.replace("Sin", "Cos")).findings[0].verdict != "holds"


def test_a_term_is_missing_in_a_very_long_law_beside_one_that_holds():
    """Of a short one two have to hold: another body has other terms."""
    text = """double pendulum
d = t1 - t2
M = m1 + m2
den = 2*m1 + m2 - m2*cos(2*d)
dw1 = (-g*(2*m1+m2)*sin(t1) - m2*g*sin(t1-2*t2) - 2*sin(d)*m2*(w2**2*l2 + w1**2*l1*cos(d)))/(l1*den)
dw2 = (2*sin(d)*(w1**2*l1*(m1+m2) + g*M*cos(t1) + w2**2*l2*m2*cos(d)))/(l2*den)
"""
    assert {one.verdict for one in pp.diagnose(text).findings} == {"holds"}
    (wrong,) = (one for one in pp.diagnose(text.replace("g*(2*m1+m2)", "g*(2*M)")).findings if one.verdict == "fails")
    assert wrong.mends[0].words == "the term - m2 is missing"
    short = r"$$\ddot\theta = -\frac gl\sin\theta$$ $$L = \frac12 m l^2\dot\theta^2$$"
    assert pp.diagnose(short).findings[1].verdict == "not checked"
