"""Pages as students and programmers write them: what is right holds, a fault that is planted in it is never said to hold."""

import re

import pytest

import pendpin as pp

PAGES = {  # a right page, a part of it, and what makes that wrong
    "components of the weight": (
        r"""The weight of a simple pendulum has the components $F_t = -mg\sin\theta$ and $F_n = mg\cos\theta$;
        the bob's acceleration has $a_t = l\ddot\theta$ and $a_n = l\dot\theta^2$. Along the arc $s = l\theta$
        $$F_t = m\frac{d^2s}{dt^2}$$ $$ml\ddot\theta = -mg\sin\theta$$ and along the string $$T - F_n = ml\dot\theta^2$$""",
        r"ml\ddot\theta = -mg\sin",
        r"ml\ddot\theta = -mg\cos",
    ),
    "an arc called x": (
        r"""The arc is $x = L\theta$, so $a = \ddot x = L\ddot\theta = -g\sin\theta$ and the force is $F = -mg\sin\theta$ or
        $$F = m\frac{d^2x}{dt^2}$$ $$\ddot\theta = -\frac gL\sin\theta$$""",
        r"\ddot\theta = -\frac gL",
        r"\ddot\theta = -\frac g{2L}",
    ),
    "KE and PE": (
        r"$PE = mgL(1-\cos\theta)$, $KE = \frac12mL^2\omega^2$, $E = KE + PE$, $\omega = \frac{d\theta}{dt}$",
        r"KE = \frac12mL^2",
        r"KE = \frac12mL",
    ),
    "a spring with KE and PE": (
        r"""A spring pendulum with $r = l_0 + x$. $KE = \frac12m(\dot x^2+r^2\dot\theta^2)$, $PE_{spr} = \frac12kx^2$,
        $PE_g = -mgr\cos\theta$, $L = KE - PE_{spr} - PE_g$. $$m\ddot x = mr\dot\theta^2 - kx + mg\cos\theta$$""",
        "- kx + mg",
        "+ kx + mg",
    ),
    "a torque at the joint": (
        r"""$$ml^2\ddot\theta + mgl\sin\theta = \tau$$ $$E = \frac12ml^2\dot\theta^2 - mgl\cos\theta$$
        $$\dot E = \tau\dot\theta$$
        $$\ddot\theta = -\frac gl\sin\theta + \frac\tau{ml^2}$$""",
        r"-\frac gl\sin\theta + \frac\tau{ml^2}",
        r"-\frac gl\sin\theta + \frac\tau{ml}",
    ),
    "released at rest": (
        r"""At the bottom $\frac12mv^2 = mgl(1-\cos\theta_0)$ and $v = \sqrt{2gl(1-\cos\theta_0)}$, at the angle $\theta$
        $$\dot\theta^2 = \frac{2g}{l}(\cos\theta-\cos\theta_0)$$ and the tension is $T = mg(3\cos\theta - 2\cos\theta_0)$""",
        r"\frac{2g}{l}(",
        r"\frac{g}{l}(",
    ),
    "a cart with a speed": (
        r"""A cart of mass $M$ at $s$ with the velocity $v$ and the acceleration $a$ carries a hanging point mass $m$.
        $$x_p = s + l\sin\varphi,\qquad y_p = -l\cos\varphi$$
        $$T = \tfrac12(M+m)v^2 + m\,v\,l\cos\varphi\,\dot\varphi + \tfrac12 m l^2\dot\varphi^2$$
        $$(M+m)\,a + ml\cos\varphi\,\alpha = \tau - d_{cart}v + ml\sin\varphi\,\dot\varphi^2 \qquad (I)$$
        $$ml\cos\varphi\,a + ml^2\,\alpha = -mgl\sin\varphi - d_{pend}\dot\varphi \qquad (II)$$""",
        r"\tfrac12 m l^2\dot",
        r"m l^2\dot",
    ),
    "a bob with a speed": (
        r"""On a cart the speed of the bob is $v_p^2 = \dot x^2 + 2l\dot x\dot\theta\cos\theta + l^2\dot\theta^2$, and so
        $T = \frac12M\dot x^2 + \frac12mv_p^2$, $V=-mgl\cos\theta$.
        $$l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$$""",
        r"\cos\theta + g\sin",
        r"\cos\theta - g\sin",
    ),
    "a length beside a radius": (
        r"""An inverted pendulum on a cart. |r|Radius of the rod (m)|0.05|
        $x_m = x - \frac{L}{2}\sin\theta$, $y_m = \frac{L}{2}\cos\theta$, $r = 0.05$
        - $\sum F_x:  F = (M+m)\ddot{x} + \frac L2m\sin\theta\cdot\dot\theta^2 - \frac L2m\cos\theta\cdot\ddot\theta$

        - $I\ddot\theta = \frac L2m\ddot x\cos\theta + \frac L2mg\sin\theta - \left(\frac L2\right)^2m\ddot\theta$""",
        r"+ \frac L2mg\sin",
        r"- \frac L2mg\sin",
    ),
    "periods alone": (
        r"$T = 2\pi\sqrt{\frac{k^2+h^2}{gh}}$, $I = m(k^2+h^2)$, $L = h+\frac{k^2}{h}$, $g = \frac{4\pi^2L}{T^2}$",
        r"L = h+",
        r"L = h-",
    ),
    "drag and algebra": (
        r"""$$ml\ddot\theta = -mg\sin\theta - \frac12\rho C_dAl^2\dot\theta|\dot\theta|$$
        $$\frac{A}{B}+\frac{C}{B} = \frac{A+C}{B}$$ $$\ddot\phi + q\dot\phi + \frac gl\sin\phi = F_D\sin(\Omega_Dt)$$""",
        r"\frac{A+C}{B}",
        r"\frac{A-C}{B}",
    ),
    "the package physics": (
        r"""$$\dv{t}\pdv{L}{\dot\theta} - \pdv{L}{\theta} = 0$$ $$\pdv{L}{\dot\theta} = ml^2\dot\theta$$
        $$\xrightarrow{\text{so}} \dv[2]{\theta}{t} = -\frac gl\sin\theta \tag{\ref{eq:a}}$$
        $$\overset{..}{\theta} + \frac gl\sin\theta = 0$$ $$\abs{\vec v} = \l\abs{\dot\theta}$$""",
        r"ml^2\dot",
        r"ml\dot",
    ),
    "marks of Markdown": (
        "# Double pendulum\n- Position: `x1 = l1*sin(θ1)`, `y1 = -l1*cos(θ1)`\n- and `x2 = x1 + l2*sin(θ2)`, "
        "`y2 = y1 - l2*cos(θ2)`\nPotential energy V = m1*g*y1 + m2*g*y2\n",
        "+ m2*g*y2",
        "+ m2*g*y1",
    ),
    "options of a directive": (
        "```{math}\n:label: eq:pend\n\n\\ddot\\theta = -\\frac{g}{l}\\sin\\theta\n```\n"
        "x\u2061 = l\u2061 sin θ, y = −l cos\u2061θ",
        "\\frac{g}{l}\\sin",
        "\\frac{g}{l}\\cos",
    ),
    "sympy": (
        """theta = sp.Function('theta')(t)
x = l*sp.sin(theta)
y = -l*sp.cos(theta)
T = sp.Rational(1, 2)*m*(sp.diff(x, t)**2 + sp.diff(y, t)**2)
V = m*g*y
L = T - V
eq = sp.diff(sp.diff(L, sp.diff(theta, t)), t) - sp.diff(L, theta)
theta_dd = sp.diff(theta, t, 2)
p = m*l**2*theta.diff(t)
""",
        "Rational(1, 2)",
        "Rational(1, 3)",
    ),
    "a sketch in JavaScript": (
        """let num1 = -g * (2 * m1 + m2) * sin(a1);
let num2 = -m2 * g * sin(a1-2*a2);
let num3 = -2*sin(a1-a2)*m2;
let num4 = a2_v*a2_v*r2+a1_v*a1_v*r1*cos(a1-a2);
let den = r1 * (2*m1+m2-m2*cos(2*a1-2*a2));
let a1_a = (num1 + num2 + num3*num4) / den;
let x2 = r1 * sin(a1) + r2 * sin(a2);
a1_v += a1_a;
a1 += a1_v;
""",
        "sin(a1-2*a2)",
        "sin(a1-a2)",
    ),
    "a sketch with a force": (
        "let force = gravity * sin(angle);\nangleA = (-1 * force) / len;\nangleV += angleA;\nangle += angleV;\n",
        "sin(angle)",
        "cos(angle)",
    ),
    "C": (
        """sin_theta = sin(x_current->theta);
auto cos = std::cos(x_current->theta);
den = M + m - m * cos * cos;
x_ddot = (u + m * l * x_current->theta_dot * x_current->theta_dot * sin_theta - m * g * sin_theta * cos) / den;
theta_ddot = (-u * cos - m * l * x_current->theta_dot * x_current->theta_dot * sin_theta * cos
    + (M + m) * g * sin_theta) / (l * den);
""",
        "+ (M + m) * g",
        "+ (M - m) * g",
    ),
    "Java": (
        """double theta1 = state.getTheta1();
double omega1 = state.getOmega1();
double a = theta1 - theta2;
double den1 = (m1 + m2) * l1 - m2 * l1 * Math.cos(a) * Math.cos(a);
double alpha1 = (-m2 * l1 * omega1 * omega1 * Math.sin(a) * Math.cos(a) + m2 * g * Math.sin(theta2) * Math.cos(a)
    - m2 * l2 * omega2 * omega2 * Math.sin(a) - (m1 + m2) * g * Math.sin(theta1)) / den1;
""",
        "+ m2 * g",
        "- m2 * g",
    ),
    "Rust": (
        """let delta = theta2 - theta1;
let den1 = (m1 + m2) * l1 - m2 * l1 * delta.cos().powi(2);
let a1 = (m2 * l1 * omega1.powi(2) * delta.sin() * delta.cos() + m2 * g * theta2.sin() * delta.cos()
    + m2 * l2 * omega2.powi(2) * delta.sin() - (m1 + m2) * g * theta1.sin()) / den1;
""",
        "delta.cos().powi(2)",
        "delta.sin().powi(2)",
    ),
    "Julia": (
        """function cartpole!(du, u, p, t)
    x, xd, θ, θd = u
    s, c = sincos(θ)
    du[1] = xd
    du[2] = (F + mp*s*(l*θd^2 + g*c)) / (mc + mp*s^2)
    du[3] = θd
    du[4] = (-F*c - mp*l*θd^2*c*s - (mc+mp)*g*s) / (l*(mc + mp*s^2))
end
""",
        "(mc+mp)*g*s",
        "(mc-mp)*g*s",
    ),
    "a solution in time": (
        r"""$\ddot\theta + 2\beta\dot\theta + \omega_0^2\sin\theta = 0$, $\omega_0 = \sqrt{g/L}$, and for small angles
        $$\ddot\theta + 2\beta\dot\theta + \omega_0^2\theta = 0$$ $$\theta(t) = A e^{-\beta t} \cos(\omega_d t + \phi)$$
        $$\omega_d = \sqrt{\omega_0^2 - \beta^2}$$""",
        r"e^{-\beta t}",
        r"e^{-2\beta t}",
    ),
    "its rate": (
        r"""$\ddot\varphi + \frac gl\sin\varphi = 0$, $\omega = \sqrt{g/l}$, $\ddot\varphi + \omega^2\varphi = 0$,
        $\varphi(t) = \varphi_0\cos(\omega t)$ and $\dot\varphi(t) = -\varphi_0\omega\sin(\omega t)$""",
        r"= -\varphi_0\omega",
        r"= -\varphi_0",
    ),
    "two objects of C++": (
        """float m1 = p1.mass;
float l1 = p1.length;
float a1 = p1.angle;
float a1_v = p1.angularVelocity;
float num = -g * (2 * m1 + m2) * std::sin(a1) - m2 * g * std::sin(a1 - 2 * a2);
float more = -2 * std::sin(a1 - a2) * m2 * (a2_v * a2_v * l2 + a1_v * a1_v * l1 * std::cos(a1 - a2));
float a1_a = (num + more) / (l1 * (2 * m1 + m2 - m2 * std::cos(2 * a1 - 2 * a2)));
p1.angularVelocity += a1_a * dt;
p1.angle += p1.angularVelocity * dt;
float x1 = p1.length * std::sin(p1.angle);
""",
        "std::sin(a1 - 2 * a2)",
        "std::sin(a1 - a2)",
    ),
    "dry friction on a cart": (
        r"""A pole, half as long as $2l$, stands on a cart, with friction $\mu_c$ of the cart and $\mu_p$ of the hinge.
        $$\ddot\theta = \frac{g\sin\theta + \cos\theta\left(\frac{-F - m_pl\dot\theta^2\sin\theta
        + \mu_c\,\mathrm{sgn}(\dot x)}{m_c+m_p}\right) - \frac{\mu_p\dot\theta}{m_pl}}
        {l\left(\frac43 - \frac{m_p\cos^2\theta}{m_c+m_p}\right)}$$
        $$\ddot x = \frac{F + m_pl(\dot\theta^2\sin\theta - \ddot\theta\cos\theta)
        - \mu_c\,\mathrm{sgn}(\dot x)}{m_c+m_p}$$""",
        r"m_pl(\dot\theta^2\sin\theta -",
        r"m_pl(\dot\theta^2\sin\theta +",
    ),
    "Go": (
        """```go
t1, w1, t2, w2 := s[0], s[1], s[2], s[3]
d := t1 - t2
den := 2*p.m1 + p.m2 - p.m2*math.Cos(2*d)
a1 := (-p.g*(2*p.m1+p.m2)*math.Sin(t1) - p.m2*p.g*math.Sin(t1-2*t2) -
    2*math.Sin(d)*p.m2*(w2*w2*p.l2 + w1*w1*p.l1*math.Cos(d))) / (p.l1 * den)
```""",
        "w1*w1*p.l1*math.Cos(d)",
        "w1*w1*p.l2*math.Cos(d)",
    ),
    "Fortran": (
        """```fortran
 th1dd = (-g*(2*m1+m2)*sin(th1) - m2*g*sin(th1-2*th2) &
          - 2*sin(th1-th2)*m2*(th2d**2*l2 + th1d**2*l1*cos(th1-th2))) / &
         (l1*(2*m1+m2-m2*cos(2*th1-2*th2)))
```""",
        "sin(th1-2*th2)",
        "sin(th1-th2)",
    ),
    "steps in arrays": (
        """A pendulum in Python
for i in range(n - 1):
    omega[i+1] = omega[i] + (-g/l*np.sin(theta[i]) - c*omega[i])*dt
    theta[i+1] = theta[i] + omega[i+1]*dt
""",
        "theta[i] + omega",
        "theta[i] - omega",
    ),
    "equations of sympy": (
        """x1 = l1*sp.sin(th1)
y1 = -l1*sp.cos(th1)
x2 = x1 + l2*sp.sin(th2)
y2 = y1 - l2*sp.cos(th2)
eq1 = sp.Eq(sp.sin(th1)*(m1*y1_dd + m2*y2_dd + (m1 + m2)*g), -sp.cos(th1)*(m1*x1_dd + m2*x2_dd))
eq2 = sp.Eq(sp.sin(th2)*(m2*(y2_dd + g)), -sp.cos(th2)*m2*x2_dd)
""",
        "(m2*(y2_dd + g))",
        "(m2*(y2_dd - g))",
    ),
    "a forced pendulum and its special case": (
        r"""$$\ddot\theta + \beta\dot\theta + \omega_0^2\sin\theta = A\cos(\Omega_D t)$$
        $$\frac{d\omega}{dt} = -\beta\omega - \omega_0^2\sin\theta + A\cos(\Omega_D t)$$
        For critical damping $\beta$ would be $2\omega_0$; here $$\ddot\theta + \beta\dot\theta + \omega_0^2\theta = 0$$""",
        r"-\beta\omega - \omega_0^2\sin",
        r"-\beta\omega + \omega_0^2\sin",
    ),
    "masses with letters of their own": (
        r"""The platform $m_p$ carries a homogeneous stick of mass $m_s$ and length $l$; $\phi$ is measured from the upright.
        $$x_s = x + \frac l2\sin\phi$$ $$E_{kin} = \frac12(m_p + m_s)\dot x^2 + \frac12 m_s l\dot x\dot\phi\cos\phi
        + \frac16 m_s l^2\dot\phi^2$$ $$E_{pot} = m_s g\frac l2\cos\phi$$
        $$(m_p + m_s)\ddot x = \frac12 m_s l(\dot\phi^2\sin\phi - \ddot\phi\cos\phi)$$
        $$\frac l3\ddot\phi + \frac12\ddot x\cos\phi - \frac g2\sin\phi = 0$$""",
        r"\frac g2\sin\phi",
        r"g\sin\phi",
    ),
    "vectors along x and y": (
        r"""A cart at $x$ with a pendulum that leans by $\theta$. $\vec r_P = (x - l\sin\theta)\hat x + l\cos\theta\,\hat y$
        $$\vec v_P = (\dot x - l\cos\theta\,\dot\theta)\hat x - l\sin\theta\,\dot\theta\hat y$$
        $$F - R_x - b\dot x = M\ddot x$$
        $$F - (M+m)\ddot x - ml\sin\theta\,\dot\theta^2 - b\dot x + ml\cos\theta\,\ddot\theta = 0$$""",
        r"F - R_x",
        r"F + R_x",
    ),
    "energies by their names": (
        """syms theta(t) x(t) M m L I u
Ekin = 0.5*(M+m)*diff(x, t)^2 + m*L*diff(x, t)*diff(theta, t)*cos(theta) + 0.5*(m*L^2 + I)*diff(theta, t)^2
Epot = -m*g*L*cos(theta)
total_energy = Ekin + Epot
""",
        "Epot = -m*g*L*cos(theta)",
        "Epot = -m*g*L*sin(theta)",
    ),
    "units of a pendulum": (
        r"""In units of a pendulum: $H = \frac12p^2 - \cos q$, $\dot q = p$, $\dot p = -\sin q$; driven
        $$\ddot q = -\sin q - \gamma\dot q + A\cos(\frac23t)$$""",
        r"- \cos q$",
        r"- \sin q$",
    ),
    "Mathematica": ("```mathematica\ntheta''[t] + g/l Sin[theta[t]] == 0\n```", "+ g/l", "+ l/g"),
}


MOST = [pytest.param(name, marks=[pytest.mark.slow] if i % 5 else []) for i, name in enumerate(PAGES)]


@pytest.mark.parametrize("name", PAGES)
def test_a_right_page_holds(name):
    """Every line of it but what gives a value or a name."""
    found = [one for one in pp.diagnose(PAGES[name][0]).findings if one.kind != "condition"]
    assert {one.verdict for one in found} <= {"holds", "holds if"}, [(one.latex, one.remark) for one in found]


@pytest.mark.parametrize("name", MOST)
def test_a_fault_in_a_page_is_not_said_to_hold(name):
    """Something of the page is no longer said to hold, and no line is accused that stayed right."""
    text, right, wrong = PAGES[name]
    assert text.count(right) >= 1
    found, kept = pp.diagnose(text.replace(right, wrong, 1)).findings, {one.latex for one in pp.diagnose(text).findings}
    assert not all(one.verdict in ("holds", "holds if") for one in found if one.kind != "condition")
    accused = [one.latex for one in found if one.verdict == "fails" and not one.follows]
    assert not {*accused} & kept, accused


def test_a_section_is_read_by_itself_where_letters_of_another_hide_what_it_says():
    """Two more angles in the code of a later section, as numbers of variants, do not make the first one a cart's."""
    first = r"""# Theory
The arc is $s = L\theta$, so $v=\frac{ds}{dt}=L\frac{d\theta}{dt}$ and $a=\frac{d^{2}s}{dt^{2}}=L\frac{d^{2}\theta}{dt^{2}}$.
$$mg\sin\theta=-mL\frac{d^{2}\theta}{dt^{2}}$$ $$\frac{d^{2}\theta}{dt^{2}} + \frac{g}{L}\sin\theta = 0$$
"""
    later = "# Code\ntheta1 = the0\ntheta1 = -(g/l)*(theta1[i])*dt**2 + 2*theta1[i] - theta1[i-1]\ntheta2 = the0\n"
    later += "theta2 = -(g/l)*(theta2[i])*dt**2 + 2*theta2[i] - theta2[i-1]\n"
    for text in (first, first + later, later + first):
        found = [one for one in pp.diagnose(text).findings if "theta1" not in one.latex and "theta2" not in one.latex]
        assert len(found) == 5
        assert {one.verdict for one in found} == {"holds"}, [(one.latex, one.verdict, one.remark) for one in found]


def test_a_guessed_bracket_accuses_nobody():
    """A line of a right derivation, whose missing bracket may stand in several places."""
    text = r"""$$m\ddot x = -T\sin\theta$$ $$m\ddot y = T\cos\theta - mg$$ $$\ddot\theta = -\frac gl\sin\theta$$
$$m g\sin\theta + \cos\theta(m(\ddot\theta l\cos\theta - \dot\theta^2l\sin\theta)
= -m(\ddot\theta l\sin^2\theta + \dot\theta^2l\cos\theta\sin\theta)$$"""
    *right, last = pp.diagnose(text).findings
    assert {one.verdict for one in right} == {"holds"}
    assert last.verdict != "fails"
    assert "bracket" in last.remark


def test_a_damping_is_one_beside_what_does_not_move():
    """In b/2m and r^2 + b r nothing moves, so that they tell nothing of b; a phase is no second angle."""
    text = r"""# Damped swings
$$\theta'' + \frac{b}{m}\theta' + \frac gL\sin(\theta) = 0$$ $$\theta'' + \frac{b}{m}\theta' + \frac gL\theta = 0$$
$\beta = \frac{b}{2m}$, $\omega_0 = \sqrt{\frac gL}$ $$r^2 + \frac bm r + \frac gL = 0$$ $$r^2 + 2\beta r + \omega_0^2 = 0$$
$$\Delta = \left(\frac{b}{m}\right)^2 - 4 \frac{g}{L} = 4\beta^2 - 4\omega_0^2$$
## Weakly damped
$$\theta(t) = e^{-\beta t}[A\cos(\omega t) + B\sin(\omega t)]$$
$$\theta(t) = C e^{-\beta t} \cos(\omega t + \phi)$$
$\omega = \sqrt{\omega_0^2 - \beta^2}$"""
    assert [one.verdict for one in pp.diagnose(text).findings[:2]] == ["holds", "holds if"]


def test_a_solution_has_the_letters_that_its_page_defines():
    """omega, which usually is a rate, and beta of 2 beta = b/m."""
    text = r"""$$\theta'' + \frac{b}{m}\theta' + \frac gL\sin\theta = 0$$
$$\theta'' + \frac{b}{m}\theta' + \frac gL\theta = 0$$
$$r^2 + \frac bm r + \frac gL = 0$$ $$2\beta = \frac bm$$ $\omega = \sqrt{\frac gL - \beta^2}$
$$\theta(t) = C e^{-\beta t}\cos(\omega t + \phi)$$"""
    found = pp.diagnose(text).findings
    assert [one.verdict for one in found[:2]] == ["holds", "holds if"]
    assert (found[-1].verdict, found[-1].kind) == ("holds if", "solution")
    wrong = pp.diagnose(text.replace("2\\beta", "3\\beta")).findings
    assert wrong[-1].verdict == "not checked"


def test_objects_with_numbers_are_two_bodies():
    lines = "a1 = p1.angle\na2 = p2.angle\nv2 = p2.angularVelocity\n"
    law = "(m1 + m2)*l1*a1dotdot + m2*l2*a2dotdot*cos(a1 - a2) + m2*l2*v2*v2*sin(a1 - a2) + (m1 + m2)*g*sin(a1) = 0"
    assert pp.diagnose(f"{lines}{law}").findings[-1].verdict == "holds"


def test_a_letter_of_a_damping_ratio_means_what_makes_it_one():
    """In b/(2 m L^2 omega) L is a length, though T - V would do where there is no damping."""
    text = r"""$$\ddot\theta + 2\zeta\omega_n\dot\theta + \omega_n^2\sin\theta = 0$$ with $\omega_n = \sqrt{g/L}$ and
$$\zeta = \frac{b}{2mL^2\omega_n}$$"""
    found = pp.diagnose(text).findings
    assert (found[0].verdict, found[0].remark) == ("holds", "b is a damping")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (r"""$$\ddot\theta + 2\gamma\dot\theta + \frac gL\sin\theta = F_0\cos(\omega t)$$ $$\omega_0 = \sqrt{\frac gL}$$
        The pendulum swings most at resonance, where $$\omega = \omega_0$$""", r"\omega = \omega_0"),
        (r"""A cart with a pendulum, pushed by a constant force $F$.
        $$T = \frac12(M+m)\dot x^2 + ml\dot x\dot\theta\cos\theta + \frac12ml^2\dot\theta^2$$
        $$(M+m)\ddot x + ml\ddot\theta\cos\theta - ml\dot\theta^2\sin\theta = F$$
        $$l\ddot\theta + \ddot x\cos\theta - g\sin\theta = 0$$
        $$V = mgl\cos\theta - F x$$""", "V = mgl"),
        (r"""A robot on wheels. $$T = \frac12(M+m+\frac{J}{r^2})\dot x^2 + ml\dot x\dot\theta\cos\theta
        + \frac12ml^2\dot\theta^2$$ $$V = -mgl\cos\theta$$ $$l\ddot\theta = -g\sin\theta$$""", "T = "),
        ("V = -m*g*L*cos(theta)\nL = T - V\nq = (x, y, theta)", "V = "),
    ],
    ids=["resonance", "the potential of a force", "a cart of another kind", "an angle that stands nowhere"],
)  # fmt: skip
def test_a_right_line_of_another_kind_is_not_accused(text, line):
    """A condition, a load in a potential, a body that moves by itself, a system whose other angle is nowhere."""
    found = [one for one in pp.diagnose(text).findings if one.latex.startswith(line)]
    assert found
    assert "fails" not in {one.verdict for one in found}


def test_a_damping_of_a_known_size_is_a_special_case():
    """beta = 2 omega_0 and q = 1/2 say nothing of the pendulum, which is right with any damping."""
    law = r"$$\ddot\theta + \beta\dot\theta + \omega_0^2\sin\theta = 0$$"
    for case in (r"\beta^2 = 4\omega_0^2", r"\beta = \frac12", r"\beta = 2\omega_0"):
        assert pp.diagnose(f"{law} Critical damping: ${case}$").findings[0].verdict == "holds"


def test_an_initial_value_is_no_second_angle_and_no_other_period():
    text = r"""A lab report: $\theta(t) = \theta_{max}\cos(\omega t)$ with the period $T(\theta_0) = T_0(1 + B\theta_0)$,
$$T = T_0$$ and $$T = 2\pi\sqrt{\frac Lg}$$"""
    assert [one.verdict for one in pp.diagnose(text).findings[-2:]] == ["holds", "holds"]


def test_a_state_that_no_equation_uses_has_no_name():
    """The first of four states of MATLAB, that of the cart: its rate is the third."""
    text = """m1 = param.mass_cart; m2 = param.mass_pole; L = param.len_pole;
ang_pos = state(2);
lin_vel = state(3);
ang_vel = state(4);
lin_accel = (L*m2*sin(ang_pos)*ang_vel^2 + u + m2*g*cos(ang_pos)*sin(ang_pos))/(m1 + m2*sin(ang_pos)^2);
ang_accel = -(L*m2*cos(ang_pos)*sin(ang_pos)*ang_vel^2 + u*cos(ang_pos) + (m1 + m2)*g*sin(ang_pos)) ...
    /(L*m1 + L*m2*sin(ang_pos)^2);
state_dot = [lin_vel; ang_vel; lin_accel; ang_accel];
"""
    held = [one.latex[:9] for one in pp.diagnose(text).findings if one.verdict == "holds"]
    assert {"lin_accel", "ang_accel"} <= {*held}
    wrong = pp.diagnose(text.replace("cos(ang_pos) + (m1", "cos(ang_pos) - (m1")).findings
    assert "ang_accel" not in {one.latex[:9] for one in wrong if one.verdict == "holds"}


HEIGHT = r"""$E_{kin} = \frac12 ml^2\dot\varphi^2$, $E_{pot} = m g h$ with $h = l(1-\sin\varphi)$,
$$\frac12ml^2\dot\varphi^2 + mgl(1-\cos\varphi) = E$$ $$\ddot\varphi = -\frac gl\sin\varphi$$"""
LISTS = """L, A, g = 1.0, 0.1, 9.81
theta0 = np.pi - 0.1
def swing(omega):
    theta_vals = [theta0]
    theta_dot_vals = [theta_dot0]
    for t in times:
        theta = theta_vals[-1]
        theta_dot = theta_dot_vals[-1]
        y_ddot = -omega**2*A*np.cos(omega*t)
        theta_ddot = -(g + y_ddot)/L*np.sin(theta)
        theta_dot_new = theta_dot + theta_ddot*dt
        theta_new = theta + theta_dot_new*dt
        theta_dot_vals.append(theta_dot_new)
        theta_vals.append(theta_new)
"""


@pytest.mark.parametrize(("text", "line"), [(HEIGHT, "E_{pot}"), (LISTS, "theta")], ids=["a height", "lists"])
def test_a_line_of_names_or_heights_is_not_accused(text, line):
    """m g h is a potential whatever h is said to be, and a list that begins with theta_0 is no angle."""
    found = [one for one in pp.diagnose(text).findings if one.latex.startswith(line)]
    assert found
    assert "fails" not in {one.verdict for one in found}


@pytest.mark.parametrize(
    "line",
    [
        r"$$T = 2\pi\sqrt{\frac{{I_c + Md^2}}{{Mg{\kern 1pt}d}}} {\rm   }$$",
        r"$$\theta(t) = \theta_0\e^{-\gamma t}\cos(\omega t)$$",
        r"$$l\ddot\theta = -g\sin\theta,\quad g = 4\pi^2\frac{l}{T^2}\unit{m/s^2}$$",
    ],
    ids=["kern and an empty group", "a macro for e", "a unit"],
)
def test_marks_of_latex_that_say_nothing_are_read(line):
    remarks = [one.remark for one in pp.diagnose(f"A pendulum. {line}").findings]
    assert not re.search("has no meaning|stands where", str(remarks))


def test_a_cart_stays_a_number_beside_a_vector_of_its_letter():
    """x is the place of a cart and the vector of states."""
    text = r"""A cart. $x_b = x + L\sin\theta$ and $\dot x_b = \dot x + L\dot\theta\cos\theta$
$$(M+m)\ddot x + mL\ddot\theta\cos\theta - mL\dot\theta^2\sin\theta = F$$
$$L\ddot\theta + \ddot x\cos\theta - g\sin\theta = 0$$
$$x = \begin{bmatrix} x \\ \dot x \\ \theta \\ \dot\theta \end{bmatrix}~ A = \begin{bmatrix} 0 & 1 & 0 & 0 \\
0 & 0 & -mg/M & 0 \\ 0 & 0 & 0 & 1 \\ 0 & 0 & (M+m)g/(ML) & 0 \end{bmatrix}$$"""
    assert [one.verdict for one in pp.diagnose(text).findings[:4]] == ["holds"] * 4


def test_a_length_may_have_the_letter_of_lagrange_beside_a_letter_of_a_distance():
    """Beside d, which usually is the distance of the centre of mass, L may still be that."""
    text = r"""A pendulum on a cart with the friction $d$: $$T = \frac12(M+m)\dot x^2 + mL\dot x\dot\theta\cos\theta
+ \frac12(mL^2 + I)\dot\theta^2$$ $$V = -mgL\cos\theta$$ $$(M+m)\ddot x + mL\ddot\theta\cos\theta
- mL\dot\theta^2\sin\theta + d\dot x = u$$"""
    assert {one.verdict for one in pp.diagnose(text).findings} == {"holds"}


def test_a_page_with_a_length_is_in_no_units_of_a_pendulum():
    """Where l stands, theta'' = -sin(theta) is no law of a pendulum but of one with g = l."""
    text = r"$$\ddot\theta = -\sin\theta$$ for a pendulum of the length $l$ with $E = \frac12 m l^2\dot\theta^2 + V$"
    assert pp.diagnose(text).findings[0].verdict != "holds"


def test_a_law_in_units_of_a_pendulum_says_enough_by_itself():
    assert pp.diagnose(r"$$\ddot\theta = -\sin\theta$$").findings[0].verdict == "holds"


def test_the_rate_of_a_rate_in_code_is_an_acceleration():
    text = r"""A pendulum. $\ddot\theta + \gamma\dot\theta + \frac gL\sin\theta = A\cos\Omega t$
dtheta_dot_dt = -gamma*theta_dot - g/L*np.sin(theta) + A*np.cos(Omega*t)
"""
    assert pp.diagnose(text).findings[1].verdict == "holds"
