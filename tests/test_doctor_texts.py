"""The equation doctor on whole texts: ten systems, each in one of ten notations; nobody who is right is accused."""

import sys
from contextlib import suppress
from pathlib import Path

import pytest

import pendpin as pp
from pendpin.errors import InputError

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from hostile_texts import hostile_text, written_by_hand
from printed.sheets import NOTATIONS, by_hand, sheets, texts

TITLES = list(sheets())
PAIRS = [(title, list(NOTATIONS)[(3 * i + 1) % len(NOTATIONS)]) for i, title in enumerate(TITLES)]
USUAL, RARE = 4, 6  # every so many of these is tried each time, the others are slow
PAIRS = [pair if i % USUAL == 2 else pytest.param(*pair, marks=pytest.mark.slow) for i, pair in enumerate(PAIRS)]
BY_HAND = by_hand()
BY_HAND = [text if i % RARE == 0 else pytest.param(*text, marks=pytest.mark.slow) for i, text in enumerate(BY_HAND)]


@pytest.mark.parametrize(("title", "text"), BY_HAND, ids=[title for title, _ in by_hand()])
def test_texts_by_hand_are_right(title, text):
    """Every equation holds, if only under a condition, but for states, and for definitions that nothing uses."""
    others = ("it gives ", "no other equation uses ", "no equation that holds uses ")
    laws = [f for f in pp.diagnose(text).findings if not f.remark.startswith(others)]
    assert {finding.verdict for finding in laws} <= {"holds", "holds if"}


@pytest.mark.parametrize(("title", "notation"), PAIRS)
def test_right_texts_hold_and_a_planted_fault_is_found(title, notation):
    """Every equation holds, one of them for small angles; with one sign changed that equation alone fails, and is mended.

    A lone height with the other sign may be meant downwards: it is doubted.
    """
    [(_, _, text, _)] = texts(only=title, style=notation)
    found = pp.diagnose(text)
    assert {finding.verdict for finding in found.findings} <= {"holds", "holds if"}, found
    place = next(i for i, line in enumerate(sheets()[title]) if " = -" in line or "= m*" in line)
    [(_, _, wrong, _)] = texts(lambda i, line: _flipped(line) if i == place else line, only=title, style=notation)
    every = pp.diagnose(wrong).findings
    doubted = every[place].remark.endswith("measured the other way")
    assert [i for i, one in enumerate(every) if one.verdict == "fails"] == ([] if doubted else [place])
    assert not doubted or every[place].latex.replace(" ", "")[:2] in ("y=", "z=")


def _flipped(line):
    """An equation with another sign at the head of its right side."""
    return line.replace(" = -", " = ") if " = -" in line else line.replace("= m*", "= -m*")


@pytest.mark.parametrize(
    "text",
    [
        "# A disc that rolls\n$\\frac32 m R^2\\ddot\\chi = m g R\\sin\\beta$, $\\dot X = R\\dot\\chi$",
        "# Two bodies around each other\n$\\ddot r - r\\dot\\nu^2 = -\\mu/r^2$, $r\\ddot\\nu + 2\\dot r\\dot\\nu = 0$",
    ],
    ids=["disc", "orbit"],
)
def test_an_unknown_system_is_named_first_and_nothing_fails(text):
    found = pp.diagnose(text)
    assert str(found).startswith("No system that pendpin knows")
    assert {finding.verdict for finding in found.findings} == {"not checked"}


def test_other_letters_are_given_or_said():
    """By --symbols, or by a sentence of the text."""
    text = "$A \\ddot\\beta + (A - C)\\sin\\beta\\cos\\beta\\,\\dot\\alpha^2 + M g c\\cos\\alpha\\sin\\beta = 0$"
    symbols = {"alpha": "theta", "beta": "phi", "A": "J_1", "C": "I_3", "M": "m", "c": "h"}
    assert [f.verdict for f in pp.diagnose(text, symbols=symbols).findings] == ["holds"]
    legend = (
        "where $\\alpha$ is the angle theta, $\\beta$ the angle phi, $A$ the transverse inertia about the joint, "
        "$C$ the axial inertia, $M$ the mass and $c$ the distance of the centre of mass from the joint.\n\n"
    )
    assert [f.verdict for f in pp.diagnose(legend + text).findings] == ["holds"]


def test_a_scene_is_the_truth_of_its_own_text():
    chain = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=2.0), pp.Rod(length=0.7, mass=1.3)]))
    chain = chain.replace(effects=[pp.effects.Gravity()])
    right = r"$\frac{d}{dt}\frac{\partial L}{\partial\dot\theta_1} = \frac{\partial L}{\partial\theta_1}$"
    assert [f.verdict for f in pp.diagnose(right, scene=chain).findings] == ["holds"]
    wrong = pp.diagnose("$E = T - V$", scene=chain)
    assert [f.verdict for f in wrong.findings] == ["fails"]
    assert "\n1 equation of the scene's chain of 2 rods: " in str(wrong)


PENDULUM = r"$J = I + m h^2$, $J\ddot\theta = -m g h\sin\theta$, $T = \frac12 J\dot\theta^2$, $V = -m g h\cos\theta$, "
PENDULUM += (
    r"$T = \frac12 m v^2 + \frac12 I\dot\theta^2$, $(I + m h^2)\ddot\theta = -m g h\sin\theta$, $v = h\dot\theta$, "
)


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        (r"$p = I\dot\theta$", "J"),  # I may be the inertia about the pivot, but here it is not
        (r"$V = m g l(1 - \cos\theta)$", "h"),  # as if l were a second name of h
    ],
)
def test_a_letter_has_one_meaning_in_a_text(wrong, right):
    finding = pp.diagnose(PENDULUM + wrong).findings[-1]
    assert finding.verdict == "not checked"  # unless the text means another body there
    assert f"should be {right}" in finding.remark


@pytest.mark.parametrize(
    ("text", "verdict"), [("J_1 = I_1", "fails"), ("h = l/2", "not checked"), ("l = 2 m", "not checked")]
)
def test_a_parameter_is_chosen_only_among_those_that_there_are(text, verdict):
    """J_1 is always larger than I_1; l may be two metres. Where nobody named the system, J may be another name of I."""
    assert [f.verdict for f in pp.diagnose([text], rod="general").findings] == [verdict]
    renamed = pp.diagnose(r"$J=I$, $J\ddot\theta = -m g h\sin\theta$, $T = J\dot\theta^2/2$")
    assert [f.verdict for f in renamed.findings] == ["not checked", "holds", "holds"]


@pytest.mark.slow
def test_one_fault_leaves_the_system_and_the_letters_as_they_are():
    """A wrong sign in a Lagrangian makes no other system of the text; s_2 = sin q_2 is no length, though T is wrong."""
    texts_by_title = {title.partition(" [")[0]: text for title, text in by_hand()}
    faults = {
        "spherical pendulum by its constant momentum": (r"\sin^2\theta) + mgR", r"\sin^2\theta) - mgR"),
        "an article on two rods, relative angles": (r"l_1^2}{3}+m_2", r"l_1^2}{3}-m_2"),
    }
    for title, change in faults.items():
        (wrong,) = pp.diagnose(texts_by_title[title].replace(*change)).wrong
        assert wrong.mends[0].words.startswith("the sign of")


def test_a_damping_is_known_as_one():
    """Its letter may be a length elsewhere."""
    energies = r"$T = \frac12 m l^2\dot\theta^2$, $V = -m g l\cos\theta$, "
    damped = energies + r"$m l^2\ddot\theta + b\dot\theta + m g l\sin\theta = 0$"
    assert [(f.verdict, f.remark) for f in pp.diagnose(damped).findings[2:]] == [("holds", "b is a damping")]


MANY = [pytest.param(range(i, i + 39), marks=pytest.mark.slow) for i in range(5, 200, 39)]


@pytest.mark.parametrize("seeds", [range(5), *MANY], ids=str)
def test_damaged_texts_are_answered(seeds, tmp_path, monkeypatch):
    """No exception but pendpin's own, and nothing that a text says is run."""
    monkeypatch.chdir(tmp_path)
    texts_by_hand = written_by_hand()
    for seed in seeds:
        with suppress(pp.PendpinError):
            found = pp.diagnose(hostile_text(seed, texts_by_hand))
            assert str(found)
            assert len(found.to_json()) == len(found.findings)
    assert not list(tmp_path.iterdir())


OWN_ANGLES = r"""The angles are $\alpha$ and $\beta$, $z$ points up.
$$ x = -\frac{l}{2}\sin\beta $$
$$ y = \frac{l}{2}\sin\alpha\cos\beta $$
$$ z = -\frac{l}{2}\cos\alpha\cos\beta $$
$$ T = \frac{m l^2}{6}(\dot\alpha^2\cos^2\beta + \dot\beta^2) $$
"""


@pytest.mark.parametrize("options", [{}, {"rod": "thin"}, {"convention": "z-mirrored,phi-reversed"}], ids=str)
def test_angles_with_other_names_are_guessed_in_every_convention_and_beside_every_option(options):
    found = pp.diagnose(OWN_ANGLES, **options)
    assert {finding.verdict for finding in found.findings} == {"holds"}
    assert "alpha=theta,beta=phi" in found.remarks[0]
    assert "z points up" in found.remarks[1]


def test_a_mend_takes_a_minus_away_and_writes_none_before_another():
    found = pp.diagnose(OWN_ANGLES, convention="standard")
    mended = [mend.latex for finding in found.findings for mend in finding.mends]
    assert mended
    assert not any("--" in text.replace(" ", "") for text in mended)


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        (r"-x = \frac{l}{2}\sin\phi", r"x = \frac{l}{2}\sin\phi"),
        (r"x = -\frac{l}{2}\sin\phi", r"x = \frac{l}{2}\sin\phi"),
    ],
)
def test_a_wrong_minus_in_front_is_taken_away(wrong, right):
    (finding,) = pp.diagnose([wrong]).findings
    assert finding.mends[0].latex == right
    assert finding.mends[0].words.startswith("the sign of -")


def test_a_symbol_cannot_stand_for_a_word_that_names_nothing():
    with pytest.raises(InputError, match="did you mean 'theta'"):
        pp.diagnose("x = l/2*sin(a)", symbols={"a": "thetaa"})
    assert pp.diagnose("x = l/2*sin(a)", symbols={"a": "phi"}).ok


def test_a_file_of_other_bytes_is_no_text(tmp_path):
    path = tmp_path / "page.md"
    path.write_bytes(b"x = 1\x00\x02")
    with pytest.raises(InputError, match="not a text file"):
        pp.diagnose(path)
    path.write_bytes("Länge: $x = \\frac{l}{2}\\sin\\phi$".encode("latin-1"))
    assert pp.diagnose(path).ok


def test_conditions_that_nobody_states_are_found():
    """A pendulum that is released, and a cart that nobody pushes; but a wrong factor holds under none of these."""
    energies = r"$T = \frac12 m l^2\dot\theta^2$, $V = -m g l\cos\theta$, $\ddot\theta = -\frac gl\sin\theta$, "
    released = r"$\dot\theta^2 = \frac{2g}{l}(\cos\theta - \cos\theta_0)$, $S = 3 m g\cos\theta$, $S = 2 m g\cos\theta$"
    found = pp.diagnose(energies + released).findings[3:]
    assert [f.condition for f in found] == [f"it is released at rest from {place}" for place in ("theta_0", "90°")] + [
        ""
    ]
    assert found[2].verdict == "not checked"
    assert "no small change" in found[2].remark


def test_a_slip_in_a_sentence_on_symbols_is_no_traceback():
    found = pp.diagnose(r"where $\thta$ is the angle from the vertical: $\ddot\theta = -\frac gl\sin\theta$")
    assert [finding.verdict for finding in found.findings] == ["holds"]


HANGING = r"""A slender rod of mass $M$ and length $L$ hangs on a Cardan joint, with angles $\theta$ and $\phi$.
$$ J = \frac13 M L^2 $$
$$ U = -\frac{M g L}{2}\cos\theta\cos\phi $$
$$ T = \frac12 J(\dot\theta^2\cos^2\phi + \dot\phi^2) $$
"""
PULL = r"$$ N = \frac{M L}{2}(\dot\phi^2 + \dot\theta^2\cos^2\phi) + M g\cos\theta\cos\phi $$"


def verdicts(text, **options):
    """The verdicts in order."""
    return [finding.verdict for finding in pp.diagnose(text, **options).findings]


@pytest.mark.parametrize("letters", [("M", "L"), ("M", "l"), (r"\mu", "b")], ids=" ".join)
@pytest.mark.parametrize("rod", [None, "thin"])
def test_letters_that_a_text_names_in_passing_are_mass_and_length(letters, rod):
    text = HANGING.replace("M", letters[0] + " ").replace("L", letters[1])
    assert verdicts(text, rod=rod) == ["holds"] * 3


@pytest.mark.parametrize(
    ("words", "force", "verdict"),
    [
        ("The tension in the rod is", PULL, "holds"),
        ("With a force", PULL, "holds"),
        ("With a force", PULL.replace("+ M g", "- M g"), "not checked"),
        pytest.param("The tension in the rod is", PULL.replace("+ M g", "- M g"), "fails", marks=pytest.mark.slow),
    ],
    ids=["tension", "any force", "another force", "wrong"],
)
def test_a_force_is_what_the_words_before_it_say(words, force, verdict):
    """A tension is R_3, and another force holds where it is that."""
    assert verdicts(f"{HANGING}{words}\n{force}", rod="thin")[3] == verdict


def test_the_first_line_says_how_many_equations_are_not_checked():
    found = pp.diagnose(HANGING + PULL.replace("+ M g", "- M g"), rod="thin")
    assert found.ok
    assert "1 of 4 equations is NOT CHECKED; say what these symbols are: --symbols N=" in str(found).split("\n")[1]
    assert "NOT CHECKED" not in str(pp.diagnose(HANGING, rod="thin"))


# --- strangers' pages ------------------------------------------------------------------------------------------------


def test_each_section_is_read_as_of_its_own_system():
    """A pendulum, then two: what holds in its section is not held against the other."""
    single = "# One bob\n$$ m l^2\\ddot\\theta = -m g l\\sin\\theta $$\n$$ T = \\frac12 m l^2\\dot\\theta^2 $$\n"
    double = (
        "# Double pendulum\n$$ V = -(m_1+m_2) g l_1\\cos\\theta_1 - m_2 g l_2\\cos\\theta_2 $$\n"
        "$$ (m_1+m_2) l_1\\ddot\\theta_1 + m_2 l_2\\ddot\\theta_2\\cos(\\theta_1-\\theta_2) "
        "+ m_2 l_2\\dot\\theta_2^2\\sin(\\theta_1-\\theta_2) + (m_1+m_2) g\\sin\\theta_1 = 0 $$\n"
    )
    assert verdicts(single + double) == ["holds"] * 4


def test_two_equations_on_a_line_and_a_chain_that_goes_on_are_read():
    text = r"$$ T = \frac12 m l^2\dot\theta^2 \qquad V = -m g l\cos\theta $$ and $$ \ddot\theta = -\frac gl\sin\theta $$ so "
    assert verdicts(text) == ["holds"] * 3
    chain = (
        r"$$ T - V = \frac12 m l^2\dot\theta^2 - V $$" + "\n" + r"$$ = \frac12 m l^2\dot\theta^2 + m g l\cos\theta $$"
    )
    assert verdicts(text + chain) == ["holds"] * 5
    assert verdicts(text + chain.replace("+ m g l", "- m g l"))[4] == "fails"


STATES = """function dydt = f(t, y)
dydt(1) = y(2);
dydt(2) = -(g/l)*sin(y(1));
dydt(3) = 0;
"""


def test_a_vector_of_states_is_read_as_angles_and_rates():
    assert verdicts(STATES)[:2] == ["holds", "holds"]
    assert verdicts(STATES.replace("-(g/l)", "-(l/g)"))[1] != "holds"


def test_code_goes_on_over_lines_and_nothing_is_dropped_in_silence():
    """The accelerations of two pendulums by their numerators; a loop is named as not looked at."""
    code = """for i = 1:3
num = -m2*l1*omega1**2*sin(theta1 - theta2)*cos(theta1 - theta2) + g*m2*sin(theta2)*cos(theta1 - theta2)
num = num - m2*l2*omega2**2*sin(theta1 - theta2) - (m1 + m2)*g*sin(theta1)
x1 = l1*sin(theta1)
y1 = (-l1*
  cos(theta1))
omega1 = dtheta1
omega2 = dtheta2
x2 = x1 + l2*sin(theta2)
"""
    found = pp.diagnose(code)
    assert [f.verdict for f in found.findings if f.latex.startswith(("x", "y"))] == ["holds"] * 3
    assert found.skipped == ("line 1",)
    assert "line 1" in str(found).splitlines()[-1]


def test_equations_that_contradict_each_other_are_not_said_to_hold():
    """Of two definitions of one symbol the one is right with which an equation holds."""
    text = r"$D = m l^2$, $T = \frac12 D\dot\theta^2$, $m l^2\ddot\theta = -m g l\sin\theta$, $V = -m g l\cos\theta$, "
    assert verdicts(text + r"$D = 3 m l^2$")[4] == "not checked"
    assert verdicts(text + r"$V = m g l\cos\theta$")[4] != "holds"


def test_no_body_is_made_equal_to_another_to_save_a_slip():
    text = r"""$$ x_1 = l_1\sin\theta_1, \quad x_2 = l_1\sin\theta_1 + l_2\sin\theta_2 $$
$$ V = -(m_1+m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2 $$
$$ T = \frac12 m_1 l_1^2\dot\theta_1^2 + \frac12 m_2(l_1^2\dot\theta_1^2 + l_2^2\dot\theta_2^2
+ 2 l_1 l_2\dot\theta_1\dot\theta_2\cos(\theta_1-\theta_2)) $$"""
    assert verdicts(text) == ["holds"] * 4
    assert verdicts(text.replace("m_2(l_1^2", "m_1(l_1^2"))[3] == "fails"


def test_hamiltons_equations_are_derived_at_constant_momenta():
    text = r"$$ H = \frac{p^2}{2 m l^2} - m g l\cos\theta $$ $$ p = m l^2\dot\theta $$ $$ V = -m g l\cos\theta $$"
    double = r"""$$ V = -(m_1+m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2 $$
$$ \dot p_1 = -\frac{\partial H}{\partial\theta_1} $$
$$ \dot\theta_1 = \frac{\partial H}{\partial p_1} $$
$$ \dot y_2 = l_1\dot\theta_1\sin\theta_1 + l_2\dot\theta_2\sin\theta_2 $$"""
    assert verdicts(text + r" $$ \dot p = -\frac{\partial H}{\partial\theta} $$") == ["holds"] * 4
    assert verdicts(double) == ["holds"] * 4
    assert verdicts(double.replace(r"= -\frac{\partial H}", r"= \frac{\partial H}"))[1] == "fails"


def test_an_equation_without_gravity_beside_gravity_does_not_hold():
    text = r"$$ V = -m g l\cos\theta $$ $$ T = \frac12 m l^2\dot\theta^2 $$ $$ m l^2\ddot\theta = 0 $$"
    assert verdicts(text)[:2] == ["holds", "holds"]
    assert verdicts(text)[2] not in ("holds", "holds if")


DAMPED = r"""# A string with friction
A bob on a string of length $L$ turns by $\theta$:
$$\ddot\theta + \frac{g}{L}\sin\theta = 0$$
With the damping coefficient $b$ this becomes
$$\ddot\theta + b\,\dot\theta + \frac{g}{L}\sin\theta = 0$$
and for small angles
$$\ddot\theta + b\,\dot\theta + \frac{g}{L}\theta = 0$$
"""


def test_a_letter_that_no_other_law_confirms_may_be_a_damping():
    """b would mean a length, as in a bob's distance; without its term both equations hold, so it is not accused."""
    findings = pp.diagnose(DAMPED).findings
    assert [finding.verdict for finding in findings] == ["holds", "holds", "holds if"]
    assert [finding.remark for finding in findings[1:]] == ["b is a damping"] * 2
    assert findings[2].condition == "the angles are small, to the first order"
    wrong = pp.diagnose(DAMPED.replace(r"{L}\sin\theta = 0", r"{L}\cos\theta = 0", 2)).findings
    assert not any(finding.verdict.startswith("holds") for finding in wrong[:2])


GENERAL = r"""# Two rods in a plane
Masses $m_1, m_2$ hang on massless rods $l_1, l_2$ with the angles $\theta_1, \theta_2$.
$$T = \frac12 (m_1+m_2) l_1^2\dot\theta_1^2 + \frac12 m_2 l_2^2\dot\theta_2^2
+ m_2 l_1 l_2\dot\theta_1\dot\theta_2\cos(\theta_1-\theta_2)$$
$$V = -(m_1+m_2) g l_1\cos\theta_1 - m_2 g l_2\cos\theta_2$$
The motion follows from $L = T - V$ and
$$\frac{d}{dt}\frac{\partial L}{\partial\dot\theta_i} - \frac{\partial L}{\partial\theta_i} = 0 \dots(1)$$
"""


def test_a_law_for_any_coordinate_holds_in_every_system():
    """Euler and Lagrange's equation for theta_i, with a number behind it; with the other sign it is not said to hold."""
    assert [finding.verdict for finding in pp.diagnose(GENERAL).findings] == ["holds"] * 4
    reversed_ = GENERAL.replace(r"_i} - \frac{\partial L}", r"_i} + \frac{\partial L}")
    assert pp.diagnose(reversed_).findings[-1].verdict == "not checked"
    driven = GENERAL.replace(r"= 0 \dots(1)", "= Q_i")
    assert pp.diagnose(driven).findings[-1].verdict == "holds"


def test_a_sum_of_names_is_not_accused_for_what_its_names_stand_for():
    """L = T - V is right in general, though V is wrong where it is defined."""
    wrong = pp.diagnose(GENERAL.replace("- m_2 g l_2", "+ m_2 g l_2")).findings
    assert [finding.latex for finding in wrong if finding.verdict == "fails"] == [wrong[1].latex]


POINTS = r"""# Two bobs
Masses $m_1, m_2$ on massless rods $L_1, L_2$ with the angles $\theta_1, \theta_2$.
$$x_1 = L_1\sin\theta_1$$ $$y_1 = -L_1\cos\theta_1$$
$$x_2 = x_1 + L_2\sin\theta_2$$ $$y_2 = y_1 - L_2\cos\theta_2$$
$$\dot x_1 = L_1\cos\theta_1$$ $$\dot y_1 = L_1\sin\theta_1$$
$$\dot x_2 = \dot x_1 + L_2\cos\theta_2$$ $$\dot y_2 = \dot y_1 + L_2\sin\theta_2$$
$$V = m_1 g y_1 + m_2 g y_2$$
"""


def test_how_points_move_confirms_how_others_do():
    """Four velocities lack a rate. Four positions and one energy hold: that is enough to accuse a velocity."""
    said = [finding.verdict for finding in pp.diagnose(POINTS).findings]
    assert said == ["holds"] * 4 + ["fails"] * 4 + ["holds"]


LAWS = r"""
$$(m_1 + m_2) l_1 \ddot\theta_1 + m_2 l_2 \ddot\theta_2 \cos(\theta_1 - \theta_2)
 + m_2 l_2 \dot\theta_2^2 \sin(\theta_1 - \theta_2) + (m_1 + m_2) g \sin\theta_1 = 0$$
$$l_2 \ddot\theta_2 + l_1 \ddot\theta_1 \cos(\theta_1 - \theta_2) - l_1 \dot\theta_1^2 \sin(\theta_1 - \theta_2)
 + g \sin\theta_2 = 0$$
"""


def test_heights_may_be_measured_downwards():
    """A text may choose the direction of an axis; one sign that differs from the others is a fault."""
    points = r"$$x_1 = l_1 \sin\theta_1$$ $$y_1 = l_1 \cos\theta_1$$ $$y_2 = y_1 + l_2 \cos\theta_2$$"
    down = pp.diagnose(f"A double pendulum of two point masses.\n{points}{LAWS}").findings
    assert [finding.verdict for finding in down] == ["holds", "holds if", "holds if", "holds", "holds"]
    assert {finding.condition for finding in down[1:3]} == {"y is measured the other way"}
    up = points.replace(r"y_1 = l_1", r"y_1 = -l_1")
    mixed = pp.diagnose(f"A double pendulum of two point masses.\n{up}{LAWS}").findings
    assert [finding.verdict for finding in mixed] == ["holds", "holds", "fails", "holds", "holds"]


def test_a_height_under_another_name_shows_no_direction():
    """y_o = y_1 holds with y upwards and downwards: the one height with a cosine says which way y is measured."""
    text = """double pendulum
xo = x1
yo = y1
x2 = xo + l2*sin(t2)
y2 = yo + l2*cos(t2)
dw1 = (-g*(2*m1+m2)*sin(t1) - m2*g*sin(t1-2*t2) - 2*sin(t1-t2)*m2*(w2**2*l2 + w1**2*l1*cos(t1-t2)))/(l1*(2*m1 + m2 -
m2*cos(2*t1-2*t2)))
"""
    for names in ({}, {"yo": "y_o", "xo": "x_o"}):
        for old, new in names.items():
            text = text.replace(old, new)
        found = pp.diagnose(text).findings
        assert (found[3].verdict, found[3].remark) == ("not checked", "it holds if y is measured the other way")
    shown = pp.diagnose(text + "\ny1 = -l1*cos(t1)").findings
    assert shown[3].verdict == "fails"


def test_what_uses_a_name_that_is_not_checked_is_not_accused():
    """A height of which the text says what it is, in a symbol that nobody knows; a torque that is no period."""
    text = rf"A double pendulum of two point masses. $$h_1 = Z (1 - \cos\theta_1)$$ $$V_1 = m_1 g h_1$${LAWS}"
    unknown, uses, *laws = pp.diagnose(text).findings
    assert (unknown.verdict, uses.verdict) == ("not checked", "not checked")
    assert uses.remark.startswith("the symbol Z is not known")
    assert {finding.verdict for finding in laws} == {"holds"}
    torque = pp.diagnose(
        r"The torque about the pivot of a swinging body: $$\tau = -M g d \sin\theta$$ $$\tau = I_q \ddot\theta$$"
        r"$$I_P = I_{cm} + M d^2$$ $$\omega^2 = \frac{M g d}{I_{cm} + M d^2}$$"
    )
    assert [finding.verdict for finding in torque.findings] == ["holds", "not checked", "holds", "holds"]


def test_a_sign_in_braces_is_a_sign():
    """LaTeX sets {+} without blanks around it."""
    plain = r"A pendulum on a cart. $$(M + m)\ddot x + m l \ddot\theta \cos\theta - m l \dot\theta^2 \sin\theta = F$$"
    braced = plain.replace("+ m)", "{+}m)").replace("- m", "{-} m").replace("= F", "{=} F")
    assert [finding.verdict for finding in pp.diagnose(plain).findings] == ["holds"]
    assert [finding.verdict for finding in pp.diagnose(braced).findings] == ["holds"]


def test_a_number_behind_a_letter_is_the_index_that_the_text_writes_elsewhere():
    """m2 beside m_2, and the word that names a letter before its value is none of it."""
    text = r"$$y_2 = -L_1\cos\theta_1 - L2\cos\theta_2$$ $$V = -(m1 + m_2) g L_1\cos\theta_1 - m2 g L_2\cos\theta2$$"
    assert verdicts(text + r" $$x_1 = L_1\sin\theta_1$$ $$m_1 + m_2 > 0$$")[:2] == ["holds", "holds"]
    value, law = pp.diagnose("length l = 1.0\n\nddtheta = -g/l*sin(theta)\n", rod="plane").findings
    assert (value.kind, law.verdict) == ("condition", "holds")
