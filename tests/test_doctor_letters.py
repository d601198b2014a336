"""The equation doctor: what the words of a text say of its letters, and that one text has one convention."""

import pytest

import pendpin as pp
from pendpin.doctor.reading.names import Written
from pendpin.doctor.systems.tables import FAMILIES


def verdicts(text):
    """The verdicts in order."""
    return [finding.verdict for finding in pp.diagnose(text).findings]


SYMMETRIC = r"""
$$ T = \frac12 A(\dot\phi^2 + \dot\theta^2\cos^2\phi) + \frac12 C\dot\theta^2\sin^2\phi $$
$$ V = - M g c\cos\theta\cos\phi $$
$$ A\ddot\phi + (A - C)\dot\theta^2\sin\phi\cos\phi + M g c\cos\theta\sin\phi = 0 $$
"""
SAID = "A symmetric rod of mass $M$ on a universal joint; $c$ is the distance of the centre of mass from the joint"


@pytest.mark.parametrize(
    "words",
    [
        "$A$ is the transverse inertia about the joint, $C$ the inertia about the axis",
        "$A$ is the transverse inertia about the joint and $C$ the moment of inertia about the axis of symmetry",
        "$A$ denotes the moment of inertia about a transverse axis through the joint, $C$ the polar moment of inertia",
        "it has the transverse inertia $A$ about the joint and the spin inertia $C$",
        "$A$ is the inertia about the joint, $C$ the inertia about its symmetry axis",
    ],
)
def test_inertias_are_what_the_words_beside_them_say(words):
    text = f"{SAID}; {words}.\n{SYMMETRIC}"
    assert verdicts(text) == ["holds"] * 3
    if "symmetry" in words:  # a fault beside two of the five ways of saying it
        assert verdicts(text.replace("(A - C)", "(A + C)")) == ["holds", "holds", "fails"]


HALVES = {  # texts whose kinetic energy lacks a half
    "a bob": r"A bob of mass $m$ hangs on a string: $T = m l^2\dot\theta^2$, $V = -m g l\cos\theta$, "
    r"$l\ddot\theta = -g\sin\theta$",
    "a body": r"With $J_1$ and $I_3$: $T = J_1(\dot\phi^2 + \dot\theta^2\cos^2\phi) + \frac12 I_3\dot\theta^2\sin^2\phi$, "
    r"$V = -m g h\cos\theta\cos\phi$",
    "a cart": r"A cart $M$ at $x$: $T = \frac12 M\dot x^2 + m(\dot x^2 + 2 l\dot x\dot\theta\cos\theta + l^2\dot\theta^2)$, "
    r"$V = -m g l\cos\theta$, $l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$",
    "a sphere": r"With the azimuth $\phi$: $T = m l^2(\dot\theta^2+\dot\phi^2\sin^2\theta)$, $V = -m g l\cos\theta$, "
    r"$l\ddot\theta = l\dot\phi^2\sin\theta\cos\theta - g\sin\theta$",
    "said": f"{SAID}; $A$ is the inertia about the joint, $C$ the axial inertia.\n"
    + SYMMETRIC.replace(r"T = \frac12 A", "T = A"),
}


@pytest.mark.parametrize("text", HALVES.values(), ids=HALVES.keys())
def test_a_half_is_missing_beside_a_right_potential_energy(text):
    """Where a law contradicts it: without one the kinetic energy may be that of another body."""
    kinetic, *others = pp.diagnose(text).findings
    assert {finding.verdict for finding in others} == {"holds"}
    assert kinetic.verdict == "fails"
    assert kinetic.mends[0].words.startswith(r"the factor \frac{1}{2} is missing")


MASSES = r"""# Double pendulum
$$ M_{11} = I_1 + m_2 l_1^2 $$
$$ M_{12} = m_2 l_1 h_2\cos(\theta_1-\theta_2) $$
$$ M_{22} = m_2 h_2^2 + I_2 $$
"""
JOINT = "$I_1$ is the inertia about the pivot of the first link.\n"


def test_inertias_of_one_text_are_about_the_same_point_unless_it_says_otherwise():
    """M_11 lacks m_1 h_1^2 if I_2 is central; I_1 may be said to be about the pivot; both may be."""
    first, *others = pp.diagnose(MASSES).findings
    assert (first.verdict, *(finding.verdict for finding in others)) == ("fails", "holds", "holds")
    assert first.mends[0].words == "the term + m_1 h_1^2 is missing"
    assert verdicts(MASSES + JOINT) == ["holds"] * 3
    assert verdicts(MASSES.replace("m_2 h_2^2 + I_2", "I_2")) == ["holds"] * 3
    central = "The links have the central inertias $I_1$ and $I_2$.\n" + MASSES.replace("m_2 h_2^2 + I_2", "I_2")
    assert verdicts(central) == ["not checked", "holds", "not checked"]  # M_22 = I_2 may say when they are equal


@pytest.mark.parametrize(
    ("text", "right"),
    [
        (r"The central inertia of the rod is $I_G = l^2 m/3$, $T = \frac{m l^2}{6}\dot\theta^2$", "m/12"),
        (r"$J$ is the inertia about the pivot: $J = l^2 m/12$, $T = \frac{m l^2}{6}\dot\theta^2$", "m/3"),
        (
            r"The central inertia is $I = \frac{m l^2}{3}$, $(I + m l^2/4)\ddot\theta = -\frac{m g l}{2}\sin\theta$",
            "12",
        ),
        (
            r"$I_1 = \frac13 m_1 l_1^2$, $I_2 = \frac1{12} m_2 l_2^2$, $M_{12} = m_2 l_1 l_2\cos(\theta_1-\theta_2)/2$",
            "12",
        ),
    ],
)
def test_an_inertia_about_another_point_than_the_text_says_is_mended(text, right):
    first, *others = pp.diagnose(text).findings
    assert {finding.verdict for finding in others} == {"holds"}
    assert first.verdict == "fails"
    assert right in first.mends[0].new


@pytest.mark.parametrize(
    "text",
    [
        r"$a$ is the angle theta and $b$ is the angle phi of a rod: $T = \frac{m l^2}{6}(\dot b^2 + \dot a^2\cos^2 b)$, "
        r"$\ddot b = -\dot a^2\sin b\cos b - \frac{3g}{2l}\cos a\sin b$",
        r"where $a$ is the angle from the vertical: $\ddot a + \frac{g}{l}\sin a = 0$. The kinetic energy is "
        r"$K = \frac12 m l^2\dot a^2$, the potential energy of the bob is $P = -m g l\cos a$",
        r"The potential energy is $$ P = -(m_1+m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2, $$ the kinetic energy $$ K = "
        r"\frac12(m_1+m_2)l_1^2\dot\theta_1^2 + \frac12 m_2l_2^2\dot\theta_2^2 + m_2l_1l_2\dot\theta_1\dot\theta_2"
        r"\cos(\theta_1-\theta_2) $$",
        r"The potential energy is $P = -\frac{m g l}{2}\cos\theta\cos\phi$, the kinetic energy "
        r"$K = \frac{m l^2}{6}(\dot\phi^2 + \dot\theta^2\cos^2\phi)$.",
    ],
    ids=["angles", "plane", "double", "rod"],
)
def test_angles_and_energies_may_have_any_letter(text):
    found = verdicts(text)
    assert found == ["holds"] * len(found)
    assert "fails" in verdicts(text.replace("P = -", "P = ").replace(r"\sin b\cos b -", r"\sin b\cos b +"))


BOBS = r"""# Two bobs
$$x_1 = l_1\sin\theta_1,\quad y_1 = -l_1\cos\theta_1$$
$$x_2 = x_1 + l_2\sin\theta_2,\quad y_2 = y_1 - l_2\cos\theta_2$$
$$v_1^2 = \dot x_1^2 + \dot y_1^2 \qquad v_2^2 = \dot x_2^2 + \dot y_2^2$$
$$T = \frac12 m_1 v_1^2 + \frac12 m_2 v_2^2$$
$$V = -(m_1+m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2$$
# Two rods
Each has its moment of inertia $I_1$, $I_2$ about its centre of mass at $h_1$, $h_2$.
$$V = -(m_1 h_1 + m_2 l_1) g\cos\theta_1 - m_2 g h_2\cos\theta_2$$
$$M_{12} = m_2 l_1 h_2\cos(\theta_1-\theta_2)$$
$$M_{22} = I_2 + m_2 h_2^2$$
"""


def test_each_section_has_bodies_of_its_own():
    """Bobs in one section and rods in the next: the energies of both hold, and v^2 = ... says what v is."""
    assert set(verdicts(BOBS)) == {"holds"}


CODE = """
def rates(t, y):
    {angles}
    dtheta = y[2] - y[0]
    den = (M1 + M2)*L1 - M2*L1*cos(dtheta)**2
    acc1 = (M2*L1*y[1]**2*sin(dtheta)*cos(dtheta) + M2*G*sin(y[2])*cos(dtheta) + M2*L2*y[3]**2*sin(dtheta)
            - (M1 + M2)*G*sin(y[0]))/den
    dydt[1] = acc1
"""


CART = """
den = M + m*sin({th})**2
{acc} = (F + m*sin({th})*(l*{om}**2 + g*cos({th})))/den
{alf} = (-F*cos({th}) - m*l*{om}**2*sin({th})*cos({th}) - (M + m)*g*sin({th}))/(l*den)
"""
UNPACKED = {  # lines that tell which name of a state is the rate of which other
    "elements": "x1 = s(1)\nx2 = s(2)\nx3 = s(3)\nx4 = s(4)\nsdot(1) = x2\nsdot(3) = x4"
    + CART.format(th="x3", om="x4", acc="sdot(2)", alf="sdot(4)"),
    "column": "pos = z(1)\nxd = z(2)\nalfa = z(3)\nalfad = z(4)"
    + CART.format(th="alfa", om="alfad", acc="xdd", alf="alfadd")
    + "dz = [xd; xdd; alfad; alfadd]",
    "tuple": "x, z1, theta, z2 = y\nxdot = z1\nthetadot = z2"
    + CART.format(th="theta", om="z2", acc="z1dot", alf="z2dot"),
    "rates first": "thetaDot = state(1)\ntheta = state(2)\nxDot = state(3)\nx = state(4)\nstateDot(2) = thetaDot"
    + CART.format(th="theta", om="thetaDot", acc="stateDot(3)", alf="stateDot(1)"),
}


@pytest.mark.parametrize("text", UNPACKED.values(), ids=UNPACKED.keys())
def test_names_of_states_are_what_the_lines_that_unpack_them_say(text):
    """Both accelerations hold, and one with a wrong sign does not."""
    laws = [f for f in pp.diagnose(text).findings if "F" in f.latex]
    assert [f.verdict for f in laws] == ["holds", "holds"]
    wrong = [f for f in pp.diagnose(text.replace("- (M + m)*g", "+ (M + m)*g")).findings if "F" in f.latex]
    assert [f.verdict for f in wrong] == ["holds", "fails"]


NUMBERED = {
    "letters": (
        r"$T = \frac12(m_A+m_B) l_A^2\dot\theta_A^2 + \frac12 m_B l_B^2\dot\theta_B^2 "
        r"+ m_B l_A l_B\dot\theta_A\dot\theta_B\cos(\theta_A-\theta_B)$, "
        r"$V = -(m_A + m_B) g l_A\cos\theta_A - m_B g l_B\cos\theta_B$"
    ),
    "from 0": """T = 0.5*(m[0]+m[1])*(L[0]*omega[0])**2 + 0.5*m[1]*(L[1]*omega[1])**2 + m[1]*L[0]*L[1]*omega[0]*omega[1]*c01
c01 = cos(theta[0] - theta[1])
V = -(m[0] + m[1])*g*L[0]*cos(theta[0]) - m[1]*g*L[1]*cos(theta[1])
x0 = origin[0] + L[0]*sin(theta[0])
x1 = x0 + L[1]*sin(theta[1])
""",
}


@pytest.mark.parametrize("text", NUMBERED.values(), ids=NUMBERED.keys())
def test_two_bodies_may_have_letters_or_be_counted_from_0(text):
    """A place may be measured from a pivot."""
    assert {verdict.partition(" if")[0] for verdict in verdicts(text)} == {"holds"}
    assert "fails" in verdicts(text.replace("V = -", "V = ", 1))


@pytest.mark.parametrize("sign", ["-", pytest.param("+", marks=pytest.mark.slow)])
def test_a_letter_that_only_multiplies_a_rate_is_a_damping(sign):
    """b is a length of a pendulum on a cart elsewhere; q is no vector of coordinates where it is a number."""
    text = """q = (M + m)*(I + m*L^2) - m^2*L^2*cos(theta)^2
xddot = ((I + m*L^2)*(F - b*xdot + m*L*thetadot^2*sin(theta)) + m^2*L^2*g*sin(theta)*cos(theta))/q
thetaddot = -(m*L*cos(theta)*(F - b*xdot + m*L*thetadot^2*sin(theta)) + (M + m)*m*g*L*sin(theta))/q
"""
    found = verdicts(text.replace("+ (M + m)*m*g", f"{sign} (M + m)*m*g"))
    assert found == ["holds"] * 3 if sign == "+" else found[2] not in ("holds", "holds if")


def test_an_entry_of_a_matrix_that_is_0_is_one():
    text = (
        "$$ M_{11} = (m_1+m_2) l_1^2, M_{12} = m_2 l_1 l_2\\cos(\\theta_1-\\theta_2), M_{22} = m_2 l_2^2, C_{22} = 0 $$"
    )
    assert verdicts(text) == ["holds"] * 4


@pytest.mark.parametrize("angles", ["dtheta1dt = y[1]\n    dtheta2dt = y[3]", "dydt[0] = y[1]\n    dydt[2] = y[3]"])
def test_a_vector_of_states_is_read_by_its_places(angles):
    """The rate of y[0] stands at y[1], whether a vector or names say so; a difference may be called dtheta."""
    found = {
        finding.latex.split(" ")[0]: finding.verdict for finding in pp.diagnose(CODE.format(angles=angles)).findings
    }
    assert {found[name] for name in ("dtheta", "den", "acc1")} == {"holds"}


ARM = """
function dz = arm(t, Z)
  M11 = (m1/3 + m2)*L1^2 + m2*L2^2/3 + m2*L1*L2*cos(Z(2));
  M12 = m2*L2^2/3 + m2*L1*L2*cos(Z(2))/2;
  M22 = m2*L2^2/3;
  h1 = -m2*L1*L2*sin(Z(2))*(Z(3)*Z(4) + Z(4)^2/2);
  G1 = (m1/2 + m2)*g*L1*cos(Z(1)) + m2*g*L2*cos(Z(1) + Z(2))/2;
  G2 = m2*g*L2*cos(Z(1) + Z(2))/2;
"""


def test_two_elements_of_a_vector_in_sines_are_angles_and_the_next_two_their_rates():
    found = {finding.latex.split(" ")[0]: finding for finding in pp.diagnose(ARM).findings}
    assert {found[name].verdict for name in ("M11", "M12", "M22", "G1", "G2")} == {"holds"}
    rates = "E = M11*Z(3)^2/2 + M12*Z(3)*Z(4) + M22*Z(4)^2/2 + g*(m1/2 + m2)*L1*sin(Z(1)) + m2*g*L2*sin(Z(1) + Z(2))/2"
    held = [pp.diagnose(f"{ARM}  {line};\n").findings[-1].verdict for line in (rates, rates.replace("+ M12", "- M12"))]
    assert held == ["holds", "fails"]


BOTH = """
# M theta_ddot + c = tau
angle1, angle2, velocity1, velocity2 = state
x1 = length1*sin(angle1)
y1 = -length1*cos(angle1)
x2 = x1 + length2*sin(angle2)
y2 = y1 - length2*cos(angle2)
V = mass1*g*y1 + mass2*g*y2
T1 = mass1*(length1*velocity1)**2/2
"""


def test_a_line_holds_only_with_what_the_text_says_of_its_letters():
    """v2 means the speed of the second bob, unless the text says that it is another thing."""
    right = "T2 = mass2*v2**2/2"
    for line, verdict in (("", "holds"), ("v2 = length2*velocity2\n", "not checked")):
        findings = pp.diagnose(f"{BOTH}{line}{right}\n").findings
        assert [finding.verdict for finding in findings[1:7]] == ["holds"] * 6
        assert findings[-1].verdict == verdict


CENTRES = r"""# Two uniform rods
$$x_1 = \frac{l_1}{2}\sin\theta_1,\quad y_1 = -\frac{l_1}{2}\cos\theta_1$$
$$x_2 = l_1\sin\theta_1 + \frac{l_2}{2}\sin\theta_2$$
$$y_2 = y_1 - \frac{l_2}{2}\cos\theta_2$$
"""


def test_a_letter_is_the_centre_of_mass_where_a_line_of_the_section_says_so():
    assert verdicts(CENTRES) == ["holds"] * 3 + ["not checked"]
    assert verdicts(CENTRES.replace("y_2 = y_1", "y_2 = y_1 - \\frac{l_1}{2}\\cos\\theta_1")) == ["holds"] * 4


PLANE = (
    r"The angle from the vertical is $\theta$. $$\ddot\theta + \frac{g}{l}\sin\theta = 0$$ $$V = -m g l\cos\theta$$ "
)


@pytest.mark.parametrize(
    ("line", "verdict"),
    [
        (r"$$\theta(0) = \theta_0$$ $$\dot\theta(0) = \omega_0$$", "not checked"),  # where the motion begins
    ],
    ids=["start"],
)
def test_what_is_no_law_of_the_motion_neither_holds_nor_fails(line, verdict):
    assert verdicts(PLANE)[:2] == ["holds", "holds"]
    assert verdicts(PLANE + line)[-1] == verdict


def test_a_section_that_measures_its_angle_the_other_way_says_so():
    """x_p = x + l sin(theta) is at odds with the energy of the same cart, in which the angle counts to the other side."""
    cart = r"""# Places
$$x_p = x {} l\sin\theta,\quad y_p = l\cos\theta$$
# Energies of the cart and its pendulum
$$T = \frac12 (M + m)\dot x^2 - m l\dot x\dot\theta\cos\theta + \frac12 m l^2\dot\theta^2$$
$$V = m g l\cos\theta$$
$$(M + m)\ddot x - m l\ddot\theta\cos\theta + m l\dot\theta^2\sin\theta = F$$
"""
    assert verdicts(cart.replace("{}", "-")) == ["holds"] * 5
    odd = pp.diagnose(cart.replace("{}", "+")).findings[0]
    assert odd.verdict == "not checked"
    assert odd.remark.startswith("it holds if angles are measured otherwise than in most of the text")


def test_a_fault_in_code_on_states_is_mended():
    """The changed text is read with the same states: y[1] is a rate there too."""
    azimuth = "dx1 = x3\ndx2 = x4\ndx3 = x4^2*sin(x1)*cos(x1) - g/l*sin(x1)\ndx4 = 2*x3*x4/tan(x1)\n"
    found = pp.diagnose(azimuth)
    assert [finding.verdict for finding in found.findings] == ["holds"] * 3 + ["fails"]
    assert found.wrong[0].mends[0].latex == "dx4 = -2*x3*x4/tan(x1)"
    assert found.title.startswith("a spherical pendulum")


ALIKE = r"""A pendulum on a cart, the pole upright at theta = 0.
$$L = \frac12 (M+m)\dot x^2 + m L \dot x\dot\theta\cos\theta + \frac12 m L^2\dot\theta^2 - m g L\cos\theta$$
$$\frac{\partial L}{\partial\dot\theta} = m L\dot x\cos\theta + m L^2\dot\theta$$
$$\frac{d}{dt}\frac{\partial L}{\partial\dot\theta}
    = m L\ddot x\cos\theta - m L\dot x\dot\theta\sin\theta + m L^2\ddot\theta$$
$$\frac{\partial L}{\partial\theta} = -m L\dot x\dot\theta\sin\theta + m g L\sin\theta$$
"""


def test_a_letter_is_the_lagrangian_on_the_left_and_a_length_on_the_right():
    assert pp.diagnose(ALIKE).ok


def test_two_letters_for_a_length_are_read():
    """L and L_p stand on both sides; each of them may be the length, and reading them ends."""
    (found,) = pp.diagnose(r"m_p L\ddot\theta\sin\theta = R_x - \frac{1}{L_p \sin\theta} I_p\ddot\theta").findings
    assert found.verdict == "not checked"


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (r"\frac12 m L^2", "m L^2"),
        (r"- m L\dot x\dot\theta\sin\theta + m L^2", r"+ m L\dot x\dot\theta\sin\theta + m L^2"),
    ],
)
def test_a_lagrangian_beside_a_length_of_the_same_letter_is_mended(right, wrong):
    """As it is read."""
    (found,) = [f for f in pp.diagnose(ALIKE.replace(right, wrong)).findings if f.verdict != "holds"]
    assert found.verdict == "fails"
    assert pp.diagnose(ALIKE.replace(found.latex, found.mends[0].latex)).ok


def test_a_load_that_gets_a_name_is_not_wrong():
    """F_x = F(t) - d x' says what F_x is where the law that it belongs to holds without the damping d."""
    text = r"""A pendulum on a cart. $F_x = F(t) - d \dot x$
    $$(M + m)\ddot x + m l\ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F(t) - d\dot x$$
    $$l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$$"""
    assert [f.verdict for f in pp.diagnose(text).findings] == ["not checked", "holds", "holds"]


POLE = """({M} + {m})*xddot + {m}*l*thetaddot*cos(theta) - {m}*l*thetadot**2*sin(theta) = F
({I} + {m}*l**2)*thetaddot + {m}*l*xddot*cos(theta) + {m}*g*l*sin(theta) = 0
"""
INDICES = {
    "in code": "Mc mp Ip",
    "in capitals": "M_C m_P I_P",
    "after a bar": "m_c m_p I_p",
}


@pytest.mark.parametrize("names", INDICES.values(), ids=INDICES)
def test_an_index_is_the_same_however_it_is_set(names):
    """As m_p, m_P and mp: in all of them a law holds, and one with another power is mended."""
    text = POLE.format(**dict(zip("MmI", names.split(), strict=True)))
    assert [f.verdict for f in pp.diagnose(text).findings] == ["holds", "holds"]
    assert [f.verdict for f in pp.diagnose(text.replace("l**2", "l**3")).findings] == ["holds", "fails"]


def test_an_index_of_an_index_is_one_index():
    words = next(spec.words for spec in FAMILIES["double"] if spec.kind == "double any absolute down")
    plain = words(Written("l", 0, "c1"))
    assert plain == ("h1",)
    assert all(words(Written("l", 0, index)) == plain for index in ("{c_1}", "c,1", "{c,1}", "C1"))
    assert words(Written("lc", 0, "1")) == words(Written("lc1")) == plain
    tables = [spec.words for spec in FAMILIES["cart-pole"]]
    assert all(table(Written("T", 0, "M")) == ("Tc",) != table(Written("T", 0, "m")) for table in tables)


BOB = r"$$\ddot\theta = -\frac{g}{l}\sin\theta$$ $$V = -mgl\cos\theta$$ $$T = \frac12 m l^2\dot\theta^2$$ "


@pytest.mark.parametrize(
    ("line", "verdict"), [(r"v = \dot\theta", "not checked"), (r"\omega = \theta", "not checked"), ("v = l", "fails")]
)
def test_a_state_may_get_any_name_and_a_length_no_speed(line, verdict):
    *_, last = pp.diagnose(f"{BOB} $${line}$$").findings
    assert last.verdict == verdict
    assert (last.remark == "it gives a state a name") == (verdict == "not checked")


def test_a_name_for_a_name_comes_to_nothing():
    """An expression of some length does."""
    code = (
        "x1 = l1*sin(theta1)\nx2 = x1 + l2*sin(theta2)\nacc_b1 = ddtheta1\nalpha_s = ddtheta2\nxs = x1 + l2*sin(theta2)"
    )
    findings = pp.diagnose(code).findings
    assert [finding.kind for finding in findings[2:4]] == ["definition"] * 2
    assert [finding.verdict for finding in findings] == ["holds", "holds", "not checked", "not checked", "holds"]


@pytest.mark.parametrize(("rates", "states"), [("f", "y"), ("dydt", "y"), ("p", "u")])
def test_a_function_of_a_vector_of_states_gives_their_rates(rates, states):
    """Whatever the vector of rates is called."""
    code = f"{rates}(1) = {states}(2);\n{rates}(2) = -g/l*sin({states}(1));\n"
    assert verdicts(code) == ["holds", "holds"]
    assert verdicts(code.replace("sin", "cos"))[1] != "holds"


def test_what_is_measured_the_other_way_is_so_in_energies_too():
    """With y downwards V = -m g y, and the rate of y_2 has the sign of y_2's own equation."""
    text = r"""
    $$x_1 = l_1\sin\theta_1,\quad y_1 = l_1\cos\theta_1,\quad x_2 = x_1 + l_2\sin\theta_2,\quad y_2 = y_1 + l_2\cos\theta_2$$
    $$\dot y_2 = \dot y_1 - l_2\dot\theta_2\sin\theta_2$$
    $$T = \frac12 m_1(\dot x_1^2 + \dot y_1^2) + \frac12 m_2(\dot x_2^2 + \dot y_2^2)$$
    $$T = \frac12 (m_1 + m_2) l_1^2\dot\theta_1^2 + \frac12 m_2 l_2^2\dot\theta_2^2
      + m_2 l_1 l_2\dot\theta_1\dot\theta_2\cos(\theta_1-\theta_2)$$
    $$V = -m_1 g y_1 - m_2 g y_2$$
    $$V = -(m_1 + m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2$$
    $$l_2\ddot\theta_2 + l_1\ddot\theta_1\cos(\theta_1-\theta_2) - l_1\dot\theta_1^2\sin(\theta_1-\theta_2)
      = -g\sin\theta_2$$
    $$(m_1 + m_2)(l_1\ddot\theta_1 + g\sin\theta_1) + m_2 l_2\ddot\theta_2\cos(\theta_1-\theta_2)
      = -m_2 l_2\dot\theta_2^2\sin(\theta_1-\theta_2)$$
    """
    found = pp.diagnose(text).findings
    assert all(finding.verdict.startswith("holds") for finding in found)
    assert [finding.condition for finding in found if finding.condition] == ["y is measured the other way"] * 4


def test_equations_of_two_uniform_rods_hold():
    arm = r"\frac{m_2 l_1 l_2}{2}"
    first = rf"(\frac{{m_1}}{{3}} + m_2) l_1^2\ddot\theta_1 + {arm}\cos(\theta_1-\theta_2)\ddot\theta_2"
    first += rf" + {arm}\sin(\theta_1-\theta_2)\dot\theta_2^2 = -(\frac{{m_1}}{{2}} + m_2) g l_1\sin\theta_1"
    second = rf"{arm}\cos(\theta_1-\theta_2)\ddot\theta_1 + \frac{{m_2 l_2^2}}{{3}}\ddot\theta_2"
    second += rf" = {arm}\sin(\theta_1-\theta_2)\dot\theta_1^2 - \frac{{m_2}}{{2}} g l_2\sin\theta_2"
    assert [f.verdict for f in pp.diagnose([first, second]).findings] == ["holds", "holds"]


@pytest.mark.parametrize(
    ("line", "remark"),
    [
        (r"m l^2\ddot\theta + m g l\sin\theta = -b\dot\theta", "b is a damping"),
        (r"\ddot\theta = -\frac{g}{l}\sin\theta - b\dot\theta", "b is a damping"),  # for each m l^2
        (r"m l^2\ddot\theta + m g l\sin\theta = -k\theta + u", "k is a spring and u is a load"),
        (r"m l^2\ddot\theta + m g l\sin\theta = b\dot\theta", ""),  # it drives the swing
        (r"m l^2\ddot\theta + m g l\sin\theta = -b\dot\theta\sin\theta", ""),
    ],
)
def test_a_load_is_known_by_what_it_does_to_the_motion(line, remark):
    """A damping takes energy from the swing; what drives it, or is none of the usual loads, is not called right."""
    found = pp.diagnose(
        rf"$$T = \frac12 m l^2\dot\theta^2$$ $$V = -m g l\cos\theta$$ $${line}$$", rod="plane"
    ).findings[-1]
    assert (found.verdict, found.remark) == ("holds", remark) if remark else found.verdict == "not checked"


@pytest.mark.parametrize(("sign", "verdict"), [("", "holds"), ("-", "not checked")])
def test_a_damper_between_two_rods_pulls_the_slower_one_along(sign, verdict):
    first = r"(m_1 + m_2) l_1^2\ddot\theta_1 + m_2 l_1 l_2\cos(\theta_1-\theta_2)\ddot\theta_2"
    first += r" + m_2 l_1 l_2\sin(\theta_1-\theta_2)\dot\theta_2^2 + (m_1 + m_2) g l_1\sin\theta_1"
    second = r"l_1\cos(\theta_1-\theta_2)\ddot\theta_1 + l_2\ddot\theta_2 - l_1\sin(\theta_1-\theta_2)\dot\theta_1^2"
    texts = [rf"{first} = {sign} b(\dot\theta_2 - \dot\theta_1)", rf"{second} = -g\sin\theta_2"]
    assert [finding.verdict for finding in pp.diagnose(texts, rod="double").findings] == [verdict, "holds"]


def test_a_sine_of_time_alone_is_a_drive():
    """At an instant it is some number, whatever its frequency; a motion that a text gives is no law of them."""
    driven = r"A driven pendulum: $$\ddot\theta = -\frac{g}{L}\sin\theta - b\dot\theta + A\cos(\Omega t)$$"
    (law,) = pp.diagnose(driven).findings
    assert (law.verdict, law.remark) == ("holds", "A is a load and b is a damping")
    assert pp.diagnose(driven.replace(r"\sin", r"\cos")).findings[0].verdict != "holds"
    motion = pp.diagnose(r"$$\ddot\theta = -\frac gL\sin\theta$$ $$\theta = \theta_0\cos(\nu t)$$").findings[1]
    assert (motion.verdict, motion.doubtful) == ("not checked", False)
