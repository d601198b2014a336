"""The equation doctor on code: names made of words, returned rates, steps in time, matrices of linear models."""

import re

import pytest

import pendpin as pp
from pendpin.doctor.reading.documents import read_text


def verdicts_of(text):
    """The verdict on each equation, by how it begins."""
    return {finding.latex.split(" ")[0]: finding.verdict for finding in pp.diagnose(text).findings}


CART = """# inverted pendulum on a cart
def f(t, state, force):
    x, v, theta, omega = state
    s = np.sin(theta)
    c = np.cos(theta)
    den = cart_mass + pole_mass*s**2
    acc = (force + pole_mass*s*(poleLength*omega**2 - gravity*c))/den
    alpha = (-force*c - pole_mass*poleLength*omega**2*s*c + (cart_mass + pole_mass)*gravity*s)/(poleLength*den)
    return [v, acc, omega, alpha]
"""


def test_names_made_of_words_and_what_a_function_returns_are_read():
    """A returned list is the rates of the states that the function begins with, so a wrong acceleration is found there."""
    right, wrong = verdicts_of(CART), verdicts_of(CART.replace("omega**2 - gravity*c", "omega**2 - 2*gravity*c"))
    for name in ("den", "acc", "alpha", "v_dot", "omega_dot"):
        assert right[name] == "holds"
    assert wrong["acc"] == "fails"
    assert wrong["omega_dot"] == "holds"
    other = verdicts_of(CART.replace("[v, acc, omega, alpha]", "[v, omega, acc, alpha]"))
    assert "v_dot" not in other  # v is no rate of x and has the rate omega
    assert "fails" not in other.values()


STEPS = """// double pendulum
let num1 = -g*(2*m1 + m2)*sin(a1) - m2*g*sin(a1 - 2*a2);
let num2 = 2*sin(a1 - a2)*m2*(a2_v*a2_v*r2 + a1_v*a1_v*r1*cos(a1 - a2));
let den = r1*(2*m1 + m2 - m2*cos(2*a1 - 2*a2));
let a1_a = (num1 - num2)/den;
num1 = 2*sin(a1 - a2);
num2 = a1_v*a1_v*r1*(m1 + m2) + g*(m1 + m2)*cos(a1) + a2_v*a2_v*r2*m2*cos(a1 - a2);
den = r2*(2*m1 + m2 - m2*cos(2*a1 - 2*a2));
let a2_a = num1*num2/den;
a1_v += a1_a;
a2_v += a2_a*dt;
a1 = a1 + dt*a1_v;
a2 += a2_v;
"""


def test_a_step_in_time_says_what_the_rate_is():
    """With a1_v += a1_a the rate of a1_v is a1_a; what is computed twice means at each place what it was last."""
    right, wrong = verdicts_of(STEPS), verdicts_of(STEPS.replace("+ g*(m1", "- g*(m1"))
    assert {right[name] for name in ("der(a1_v)", "der(a2_v)", "der(a1)", "a1_a", "a2_a", "num1", "den")} == {"holds"}
    assert wrong["der(a1_v)"] == "holds"
    assert wrong["a2_a"] != "holds"
    for text in ("T += T_1", "t += dt", "x += 5", "V += m*g*h"):  # a sum, and time itself
        assert not read_text(text).statements


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (r"\ba([12])", r"angle\1"),
        (r"\ba([12])(?!_)", r"tht\1"),
        (r"let (\w+)", r"qreal \1"),
        (r"(?<=\d\) )\+ g", r"\\\n  + g"),
        (r"a1 \+ dt\*a1_v", "a1 + (dt * a1_v)"),
        (r"(?<!\w)(sin|cos)", r"std::\1"),
    ],
    ids=[
        "the rate of angle1 is angle1_v",
        "tht is no rate of th",
        "a type",
        "a line that goes on",
        "a step in brackets",
        "a library",
    ],
)
def test_a_step_may_be_written_otherwise(old, new):
    """What a language asks for says nothing of mechanics."""
    assert [*verdicts_of(re.sub(old, new, STEPS)).values()] == [*verdicts_of(STEPS).values()]


VECTOR = """# double pendulum
def f(t, x, m1, m2, L1, L2, g):
    theta1, omega1, theta2, omega2 = x
    d = theta1 - theta2
    dydt[0] = omega1
    dydt[1] = (m2*g*sin(theta2)*cos(d) - m2*sin(d)*(L1*omega1**2*cos(d) + L2*omega2**2) \\
               - (m1 + m2)*g*sin(theta1))/(L1*(m1 + m2*sin(d)**2))
    dydt[2] = omega2
    return np.array([theta1, omega1])
"""


def test_a_vector_of_rates_may_have_a_name_of_its_own():
    """As dydt of states that are called x: the first of both is the first, whichever number that is."""
    right, wrong = verdicts_of(VECTOR), verdicts_of(VECTOR.replace("L2*omega2", "2*L2*omega2"))
    assert {right[name] for name in ("d", "dydt[0]", "dydt[1]", "dydt[2]")} == {"holds"}
    assert wrong["dydt[1]"] != "holds"


@pytest.mark.parametrize("returned", ["[]", "()", "np.array([])"])
def test_a_function_may_return_nothing(returned):
    assert [f.verdict for f in pp.diagnose(f"def f(t, y):\n    v = y[0]\n    return {returned}\n").findings]


LINEAR = """% inverted pendulum on a cart
b = 0.1;  % friction of the cart
p = I*(M+m) + M*m*l^2;
A = [0 1 0 0;
     0 -(I+m*l^2)*b/p  (m^2*g*l^2)/p 0;
     0 0 0 1;
     0 -(m*l*b)/p  m*g*l*(M+m)/p 0];
B = [0; (I+m*l^2)/p; 0; m*l/p];
"""


def test_the_matrices_of_a_linear_model_are_the_derivatives_of_its_accelerations():
    """A and B hold to the first order, in either order of the states."""
    right = verdicts_of(LINEAR)
    assert (right["p"], right["A"], right["B"]) == ("holds", "holds if", "holds if")


@pytest.mark.slow
def test_an_entry_of_a_linear_model_may_be_wrong():
    free = LINEAR.replace("-(I+m*l^2)*b/p", "0").replace("-(m*l*b)/p", "0")
    wrong = verdicts_of(free.replace("m*g*l*(M+m)/p", "m*g*l*(M-m)/p"))
    assert (wrong["A"], wrong["B"]) == ("not checked", "holds if")


def test_the_states_of_a_linear_model_may_be_grouped():
    grouped = verdicts_of(
        r"The cart-pole: $A = \begin{bmatrix} 0&0&1&0\\ 0&0&0&1\\ 0&mg/M&0&0\\ 0&(M+m)g/(Ml)&0&0\end{bmatrix}$"
    )
    assert grouped["A"] == "holds if"


def test_bodies_may_be_called_a_and_b():
    """mA and thetaDotA are a mass and a rate; a lone height that is positive downwards is no mistake."""
    text = """% double pendulum
mA = 1; mB = 1; LA = 1; LB = 1;
PEA = -mA*g*LA*cos(thetaA);
KEA = mA*(LA*thetaDotA)^2/2;
KEB = mB*(LA^2*thetaDotA^2 + LB^2*thetaDotB^2 + 2*LA*LB*thetaDotA*thetaDotB*cos(thetaA - thetaB))/2;
yA = LA*cos(thetaA);
"""
    found = verdicts_of(text)
    assert {found[name] for name in ("PEA", "KEA", "KEB")} == {"holds"}
    assert found["yA"] == "not checked"


MEMBERS = """// double pendulum
void Pendulum::derivs(const double *yin, double *dydx) {
    const double delta = yin[THETA_2] - yin[THETA_1];
    const double M = m_m1 + m_m2;
    double den = M*m_l1 - m_m2*m_l1*std::cos(delta)*cosf(delta);
    dydx[THETA_1] = yin[OMEGA_1];
    dydx[OMEGA_1] = (m_m2*m_l1*yin[OMEGA_1]*yin[OMEGA_1]*sin(delta)*cos(delta)
                  + m_m2*m_g*glm::sin(yin[THETA_2])*cos(delta)
                  + m_m2*m_l2*yin[OMEGA_2]*yin[OMEGA_2]*sin(delta)
                  - M*m_g*(float)(sin(yin[THETA_1]))) / den;
    dydx[THETA_2] = yin[OMEGA_2];
    // the ratio of the lengths = l2/l1
    den *= m_l2 / m_l1;
    dydx[OMEGA_2] = (-m_m2*m_l2*yin[OMEGA_2]*yin[OMEGA_2]*sin(delta)*cos(delta)
                  + M*m_g*sin(yin[THETA_1])*cos(delta)
                  - M*m_l1*Pow(yin[OMEGA_1], 2)*sin(delta)
                  - M*m_g*sin(yin[THETA_2])) / den;
}
"""


def test_an_object_of_c_is_read_to_the_end_of_each_line():
    """Lines go on until the semicolon; members, elements by their names and what is computed again are read."""
    assert [finding.verdict for finding in pp.diagnose(MEMBERS).findings] == ["holds"] * 8
    for right, wrong in (("den *= m_l2 / m_l1", "den *= m_l1 / m_l2"), ("- M*m_l1*Pow", "+ M*m_l1*Pow")):
        assert not pp.diagnose(MEMBERS.replace(right, wrong)).ok


def test_a_step_in_time_is_what_several_names_are_multiplied_by():
    """Any name may be the step, if several lines have it; another sum is none."""
    steps = STEPS_OF_ANY_NAME.format(step="physicalTime")
    assert [finding.verdict for finding in pp.diagnose(steps).findings] == ["holds"] * 6
    assert not pp.diagnose(steps.replace("a1 += av1", "a1 += aa1")).ok


STEPS_OF_ANY_NAME = """# double pendulum
denom = 2*m1 + m2 - m2*cos(2*a1 - 2*a2)
aa1 = (-g*(2*m1 + m2)*sin(a1) - m2*g*sin(a1 - 2*a2) - 2*sin(a1 - a2)*m2*(av2*av2*l2 + av1*av1*l1*cos(a1 - a2)))/(l1*denom)
aa2 = 2*sin(a1 - a2)*(av1*av1*l1*(m1 + m2) + g*(m1 + m2)*cos(a1) + av2*av2*l2*m2*cos(a1 - a2))/(l2*denom)
av1 += aa1 * {step}
a1 += av1 * {step}
a2 += av2 * {step}
"""


@pytest.mark.parametrize(
    ("angle", "rate"),
    [("th", "v"), ("a", "v"), ("θ", "ω"), ("Theta", "Omega")],
    ids=["th v", "a v", "greek", "capitals"],
)
def test_rates_of_two_angles_may_be_called_otherwise(angle, rate):
    """v1 and v2 beside two angles without rates are theirs; Greek letters and capitals are names too."""
    code = re.sub(r"\ba(?=[12])", angle, STEPS_OF_ANY_NAME.partition("av1 +=")[0])
    code = re.sub(r"\bav(?=[12])", rate, code)
    assert {*verdicts_of(code).values()} == {"holds"}
    assert verdicts_of(code.replace("- 2*sin(", "- 3*sin("))["aa1"] != "holds"


def test_a_new_value_of_a_state_is_no_law():
    """An angle that is brought back to one turn, and a rate that is damped in each step."""
    said = pp.diagnose("theta_ddot = -g/l*sin(theta)\ntheta = 0.3\ntheta -= 2*pi\ntheta *= 0.99\n")
    assert said.ok
    assert [finding.verdict for finding in said.findings] == ["holds"] + ["not checked"] * 3


@pytest.mark.parametrize(
    "steps",
    [
        "omega -= g/l*sin(theta)*dt\ntheta += omega*dt\n",
        "omega = omega - (g/l)*np.sin(theta)*dt\ntheta = theta + dt*omega\n",
        "omega_new = omega - g*sin(theta)/l*dt\ntheta_new = theta + omega_new*dt\n",
        "next_omega = omega + (-g/l*sin(theta))*dt\nnext_theta = theta + next_omega*dt\n",
        "newthdot = thdot - dt*g/l*sin(th)\nnewth = th + newthdot*dt\n",
        "self.d_omega = -(g/l)*np.sin(theta)*dt\nself.d_theta = self.omega*dt\n",
    ],
)
def test_a_step_may_take_away_and_have_names_for_what_is_new(steps):
    """The rate of omega is what is taken away times dt, with a minus; omega_new is the last omega."""
    assert [*verdicts_of(steps).values()] == ["holds"] * 2
    assert next(iter(verdicts_of(steps.replace("sin(th", "cos(th")).values())) != "holds"
    assert not any("der(" in one.text for one in read_text(steps.replace("dt", "b")).statements)


@pytest.mark.parametrize(
    "code",
    [
        "domega_dt = -(g/L)*sin(theta) - k*omega*fabs(omega)",
        "double alpha = -(_g/_L)*sin((double)_theta);\ndouble T0 = 2*M_PI*sqrt(_L/_g);",
        "double alpha = -(g / L) * sin(theta);\ndouble T0 = 2. * M_PI * sqrt(L / g);",
        "alpha = -(g/l)*sin(theta)\nT = 0.5d0*m*l**2*theta_dot**2\ndo i = 1, 1000",
        "dw = -g/l*sin(th) + u[0]/(m*l**2)\ndth = w",
        "\u03b8\u0307 = x[2]\ndx[1] = \u03b8\u0307\ndx[2] = -g/l*sin(\u03b8)",
        "double V = -p.m*p.g*p.l*cos(s.th);\nds.th = s.om;\nds.om = -p.g/p.l*sin(s.th);",
        'g = p["g"]\ndw = -g/p["l"]*sin(th) - p.get("damping", 0.1)*w\ndth = w',
        "alpha = -(2._rk*g/(2.0_rk*l))*sin(theta)\nT = 0.5_dp*m*l**2*theta_dot**2\ndo i = 1, 1000",
        "/// \u03b8\u0308 = [ -g sin \u03b8 ]\n///     / [ l ]\nfn step(dt: f64) {}",
    ],
    ids=[
        "abs",
        "names that begin with _",
        "numbers of C",
        "numbers of Fortran",
        "one input",
        "a dot above",
        "records of rates",
        "a table of parameters",
        "numbers of Fortran with their kind",
        "equations in comments alone",
    ],
)
def test_idioms_of_other_languages(code):
    assert {one.verdict for one in pp.diagnose(code).findings} == {"holds"}


POLE = """#define TOTAL_MASS (MASSPOLE + MASSCART)  /* of both */
#define POLEMASS_LENGTH (MASSPOLE * LENGTH)
costheta = cos(*theta);
temp = (force + POLEMASS_LENGTH * *theta_dot * *theta_dot * sin(*theta)) / TOTAL_MASS;
thetaacc = (GRAVITY * sin(*theta) - costheta* temp) / (LENGTH * (FOURTHIRDS - MASSPOLE * costheta * costheta / TOTAL_MASS));
xacc = temp - POLEMASS_LENGTH * thetaacc* costheta / TOTAL_MASS;
"""
NAMES = """a1 = (-g*(2*m1+m2)*sin(t1) - m2*g*sin(t1-2*t2) - 2*sin(t1-t2)*m2*(o2*o2*l2 + o1*o1*l1*cos(t1-t2)))
    /
    (l1*(2*m1 + m2 - m2*cos(2*t1-2*t2)));
a2 = (2*sin(t1-t2)*(o1*o1*l1*(m1+m2) + g*(m1+m2)*cos(t1) + o2*o2*l2*m2*cos(t1-t2)))/(l2*(2*m1 + m2 - m2*cos(2*t1-2*t2)));
"""


@pytest.mark.parametrize(
    ("code", "names"),
    [
        (POLE, {}),
        (POLE, {"*theta": "self.pole_angle"}),
        (POLE, {"*theta_dot": "thetaD", "*theta": "theta", "thetaacc": "thetaDD", "xacc": "xDD"}),
        (NAMES, {"a": "thetapuntopunto", "o": "thetapunto", "t": "theta"}),
        (NAMES, {r"a(\d)": r"bob\1.acc", r"o(\d)": r"bob\1.speed", r"t(\d)": r"bob\1.theta", r"l(\d)": r"bob\1.leng"}),
    ],
    ids=["pointers and definitions", "the angle of a pole", "capital letters", "Spanish", "members of two objects"],
)
def test_laws_hold_by_the_names_that_code_has_for_rates(code, names):
    """A whole left side belongs to its equation: of bob1.acc = ... no letter is lost."""
    for old, new in names.items():
        code = re.sub(rf"\b{old}(?=\d)" if len(old) == 1 else old if "(" in old else re.escape(old), new, code)
    findings = pp.diagnose(code).findings
    assert {one.verdict for one in findings} == {"holds"}
    assert len(findings) == (6 if "TOTAL" in code else 2)
    assert findings[-1].latex[:8] == code.splitlines()[-1][:8]


RATES = """def rates(t1, t2, o1, o2):
    d = t1 - t2
    den = 2*m1 + m2 - m2*np.cos(2*d)
    a1 = (-g*(2*m1+m2)*np.sin(t1) - m2*g*np.sin(t1-2*t2) - 2*np.sin(d)*m2*(o2**2*l2 + o1**2*l1*np.cos(d)))/(l1*den)
    a2 = (2*np.sin(d)*(o1**2*l1*(m1+m2) + g*(m1+m2)*np.cos(t1) + o2**2*l2*m2*np.cos(d)))/(l2*den)
    return o1, o2, a1, a2
"""


@pytest.mark.parametrize("given", ["t1, t2, o1, o2", "self, t1, t2, o1, o2", "t, t1, t2, o1, o2, m1"])
def test_the_arguments_of_a_function_are_the_states_whose_rates_it_returns(given):
    code = RATES.replace("(t1, t2, o1, o2)", f"({given})", 1)
    assert {one.verdict for one in pp.diagnose(code).findings} == {"holds"}


@pytest.mark.parametrize(("old", "new"), [("o1**2*l1*(m1", "o1**2*l2*(m1"), ("t1-2*t2", "t1+2*t2")])
def test_an_acceleration_is_compared_with_what_its_name_says_beside_the_other_one(old, new):
    """Where the second one comes to an acceleration, the first is that of the other angle."""
    code = RATES.replace("def rates(", "def rates(y):\n    t1, o1, t2, o2 = y\n# (").replace(old, new)
    code = code.replace("return o1, o2, a1, a2", "return [o1, a1, o2, a2]")
    (wrong,) = (one for one in pp.diagnose(code).findings if one.verdict == "fails" and not one.follows)
    assert wrong.latex.startswith("a1" if new == "t1+2*t2" else "a2")
    assert old in wrong.mends[0].latex


def test_one_computed_name_may_be_another():
    """Of den_2 = den all holds; what is wrong in den is wrong in both laws, and mended there."""
    code = RATES.replace("    a1 =", "    den_2 = den\n    a1 =").replace("/(l2*den)", "/(l2*den_2)")
    assert {one.verdict for one in pp.diagnose(code).findings} == {"holds"}
    wrong = pp.diagnose(code.replace("m2 - m2*np.cos(2*d)", "m2 + m2*np.cos(2*d)")).findings
    assert [one.latex for one in wrong if one.verdict == "fails"] == ["den = 2*m1 + m2 + m2*np.cos(2*d)"]


def test_a_block_of_code_has_letters_of_its_own():
    """In prose the angles are theta, in the code below t."""
    prose = r"""$$T = \frac12 (m_1 + m_2) l_1^2\dot\theta_1^2 + \frac12 m_2 l_2^2\dot\theta_2^2
+ m_2 l_1 l_2\dot\theta_1\dot\theta_2\cos(\theta_1 - \theta_2)$$
$$V = -(m_1 + m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2$$
"""
    found = pp.diagnose(f"{prose}\n```python\n{RATES}```\n\nThe Lagrangian is $L = T - V$.\n").findings
    assert {one.verdict for one in found} == {"holds"}


FUNCTIONS = {
    "a list": """def f(y, t):
    theta1, z1, theta2, z2 = y
    c, s = np.cos(theta1 - theta2), np.sin(theta1 - theta2)
    dydt = [z1, (m2*g*np.sin(theta2)*c - m2*s*(L1*z1**2*c + L2*z2**2) - (m1 + m2)*g*np.sin(theta1))/(L1*(m1 + m2*s**2)),
            z2, ((m1 + m2)*(L1*z1**2*s - g*np.sin(theta2) + g*np.sin(theta1)*c) + m2*L2*z2**2*s*c)/(L2*(m1 + m2*s**2))]
    return dydt
""",
    "rates among the states": """def f(t, y):
    phi1, phi1_point, phi2, phi2_point = y
    c, s = np.cos(phi1 - phi2), np.sin(phi1 - phi2)
    return [phi1_point, (m2*g*np.sin(phi2)*c - m2*s*(L1*phi1_point**2*c + L2*phi2_point**2)
        - (m1 + m2)*g*np.sin(phi1))/(L1*(m1 + m2*s**2)), phi2_point, ((m1 + m2)*(L1*phi1_point**2*s
        - g*np.sin(phi2) + g*np.sin(phi1)*c) + m2*L2*phi2_point**2*s*c)/(L2*(m1 + m2*s**2))]
""",
    "a sphere": """def f(t, y):
    theta, dtheta, phi, dphi = y
    return [dtheta, dphi**2*np.sin(theta)*np.cos(theta) - g/L*np.sin(theta), dphi, - 2*dtheta*dphi/np.tan(theta)]
""",
    "a sphere in Greek": """def f(t, y):
    θ, dθ, φ, dφ = y
    return [dθ, dφ**2*np.sin(θ)*np.cos(θ) - g/L*np.sin(θ), dφ, - 2*dθ*dφ/np.tan(θ)]
""",
    "states without names": """function xdot = cart(t, x, u)
D = M + m*sin(x(3))^2;
xdot = [x(2); (u + m*l*x(4)^2*sin(x(3)) + m*g*sin(x(3))*cos(x(3)))/D;
        x(4); (-u*cos(x(3)) - m*l*x(4)^2*sin(x(3))*cos(x(3)) - (M + m)*g*sin(x(3)))/(l*D)];
""",
    "two entries": """function dx = f(t, x)
M = [(m1+m2)*l1^2, m2*l1*l2*cos(x(1)-x(2)); m2*l1*l2*cos(x(1)-x(2)), m2*l2^2];
h = [m2*l1*l2*x(4)^2*sin(x(1)-x(2)) + (m1+m2)*g*l1*sin(x(1)); - m2*l1*l2*x(3)^2*sin(x(1)-x(2)) + m2*g*l2*sin(x(2))];
dx(1) = x(3);
dx(2) = x(4);
dx(3:4) = -inv(M)*h;
""",
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_vector_of_rates_is_read_entry_by_entry(name):
    """Of a list, a column of MATLAB or what is returned: all entries hold, and one that is wrong does not."""
    idle = ("it gives the states their names: nothing to check", "no equation that holds uses y as it is defined here")
    found = pp.diagnose(FUNCTIONS[name]).findings
    assert all(one.verdict == "holds" for one in found if one.remark not in idle)
    assert sum(one.verdict == "holds" for one in found) > 1
    at = FUNCTIONS[name].rindex(" - ")
    wrong = pp.diagnose(FUNCTIONS[name][:at] + " + " + FUNCTIONS[name][at + 3 :]).findings
    assert [one.verdict for one in wrong].count("fails") == (name != "two entries")
    assert "holds if" not in [one.verdict for one in wrong]
    assert sum(one.verdict != "holds" for one in wrong) > sum(one.verdict != "holds" for one in found)


def test_columns_of_two_branches_are_no_rates_of_one_vector():
    code = "function xdot = f(t, x)\nif a\nxdot = [x(2); -g/l*sin(x(1))];\nelse\nxdot = [x(1); x(2)];\nend\n"
    assert not any(one.latex.startswith("dx(1)") for one in pp.diagnose(code + "G = -m*g*l*cos(x(1));").findings)


@pytest.mark.parametrize("end", ["", ";", "  # of theta"])
def test_an_expression_that_a_solver_makes_vanish_is_a_law(end):
    """As eq1 = ..., which solve(eq1, ...) takes; an equation keeps its right side."""
    code = f"th, g = symbols('th g')\neq1 = m*l**2*ddtheta + m*g*l*sin(theta){end}\n"
    right, wrong = pp.diagnose(code).findings[-1], pp.diagnose(code.replace("l**2", "l**3")).findings[-1]
    assert (right.verdict, right.kind, wrong.verdict) == ("holds", "moment balance", "not checked")
    assert "it does not hold" in wrong.remark
    given = pp.diagnose(code.replace(" + m*g*l*", " == -m*g*l*")).findings[-1]
    assert given.verdict == "holds"
