"""What the equation doctor reads: right equations hold in any notation, hostile texts are refused in one line."""

import re
from itertools import product

import numpy as np
import pytest

import pendpin as pp
from pendpin.doctor.printed import name_states, parse_statements
from pendpin.doctor.reading.documents import read_text
from pendpin.doctor.reading.names import Written
from pendpin.doctor.reading.tree import Node
from pendpin.doctor.systems.rod import SPECS, meanings
from pendpin.errors import InputError

# --- right equations hold -------------------------------------------------------------------------------------------

RIGHT = {
    "thin": [
        r"\ddot\theta = 2\dot\theta\dot\phi\tan\phi - \tfrac32\,\frac{g}{l}\,\frac{\sin\theta}{\cos\phi}",
        r"\frac{d^2\phi}{dt^2} = -\left(\frac{d\theta}{dt}\right)^2\sin\phi\cos\phi - \frac{3g}{2l}\cos\theta\sin\phi",
        "θ̈ = 2θ̇φ̇ tan φ − 3g/2l sin θ/cos φ",
        "phi'' = -theta'^2 sin(2 phi)/2 - 3/2 g/l cos(theta) sin(phi)",
        r"\vec\omega = (-\dot\theta\cos\phi,\ \dot\phi,\ -\dot\theta\sin\phi)",
        r"\mathbf{a}_G = \dot{\vec\omega}\times\vec{r}_G + \vec\omega\times(\vec\omega\times\vec{r}_G)",
        r"\frac{d}{dt}\frac{\partial L}{\partial\dot\phi} = \frac{\partial L}{\partial\phi}",
        r"\frac d{dt}\frac{\partial L}{\partial\dot\phi} - \frac\partial{\partial\phi} L = 0",
        r"\ddot\phi = -\dot\theta^2 sen\phi\cos\phi - \frac{3g}{2l}\cos\theta sen(\phi)",
        r"L = \frac{ml^2}{6}(\dot\phi^2+\dot\theta^2\cos^2\phi) + \frac{mgl}{2}(\cos\theta\cos\phi - 1)",
        "L = m*l**2/6*(dphi**2+dtheta**2*cos(phi)**2) + m*g*l/2*cos(theta)*cos(phi) + dphi*cos(theta)-phi*dtheta*sin(theta)",
        r"R_1 = \frac{mg}{4}\cos\theta\sin\phi",
        r"\hat{b}_3 \cdot \hat{x} = \sin\phi",
        r"\mathbf{I}\dot{\vec\omega}+\vec\omega\times\mathbf{I}\vec\omega = -\mathbf{r}_G\times\mathbf{R}+\mathbf{M}",
        r"\dot{\hat{b}}_3 = \dot\phi\hat b_1+\dot\theta\cos\phi\hat b_2",
        r"T=\frac{1}{2}m\left|\mathbf{v}_G\right|^2+\frac12 \vec\omega\cdot\mathbf{I}\vec\omega",
        r"\frac{dE}{dt} = 0",
        r"\ddot\theta(t)\,c_\phi = 2\dot\theta(t)\dot\phi(t)\sin\phi(t) - \frac{3g}{2l}\operatorname{sin}\theta(t)",
        r"V = V_0 - \frac{mgl}{2}\cos\theta\cos\phi",
        r"E = T + V = \text{const}",
        r"\mathcal{L} = \frac13(\dot\phi^2+\dot\theta^2\cos^2\phi)+\frac gl\cos\theta\cos\phi",
        r"\frac{\mathrm d}{\mathrm dt}\left(\tfrac13 ml^2\dot\theta\cos^2\phi\right) = -\tfrac12 mgl\sin\theta\cos\phi",
        r"R_1 = \tfrac14 mg\cos\theta\sin\phi \quad\text{(thin rod)}",
        r"\boldsymbol\omega = \left[-\dot\theta\cos\phi,\ \dot\phi,\ -\dot\theta\sin\phi\right]^\top",
        r"{}^BC^A = ({}^AC^B)^T",
        r"\begin{bmatrix}\cos^2\phi&0\\0&1\end{bmatrix}\begin{bmatrix}\ddot\theta\\\ddot\phi\end{bmatrix}"
        r"=\begin{bmatrix}\dot\theta\dot\phi\sin2\phi-\frac{3g}{2l}\sin\theta\cos\phi\\"
        r"-\dot\theta^2\sin\phi\cos\phi-\frac{3g}{2l}\cos\theta\sin\phi\end{bmatrix}",
        r"\ddot\phi = -\dot\theta^2\,s\phi\,c\phi - {3g \over 2l}\,c\theta\,s\phi",
        r"V = -m\mathbf g\cdot\mathbf r_G",
        r"\|\mathbf{r}_G\|^2 = \frac{l^2}{4}",
        r"\boxed{R_2 = \underbrace{\frac{mg}{4}\sin\theta}_{\text{weight}}.}",
        r"\begin{aligned} \ddot\phi &= -\dot\theta^2\sin\phi\cos\phi \\ &- \frac{3g}{2l}\cos\theta\sin\phi \end{aligned}",
    ],
    "uniform": [r"I_1 = m(3r^2+l^2)/12", r"T = \frac12 m v_G^2 + \frac12 \omega\cdot\mathbf{I}\omega"],
    "symmetric": [r"I\ddot\phi+(I-I_3)\dot\theta^2\sin\phi\cos\phi=-hR_1"],
    "general": [
        r"\ddot\theta (J_1\cos^2\phi+I_3\sin^2\phi) = (2(J_1-I_3)\dot\theta\dot\phi\sin\phi - mgh\sin\theta)\cos\phi",
        "M_c = -(I_3*sin(phi)*ddtheta/cos(phi) + (I_3 + J_2 - J_1)*dtheta*dphi)",
    ],
}


@pytest.mark.parametrize(("rod", "equation"), [(rod, e) for rod, equations in RIGHT.items() for e in equations])
def test_right_equations_hold(rod, equation):
    (finding,) = pp.diagnose([equation], rod=rod).findings
    assert (finding.verdict, finding.proved) == ("holds", True), finding.remark


# --- hostile texts --------------------------------------------------------------------------------------------------

HOSTILE = [
    "(" * 10_000 + "x" + ")" * 10_000 + "=1",
    r"\[" + "{" * 9_000 + "x=1" + r"\]",
    "x=" * 9_000,
    "x" * 1_000_000 + "=1",
    r"\[\input{/etc/passwd}=1\]",
    r"\[\write18{touch /tmp/x}=1\]",
    "__import__('os').system('x')=1",
    r"\[\def\x{\x\x}\x=1\]",
    "а=b",  # a Cyrillic letter
    "x = 9^9^9^9",
    "x=2^(99999)",
    "x=1e400",
    "x = 1/0",
    r"\dot{" * 3_000 + r"\theta=1",
    r"\sin" * 3_000 + "=1",
    r"\[\begin{bmatrix}1&2\\3\end{bmatrix}=I\]",
    "\x00=1",
    r"\[x=\]",
    r"\begin{equation}x=1",
    "sqrt(sqrt(-1))=theta",
    "theta''''''=0",
    "(((a+b+c+d)^12)^12)^12 = 1",
    r"\[\theta\over 2=1\]",
    "$" * 10_001,
    r"\[" * 10_000 + "x=1",
    "-" * 5_000 + "x=l",
    r"\[" * 1_000,
    "=" * 10_000,
    "$a=b" * 2_000,
    r"\frac{" * 3_000 + "=1",
    r"\hat" * 3_000 + "=1",
    "x_{" * 3_000 + "=1",
    r"\[" + "a+" * 300_000 + r"a=1\]",
    "x = " + "9" * 1_000_000,
    r"\[θ = ѳ\]",  # Cyrillic fita
    "x=0/0",
    "x = l/(m-m)",
    r"\[\left(\left(=1\]",
    "lambda x: x = 1",
    "exec('1')=2",
    r"\begin{align}" * 3_000,
    "```math\n" * 3_000,
    "x=\u202e1",  # text from right to left
    r"\frac{d^9\theta}{dt^9}=0",
    "x = (1,2,3,4)",
    r"\[\begin{pmatrix}=\]",
    "'=1",
    " + ".join(["l*sin(phi)"] * 1_500) + "=x",
    r"\[\catcode`\@=11\]",
    r"\[\csname input\endcsname{x}=1\]",
    r"\[\openin5=/etc/passwd\]",
    "x={{7*7}}",
    "x=${jndi:ldap://x}",
    "<script>alert(1)</script>=1",
    "\x1b[31mx\x1b[0m=1",
    "R = (m+l+g)^13",
    r"$$x = \underbrace= {a}_{b}$$",
    r"$$x = \frac{d}$$",
    r"$$\sum_{i=1}^{99999} x_i = \sum$$",
    "<sub><sub>&amp;<sub> = [[[;;]] 1",
]


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_texts_are_refused_in_one_line(text, tmp_path):
    path = tmp_path / "hostile.tex"
    path.write_text(text)
    done = outcome(path)
    assert done
    assert all("\n" not in line for line in done)


def outcome(path):
    """The lines that a file comes to: its error, or the remarks on its equations, none of which holds."""
    try:
        found = pp.diagnose(path)
    except InputError as error:
        return [str(error)]
    assert not found.ok
    return [finding.remark for finding in found.findings]


LETTERS = [
    "theta",
    "phi",
    "omega",
    "alpha",
    "a",
    "b",
    "e",
    "n",
    "i",
    "j",
    "k",
    "x",
    "y",
    "z",
    "v",
    "r",
    "I",
    "J",
    "R",
    "M",
    "F",
    "W",
    "g",
    "q",
    "T",
    "V",
    "U",
    "L",
    "E",
    "m",
    "l",
    "h",
]
INDICES = ["", *"123xyzGOcgpi", "xx", "11", "G1", "G,x", "B,2", "tip", "k", "pot"]


def test_a_printed_name_of_a_rod_is_a_quantity_and_its_dot_the_rate():
    """Every meaning has a dimension, and what a dot makes of it one with a second less."""
    dimensions = SPECS["thin"].dimensions
    for letter, index, styled in product(LETTERS, INDICES, (False, True)):
        names, rates = (meanings(Written(letter, dots, index, styled)) for dots in (0, 1))
        assert {*names} <= dimensions.keys() | {"q_i"}
        slower = {(kg, m, s - 1) for kg, m, s in (dimensions[name] for name in names if name != "q_i")}
        assert {dimensions[name] for name in rates if name != "dq_i"} <= slower


# --- what strangers write has the value that it has in Python ---------------------------------------------------------


class Numbers(dict):
    """A number of its own for every name, the same wherever it stands."""

    def __missing__(self, name: str) -> float:
        return self.setdefault(name, float(np.random.default_rng([*name.encode()]).uniform(0.3, 2.0)))


def value(node: Node) -> np.ndarray | float:
    """A tree in floating point; what a name stands for is a number of its own."""
    inside = [value(child) for child in node.children]
    match node.kind:
        case "number":
            return float(node.value)
        case "symbol":
            return Numbers()[node.value.lstrip("?")]
        case "sum":
            return sum(sign * term for sign, term in zip(node.value, inside, strict=True))
        case "product":
            total = 1.0
            for operator, factor in zip(node.value, inside, strict=True):
                both = np.ndim(total) == 2 and np.ndim(factor) == 2
                total = total / factor if operator == "/" else total @ factor if both else total * factor
            return total
        case "power":
            squared = np.ndim(inside[0]) == 2  # of a vector: its length
            return np.sum(inside[0] ** 2) if squared else inside[0] ** float(node.value)
        case "matrix":
            return np.array(inside).reshape(node.value)
        case "derivative":
            return Numbers()[f"D{node.value.lstrip('?')}_{node.children[0].value.lstrip('?')}"]
    functions = {"transpose": np.transpose, "norm": np.linalg.norm, "cot": lambda x: 1 / np.tan(x)}
    return functions.get(node.value, getattr(np, node.value, None))(inside[0])


# an equation as it is printed, and its sides in Python; dtheta is the rate of theta
PRINTED = [
    ("dydt(2) = -(g/l)*sin(y(1));", "y2d", "-(g/l)*sin(y1)"),
    ("xdot(4,1) = y(3, 1) + y(2,:)", "x4d", "y3 + y2"),
    ("ddq = -(u.*cos(q).^2)./(l.*np.sqrt(m))", "ddq", "-u*cos(q)**2/(l*sqrt(m))"),
    ("acc = num/den + temp", "acc", "num/den + temp"),
    ("velQ = diff(posQ, t)", "velQ", "dposQ"),
    ("domegadt2 = self.M2*math.sin(dthetadt1)", "domega_2", "M_2*sin(dtheta_1)"),
    ("pthetaDot1 = -ptheta2*thetaDot1", "dp_theta1", "-p_theta2*dtheta_1"),
    ("h1 = [h*a -h*(a+b)]*[a; b]", "h_1", "(h*a)*a - h*(a+b)*b"),
    ("dx = [dx1 dx2]'", "dx", "transpose([[dx_1, dx_2]])"),
    ("A = np.array([[a, b], [c, q]])", "A", "array([[a, b], [c, q]])"),
    ("τ₁ = m₁ l₁² ẍ + ½ √(g/l) + θ1'", "tau_1", "m_1*l_1**2*ddx + sqrt(g/l)/2 + dtheta_1"),
    (r"dot x_1 = r\ dot theta cos theta", "dx_1", "r*dtheta*cos(theta)"),
    ("V = 1.5e-3 mgl", "V", "1.5e-3*m*g*l"),
    (r"l = 1.5\,\mathrm{m}", "l", "1.5"),
    (r"g = 9.81\frac{m}{s^2}", "g", "9.81"),
    (r"x_{1} = l_1 \sin{\left(\theta_{1}{\left(t \right)} \right)}", "x_1", "l_1*sin(theta_1)"),
    (r"H = \operatorname{p_{\theta 2}}^{2}{\left(t \right)}/2", "H", "p_theta2**2/2"),
    (r"T = \sum_{i=1}^2 \frac{p_{\theta_i}^2}{2m_i} - L", "T", "p_theta_1**2/(2*m_1) + p_theta_2**2/(2*m_2) - L"),
    (r"T = \sum_{k=1}^{3} \left[ m_k \dot{x}_{c,k} + h \right]", "T", "m_1*dx_c1 + m_2*dx_c2 + m_3*dx_c3 + 3*h"),
    (r"T^r_p = \frac{1}{2} I_p \dot\theta^2 + T_p^{t}", "T_pr", "I_p*dtheta**2/2 + T_pt"),
    (r"K = \frac12 m \|\pmat{a \\ b}\|^2", "K", "m*(a*a + b*b)/2"),
    (r"{\bf q}_1 = \overrightarrow{r} \tilde{\phi} \varepsilon", "q_1", "r*phi*epsilon"),
    (r"a = b + d/dt (\partial L/\partial\dot q)", "a", "b + Dt_dq"),
    (r"R = mg\cos\theta \\ &\qquad+\frac{ml}{2}\dot\theta^2", "R", "m*g*cos(theta) + m*l/2*dtheta**2"),
    (r"H = p\dot\theta %2B q", "H", "p*dtheta + q"),
    (r"F = A\omega^2\cos\omega t + \sin 2\omega t", "F", "A*omega**2*cos(omega*t) + sin(2*omega*t)"),
    (r"\frac{{\rm d}\theta}{{\rm d}t} = \frac{\textrm{d}}{\textrm{d}t} x", "dtheta", "dx"),
    (
        "θ<sub>1</sub>'' = −g m<sub>1</sub> sin θ<sub>1</sub> &minus; &omega;<sup>2</sup>",
        "ddtheta_1",
        "-g*m_1*sin(theta_1)-omega**2",
    ),
    ("x = pow(l, 2)*Math.sin(a) + np.square(c)", "x", "l**2*sin(a) + c**2"),
    ("A*Derivative(theta(t), (t, 2)) = B*diff(x, t, t)", "A*ddtheta", "B*ddx"),
    ("theta1''[t] == -g/l*Sin[theta1[t] - b]*Cos[c]^2", "ddtheta_1", "-g/l*sin(theta_1 - b)*cos(c)**2"),
    (r"x = \textcolor{red}{a}\phantom{=} b", "x", "a*b"),
    ("x = M(1, 2)*G(2, 1)*q(1)", "x", "M_12*G_2*q1d"),
    ("x = robot.m1*bob2.mass", "x", "m_1*m_2"),
    ("a = cart.mass + self.pole.m", "a", "m_cart + m_pole"),
    ("T_p = T^r_p", "T_p", "T_pr"),
    (r"\frac{ \partial L}{ \dot{\partial}q } = -mgL", "Ddq_L", "-m*g*L"),
    (r"$$T ={}& \frac12 m \(a + b\)$$", "T", "m*(a + b)/2"),
    (r"\dtheta = b", "dtheta", "b"),
    ("theta1_double_dot = a", "ddtheta_1", "a"),
    (r"\omega´ = -\frac{g}{l} \sin\theta", "domega", "-g/l*sin(theta)"),
    (r"\dot{{\bf{x}}}_{c} = {\bf{J}}_c \dot{{\bf{q}}}", "dx_c", "J_c*dq"),
    (r"\sin^2(\theta) \Pi = const.", "sin(theta)**2*Pi", "const"),
    ("x = (env->gravity*sin(q) + 4.0f)/pend->m2", "x", "(g*sin(q) + 4.0)/m_2"),
    (r"v^{B_1} = r", "v_B_1", "r"),
    ("a = m*ê₂ + θ̇ᵢ", "a", "m*e_2 + dtheta_i"),
    ("u = F [N/m]", "u", "F"),
    (r"x = \sin^{1/2} q + \cos^{3/2} q", "x", "sqrt(sin(q)) + cos(q)**1.5"),
    ("theta_d = theta_dot_1 + x_ddot - z2_tt", "dtheta", "dtheta_1 + ddx - ddz_2"),
]


@pytest.mark.parametrize(("text", "left", "right"), PRINTED, ids=[text[:40] for text, _, _ in PRINTED])
def test_what_is_printed_has_the_value_that_it_has_in_python(text, left, right):
    (equation,) = name_states(parse_statements(read_text(text).statements))
    numbers = Numbers()
    names = {"x4d": "dx_[4]", "y2d": "dy_[2]", **{f"y{i}": f"y_[{i}]" for i in (1, 2, 3)}}
    names |= {
        "q1d": "q_[1]",
        "T_pr": "T_p,r",
        "T_pt": "T_p,t",
        **{f"dx_c{i}": f"dx_c,{i}" for i in (1, 2, 3)},
    }
    known = {name: numbers[names.get(name, name)] for name in re.findall(r"[A-Za-z_]\w*", f"{left} {right}")}
    functions = {name: getattr(np, name) for name in ("sin", "cos", "sqrt", "transpose", "array")}
    for side, expected in zip(equation.sides, (left, right), strict=True):
        assert np.allclose(value(side), eval(expected, {}, known | functions), rtol=1e-13), (text, side)


UNREAD = [
    "dydt = zeros(4, 1)",
    "k1 = dynamics(u + v)",
    "balance of forces m*a = F",
    r"T = \sum_i m_i v_i^2",
    r"x = \sin^{-1} \theta",
    r"y = 2^n",
    r"\dot{\theta_1 - \theta_2} = 0",
    r"\sin(\theta)_{1} = x",
    r"\frac{d^2 L}{dq dp} = 0",
    r"T = \sum m v^2",
    r"x = \cos",
    r"\dot{\theta^2} = a",
    r"x \to 0 = y",
    "state = [thetas[i - 1], omega]",
    r"A = \begin{bmatrix} a & b \\ c \end{bmatrix}",
    "a = cart.mass()",
    r"$x = \hat{b}_)1$",
    r"$\theta, \phi = c$",
]


@pytest.mark.parametrize("text", UNREAD)
def test_what_cannot_be_read_is_not_read_as_something_else(text):
    document = read_text(text)
    assert all(one.reason for one in name_states(parse_statements(document.statements)))
    assert document.statements or document.skipped  # nothing is dropped without a word


# a text and the equations that it holds, each with its line
DOCUMENTS = [
    ("$$L = a +$$\n\n$$b\\dot x$$", [(1, "L = a +    \n\n  b\\dot x")]),
    ("$$L = a$$\n\n$$+ b$$", [(1, "L = a    \n\n  + b")]),
    ("$$a + b$$\n$$+ c = 0$$", [(1, "a + b + c = 0")]),
    ("$$a = b$$\n$$-c = d$$", [(1, "a = b"), (2, "-c = d")]),
    ("$a = b$, $c = d$ and $e = f$", [(1, "a = b"), (1, "c = d"), (1, "e = f")]),
    (r"$$\left\{\begin{array}{l} x = a \\ y = b \end{array}\right.$$", [(1, "x = a"), (1, "y = b")]),
    (r"$$\begin{array}{rcl} x &=& a \\ y &=& b \end{array}$$", [(1, "x &=& a"), (1, "y &=& b")]),
    (r"$$x = a \rightarrow y = b$$", [(1, "x = a"), (1, "y = b")]),
    (r"\begin{align} x &= a & y &= b & (1) \\ -c &= d \end{align}", [(1, "x &= a"), (1, "y &= b"), (1, "-c &= d")]),
    (r"\[\boxed{\left(a\right) x = b, \quad c = d}\]", [(1, r"\left(a\right) x = b"), (1, "c = d")]),
    (r"$$L = a \\ &\qquad + b \\ &= c$$", [(1, r"L = a \\ &\qquad + b"), (1, "L = c")]),
    ("theta, w = y.T", [(1, "(theta, w) = y")]),
    ("$$L = a =$$\n$$= b$$", [(1, "L = a"), (2, "L = b")]),
    ("$$T = a$$\nand\n$$ = b$$", [(1, "T = a"), (3, "T = b")]),
    (r"$x = a \quad y = b$", [(1, "x = a"), (1, "y = b")]),
    (
        r"$$A \cdot \pmat{a \\ b} = C \iff \pmat{a \\ b} = B$$",
        [(1, r"A \cdot \pmat{a \\ b} = C"), (1, r"\pmat{a \\ b} = B")],
    ),
    ("m1, m2 = 1, 2", [(1, "m1 = 1"), (1, "m2 = 2")]),
    ("s, c = sincos(q)", [(1, "s = sin(q)"), (1, "c = cos(q)")]),
    ("theta, w = y", [(1, "(theta, w) = y")]),
    ("a = [b;\n     c];\nd = 1", [(1, "a = [b;\n     c]"), (3, "d = 1")]),
    ("G: float = 9.81", [(1, "G         = 9.81")]),
    ("acc = num / den + temp;", [(1, "acc = num / den + temp")]),
    ("Th'' = -g / L * sin(Th)", [(1, "Th'' = -g / L * sin(Th)")]),
    ("![f](https://latex.codecogs.com/svg.latex?\\large&space;x=%5Cfrac{a}{b})", [(1, r"x=\frac{a}{b}")]),
    ("![f](https://latex.codecogs.com/gif.latex?\\bg_white&space;\\begin{cases}x=a\\end{cases})", [(1, "x=a")]),
    (r"$\because x = a$", [(1, "x = a")]),
    (r"$\mathbf{x = a_{1}}$", [(1, "x = a_{1}")]),
    ("- <math>\nx = a. <math> and\n- <math> y = b <math>", [(2, "x = a"), (3, "y = b")]),
    ("```{math}\nx = a\n\ny = b\n```\n---", [(2, "x = a"), (4, "y = b")]),
    (".. math::\n\n  x = a\n  + b\n\nend", [(3, "x = a + b")]),
    ("so ${e`x = a`} and", [(1, "x = a")]),
    ('  parameter SI.Mass m = 2 "the mass";', [(1, "m = 2")]),
    ("fprintf('M = %.4f (m)', M);\nx = b;", [(2, "x = b")]),
    ("入力（水平力）：u = F", [(1, "u = F")]),
    ("Title\n=====\n\n$x = a$", [(4, "x = a")]),
]


@pytest.mark.parametrize(("text", "equations"), DOCUMENTS, ids=[text[:30] for text, _ in DOCUMENTS])
def test_a_text_is_cut_into_its_equations(text, equations):
    """In its lines; a display that goes on with the sum or chain of the one before belongs to that."""
    found = name_states(parse_statements(read_text(text).statements))
    lines = [(one.statement.place, " ".join(one.latex.split())) for one in found]
    assert lines == [(f"line {line}", " ".join(text.split())) for line, text in equations]
    assert all(one.ways for one in found)


def test_a_line_that_is_no_equation_is_named():
    document = read_text("for i = 1:10\ng = p.g;\nx = l*sin(q)")
    assert [one.text for one in document.statements] == ["x = l*sin(q)"]
    assert document.skipped == ("line 1", "line 2")


def test_a_difference_of_angles_is_one_name_of_either_sign():
    """Whatever the page leaves out of it; but of one sign in each equation."""
    for sign in "+-":
        text = rf"""$$(m_1+m_2)l_1\ddot\theta_1 + m_2l_2\ddot\theta_2\cos(\Delta\theta)
        {sign} m_2l_2\dot\theta_2^2\sin(\Delta\theta) + (m_1+m_2)g\sin\theta_1 = 0$$
        $$l_2\ddot\theta_2 + l_1\ddot\theta_1\cos(\theta_1-\theta_2)
        - l_1\dot\theta_1^2\sin(\theta_1-\theta_2) + g\sin\theta_2 = 0$$"""
        assert [f.verdict for f in pp.diagnose(text).findings] == ["holds", "holds"]
        wrong = pp.diagnose(text.replace(r"\ddot\theta_2\cos(\Delta", r"\ddot\theta_2\sin(\Delta"))
        assert [f.verdict for f in wrong.findings] == ["fails", "holds"]


def test_latex_in_a_string_of_code_and_functions_of_each_element():
    text = r"$$\\ddot{\\theta} + \\frac{g}{l} \\sin\\theta = 0$$ $$V = -m g l \\cos\\theta$$"
    assert [f.verdict for f in pp.diagnose(text).findings] == ["holds", "holds"]
    code = "x1 = L1 * sin.(theta1)\nx2 = x1 + L2*sin.(theta2)\ny2 = -L1*cos.(theta1) - L2*cos.(theta2)\n"
    assert [f.verdict for f in pp.diagnose(code).findings] == ["holds"] * 3
    assert [f.verdict for f in pp.diagnose("V = m*g*l*-cos(theta)\nddtheta = -g/l*sin(theta)").findings] == [
        "holds"
    ] * 2


def test_several_names_get_a_value_each():
    """As many as there are values; a right side that is one vector is left as it is."""
    code = """x1, y1 = l1*sin(theta1), -l1*cos(theta1)
x2, y2 = x1 + l2*sin(theta2), y1 - l2*cos(theta2)
c, s = np.cos(theta1 - theta2), np.sin(theta1 - theta2)
ddtheta2 = (m2*g*cos(theta1)*s + m1*g*cos(theta1)*s + (m1 + m2)*l1*w1**2*s + m2*l2*w2**2*s*c)/l2/(m1 + m2*s**2)
th, w = state
"""
    findings = pp.diagnose(code).findings
    assert [f.verdict for f in findings[:7]] == ["holds"] * 7
    assert [f.verdict for f in findings[7:]] == ["not checked"]
    wrong = pp.diagnose(code.replace("y1 - l2", "y1 + l2")).findings
    assert [f.verdict for f in wrong[:4]] == ["holds", "holds", "holds", "fails"]


def test_what_is_roughly_equal_holds_to_the_first_order_and_is_never_accused():
    """What is rounded behind a chain is left out."""
    text = r"$$\ddot\theta \approx -\frac{g}{l}\theta$$ $$V = -m g l\cos\theta$$ $$T = \frac12 m l^2\dot\theta^2$$"
    assert [f.verdict for f in pp.diagnose(text).findings] == ["holds if", "holds", "holds"]
    wrong = pp.diagnose(text.replace(r"-\frac{g}{l}", r"\frac{g}{l}"))
    assert [f.verdict for f in wrong.findings] == ["not checked", "holds", "holds"]
    (equation,) = name_states(parse_statements(read_text(r"$$T_0 = 2\pi\sqrt{l/g} \approx 2.006$$").statements))
    assert [len(sides) for sides, _ in equation.ways[:1]] == [2]
