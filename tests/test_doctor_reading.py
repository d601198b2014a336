"""What the equation doctor reads: right equations hold in any notation, hostile texts are refused in one line."""

from itertools import product

import pytest

import pendpin as pp
from pendpin.doctor.reading.names import Written
from pendpin.doctor.systems.rod_names import DIMENSION_OF, meanings
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
    for letter, index, styled in product(LETTERS, INDICES, (False, True)):
        names, rates = (meanings(Written(letter, dots, index, styled)) for dots in (0, 1))
        assert {*names} <= DIMENSION_OF.keys() | {"q_i"}
        slower = {(kg, m, s - 1) for kg, m, s in (DIMENSION_OF[name] for name in names if name != "q_i")}
        assert {DIMENSION_OF[name] for name in rates if name != "dq_i"} <= slower
