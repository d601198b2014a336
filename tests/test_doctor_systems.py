"""The systems that the doctor knows: each obeys Lagrange's equations, and texts about the newer ones hold."""

from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin.doctor.systems.base import System, random_states
from pendpin.doctor.systems.rod import RODS
from pendpin.doctor.systems.tables import FAMILIES


@pytest.mark.parametrize("spec", [spec for specs in FAMILIES.values() for spec in specs], ids=lambda spec: spec.kind)
def test_each_system_obeys_lagrange(spec):
    """d/dt of dL/dq' less dL/dq is the load on each coordinate, to the rounding of one step in the complex plane.

    And every quantity of its table has a value.
    """
    q = random_states(System(spec))
    assert all(np.isfinite(q[name]).all() for name in spec.formulas)
    loads = {name: q.number(0) for name in spec.coordinates}
    loads |= {"x": q["F"]} if "F" in spec.parameters else {}
    loads |= {"theta": q["tau1"]} if "tau1" in spec.parameters and "theta" in spec.coordinates else {}
    loads |= {f"theta{i}": q[f"tau{i}"] for i in "12" if f"tau{i}" in spec.parameters}
    loads |= {"s": -q["S"]} if "S" in spec.parameters else {}  # of a string that is pulled
    for name in spec.coordinates:
        momentum = q.derivative(lambda there, name=name: there.derivative(lambda z: z["L"], f"d{name}"), "t")
        slope = q.derivative(lambda there: there["L"], name)
        np.testing.assert_allclose(momentum - slope, loads[name], atol=1e-9)


def test_the_page_shows_every_system():
    """docs/systems.md includes each file of tables, and each is of a system that the doctor knows."""
    folder = Path(__file__).parents[1] / "src/pendpin/doctor/systems"
    page = (folder.parents[3] / "docs/systems.md").read_text()
    for path in folder.glob("*.md"):
        assert f"{path.name}\n" in page
    assert {spec.kind.split()[0] for specs in FAMILIES.values() for spec in specs} | {"rod", "common"} == {
        path.stem for path in folder.glob("*.md")
    }


FURTHER = {
    "a pivot that goes up": r"""The pivot oscillates by $y_0 = a\cos\gamma t$, so $x = l\sin\theta$ and
$y = a\cos(\gamma t) - l\cos\theta$. Then $V = m g y$,
$$T = \frac{m}{2}\left(l^2\dot\theta^2 - 2 a l\gamma\sin(\gamma t)\sin\theta\,\dot\theta
+ a^2\gamma^2\sin^2(\gamma t)\right)$$
$$l\ddot\theta + (g - a\gamma^2\cos\gamma t)\sin\theta = 0$$""",
    "a pivot that goes to the side": r"""With $x = A\sin\omega t + l\sin\phi$, $y = -l\cos\phi$:
$$l\ddot\phi + g\sin\phi - A\omega^2\sin(\omega t)\cos\phi = 0$$
$\dot x = A\omega\cos\omega t + l\cos\phi\,\dot\phi$ and $V = -m g l\cos\phi$;
$$\frac{\partial L}{\partial\dot\phi} = m l^2\dot\phi + m l A\omega\cos(\omega t)\cos\phi$$""",
    "a spring": r"""# An elastic pendulum
$$T = \frac12 m(\dot r^2 + r^2\dot\theta^2)$$
$$V = -m g r\cos\theta + \frac12 k(r - l_0)^2$$
$$\ddot r - r\dot\theta^2 + \frac{k}{m}(r - l_0) - g\cos\theta = 0$$
$$r\ddot\theta + 2\dot r\dot\theta + g\sin\theta = 0$$""",
    "a string that is pulled": r"""The length $l$ of the string is changed.
$$T = \frac12 m(\dot l^2 + l^2\dot\theta^2)$$
$$V = -m g l\cos\theta$$
$$l\ddot\theta + 2\dot l\dot\theta + g\sin\theta = 0$$
$$S = m g\cos\theta + m l\dot\theta^2 - m\ddot l$$""",
    "three bobs": r"""# The triple pendulum
$$x_3 = l_1\sin\theta_1 + l_2\sin\theta_2 + l_3\sin\theta_3$$
$$V = -(m_1+m_2+m_3) g l_1\cos\theta_1 - (m_2+m_3) g l_2\cos\theta_2 - m_3 g l_3\cos\theta_3$$
$$l_3\ddot\theta_3 + l_1\ddot\theta_1\cos(\theta_1-\theta_3) + l_2\ddot\theta_2\cos(\theta_2-\theta_3)
- l_1\dot\theta_1^2\sin(\theta_1-\theta_3) - l_2\dot\theta_2^2\sin(\theta_2-\theta_3) + g\sin\theta_3 = 0$$""",
    "an arm that turns": r"""# The Furuta pendulum, alpha from upright
$$T = \frac12 (J_a + m r^2 + m l^2\sin^2\alpha)\dot\theta^2
+ m r l\cos\alpha\,\dot\theta\dot\alpha + \frac12 m l^2\dot\alpha^2$$
$$V = m g l\cos\alpha$$
$$m l^2\ddot\alpha + m r l\cos\alpha\,\ddot\theta - m l^2\sin\alpha\cos\alpha\,\dot\theta^2 - m g l\sin\alpha = 0$$
$$(J_a + m r^2 + m l^2\sin^2\alpha)\ddot\theta + m r l\cos\alpha\,\ddot\alpha
+ 2 m l^2\sin\alpha\cos\alpha\,\dot\theta\dot\alpha - m r l\sin\alpha\,\dot\alpha^2 = \tau$$""",
    "two that a spring couples": r"""Two equal pendulums are coupled by a spring at the distance $a$ below their pivots.
$$T = \frac12 m l^2(\dot\theta_1^2 + \dot\theta_2^2)$$
$$V = \frac12 m g l(\theta_1^2 + \theta_2^2) + \frac12 k a^2(\theta_1 - \theta_2)^2$$
$$m l^2\ddot\theta_1 + m g l\theta_1 + k a^2(\theta_1 - \theta_2) = 0$$
$$m l^2\ddot\theta_2 + m g l\theta_2 - k a^2(\theta_1 - \theta_2) = 0$$
$$\omega_2 = \sqrt{\frac gl + \frac{2 k a^2}{m l^2}}$$""",
    "a hoop that turns": r"""A bead on a hoop that turns with $\Omega$:
$$T = \frac12 m R^2(\dot\theta^2 + \Omega^2\sin^2\theta)$$
$$V_{eff}(\theta) = -m g R\cos\theta - \frac12 m R^2\Omega^2\sin^2\theta$$
$$\ddot\theta = \Omega^2\sin\theta\cos\theta - \frac gR\sin\theta$$ $$\Omega_c = \sqrt{\frac gR}$$""",
    "a rod with a bob": r"""A rod of mass $m$ and length $l$ carries a bob of mass $M$ at its end.
$$I = \frac13 m l^2 + M l^2$$ $$I\ddot\theta = -\left(\frac m2 + M\right) g l\sin\theta$$
$$d = \frac{m l/2 + M l}{m + M}$$ $$T = 2\pi\sqrt{\frac{(m/3 + M) l}{(m/2 + M) g}}$$""",
}


FAULTS = [
    (r"(g - a", "(g + a"),
    (r"- A\omega", r"+ A\omega"),
    (r"+ 2\dot r", r"- 2\dot r"),
    (r"+ 2\dot l", r"- 2\dot l"),
    (r"- l_2\dot", r"+ l_2\dot"),
]
FAULTS += [(r"+ 2 m l^2", r"- 2 m l^2"), (r"m g l\theta_2 - k", r"m g l\theta_2 + k"), (r"- \frac gR", r"+ \frac gR")]
FAULTS += [(r"I = \frac13 m", r"I = \frac12 m")]


@pytest.mark.parametrize(("text", "fault"), [*zip(FURTHER.values(), FAULTS, strict=True)], ids=FURTHER)
def test_pivots_springs_chains_and_arms(text, fault):
    """All holds; with another sign of one term that law alone is accused."""
    right = pp.diagnose(text)
    assert {one.verdict for one in right.findings} == {"holds"}, str(right)
    wrong = pp.diagnose(text.replace(*fault)).findings
    assert text.count(fault[0]) == 1
    assert [one.latex for one in wrong if one.verdict == "fails"] == [
        one.latex for one in wrong if fault[1] in one.latex
    ]
    assert len([one for one in wrong if one.verdict == "holds"]) == len(wrong) - 1


@pytest.mark.parametrize("rod", [*FAMILIES, *RODS])
def test_a_system_that_the_user_names_is_taken_though_no_coordinate_or_word_of_the_text_shows_it(rod):
    for text in (
        "a = b",
        "L = T - V",
        r"$\frac d{dt}\frac{\partial L}{\partial\dot q} = \frac{\partial L}{\partial q}$",
    ):
        assert pp.diagnose(text, rod=rod).system.kind.split()[0] in (rod, "double")  # acrobots are double pendulums
    own = {
        "plane": r"T=\frac12 m l^2\dot\theta^2",
        "elastic": r"m\ddot r - m r\dot\theta^2 - m g\cos\theta + k(r-l_0)=0",
    }
    if rod in own:  # no spring is named
        assert [one.verdict for one in pp.diagnose(f"${own[rod]}$", rod=rod).findings] == ["holds"]


CONE = r"""The bob of a conical pendulum has the string's tension $T$ and the radius $r = l\sin\theta$.
$$T\cos\theta = m g$$ $$T\sin\theta = m\omega^2 r$$ $$\omega = \sqrt{\frac{g}{l\cos\theta}}$$
$$v = \sqrt{g r\tan\theta}$$ The period is $$T = 2\pi\sqrt{\frac{l\cos\theta}{g}}$$"""


def test_a_conical_pendulum_keeps_its_angle():
    assert {one.verdict for one in pp.diagnose(CONE).findings} == {"holds"}
    wrong = pp.diagnose(CONE.replace(r"= m\omega^2 r", r"= m\omega^2 l")).findings
    assert [one.latex for one in wrong if one.verdict != "holds"] == [r"T\sin\theta = m\omega^2 l"]


def test_a_rod_and_its_bob_have_either_letter():
    text = FURTHER["a rod with a bob"].translate(str.maketrans("mM", "Mm"))
    assert {one.verdict for one in pp.diagnose(text).findings} == {"holds"}


@pytest.mark.parametrize("name", ["omega", "Omega", "gamma"])
@pytest.mark.parametrize(
    "drive", [("", "-", "cos"), ("", "-", "sin"), ("upright", "+", "cos"), ("upright", "+", "sin")]
)
def test_the_law_of_a_pivot_that_moves_is_known_by_its_drive(drive, name):
    """What multiplies t in a sine is the frequency of a drive, and no rate, though it is called omega."""
    where, sign, function = drive
    law = rf"$$\ddot\theta = {sign}\left(\frac gl - \frac{{a\{name}^2}}{{l}}\{function}(\{name} t)\right)\sin\theta$$"
    text = f"A pendulum, its angle {where} in rad.\n{law}\n"
    (found,) = pp.diagnose(text).findings
    assert found.verdict == "holds", found
    (later,) = pp.diagnose(text.replace(r"- \frac{a", r"+ \frac{a")).findings  # its pivot begins at -a
    assert (later.verdict, "begins there" in later.remark) == ("not checked", True)
    (wrong,) = pp.diagnose(text.replace("^2", "")).findings
    assert wrong.verdict != "holds"
