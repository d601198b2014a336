"""The equation doctor: its truth, verdicts, mends and conventions; its report; code in place of formulae."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import pendpin as pp
from bad_input import run_main
from pendpin.doctor.systems.base import Convention, Quantities, System, free_states, random_states
from pendpin.doctor.systems.rod import SPECS
from pendpin.errors import InputError

PRINTED = Path(__file__).with_name("printed_derivation.md")


def verdicts(diagnosis):
    """The verdicts in order."""
    return [finding.verdict for finding in diagnosis.findings]


def first_mend(equation, **options):
    """The mended equation that is named first."""
    (finding,) = pp.diagnose([equation], **options).findings
    assert finding.verdict == ("fails" if finding.mends else "not checked")
    return finding.mends[0].latex if finding.mends else None


STRING = [  # a point mass on a string, on a universal joint
    r"\ddot\theta = 2\dot\theta\dot\phi\tan\phi - \frac{g}{l}\frac{\sin\theta}{\cos\phi}",
    r"\ddot\phi = -\dot\theta^2\sin\phi\cos\phi - \frac{g}{l}\cos\theta\sin\phi",
    r"T = \frac{m l^2}{2}(\dot\theta^2\cos^2\phi + \dot\phi^2)",
    r"R_3 = m l(\dot\phi^2 + \dot\theta^2\cos^2\phi) + m g \cos\theta\cos\phi",
]
POLAR = [  # the same in the angle from the vertical and the azimuth
    r"\ddot\theta = \dot\phi^2\sin\theta\cos\theta - \frac{g}{l}\sin\theta",
    r"\ddot\phi = -2\dot\theta\dot\phi\cot\theta",
    r"T = \frac{m l^2}{2}(\dot\theta^2 + \dot\phi^2\sin^2\theta)",
    r"J_1 \ddot\theta = J_1 \dot\phi^2\sin\theta\cos\theta + m g h \sin\theta",
]


def test_the_mass_of_a_cart_is_no_moment():
    """A letter that is a moment elsewhere does not make a balance of forces one of moments."""
    text = r"""A pendulum on a cart: M is the mass of the cart, m the point mass, l the length of the rod, F the force
on the cart, $\theta$ the angle from the downward vertical.
$$(M+m)\ddot x + m l \ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F$$
$$l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0$$"""
    found = pp.diagnose(text)
    assert verdicts(found) == ["holds"] * 2
    assert {one.kind for one in found.findings} == {"equation of motion"}


def test_a_page_on_a_point_mass_is_read_as_one():
    """Where two equations or more say so; one alone may lack the 3/2 of a rod, and the report names both."""
    found = pp.diagnose(STRING)
    assert verdicts(found) == ["holds"] * 4
    assert found.system.kind == "point"
    assert "point mass" in found.remarks[0]
    assert verdicts(pp.diagnose(STRING, rod="thin")) == ["fails"] * 4
    (alone,) = pp.diagnose(STRING[:1]).findings
    assert (alone.verdict, alone.condition) == ("holds if", "it is a point mass on a massless rod")
    assert r"\frac{3}{2}" in alone.mends[0].words
    wrong = [*STRING[:3], STRING[3].replace("+ m g", "- m g")]
    assert verdicts(pp.diagnose(wrong)) == ["holds"] * 3 + ["fails"]
    mixed = [*STRING[:2], r"V = -\frac{m g l}{2}\cos\theta\cos\phi"]  # of a rod: its equations lack the 3/2
    assert verdicts(pp.diagnose(mixed)) == ["holds if", "holds if", "holds"]


def test_a_mend_that_leaves_no_motion_is_none():
    """J_3 = I_3 holds, and says nothing of M_3."""
    wrong = r"M_3 = I_3(\ddot\theta\sin\phi + \dot\theta\dot\phi\cos\phi)"
    assert first_mend(wrong, rod="general") is None
    assert first_mend(wrong, rod="symmetric") == wrong.replace("= ", "= -")


def test_rows_of_an_align_have_their_own_lines_and_mends(tmp_path):
    """A long row counts its lines; the mended text is that of the row alone."""
    rows = [STRING[0].replace("- ", "\n  - "), STRING[1].replace("= -", "= ")]
    page = tmp_path / "page.md"
    page.write_text("Text\n\n\\begin{align}\n" + " \\\\\n".join(rows) + "\n\\end{align}\n\n$p = \\dot\\theta$")
    found = pp.diagnose(page, rod="point")
    assert [finding.place for finding in found.findings] == ["line 4", "line 6", "line 9"]
    assert r"\ddot\theta" not in str(found).split("mend:")[1].split("\n")[1]
    assert "1 holds, 1 fails, 1 is not checked" in str(found)


# --- the truth ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "convention", [Convention(), Convention(-1, -1, True, "up", -1), Convention(1, -1, False, "mirrored")]
)
def test_velocities_and_accelerations_are_the_rates_of_positions(convention):
    """Each quantity of the doctor's mechanics against a central difference along a motion with constant accelerations.

    The step of 1e-5 leaves an error of about 1e-10 times third derivatives, some tens in these units.
    """
    base = free_states(System(SPECS["general"], convention)).base
    pairs = [("rG", "vG"), ("vG", "aG"), ("omega", "alpha"), ("b3", None), ("x", "vx"), ("vy", "ay")]
    step = 1e-5

    def at(t):
        moved = dict(base)
        for angle in ("theta", "phi"):
            moved[angle] = base[angle] + base[f"d{angle}"] * t + base[f"dd{angle}"] * t**2 / 2
            moved[f"d{angle}"] = base[f"d{angle}"] + base[f"dd{angle}"] * t
        return Quantities(moved, System(SPECS["general"], convention), np)

    here = at(0.0)
    for position, rate in pairs:
        slope = (at(step)[position] - at(-step)[position]) / (2 * step)
        if rate is not None:
            np.testing.assert_allclose(slope, here[rate], atol=1e-7)
    turning = np.cross(here["omega"], here["b3"], axis=0)
    np.testing.assert_allclose((at(step)["b3"] - at(-step)["b3"]) / (2 * step), turning, atol=1e-8)


def test_energy_is_conserved_on_the_true_motion():
    """dE/dt by differences at the accelerations of the true motion: 0 to the error of the difference."""
    true = random_states(System(SPECS["general"]))
    base = {**true.base, "ddtheta": true["ddtheta"], "ddphi": true["ddphi"]}
    step = 1e-5

    def energy(t):
        moved = dict(base)
        for angle in ("theta", "phi"):
            moved[angle] = base[angle] + base[f"d{angle}"] * t + base[f"dd{angle}"] * t**2 / 2
            moved[f"d{angle}"] = base[f"d{angle}"] + base[f"dd{angle}"] * t
        return Quantities(moved, System(SPECS["general"]), np)["E"]

    np.testing.assert_allclose((energy(step) - energy(-step)) / (2 * step), 0, atol=1e-6)


# --- the printed derivation -----------------------------------------------------------------------------------------


def test_the_printed_derivation_has_exactly_its_faults():
    found = pp.diagnose(PRINTED)
    assert [f.number for f in found.wrong] == [2, 5, 6]
    assert "not checked" not in verdicts(found)
    assert all(f.proved for f in found.findings)
    sign, first, second = found.wrong
    assert r"\dot{\phi}^2+\dot{\theta}^2cos^2" in sign.mends[0].latex
    assert "bracket" in sign.remark
    assert first.mends[0].latex.count(r"\frac{ml^2}{12}") == second.mends[0].latex.count(r"\frac{ml^2}{12}") == 2
    assert found.shared[0][2] == [5, 6]
    assert "about the joint" in str(found)
    assert str(found).startswith("Equation 2, line 4, is the first wrong one: the sign of")


def test_the_first_lines_count_what_fails_and_lead_to_it():
    """The second line counts, the last one repeats which is first; on the page each number leads to its equation."""
    found = pp.diagnose(PRINTED)
    said = str(found).splitlines()
    assert said[1].startswith(f"3 of {len(found.findings)} equations fail; 5 (line ")
    assert said[-1].endswith(f"The first wrong one is equation 2, {found.wrong[0].place}.")
    shown = found.page()
    assert all(
        f'href="#equation-{one.number}"' in shown and f'id="equation-{one.number}"' in shown for one in found.wrong
    )


# --- right equations hold, wrong ones do not -------------------------------------------------------------------------


@pytest.mark.parametrize(
    "equation",
    [
        r"\frac{d}{dt}\frac{\partial L}{\partial\dot\theta}+\frac{\partial L}{\partial\theta}=0",  # L is no length here
        r"\frac{\partial L}{\partial\theta}=0",
        "T - V = const",
        "x = l/2*sin(phi) + C",  # only an energy has a constant that nobody knows
        r"L = V - T",
        r"{}^IC^B = {}^IC^A\cdot{}^AC^B",  # right if transposed, but one equation alone makes no convention
    ],
)
def test_wrong_equations_do_not_hold(equation):
    assert not pp.diagnose([equation]).ok


def test_a_rate_of_an_own_symbol():
    momentum = {"p_theta": "m*l**2/3*dtheta*cos(phi)**2"}
    found = pp.diagnose([r"\dot p_\theta = -\frac{mgl}{2}\sin\theta\cos\phi"], symbols=momentum)
    assert verdicts(found) == ["holds"]


def test_a_root_is_checked_in_50_digits():
    (finding,) = pp.diagnose([r"v = \frac{l}{2}\sqrt{\dot\phi^2+\dot\theta^2\cos^2\phi}"]).findings
    assert (finding.verdict, finding.proved) == ("holds", True)


def test_a_thin_rod_alone_is_said():
    (finding,) = pp.diagnose(
        [r"\ddot\phi = -\dot\theta^2\sin\phi\cos\phi - \frac{mgh}{J_2}\cos\theta\sin\phi"]
    ).findings
    assert finding.verdict == "holds if"
    assert "thin rod" in finding.condition


# --- conventions ----------------------------------------------------------------------------------------------------


def test_a_convention_is_found_and_said():
    texts = [
        r"\omega = \dot\theta\hat{x} + \dot\phi\hat{a}_2",
        "y = -l/2*sin(theta)*cos(phi)",
        "omega_1 = dtheta*cos(phi)",
    ]
    found = pp.diagnose(texts)
    assert found.ok
    assert "counter-clockwise" in str(found)
    assert not pp.diagnose(texts, convention="standard").ok
    assert pp.diagnose(texts, convention="theta-ccw").ok


def test_one_sign_alone_is_a_fault_and_no_convention():
    found = pp.diagnose(["V = m*g*z"])
    assert verdicts(found) == ["fails"]
    assert "z points up" in str(found)


@pytest.mark.parametrize("options", [{"rod": "thick"}, {"convention": "upside-down"}, {"symbols": {"2": "x"}}])
def test_options_are_checked(options):
    with pytest.raises(InputError):
        pp.diagnose(["x = 1"], **options)


# --- command and page -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wrong", [("--rod", "thinn"), ("--convention", "zup")], ids=" ".join)
def test_a_name_that_an_option_does_not_know_is_wrong_usage(wrong, capsys):
    assert run_main("doctor", str(PRINTED), *wrong) == 2
    assert "did you mean" in capsys.readouterr().err


def test_the_command_writes_json_and_a_page(tmp_path, capsys):
    page = tmp_path / "report.html"
    assert run_main("doctor", str(PRINTED), "--json", "--html", str(page)) == 1
    records = json.loads(capsys.readouterr().out)
    assert {"number", "latex", "kind", "verdict", "proved", "error", "mends"} <= set(records[0])
    residual = sp.sympify(records[5]["mends"][0]["residual"])
    names = {"l", "m", "R1", "phi", "dtheta", "ddphi"}
    assert {symbol.name for symbol in residual.free_symbols} == names
    text = page.read_text()
    assert "://" not in text
    assert 'class="changed"' in text


@pytest.mark.parametrize("count", [1, 2])
def test_the_page_begins_with_the_first_mend(count):
    wrong = ["x = -l/2*sin(phi)", "R1 = m*g/4*cos(theta)*sin(theta)"][:count]
    found = pp.diagnose(wrong)
    _, _, rest = found.page().partition("Mended:")
    assert [len(finding.mends) > 0 for finding in found.findings] == [True] * count
    assert re.sub("<[^>]*>", "", rest).strip().startswith(found.findings[0].mends[0].latex)


def test_the_exit_status_says_whether_all_holds(tmp_path):
    path = tmp_path / "right.toml"
    path.write_text('[equations]\nx = "l/2*sin(phi)"\nT = "D*dphi**2/2 + D*dtheta**2/2"\n[symbols]\nD = "m*l**2/3"\n')
    assert run_main("doctor", str(path)) == 1
    path.write_text('[equations]\nx = "l/2*s"\n[symbols]\ns = "sin(phi)"\n')
    assert run_main("doctor", str(path)) == 0


def test_derivatives_of_a_lagrangian_confirm_no_lagrangian():
    """They hold of any function that a text calls L, as here, where the product of the two rates is missing."""
    lagrangian = r"L = \frac{1}{2}(M + m)\dot x^2 + \frac{1}{2} m l^2 \dot\theta^2 + m g l\cos\theta"
    derivatives = (
        r"\frac{\partial L}{\partial\dot x} = (M + m)\dot x",
        r"\frac{d}{dt}\frac{\partial L}{\partial\dot x} = (M + m)\ddot x",
    )
    found = pp.diagnose([lagrangian, *derivatives], rod="cart-pole").findings
    assert {finding.verdict for finding in found} <= {"not checked", "fails"}
