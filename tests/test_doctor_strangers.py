"""What strangers write: code in several languages, vectors of points, matrices that are inverted, more bodies."""

import pytest

import pendpin as pp


def verdicts(text):
    """The verdict on each equation, by the line on which it stands."""
    return [(finding.latex.partition("=")[0].strip(), finding.verdict) for finding in pp.diagnose(text).findings]


def all_hold(text, *but):
    """Whether every equation holds, but for those with some names on the left that are not judged."""
    return {name: verdict for name, verdict in verdicts(text) if verdict != "holds" and name not in but}


ACCELERATIONS = """d = {a1} - {a2}
den = 2*{m1} + {m2} - {m2}*cos(2*d)
num = -g*(2*{m1} + {m2})*sin({a1}) - {m2}*g*sin({a1} - 2*{a2})
{acc1} = (num - 2*sin(d)*{m2}*({w2}**2*{l2} + {w1}**2*{l1}*cos(d)))/({l1}*den)
{acc2} = 2*sin(d)*({w1}**2*{l1}*({m1} + {m2}) + g*({m1} + {m2})*cos({a1}) + {w2}**2*{l2}*{m2}*cos(d))/({l2}*den)
"""
KEYS = ["a1", "a2", "w1", "w2", "m1", "m2", "l1", "l2", "acc1", "acc2"]
NAMES = {
    "short": "theta1 theta2 w1 w2 m1 m2 l1 l2 a1 a2",
    "objects": "self.angle1 self.angle2 self.velocity1 self.velocity2 p.mass1 p.mass2 p.length1 p.length2 acc1 acc2",
    "Greek": "θ1 θ2 ω1 ω2 m1 m2 L1 L2 θ1_ddot θ2_ddot",
    "samples": "theta1[end] theta2[end] w1[end] w2[end] m1 m2 L1 L2 angularAcceleration1 angularAcceleration2",
    "rates": "theta1 theta2 dtheta1 dtheta2 m1 m2 len1 len2 xdot(2) xdot(4)",
}


FAULTS = {
    "short": (" - 2*sin(d)", " - sin(d)"),
    "objects": ("cos(d)))/", "sin(d)))/"),
    "Greek": ("2*d", "d"),
    "samples": (" - 2*sin(d)", " - sin(d)"),
    "rates": ("2*d", "d"),
}


@pytest.mark.parametrize("style", NAMES)
def test_accelerations_hold_by_whatever_names_the_code_has(style):
    """Also the definitions that they use hold then; a wrong factor, argument or function never does."""
    names = NAMES[style].split()
    code = ACCELERATIONS.format(**dict(zip(KEYS, names, strict=True)))
    assert not all_hold(code)
    found = dict(verdicts(code.replace(*FAULTS[style])))
    assert found[names[8]] != "holds"


USUAL = dict(zip(KEYS, ["theta1", "theta2", "w1", "w2", "m1", "m2", "l1", "l2", "a1", "a2"], strict=True))


def test_an_acceleration_is_not_that_of_the_other_body():
    found = dict(verdicts(ACCELERATIONS.format(**USUAL | {"acc1": "a2", "acc2": "a1"})))
    assert "holds" not in {found["a1"], found["a2"]}


ROBOT = """import sympy as sy
M11 = I1 + I2 + par.m1*par.lc1**2 + par.m2*(par.l1**2 + par.lc2**2 + 2*par.l1*par.lc2*sy.cos(theta2))
M12 = I2 + par.m2*par.lc2*(par.l1*sy.cos(theta2) + par.lc2)
M22 = I2 + par.m2*par.lc2**2
M = sy.Matrix([[M11, M12], [M12, M22]])
h = par.m2*par.l1*par.lc2*sy.sin(theta2)
f = sy.Matrix([h*dtheta2*(2*dtheta1 + dtheta2), -h*dtheta1**2])
G2 = g*par.m2*par.lc2*sy.sin(theta1 + theta2)
G = sy.Matrix([g*(par.m1*par.lc1 + par.m2*par.l1)*sy.sin(theta1) + G2, G2])
"""


@pytest.mark.parametrize(
    "last",
    [
        "ddq = M.inv() @ (f - G)",
        pytest.param("ddq = np.linalg.inv(M) @ (f - G)", marks=pytest.mark.slow),
        pytest.param("ddq = np.linalg.solve(M, f - G)", marks=pytest.mark.slow),
        "ddq = M\\(f - G)",
    ],
)
def test_a_mass_matrix_is_inverted_as_each_language_does(last):
    """A wrong one is tried as a product and as a solution; the other spellings of these are read as the same trees."""
    assert dict(verdicts(ROBOT + last))["ddq"] == "holds"
    if "inv()" in last or "\\" in last:
        assert dict(verdicts(ROBOT + last.replace("f - G", "f - 2*G")))["ddq"] != "holds"


def test_matrices_of_functions_and_lines_as_rows():
    code = """M = @(q) [(m1+m2)*l1^2  m2*l1*l2*cos(q(1)-q(2))
          m2*l1*l2*cos(q(1)-q(2))   m2*l2^2];
G = @(q) [(m1+m2)*g*l1*sin(q(1))
          m2*g*l2*sin(q(2))];
"""
    assert not all_hold(code)


def test_what_a_function_returns_and_what_a_list_gets_is_read():
    code = """def theta1_dot(p1, p2):
    return (l2*p1 - l1*p2*np.cos(theta1 - theta2))/(l1**2*l2*(m1 + m2*np.sin(theta1 - theta2)**2))
def kinetic_energy():
    return 0.5*(m1+m2)*l1**2*dtheta1**2 + 0.5*m2*l2**2*dtheta2**2 + m2*l1*l2*dtheta1*dtheta2*np.cos(theta1-theta2)
  push!(x1, l1*sin(theta1))
  y2.append(-l1*cos(theta1) - l2*cos(theta2))
  global posx1 = [l1*sin(theta1[end])]
  \"\"\"
  push!(x1, cos(theta1)*l1)
  \"\"\"
  theta1[i+1] = theta1[i] + dt*dtheta1[i]
"""
    found = verdicts(code)
    assert [verdict for _, verdict in found[:5]] == ["holds"] * 5
    assert found[5][1] == "holds"  # a step in time says what the rate is


POINTS = r"""Two pendulums, one below the other.
$$\vec r_1 = \begin{pmatrix} l_1\sin\theta_1\\ -l_1\cos\theta_1\end{pmatrix}$$
$$\vec r_2 = \vec r_1 + \begin{pmatrix} l_2\sin\theta_2\\ -l_2\cos\theta_2\end{pmatrix}$$
$$\vec{v}_2 = l_1\dot\theta_1(\cos\theta_1\,\hat\imath+\sin\theta_1\,\hat\jmath)
+ l_2\dot\theta_2(\cos\theta_2\,\hat\imath+\sin\theta_2\,\hat\jmath)$$
$$v_{2x} = l_1\dot\theta_1\cos\theta_1 + l_2\dot\theta_2\cos\theta_2$$
"""


def test_points_and_their_velocities_are_vectors():
    """Nobody is accused of a vector that is none of these: it may be measured downwards."""
    assert not all_hold(POINTS)
    for right, wrong in ((r"\vec r_1 +", r"\vec r_1 -"), (r"= l_1\dot\theta_1\cos", r"= l_1\dot\theta_1\sin")):
        assert {*all_hold(POINTS.replace(right, wrong)).values()} == {"not checked"}


def test_a_spherical_pendulum_in_its_own_directions():
    text = r"""A spherical pendulum on a string.
$$\mathbf{a} = r(\ddot\theta - \dot\varphi^2\sin\theta\cos\theta)\mathbf{e_\theta}
+ r(\ddot\varphi\sin\theta+2\dot\theta\dot\varphi\cos\theta)\mathbf{e_\varphi}
- r(\dot\theta^2+\dot\varphi^2\sin^2\theta)\mathbf{e_r}$$
$$\mathbf{F_g} = -m g\mathbf{e_z} = mg\cos\theta\,\mathbf{e_r}-mg\sin\theta\,\mathbf{e_\theta}$$
$$\ddot\theta=\dot\varphi^2\sin\theta\cos\theta-\frac{g}{r}\sin\theta$$
"""
    assert not all_hold(text)


TWO_ON_A_CART = r"""Two pendulums on a cart.
$$x_2 = x + l_1\sin\theta_1 + l_2\sin\theta_2$$
$$T = \tfrac12 M\dot x^2 + \tfrac12 m_1(\dot x_1^2+\dot y_1^2) + \tfrac12 m_2(\dot x_2^2+\dot y_2^2)$$
$$U = (m_1+m_2) g l_1\cos\theta_1 + m_2 g l_2\cos\theta_2$$
$$(M+m_1+m_2)\ddot x + (m_1+m_2)l_1(\ddot\theta_1\cos\theta_1-\dot\theta_1^2\sin\theta_1)
+ m_2 l_2(\ddot\theta_2\cos\theta_2-\dot\theta_2^2\sin\theta_2) = F$$
$$\frac{\partial L}{\partial\dot\theta_2} = m_2 l_2^2\dot\theta_2 + m_2 l_2\dot x\cos\theta_2
+ m_2 l_1 l_2\dot\theta_1\cos(\theta_1-\theta_2)$$
"""


def test_two_pendulums_on_a_cart():
    assert not all_hold(TWO_ON_A_CART)
    found = pp.diagnose(
        TWO_ON_A_CART.replace("l_1\\cos\\theta_1 + m_2 g l_2", "l_1\\cos\\theta_1 - m_2 g l_2")
    ).findings
    assert [finding.verdict for finding in found] == ["holds", "holds", "fails", "holds", "holds"]


def test_masses_with_an_inertia_at_the_ends():
    code = """m11 = m1*l1^2 + J1 + m2*(l1^2 + l2^2 + 2*l1*l2*cos(theta2)) + J2
m12 = m2*(l2^2 + l1*l2*cos(theta2)) + J2
m22 = m2*l2^2 + J2
g2 = m2*l2*cos(theta1 + theta2)*g
"""
    assert not all_hold(code)
    found = pp.diagnose(code.replace("cos(theta2)) + J2\nm22", "cos(theta2) + J2)\nm22")).findings
    assert [finding.verdict for finding in found] == ["holds", "fails", "holds", "holds"]
    assert found[1].mends[0].latex == "m12 = m2*(l2^2 + l1*l2*cos(theta2)) + J2"


def test_a_bracket_that_is_missing_is_put_in():
    text = """x2 = l1*sin(theta1) + l2*sin(theta2)
V = -(m1+m2)*g*l1*cos(theta1) - m2*g*l2*cos(theta2)
T1 = 0.5*m1*(l1*w1)^2
T2 = 0.5*m2*((l1*w1)^2 + (l2*w2)^2 + 2*l1*l2*w1*w2*cos(theta1-theta2))
"""
    assert not all_hold(text)
    (mend, *_) = pp.diagnose(text.replace("m2*((", "m2*(").replace("theta2))", "theta2)")).findings[3].mends
    assert mend.latex == text.splitlines()[3]


def test_three_pendulums_are_not_read_as_two():
    """What holds for two of them does not hold for three; where the third one is does."""
    code = ACCELERATIONS.format(**USUAL) + "x3 = l1*sin(theta1) + l2*sin(theta2) + l3*sin(theta3)\n"
    assert [name for name, verdict in verdicts(code) if verdict != "not checked"] == ["x3"]


PLACES = r"""$$\vec r_1 = \begin{pmatrix} l_1\sin\theta_1 \\ -l_1\cos\theta_1 \end{pmatrix}$$
$$\vec r_2 = \vec r_1 + \begin{pmatrix} l_2\sin\theta_2 \\ -l_2\cos\theta_2 \end{pmatrix}$$
$$T = \frac12 m_1\dot{\vec r}_1^2 + \frac12 m_2\dot{\vec r}_2^2$$
"""
POLE = r"""A pendulum on a cart. $$\mathbf r_p = \begin{pmatrix} x + l\sin\theta \\ -l\cos\theta \end{pmatrix}$$
$$\dot{\mathbf r}_p^2 = \dot x^2 + 2 l\dot x\dot\theta\cos\theta + l^2\dot\theta^2$$
$$T = \frac12 M\dot x^2 + \frac12 m\dot{\mathbf r}_p^2$$
"""


@pytest.mark.parametrize("text", [PLACES, POLE], ids=["double pendulum", "cart"])
def test_places_of_masses_are_vectors(text):
    """Their squares are speeds; with a factor too many or too few no sum of them is the kinetic energy."""
    assert not all_hold(text)
    for right, wrong in (
        (r"\frac12 m", "m"),
        (r"\frac12 m", r"\frac13 m"),
        (r"r_p^2$$", r"r_p$$"),
        (r"r_2^2$$", r"r_1^2$$"),
    ):
        if right in text:
            assert verdicts(text.replace(right, wrong))[-1][1] != "holds"


def test_a_value_is_no_law():
    """What a page sets a parameter to accuses nobody, however its name is read: Ir may be I r."""
    code = "theta = y(1);\nw = y(2);\nwR = y(3);\nIr = 19;\nl = 1.2;\nr = 0.2;\ng = 9.81;\ndy(1) = w;\n"
    assert not any(one.verdict == "fails" for one in pp.diagnose(code).findings)


def test_an_element_that_gets_a_name_accuses_nobody():
    """rL may be r L, but of a vector's element nothing is known."""
    assert not any(one.verdict == "fails" for one in pp.diagnose("r = x_polar(1);\nrL = x_polar(1);\n").findings)


DOWN = r"""$$\begin{align}
x_1 &= L_1\sin\theta_1 \;, & \dot x_1 &= L_1\dot\theta_1\cos\theta_1 \\
y_1 &= L_1\cos\theta_1 \;, & \dot y_1 &= -L_1\dot\theta_1\sin\theta_1 \\
x_2 &= x_1 + L_2\sin\theta_2 \;, & \dot x_2 &= L_1\dot\theta_1\cos\theta_1 + L_2\dot\theta_2\cos\theta_2 \\
y_2 &= y_1 + L_2\cos\theta_2
\end{align}$$
$$T = \frac12 m_1 L_1^2\dot\theta_1^2 + \frac12 m_2 [L_1^2\dot\theta_1^2 + L_2^2\dot\theta_2^2
+ 2 L_1\dot\theta_1 L_2\dot\theta_2\cos(\theta_1 - \theta_2)]$$
$$U = -(m_1 + m_2) g L_1\cos\theta_1 - m_2 g L_2\cos\theta_2$$"""


def test_a_place_with_the_other_sign_is_measured_the_other_way():
    """Which way y points is a choice; the sign of one of its terms is none."""
    assert not any(one.verdict == "fails" for one in pp.diagnose(DOWN).findings)
    (wrong,) = pp.diagnose(DOWN.replace(r"x_1 + L_2\sin", r"x_1 - L_2\sin")).wrong
    assert wrong.mends[0].latex == r"x_2 &= x_1 + L_2\sin\theta_2"


POLE = r"""A pendulum on a cart.
$$\frac{\partial T}{\partial\dot r} = \frac{\partial}{\partial\dot r}\left(\frac12 m(\dot r^2 + 2l\dot r\dot\theta\cos\theta
+ l^2\dot\theta^2) + \frac12 I_p\dot\theta^2\right)$$
$$\frac{\partial T}{\partial\dot r} = m\dot r + ml\dot\theta\cos\theta$$
$$\frac{\partial T}{\partial\dot\theta} = \frac{\partial}{\partial\dot\theta}\left(\frac12 m(\dot r^2
+ 2l\dot r\dot\theta\cos\theta + l^2\dot\theta^2) + \frac12 I_p\dot\theta^2\right)$$
$$\frac{\partial T}{\partial\dot\theta} = ml\dot r\cos\theta + \dot\theta(ml^2 + I_p)$$
"""


def test_a_cart_that_no_line_names_is_not_missing():
    """Of the pole alone the momentum has no mass of the cart; where a law of the page has one, it is missing."""
    assert not any(one.verdict == "fails" for one in pp.diagnose(POLE).findings)
    law = r"$$(M + m)\ddot r + m l\ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F$$"
    wrong = pp.diagnose(POLE + law).wrong
    assert any(r"M \dot r" in mend.latex for one in wrong for mend in one.mends)
